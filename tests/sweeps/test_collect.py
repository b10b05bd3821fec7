"""Runs as one dataset: every run in its cell, what is missing with a reason, from the folders alone."""

import errno
import os
import shutil
from pathlib import Path

import numpy as np
import pytest
import xarray
import yaml
from support.command_line import Command
from support.sweeps import QUICK, Simulations, folder, state_of

from contactlab.cli.verbs.collect import collect_swept
from contactlab.metrics import METRICS, assess, read_run
from contactlab.studies.run_state import Status
from contactlab.studies.sweep.collection import collect
from contactlab.trajectory import Ending

GRID = ("law=lagrange_stick,hertz_penalty", "contact.clearance=2 um,1e-6,3e-6")


@pytest.fixture
def simulations(monkeypatch: pytest.MonkeyPatch) -> Simulations:
    # Runs that differ, so that none can stand for another.
    made = Simulations(duration=lambda clearance: 1e-3 * clearance)
    monkeypatch.setattr("contactlab.config.setup.simulate", made)
    return made


def test_a_sweep_over_an_option_and_a_number_is_a_grid_in_si(
    command: Command, simulations: Simulations
) -> None:
    status, out, err = command("-m", *GRID, *QUICK)
    assert status == 0, err
    assert "6 complete\nCollected in sweep/sweep.nc: law 2 x clearance 3." in out
    with xarray.open_dataset("sweep/sweep.nc") as result:
        assert result["peak_force"].dims == ("law", "clearance")
        assert result["law"].values.tolist() == ["lagrange_stick", "hertz_penalty"]
        assert result["clearance"].values.tolist() == [1e-6, 2e-6, 3e-6]
        assert result["clearance"].attrs["units"] == "m"
        assert result["clearance"].attrs["key"] == "contact.clearance"
        assert result.attrs["complete"] == 1
        assert result.attrs["runs"] == result.attrs["runs_complete"] == 6
        assert result.attrs["law"] == "hertz_penalty lagrange_stick"
        common = yaml.safe_load(result.attrs["configuration"])
        assert "clearance" not in common["contact"]
        assert common["contact"]["tip_length"] == 0.019
        assert set(METRICS) <= set(result.data_vars)
        for law in result["law"].values:
            for clearance in result["clearance"].values:
                cell = result.sel({"law": law, "clearance": clearance})
                run = read_run(Path("sweep") / str(cell["job"].values) / "run.nc")
                ran = yaml.safe_load(run.attrs["configuration"])
                assert (ran["law"]["name"], ran["contact"]["clearance"]) == (law, clearance)
                expected = assess(run)
                for key in METRICS:
                    np.testing.assert_equal(float(cell[key]), expected[key])
                assert cell["status"] == Status.COMPLETE
                assert str(cell["reason"].values) == ""


def test_runs_are_collected_without_their_files_but_where_their_code_is_another(
    command: Command, simulations: Simulations, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert command("-m", "contact.clearance=1e-6,2e-6", *QUICK)[0] == 0
    opened: list[Path] = []

    def counted(path: Path) -> xarray.DataTree:
        opened.append(path)
        return read_run(path)

    monkeypatch.setattr("contactlab.studies.sweep.collection.read_run", counted)
    result = collect("sweep")
    assert not opened
    assert result.attrs["runs_of_other_code"] == 0
    # Metrics by other code are computed anew, from the file.
    for clearance in ("1e-06", "2e-06"):
        text = (folder(clearance) / "state.json").read_text().replace('"code": "', '"code": "other')
        (folder(clearance) / "state.json").write_text(
            text.replace('"contact_count": 3', '"contact_count": 4')
        )
    again = collect("sweep")
    assert len(opened) == 2
    xarray.testing.assert_identical(again, result)
    monkeypatch.setattr("contactlab.studies.run_state.code_digest", lambda: "that of an edited file")
    assert collect("sweep").attrs["runs_of_other_code"] == 2


def test_what_is_not_complete_is_missing_with_a_reason(command: Command, simulations: Simulations) -> None:
    """But a run whose energy balance does not close keeps its numbers."""
    simulations.endings = {
        2.0: RuntimeError("no luck"),
        3.0: Ending.CHATTERED,
        4.0: Ending.UNBALANCED,
        5.0: Ending.STALLED,
        6.0: Ending.INTERRUPTED,
    }
    names = ["complete", "failed", "chattered", "unbalanced", "stalled", "interrupted", "absent"]
    values = f"contact.clearance={','.join(f'{n}e-6' for n in range(1, 8))}"
    assert command("-m", values, *QUICK)[0] == 130
    states = [folder(f"{n}e-06") / "state.json" for n in range(1, 8)]
    assert [state_of(state.parent)["state"] for state in states] == names
    result = collect("sweep")
    assert result.sizes == {"clearance": 7}
    assert [Status(code).name.lower() for code in result["status"].values] == names
    assert [bool(reason) for reason in result["reason"].values] == [False] + [True] * 6
    finite = [True, False, False, True, False, False, False]
    assert np.isfinite(result["peak_force"].values).tolist() == finite
    assert [result.attrs[f"runs_{name}"] for name in names] == [1] * 7
    assert result.attrs["complete"] == 0
    # The file is written with the same content, and flags that say what the codes are.
    with xarray.open_dataset("sweep/sweep.nc") as read:
        xarray.testing.assert_identical(read.load(), result)
        meanings = read["status"].attrs["flag_meanings"].split()
        assert [meanings[code] for code in read["status"].values] == names
    # The datasets alone tell the same of the runs that ended.
    for state in states:
        state.unlink()
    again, ended = collect("sweep"), [0, 2, 3, 4, 5]
    np.testing.assert_array_equal(again["status"], result["status"][ended])
    np.testing.assert_array_equal(again["peak_force"], result["peak_force"][ended])
    simulations.endings = {4.0: Ending.UNBALANCED}
    status, out, _ = command("-m", values, *QUICK)
    assert (status, "1 unbalanced" in out) == (1, True)


def test_a_run_that_was_killed_or_cut_is_told(command: Command, simulations: Simulations) -> None:
    assert command("-m", "contact.clearance=1e-6,2e-6,3e-6", *QUICK)[0] == 0
    state = folder("1e-06") / "state.json"
    state.write_text(state.read_text().replace('"complete"', '"running"'))
    data = (folder("2e-06") / "run.nc").read_bytes()
    (folder("2e-06") / "run.nc").write_bytes(data[: len(data) // 2])
    noise = bytes(np.random.default_rng(1).integers(0, 256, len(data), dtype=np.uint8))
    (folder("3e-06") / "run.nc").write_bytes(noise)
    state = folder("3e-06") / "state.json"
    state.write_text(state.read_text().replace(state_of(folder("3e-06"))["digest"], ""))
    status, out, err = command("collect", "sweep")
    assert status == 0, err
    assert "2 failed\n1 unfinished\n" in out
    result = collect("sweep")
    assert result["status"].values.tolist() == [Status.UNFINISHED, Status.FAILED, Status.FAILED]
    assert not np.isfinite(result["peak_force"]).any()


@pytest.mark.long
def test_a_sweep_that_was_extended_is_one_grid_with_the_empty_cells_told(
    command: Command, simulations: Simulations
) -> None:
    assert command("-m", "law=hertz_penalty,lagrange_stick", "contact.clearance=1e-6", *QUICK)[0] == 0
    assert command("-m", "law=hertz_penalty", "contact.clearance=2e-6,3e-6", *QUICK)[0] == 0
    result = collect("sweep")
    assert result.sizes == {"law": 2, "clearance": 3}
    rows = result.sel(law="lagrange_stick")
    assert rows["status"].values.tolist() == [Status.COMPLETE, Status.ABSENT, Status.ABSENT]
    assert (result.attrs["runs"], result.attrs["runs_absent"]) == (4, 0)


@pytest.mark.long
def test_points_that_form_no_grid_are_a_list_with_all_parameters(
    command: Command, simulations: Simulations
) -> None:
    points = [(1.0, 0.1), (2.0, 0.25), (4.0, 0.2), (5.0, 0.4)]
    for clearance, friction in points:
        lines = (f"contact.clearance={clearance} um", f"contact.friction_coefficient={friction}")
        assert command("-m", *lines, *QUICK)[0] == 0
    with xarray.open_dataset("sweep/sweep.nc") as result:
        assert result.sizes == {"run": 4}
        pairs = zip(result["clearance"].values, result["friction_coefficient"].values, strict=True)
        assert list(pairs) == [(float(f"{c}e-6"), mu) for c, mu in points]
        assert result["friction_coefficient"].attrs["units"] == "1"
        for n, (clearance, _) in enumerate(points):
            assert f"clearance={clearance}" in str(result["job"][n].values)


def test_parameters_of_one_law_are_missing_in_the_others(command: Command, simulations: Simulations) -> None:
    assert command("-m", "law=lagrange_stick", *QUICK)[0] == 0
    assert command("-m", "law=hertz_penalty", "law.stiffness=1e10,2e10", *QUICK)[0] == 0
    result = collect("sweep")
    assert result.sizes == {"run": 3}
    stiffness = dict(zip(result["job"].values, result["stiffness"].values, strict=True))
    assert sorted(stiffness.values())[:2] == [1e10, 2e10]
    assert result["stiffness"].attrs["units"] == "N m-1.5"
    assert np.isnan(result["stiffness"].where(result["law"] == "lagrange_stick", drop=True)).all()


@pytest.mark.long
def test_parts_and_placements_are_dimensions_and_what_follows_from_them_is_none(
    command: Command, simulations: Simulations
) -> None:
    groups = ("law=composed", "law/normal=linear,hertz_point", "placement=placement_1,placement_2")
    assert command("-m", *groups, *QUICK)[0] == 0
    result = collect("sweep")
    assert dict(result.sizes) == {"placement": 2, "normal": 2}
    assert result["normal"].values.tolist() == ["hertz_point", "linear"]
    assert "frequency" not in result.coords


@pytest.mark.long
def test_runs_without_a_state_are_told_apart_by_their_configurations(
    command: Command, simulations: Simulations
) -> None:
    assert command("-m", *GRID, *QUICK)[0] == 0
    # Nothing else tells the order of the options.
    expected = collect("sweep", "with.nc").sortby("law")
    for name in ("state.json", "sweep.json"):
        for path in Path("sweep").rglob(name):
            path.unlink()
    result = collect("sweep", "without.nc")
    assert result.sizes == {"law": 2, "clearance": 3}
    beside = {name: result[name] for name in result.coords if name not in expected.coords}
    same = expected[list(METRICS)].assign_coords(beside).drop_attrs()
    xarray.testing.assert_identical(result[list(METRICS)].drop_attrs(), same)
    # What follows from the law stands beside it.
    steps = result["contact_step"]
    assert steps.dims == ("law", "clearance")
    # A rigid law has none.
    assert np.isnan(steps.sel(law="lagrange_stick")).all()
    # A dataset of one's own may say nothing at all of itself.
    shutil.move(str(next(Path("sweep").glob("*/run.nc"))), "sweep/run.nc")
    assert collect("sweep").sizes == {"law": 2, "clearance": 3}


@pytest.mark.long
def test_the_same_sweep_gives_the_same_bytes(command: Command, simulations: Simulations) -> None:
    files = []
    for _ in range(2):
        assert command("-m", *GRID, *QUICK)[0] == 0
        files.append(Path("sweep/sweep.nc").read_bytes())
        collect("sweep", "again.nc")
        files.append(Path("again.nc").read_bytes())
        shutil.rmtree("sweep")
    assert len(set(files)) == 1


@pytest.mark.long
def test_time_series_are_added_a_slab_a_run(command: Command, simulations: Simulations) -> None:
    simulations.duration = lambda _: 1e-3
    simulations.endings = {2.0: RuntimeError("no luck")}
    assert command("-m", *GRID, *QUICK)[0] == 1
    names = "rotor_velocity,gap"
    status, out, err = command("collect", "sweep", f"series={names}", "output=all.nc")
    assert status == 0, err
    assert "Collected in all.nc" in out
    with xarray.open_datatree("all.nc", decode_times=False) as tree:
        assert set(METRICS) <= set(tree.data_vars)
        series = tree["series"]
        assert series["gap"].dims == ("law", "clearance", "time")
        assert series["gap"].attrs["units"] == "m"
        failed = series["gap"].sel({"clearance": 2e-6})
        assert np.isnan(failed).all()
        cell = {"law": "lagrange_stick", "clearance": 3e-6}
        run = read_run(Path("sweep") / str(tree["job"].sel(cell).values) / "run.nc")
        for name in names.split(","):
            np.testing.assert_array_equal(series[name].sel(cell), run[name])
        np.testing.assert_array_equal(series["time"], run["time"])


@pytest.mark.parametrize(
    ("arguments", "key"),
    [
        (["nowhere"], "nowhere"),
        (["."], "."),
        (["sweep", "series=speed"], "speed"),
        (["sweep", "series=gap"], "series"),
        (["sweep", "output=nowhere/all.nc"], "output"),
    ],
)
def test_what_cannot_be_collected_is_refused_by_its_key_and_leaves_no_file(
    command: Command, simulations: Simulations, arguments: list[str], key: str
) -> None:
    if arguments[0] == "sweep":
        assert command("-m", "contact.clearance=1e-6,2e-6", *QUICK)[0] == 0
        Path("sweep/sweep.nc").unlink()
    status, _, err = command("collect", *arguments)
    assert status == 2
    assert key in err
    assert "Traceback" not in err
    assert not list(Path().rglob("*.partial"))
    assert not list(Path().rglob("sweep.nc"))


def test_a_sweep_whose_dataset_has_no_room_says_so_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(tmp_path / "sweep.nc"))

    monkeypatch.setattr("contactlab.studies.sweep.collection.collect", full)
    collect_swept(tmp_path)
    error = capsys.readouterr().err
    assert os.strerror(errno.ENOSPC) in error
    assert error.count("collected") == 1
