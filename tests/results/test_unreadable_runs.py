"""One run that cannot be read is reported as failed, and the others are collected."""

import copy
import json
from pathlib import Path
from typing import Any

import pytest
import xarray
from support.command_line import Command
from support.sweeps import QUICK, Simulations, folder
from support.synthetic import CONFIGURATION, synthetic_trajectory

import contactlab as cl
from contactlab import ComparisonError, checks, compare
from contactlab.metrics import is_complete, read_run
from contactlab.results.netcdf import to_datatree, write_tree
from contactlab.studies.run_state import COMPLETE, Job, State, Status, write_state
from contactlab.studies.sweep.collection import collect


def left_run(
    folder: Path, configuration: dict[str, Any], choices: dict[str, Any], **attributes: object
) -> None:
    """A complete run with these options and this clearance."""
    folder.mkdir(parents=True)
    tree = to_datatree(synthetic_trajectory(duration=1e-3), CONFIGURATION)
    tree.attrs |= attributes
    digest = write_tree(tree, folder / "run.nc")
    job = Job("key", ("contact.clearance=1",), choices, configuration)
    write_state(folder, State(COMPLETE, job, digest=digest))


def sound(clearance: float) -> dict[str, Any]:
    configuration: dict[str, Any] = copy.deepcopy(CONFIGURATION)
    configuration["contact"]["clearance"] = clearance
    return configuration


def test_a_law_that_is_no_longer_installed_harms_no_other_run(tmp_path: Path) -> None:
    gone = sound(1e-6) | {"law": {"name": "gone", "hardness": 1.0}}
    left_run(tmp_path / "1", gone, {"law": "gone"}, law="gone")
    left_run(tmp_path / "2", sound(1e-6), {"law": "hertz_penalty"})
    result = collect(tmp_path)
    assert result.sizes == {"law": 2}
    assert (result["status"] == Status.COMPLETE).all()
    assert result["peak_force"].notnull().all()


@pytest.mark.parametrize("text", [None, 5, [1], {"law": {"name": ["x"]}}, {"status": 1, "a/b": 2}])
def test_a_configuration_that_is_none_harms_no_other_run(tmp_path: Path, text: object) -> None:
    for name, clearance in (("1", 1e-6), ("2", 2e-6), ("3", 3e-6)):
        left_run(tmp_path / name, sound(clearance), {})
    state = tmp_path / "1" / "state.json"
    read = json.loads(state.read_text())
    read["job"]["configuration"] = text
    state.write_text(json.dumps(read))
    assert (collect(tmp_path)["status"] == Status.COMPLETE).all()


@pytest.mark.parametrize(
    "change", [{"state": {}}, {"state": "complete", "job": {"overrides": 3}}, {"reason": None}]
)
def test_a_state_that_is_none_harms_no_other_run(tmp_path: Path, change: dict[str, object]) -> None:
    left_run(tmp_path / "1", sound(1e-6), {})
    left_run(tmp_path / "2", sound(2e-6), {})
    state = tmp_path / "1" / "state.json"
    state.write_text(json.dumps(json.loads(state.read_text()) | change))
    result = collect(tmp_path)
    assert result["status"].size == 2
    assert int((result["status"] == Status.COMPLETE).sum()) >= 1


@pytest.mark.parametrize("value", ["yes", "1", 2, -1, float("nan"), [1, 1]])
def test_complete_is_one_or_zero(tmp_path: Path, value: object) -> None:
    left_run(tmp_path / "1", sound(1e-6), {}, complete=value)
    left_run(tmp_path / "2", sound(2e-6), {})
    with pytest.raises(ValueError, match="complete"):
        read_run(tmp_path / "1" / "run.nc")
    with pytest.raises(ComparisonError, match="complete"):
        compare([tmp_path / "1"], refine=False)
    for name in ("1", "2"):
        (tmp_path / name / "state.json").unlink()
    result = collect(tmp_path)
    assert sorted(result["status"].values.ravel().tolist()) == [Status.COMPLETE, Status.FAILED]


@pytest.mark.parametrize(("value", "meant"), [(1, True), (1.0, True), (0, False), (None, True)])
def test_who_says_that_a_run_is_complete_may_say_it_in_any_number(value: float | None, meant: bool) -> None:
    tree = to_datatree(synthetic_trajectory(duration=1e-3), CONFIGURATION)
    tree.attrs.pop("complete")
    if value is not None:
        tree.attrs["complete"] = value
    assert isinstance(tree, xarray.DataTree)
    assert is_complete(read_run(tree)) is meant


def test_files_of_ones_own_by_our_names_harm_nothing(command: Command, simulations: Simulations) -> None:
    assert command("-m", "contact.clearance=1e-6,2e-6", *QUICK)[0] == 0
    Path("sweep/sweep.json").write_text("[1]")
    (folder("2e-06") / "state.json").write_text('{"state": "complete"}')
    Path("sweep/mine").mkdir()
    Path("sweep/mine/state.json").write_text("no json")
    result = collect("sweep")
    assert sorted(result["status"].values.ravel().tolist()) == [0, 0, Status.FAILED]


def test_what_may_be_planned_can_be_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A run has a record at its start, and more at changes; what a law remembers takes room."""
    monkeypatch.setattr(checks, "FEW_RECORDS", 0)
    monkeypatch.setattr(checks, "MOST_RECORDS", 5000)
    monkeypatch.setattr(checks, "MOST_MEMORY", 5000 * checks.RECORD_SIZE)
    coarse = cl.build(["record.interval=1e-4"])
    run = cl.simulate(coarse, duration=1e-4, record_interval=2e-8)
    run.save(tmp_path / "run.nc")
    assert cl.load(tmp_path / "run.nc").to_xarray().identical(run.to_xarray())
    for setup in (
        coarse.with_("law=composed", "law/friction=iwan"),
        coarse.with_("solver.changes=['33.33 us; rotor.load_torque=1e-3']"),
    ):
        with pytest.raises(ValueError, match="record_interval"):
            cl.simulate(setup, duration=1e-4, record_interval=2e-8)
        made = cl.simulate(setup, duration=1e-4, record_interval=6e-8)
        made.save(tmp_path / "run.nc")
        assert cl.load(tmp_path / "run.nc")["time"].identical(made["time"])
