"""Claims on recorded numbers, figures and the data of a run of `law_contrasts`, from made-up motors."""

import json
from pathlib import Path

import contrast_run
import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray
from contrast_figures import FIGURES, LEAST, SPEED, array, is_null
from law_contrasts import CONTRASTS, FITTED, LawContrasts
from results_store import text_of
from support.made_contrasts import data_of, motors_of

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


def test_a_run_under_way_has_the_motors_before_the_first_gap(tmp_path: Path) -> None:
    (tmp_path / TASKS).mkdir()
    motors = motors_of(4)
    for number in (3, 1, 0):
        motors[number].to_netcdf(tmp_path / TASKS / f"{number}-x.nc", engine="netcdf4")
    # A motor of an earlier plan, with another number of quantities, and a practised one.
    motors[2].isel(quantity=[0]).to_netcdf(tmp_path / TASKS / "2-x.nc", engine="netcdf4")
    motors[0][[*contrast_run.OF_PRACTICE]].to_netcdf(tmp_path / TASKS / "4-x.nc", engine="netcdf4")
    there = contrast_run.motors_of(tmp_path, most=8)
    assert len(there) == 2
    for own, motor in zip(there, motors, strict=False):
        xarray.testing.assert_equal(own, motor[[*contrast_run.OF_A_MOTOR]])


def test_a_whole_run_has_its_motors_in_their_order(tmp_path: Path) -> None:
    data_of(4).to_netcdf(tmp_path / "law_contrasts.nc", engine="netcdf4")
    for own, motor in zip(contrast_run.motors_of(tmp_path, most=8), motors_of(4), strict=True):
        xarray.testing.assert_equal(own, motor)


@pytest.mark.parametrize("name", ["", "value", "prediction_error"])
def test_a_motor_with_other_digits_is_refused(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    data_of(4).to_netcdf(tmp_path / "law_contrasts.nc", engine="netcdf4")
    again = motors_of(1)[0]
    if name:
        again[name] *= 1.0 + 1e-6
    every = {"computed": contrast_run.OF_A_MOTOR, "practised": contrast_run.OF_PRACTICE}
    for function, variables in every.items():
        part = Part(xarray.DataTree(again[[*variables]]))
        monkeypatch.setattr(contrast_run, function, lambda _, part=part: part)
    if name:
        with pytest.raises(ValueError, match=name):
            contrast_run.result_of(tmp_path, cl.build())
    else:
        result = contrast_run.result_of(tmp_path, cl.build())
        numbers = result.study.numbers(result.data)
        assert numbers["motors"] == len(numbers["error"]["newton"]) == 4 < FITTED


def test_a_folder_without_a_motor_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=str(tmp_path)):
        contrast_run.motors_of(tmp_path, most=8)
