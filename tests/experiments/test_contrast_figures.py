"""Claims on recorded numbers, figures and runs of `law_contrasts` and `law_practice`, from made-up motors."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import contrast_run
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray
from contrast_figures import FIGURES, LEAST, SPEED, array, is_null
from contrast_run import RUNS
from law_contrasts import CONTRASTS, LawContrasts
from law_practice import MARGIN, LawPractice, missed
from results_store import text_of
from support.made_contrasts import data_of, motors_of, practice_of, practised_motors

import contactlab as cl
from contactlab.studies.study import TASKS, Part


@pytest.fixture(scope="module")
def data() -> xarray.Dataset:
    return data_of(40)


@pytest.fixture(scope="module")
def numbers(data: xarray.Dataset) -> dict:
    """Return numbers as they are read back."""
    return json.loads(text_of(LawContrasts().numbers(xarray.DataTree(data))))


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


def test_contrasts_are_recorded_motor_by_motor(data: xarray.Dataset, numbers: dict) -> None:
    for quantity, own in numbers["size"].items():
        for name, values in own.items():
            size = np.abs(data["contrast_size"].sel(contrast=name, quantity=quantity).values)
            np.testing.assert_allclose(array(values), size, rtol=1e-3)
    assert np.isinf(array(numbers["size"][SPEED]["rigid or compliant"])).sum() == 1
    assert np.isnan(array(numbers["size"][SPEED]["restitution constant or by speed"])).sum() == 1
    assert numbers["outcomes"]["newton"] == {
        "steady": 39,
        "not settled": 1,
        "broken off": 0,
        "no such law": 0,
    }
    assert numbers["map"] == {SPEED: {}, "stall_torque": {}}


def test_points_are_the_sizes_of_motors_with_a_ratio(numbers: dict) -> None:
    (axes,) = FIGURES[""](numbers).axes
    clouds = [line.get_xdata() for line in axes.lines if line.get_marker() == "."]
    for points, values in zip(clouds, numbers["size"][SPEED].values(), strict=True):
        size = array(values)
        np.testing.assert_allclose(points, np.maximum(size[np.isfinite(size)], LEAST))
    assert {text.get_text() for text in axes.texts} == {"1 turned"}


def test_curves_cross_one_at_the_share_of_motors_beyond(numbers: dict) -> None:
    names = [name for name in CONTRASTS if not is_null(name)]
    panels = FIGURES["_knowledge"](numbers).axes
    for name, axes in zip(names, panels, strict=False):
        curves = {line.get_label(): line.get_xydata() for line in axes.lines}
        for level, width in numbers["half-width"].items():
            ratio = array(numbers["size"][SPEED][name]) / array(width)
            x, y = curves[level].T
            assert y[x <= 1.0][-1] == pytest.approx((ratio > 1.0).sum() / (~np.isnan(ratio)).sum())


def test_a_map_is_drawn_with_its_intervals_once_it_is_judged(numbers: dict) -> None:
    assert "40 motors" in FIGURES["_map"](numbers).axes[0].texts[0].get_text()
    own = {name: {"r2": 0.4, "low": 0.1, "high": 0.6} for name in CONTRASTS if not is_null(name)}
    (axes,) = FIGURES["_map"](numbers | {"map": {SPEED: own, "stall_torque": own}}).axes
    assert not axes.texts
    ends = [path.vertices[:, 0] for each in axes.collections for path in each.get_paths()]
    np.testing.assert_allclose(ends, [[0.1, 0.6]] * 2 * len(own))


MADE: dict[str, Callable[[int], list[xarray.Dataset]]] = {
    "law_contrasts": motors_of,
    "law_practice": practised_motors,
}
"""Motors by the name of their run."""


@pytest.mark.parametrize("name", MADE)
def test_a_run_under_way_has_the_motors_before_the_first_gap(name: str, tmp_path: Path) -> None:
    (tmp_path / TASKS).mkdir()
    motors, run = MADE[name](4), RUNS[name]
    for number in (3, 1, 0):
        motors[number].to_netcdf(tmp_path / TASKS / f"{number}-x.nc", engine="netcdf4")
    # A motor of an earlier plan, with another number of quantities or laws.
    (other,) = {"quantity", "law"} & {*run.sizes}
    motors[2].isel({other: [0]}).to_netcdf(tmp_path / TASKS / "2-x.nc", engine="netcdf4")
    there = contrast_run.motors_of(tmp_path, run)
    assert len(there) == 2
    for own, motor in zip(there, motors, strict=False):
        xarray.testing.assert_equal(own, motor)


@pytest.mark.parametrize("name", MADE)
def test_a_whole_run_has_its_motors_in_their_order(name: str, tmp_path: Path) -> None:
    motors, run = MADE[name](4), RUNS[name]
    run.study.join(cl.build(), motors).to_netcdf(tmp_path / f"{name}.nc", engine="netcdf4")
    for own, motor in zip(contrast_run.motors_of(tmp_path, run), motors, strict=True):
        for variable in run.variables:
            np.testing.assert_array_equal(own[variable], motor[variable])


@pytest.mark.parametrize(
    ("name", "variable"), [(name, variable) for name in MADE for variable in ("", RUNS[name].variables[1])]
)
def test_a_motor_with_other_digits_is_refused(name: str, variable: str, tmp_path: Path) -> None:
    motors, run = MADE[name](4), RUNS[name]
    run.study.join(cl.build(), motors).to_netcdf(tmp_path / f"{name}.nc", engine="netcdf4")
    again = motors[contrast_run.AGAIN].copy(deep=True)
    run = replace(run, compute=lambda _: Part(xarray.DataTree(again)))
    if variable:
        again[variable] *= 1.0 + 1e-6
        with pytest.raises(ValueError, match=variable):
            contrast_run.result_of(tmp_path, run, cl.build())
    else:
        result = contrast_run.result_of(tmp_path, run, cl.build())
        assert result.study.numbers(result.data)["motors"] == 4


def test_a_folder_without_a_motor_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=str(tmp_path)):
        contrast_run.motors_of(tmp_path, RUNS["law_practice"])


def test_a_law_is_judged_in_motors_that_have_every_law() -> None:
    study, data = LawPractice(), practice_of(40)
    numbers = json.loads(text_of(study.numbers(xarray.DataTree(data))))
    rows = {row["law"]: row for row in study.rows(data)}
    for law, values in numbers["error"].items():
        errors = data["prediction_error"].sel(law=law).isel(motor=[0, *range(2, 40)]).values
        np.testing.assert_allclose(array(values), errors, rtol=1e-3)
        assert rows[law]["near"] == pytest.approx((errors < np.log1p(MARGIN)).mean())
        assert rows[law]["error"] == pytest.approx(np.median(errors))
    (axes,) = missed(numbers).axes
    clouds = [line.get_xdata() for line in axes.lines if line.get_marker() == "."]
    for points, values in zip(clouds, numbers["error"].values(), strict=True):
        np.testing.assert_allclose(points, array(values))
    assert {len(values) for values in numbers["start"].values()} == {40}


def test_a_law_that_misses_most_motors_makes_the_finding_hold() -> None:
    study, data = LawPractice(), practice_of(40)
    good = data.assign(prediction_error=0.01 * (data["prediction_error"] < 1.0))
    assert not study.finding(good)[1]
    worse = good["prediction_error"] + 0.2 * (good["law"] == "tsuji")
    assert study.finding(good.assign(prediction_error=worse))[1]
