"""The jobs of a sweep: skipped when complete, run again otherwise, and none harmed by another."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import xarray
from hydra.core.plugins import Plugins
from support.command_line import Command
from support.sweeps import QUICK, Simulations, folder, state_of

from contactlab.results import provenance
from contactlab.sweeps import state
from contactlab.trajectory import Ending

THREE = ("-m", "contact.clearance=1e-6,2e-6,3e-6", *QUICK)


def test_a_sweep_run_again_skips_all_and_says_so(command: Command, simulations: Simulations) -> None:
    status, out, err = command(*THREE)
    assert status == 0, err
    assert "3 runs: 3 are new: these run." in out
    runs = {path: path.stat().st_mtime_ns for path in Path("sweep").glob("*/*")}
    assert len([path for path in runs if path.name == "run.nc"]) == 3
    status, out, err = command(*THREE)
    assert status == 0, err
    assert "3 runs: all are complete and skipped." in out
    assert simulations.seen == [1.0, 2.0, 3.0]
    assert {path: path.stat().st_mtime_ns for path in Path("sweep").glob("*/*")} == runs


def test_what_failed_is_run_again_and_the_others_are_not(command: Command, simulations: Simulations) -> None:
    simulations.endings = {2.0: RuntimeError("no luck"), 3.0: Ending.DIVERGED}
    status, out, err = command(*THREE)
    assert status == 1
    assert "The run raised RuntimeError: no luck." in err
    assert "Traceback" not in err
    assert "1 complete\n1 diverged\n1 failed\n" in out
    failed = folder("2e-06")
    assert "RuntimeError: no luck" in (failed / "run.log").read_text(encoding="utf-8")
    assert state_of(failed)["state"] == "failed"
    assert state_of(folder("3e-06"))["state"] == "diverged"
    assert state_of(folder("1e-06"))["state"] == "complete"
    simulations.endings = {}
    status, out, err = command(*THREE)
    assert status == 0, err
    assert "3 runs: 1 is complete and skipped; 1 failed and 1 ended early: these run." in out
    assert simulations.seen == [1.0, 2.0, 3.0, 2.0, 3.0]
    assert not (failed / "run.log").exists()
    assert state_of(failed) | {"digest": 0, "job": 0} == {
        "state": "complete", "reason": "", "digest": 0, "job": 0,
    }  # fmt: skip


def test_a_sweep_with_more_values_runs_those_alone(command: Command, simulations: Simulations) -> None:
    assert command("-m", "contact.clearance=1e-6,2e-6", *QUICK)[0] == 0
    status, out, _ = command("-m", "contact.clearance=2e-6,1e-6,0.5e-6", *QUICK)
    assert status == 0
    assert "3 runs: 2 are complete and skipped; 1 is new: this runs." in out
    assert simulations.seen == [1.0, 2.0, 0.5]


@pytest.mark.long
def test_another_configuration_in_the_same_folder_is_run(
    command: Command, simulations: Simulations, tmp_path: Path
) -> None:
    (tmp_path / "mine/contact").mkdir(parents=True)
    for coefficient in (0.3, 0.2):
        text = f"tip_length: 19e-3\nclearance: 1e-6\nfriction_coefficient: {coefficient}\n"
        (tmp_path / "mine/contact/rough.yaml").write_text(text)
        status, out, err = command("--config-dir", "mine", "-m", "contact=rough,default", *QUICK)
        assert status == 0, err
    assert "2 runs: 1 is complete and skipped; 1 is of another configuration or code: this" in out
    assert len(simulations.seen) == 3


@pytest.mark.long
def test_runs_of_another_version_code_or_law_are_run_again(
    command: Command, simulations: Simulations, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = ("-m", "contact.clearance=1e-6", *QUICK)
    assert command(*one)[0] == 0
    found = provenance.versions() | {"contactlab_version": "99"}
    changes = {
        "versions": lambda: found,
        "code_digest": lambda: "0",
        "provenance": lambda *_: "example-law 1.2.4",
    }
    for number, (name, change) in enumerate(changes.items(), 2):
        monkeypatch.setattr(state, name, change)
        status, out, _ = command(*one)
        assert status == 0
        assert "1 run: 1 is of another configuration or code: this runs." in out
        assert len(simulations.seen) == number
    assert "1 run: it is complete and skipped." in command(*one)[1]


def test_a_dataset_that_is_not_as_the_run_left_it_is_made_anew(
    command: Command, simulations: Simulations
) -> None:
    assert command(*THREE)[0] == 0
    cut, removed = (folder(clearance) / "run.nc" for clearance in ("1e-06", "3e-06"))
    os.truncate(cut, cut.stat().st_size // 2)
    removed.unlink()
    status, out, _ = command(*THREE)
    assert status == 0
    assert "1 is complete and skipped; 2 have lost their datasets: these run." in out
    for path in (cut, removed):
        with xarray.open_dataset(path) as root:
            assert root.attrs["complete"] == 1


@pytest.mark.skipif(
    sys.platform == "win32", reason="Windows has no SIGKILL; run the tests on Linux or macOS."
)
@pytest.mark.long
def test_a_run_that_was_killed_is_run_again(
    command: Command, simulations: Simulations, tmp_path: Path
) -> None:
    long_run = ["-m", "contact.clearance=1e-6,2e-6", "solver.duration=1e4", "record.interval=1e-2"]
    place = tmp_path / folder("1e-06", "record.interval=1e-2", "solver.duration=1e4")
    process = subprocess.Popen(
        [sys.executable, "-m", "contactlab", *long_run, *QUICK], cwd=tmp_path, stdout=subprocess.DEVNULL
    )
    patience = time.monotonic() + 60.0
    # Until then it is absent.
    while process.poll() is None and not ((left := state.read_state(place)) and left.state == "running"):
        assert time.monotonic() < patience
        time.sleep(0.02)
    process.kill()
    assert process.wait() == -signal.SIGKILL
    assert state_of(place)["state"] == "running"
    status, out, err = command(*long_run, *QUICK)
    assert status == 0, err
    assert "2 runs: 1 was cut short and 1 is new: these run." in out
    assert simulations.seen == [1.0, 2.0]
    assert state_of(place)["state"] == "complete"


def test_ctrl_c_stops_a_sweep_and_the_next_goes_on(command: Command, simulations: Simulations) -> None:
    simulations.endings = {2.0: Ending.INTERRUPTED}
    assert command(*THREE)[0] == 130
    assert not Path("sweep/sweep.nc").exists()
    simulations.endings = {}
    status, out, _ = command(*THREE)
    assert status == 0
    assert "1 is complete and skipped; 1 was cut short and 1 is new: these run." in out


def test_a_single_run_always_runs(command: Command, simulations: Simulations) -> None:
    for _ in range(2):
        assert command("contact.clearance=1e-6", "hydra.run.dir=here")[0] == 0
    assert simulations.seen == [1.0, 1.0]
    assert state_of(Path("here"))["state"] == "complete"


def test_the_same_run_leaves_the_same_state(command: Command, simulations: Simulations) -> None:
    for place in ("one", "two"):
        assert command("contact.clearance=1e-6", f"hydra.run.dir={place}")[0] == 0
    assert Path("one/state.json").read_bytes() == Path("two/state.json").read_bytes()


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (MemoryError(), "The run raised MemoryError: ."),
        (SystemExit(3), "The run raised SystemExit: 3."),
        (ValueError("one\n  two"), "The run raised ValueError: one two."),
    ],
)
def test_any_exception_of_a_run_is_a_sentence_with_the_traceback_in_the_log(
    command: Command, simulations: Simulations, error: BaseException, sentence: str
) -> None:
    simulations.endings = {1.0: error}
    status, _, err = command("contact.clearance=1e-6", "hydra.run.dir=here")
    assert status == 1
    said, where = err.splitlines()
    assert said == sentence
    assert where.startswith("The traceback is in ")
    assert where.endswith("here/run.log.")
    assert type(error).__name__ in Path("here/run.log").read_text(encoding="utf-8")
    assert state_of(Path("here"))["reason"] == sentence


def test_a_launcher_that_fails_is_a_sentence_and_what_there_is_is_collected(
    command: Command, simulations: Simulations, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Gone:
        def launch(self, *_: object, **__: object) -> None:
            raise RuntimeError("the cluster is gone")

    monkeypatch.setattr(Plugins, "instantiate_launcher", lambda *_, **__: Gone())
    status, out, err = command(*THREE)
    assert status == 1
    assert "The sweep stopped: RuntimeError: the cluster is gone." in err
    assert "Traceback" not in err
    assert "the cluster is gone" in Path("sweep/run.log").read_text(encoding="utf-8")
    assert "3 absent" in out


@pytest.mark.long
def test_the_jobs_of_a_sweep_are_composed_as_hydra_composes_them(
    command: Command, simulations: Simulations, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The key that the plan finds is the one that the job itself finds."""
    planned = {}

    def remember(place: Path, left: state.State) -> None:
        assert left.state == "absent"
        planned[place] = left.job

    monkeypatch.setattr("contactlab.cli.sweeper.write_state", remember)
    groups = ("law=composed", "law/normal=linear,hertz_point", "placement=placement_1,placement_2")
    status, _, err = command("-m", *groups, "drive.phase=-36 deg", *QUICK)
    assert status == 0, err
    assert len(planned) == 4
    for place, job in planned.items():
        left = state.read_state(place)
        assert left is not None
        assert left.job == job


def test_no_picture_is_drawn_where_none_is_wanted(command: Command, simulations: Simulations) -> None:
    for wanted in (True, False):
        status, out, err = command(f"record.picture={wanted}", f"hydra.run.dir=drawn_{wanted}")
        assert status == 0, err
        assert Path(f"drawn_{wanted}", "run.png").exists() is wanted
        assert ("run.png" in out) is wanted
    status, _, err = command("record.picture=5")
    assert status == 2
    assert "record.picture is 5; it must be true or false." in err


def test_a_sweep_keeps_its_status_where_it_cannot_be_collected(
    command: Command, simulations: Simulations
) -> None:
    Path("sweep/sweep.nc").mkdir(parents=True)
    status, _, err = command("-m", "contact.clearance=1e-6,2e-6", *QUICK)
    assert status == 0
    assert "The runs could not be collected: " in err
    assert "Traceback" not in err
