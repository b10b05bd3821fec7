"""Files of one's own: half of the variables, another layout, no dataset at all."""

from math import isnan, nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from support.plausibility_trees import TIME, contacts, series, tree

from contactlab.metrics import METRICS, Run, assess, metric, read_run
from contactlab.metrics.catalogue import measured


def saved(dataset: xarray.DataTree, folder: Path) -> Path:
    path = folder / "own.nc"
    dataset.to_netcdf(path)
    return path


def test_a_file_gives_what_its_tree_gives_and_is_closed_again(tmp_path: Path) -> None:
    path = saved(tree(), tmp_path)
    read = read_run(path)
    path.unlink()
    assert assess(read) == pytest.approx(assess(tree()), nan_ok=True)
    assert read_run(read) is read


def test_a_file_with_half_of_the_variables_has_half_of_the_metrics(tmp_path: Path) -> None:
    without = (*(name for name in series() if "force" not in name), "approach_velocity")
    half = saved(tree(without=without, configuration={}, law="", law_parameters=""), tmp_path)
    result = assess(read_run(half))
    assert list(result) == list(METRICS)
    known = {key for key, value in result.items() if not isnan(value)}
    assert known == {
        "impulse_balance",
        "phantom_contacts",
        "tension",
        "contact_gain",
        "contact_count",
        "peak_force",
        "peak_lasting_force",
        "mean_impulse",
        "total_impulse",
        "total_friction_impulse",
        "contact_time",
        "contact_duration",
        "stick_share",
        "force_bandwidth",
    }


@pytest.mark.parametrize("name", [*series(), *contacts()])
def test_any_variable_may_be_missing(name: str) -> None:
    assert list(assess(read_run(tree(without=(name,))))) == list(METRICS)


@pytest.mark.parametrize(
    "attributes",
    [
        {"configuration": "{unbalanced", "law_parameters": "not json"},
        {"configuration": "- a list", "law_parameters": "[1]"},
        {"configuration": "rotor: 3\ndrive: {frequency: fast}", "law_parameters": "{}"},
        {"configuration": "solver: {}\nlaw: {normal: {name: [1]}}", "law": "composed"},
        {"contact_step": "short", "law": "nobody's"},
        {"configuration": "drive: {frequency: 0.0}"},
    ],
)
def test_attributes_that_say_nothing_make_metrics_not_applicable(attributes: dict[str, object]) -> None:
    assert list(assess(read_run(tree(**attributes)))) == list(METRICS)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("measure", "near"),
    [
        (lambda run: run.gain("rotor_speed"), "rotor_velocity"),
        (lambda run: run.contacts("durations")[0], "duration"),
    ],
)
def test_a_name_that_no_dataset_has_is_told_with_its_metric(measure: Any, near: str) -> None:
    own: dict[str, Any] = {}
    metric("x", "of a wrong name", catalogue=own, key="mistaken")(measure)
    with pytest.warns(RuntimeWarning, match=f"mistaken.*{near}"):
        assert isnan(measured(own, Run.of(tree()))["mistaken"])


def test_a_gap_in_a_series_makes_what_needs_it_not_applicable() -> None:
    force = series()["normal_force"].copy()
    force[7] = nan
    result = assess(read_run(tree({"normal_force": force})))
    assert isnan(result["tension"])
    assert result["peak_force"] == 32.0


def root_of(**columns: object) -> xarray.DataTree:
    return xarray.DataTree(xarray.Dataset(columns))


TIMES = ("time", TIME, {"units": "s"})
GAP = ("time", np.zeros_like(TIME), {"units": "m"})


@pytest.mark.parametrize(
    ("wrong", "key"),
    [
        (root_of(gap=("t", np.zeros(3))), "time"),
        (root_of(time=TIMES), "time series"),
        (root_of(time=TIMES, length=GAP), "time series"),
        (root_of(time=("time", TIME[::-1]), gap=GAP), "increase"),
        (root_of(time=("time", TIME[:1]), gap=("time", np.zeros(1))), "1 times"),
        (root_of(time=TIMES, gap=("time", np.zeros_like(TIME), {"units": "mm"})), "gap"),
        (root_of(time=TIMES, gap=(("time", "run"), np.zeros((TIME.size, 2)))), "gap"),
        (root_of(time=TIMES, gap=("time", np.array(["a"] * TIME.size))), "gap"),
    ],
)
def test_another_layout_is_told_what_it_must_be(wrong: xarray.DataTree, key: str) -> None:
    with pytest.raises(ValueError, match=key):
        read_run(wrong)


@pytest.mark.parametrize("content", [None, b"time,gap\n0,1\n", "cut short"])
def test_a_file_that_is_missing_or_no_netcdf_is_refused_by_its_name(
    tmp_path: Path, content: bytes | str | None
) -> None:
    path = saved(tree(), tmp_path)
    path.write_bytes(path.read_bytes()[:3000] if isinstance(content, str) else content or b"")
    if content is None:
        path.unlink()
    with pytest.raises(ValueError, match=r"own\.nc"):
        read_run(path)
