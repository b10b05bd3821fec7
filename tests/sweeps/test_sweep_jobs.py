"""The jobs of a sweep: skipped when complete, run again otherwise, and none harmed by another."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra.core.plugins import Plugins
from support.command_line import Command
from support.sweeps import QUICK, Simulations, folder, state_of

from contactlab.cli.start import MOST_CHARACTERS, folder_name
from contactlab.config import build
from contactlab.metrics import assess, read_run
from contactlab.studies import run_state as state
from contactlab.studies.runner import done_parts
from contactlab.studies.sweep.plan import Outputs, planned
from contactlab.studies.sweep.study import Sweep, composing
from contactlab.trajectory import Ending

THREE = ("-m", "contact.clearance=1e-6,2e-6,3e-6", *QUICK)


def test_a_sweep_run_again_skips_all_and_runs_values_that_are_added(
    command: Command, simulations: Simulations
) -> None:
    status, _, err = command(*THREE)
    assert status == 0, err
    runs = {path: path.stat().st_mtime_ns for path in Path("sweep").glob("*/*")}
    assert len([path for path in runs if path.name == "run.nc"]) == 3
    assert command(*THREE)[0] == 0
    assert simulations.seen == [1.0, 2.0, 3.0]
    assert {path: path.stat().st_mtime_ns for path in Path("sweep").glob("*/*")} == runs
    assert command("-m", "contact.clearance=2e-6,1e-6,0.5e-6", *QUICK)[0] == 0
    assert simulations.seen == [1.0, 2.0, 3.0, 0.5]


def test_what_failed_is_run_again_and_the_others_are_not(command: Command, simulations: Simulations) -> None:
    simulations.endings = {2.0: RuntimeError("no luck"), 3.0: Ending.DIVERGED}
    status, out, err = command(*THREE)
    assert status == 1
    assert "Traceback" not in err
    assert "1 complete\n1 diverged\n1 failed\n" in out
    failed = folder("2e-06")
    assert "RuntimeError: no luck" in (failed / "run.log").read_text(encoding="utf-8")
    assert state_of(failed)["state"] == "failed"
    assert state_of(folder("3e-06"))["state"] == "diverged"
    assert state_of(folder("1e-06"))["state"] == "complete"
    simulations.endings = {}
    assert command(*THREE)[0] == 0
    assert simulations.seen == [1.0, 2.0, 3.0, 2.0, 3.0]
    assert not (failed / "run.log").exists()
    left = state_of(failed)
    assert left.keys() == {"state", "reason", "digest", "job", "metrics", "code"}
    assert (left["state"], left["reason"]) == ("complete", "")
    of_dataset = assess(read_run(failed / "run.nc"))
    assert left["metrics"] == {key: value for key, value in of_dataset.items() if np.isfinite(value)}


def test_jobs_with_the_same_options_are_composed_once(
    command: Command, simulations: Simulations, monkeypatch: pytest.MonkeyPatch
) -> None:
    composed: list[list[str]] = []
    before = ConfigLoaderImpl.load_sweep_config

    def counted(self: ConfigLoaderImpl, config: Any, lines: list[str]) -> Any:
        composed.append(lines)
        return before(self, config, lines)

    monkeypatch.setattr(ConfigLoaderImpl, "load_sweep_config", counted)
    counts = []
    for clearances in ("1e-6", "2e-6,3e-6,4e-6"):
        assert command("-m", "law=newton,hertz_penalty", f"contact.clearance={clearances}", *QUICK)[0] == 0
        counts.append(len(composed) - sum(counts))
    assert counts[0] == counts[1]
    for law in ("newton", "hertz_penalty"):
        for clearance in ("2e-06", "4e-06"):
            left = folder(clearance, f"law={law}")
            job = state_of(left)["job"]
            assert job["overrides"] == [
                f"law={law}",
                f"contact.clearance={clearance}",
                "record.picture=false",
            ]
            assert job["configuration"] == build(job["overrides"]).configuration
            assert job["choices"]["law"] == law


@pytest.mark.long
def test_another_configuration_in_the_same_folder_is_run(
    command: Command, simulations: Simulations, tmp_path: Path
) -> None:
    (tmp_path / "mine/contact").mkdir(parents=True)
    for coefficient in (0.3, 0.2):
        text = f"tip_length: 19e-3\nclearance: 1e-6\nfriction_coefficient: {coefficient}\n"
        (tmp_path / "mine/contact/rough.yaml").write_text(text)
        assert command("--config-dir", "mine", "-m", "contact=rough,default", *QUICK)[0] == 0
    assert len(simulations.seen) == 3


def test_a_dataset_that_is_not_as_the_run_left_it_is_made_anew(
    command: Command, simulations: Simulations
) -> None:
    assert command(*THREE)[0] == 0
    cut, removed = (folder(clearance) / "run.nc" for clearance in ("1e-06", "3e-06"))
    os.truncate(cut, cut.stat().st_size // 2)
    removed.unlink()
    assert command(*THREE)[0] == 0
    assert simulations.seen == [1.0, 2.0, 3.0, 1.0, 3.0]
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
    assert command(*long_run, *QUICK)[0] == 0
    assert simulations.seen == [1.0, 2.0]
    assert state_of(place)["state"] == "complete"


# Other processes would simulate in earnest.
@pytest.mark.parametrize("keep", ["", "sweep.keep=metrics sweep.chunk=1 sweep.workers=1 law=newton"])
def test_ctrl_c_stops_a_sweep_and_the_next_goes_on(
    command: Command, simulations: Simulations, keep: str
) -> None:
    simulations.endings = {2.0: Ending.INTERRUPTED}
    assert command(*THREE, *keep.split())[0] == 130
    assert simulations.seen == [1.0, 2.0]
    assert not Path("sweep/sweep.nc").exists()
    simulations.endings = {}
    assert command(*THREE, *keep.split())[0] == 0
    assert simulations.seen == [1.0, 2.0, 2.0, 3.0]


@pytest.mark.long
def test_the_number_of_processes_changes_no_byte_of_the_folders(command: Command) -> None:
    # The last voltage drives the tip deep into the rotor, and its run is left incomplete.
    swept = ("drive.voltage_1=90,100,1e5", "law.stiffness=1e3", "solver.duration=1 ms", "record.picture=true")
    left = []
    for workers in (1, 2):
        status, _, err = command("-m", *swept, f"sweep.workers={workers}", f"hydra.sweep.dir={workers}")
        assert (status, err) == (1, "")
        files = (path for path in sorted(Path(str(workers)).rglob("*")) if path.suffix != ".yaml")
        left.append({path.relative_to(str(workers)): path.read_bytes() for path in files if path.is_file()})
    assert len(left[0]) == 3 * len(("run.nc", "run.png", "state.json")) + len(("sweep.json", "sweep.nc"))
    assert left[0] == left[1]


def test_the_same_run_leaves_the_same_state(command: Command, simulations: Simulations) -> None:
    for place in ("one", "two"):
        assert command("contact.clearance=1e-6", f"hydra.run.dir={place}")[0] == 0
    assert Path("one/state.json").read_bytes() == Path("two/state.json").read_bytes()


@pytest.mark.parametrize("error", [MemoryError(), SystemExit(3), ValueError("one\n  two")])
def test_any_exception_of_a_run_is_a_reason_with_the_traceback_in_the_log(
    command: Command, simulations: Simulations, error: BaseException
) -> None:
    simulations.endings = {1.0: error}
    status, _, err = command("contact.clearance=1e-6", "hydra.run.dir=here")
    assert status == 1
    assert "Traceback" not in err
    assert type(error).__name__ in Path("here/run.log").read_text(encoding="utf-8")
    assert type(error).__name__ in state_of(Path("here"))["reason"]


def test_a_run_that_can_no_longer_be_built_is_refused_alone(tmp_path: Path) -> None:
    faulty = {**build().configuration, "law": "none of these"}
    plan = planned(composing(["law=newton"]), {"drive.phase": [0.0]}, Outputs(), keep="runs")
    folders = {0: (tmp_path, state.Job(configuration=faulty))}
    parts, _ = done_parts(Sweep(plan=plan, folders=folders), {})
    assert parts["0"]["status"].values.tolist() == [state.Status.REFUSED]
    left = state_of(tmp_path)
    assert left["state"] == "refused"
    assert "law" in left["reason"]


def test_a_launcher_that_fails_is_a_sentence_and_what_there_is_is_collected(
    command: Command, simulations: Simulations, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Gone:
        def launch(self, *_: object, **__: object) -> None:
            raise RuntimeError("the cluster is gone")

    monkeypatch.setattr(Plugins, "instantiate_launcher", lambda *_, **__: Gone())
    status, out, err = command(*THREE, "hydra/launcher=joblib")
    assert status == 1
    assert "Traceback" not in err
    assert "the cluster is gone" in Path("sweep/run.log").read_text(encoding="utf-8")
    assert "3 absent" in out


def test_no_picture_is_drawn_where_none_is_wanted(command: Command, simulations: Simulations) -> None:
    for wanted in (True, False):
        status, _, err = command(f"record.picture={wanted}", f"hydra.run.dir=drawn_{wanted}")
        assert status == 0, err
        assert Path(f"drawn_{wanted}", "run.png").exists() is wanted


def test_a_sweep_keeps_its_status_where_it_cannot_be_collected(
    command: Command, simulations: Simulations
) -> None:
    Path("sweep/sweep.nc").mkdir(parents=True)
    status, _, err = command("-m", "contact.clearance=1e-6,2e-6", *QUICK)
    assert status == 0
    assert "Traceback" not in err


def test_a_folder_that_is_named_by_numbers_keeps_them(command: Command, simulations: Simulations) -> None:
    numbered = [*THREE, "hydra.sweep.subdir=${hydra.job.num}"]
    simulations.endings = {1.0: RuntimeError("no luck"), 3.0: RuntimeError("no luck")}
    assert command(*numbered)[0] == 1
    simulations.endings = {}
    assert command(*numbered)[0] == 0
    assert simulations.seen == [1.0, 2.0, 3.0, 1.0, 3.0]
    assert [state_of(Path("sweep") / str(n))["state"] for n in range(3)] == ["complete"] * 3


def test_a_sweep_without_a_folder_finds_its_own_again(command: Command, simulations: Simulations) -> None:
    values = "contact.clearance=1 um,2 um"
    assert command("-m", "law=hertz_penalty", values, "record.picture=false")[0] == 0
    assert command("-m", "record.picture=false", values, "law=hertz_penalty")[0] == 0
    assert simulations.seen == [1.0, 2.0]
    (only,) = Path("multirun").iterdir()
    assert only.name == "contact.clearance=1_um,2_um,law=hertz_penalty,record.picture=false"


def test_the_folder_that_a_file_of_ones_own_gives_is_taken(
    command: Command, simulations: Simulations, tmp_path: Path
) -> None:
    (tmp_path / "mine/experiment").mkdir(parents=True)
    (tmp_path / "mine/experiment/mine.yaml").write_text(
        "# @package _global_\nhydra:\n  sweep:\n    dir: out/${folder_name:${hydra.job.override_dirname}}\n"
    )
    lines = ("-m", "experiment=mine", "contact.clearance=1e-6,2e-6", "record.picture=false")
    assert command("--config-dir", "mine", *lines)[0] == 0
    (only,) = Path("out").iterdir()
    assert only.name == "contact.clearance=1e-6,2e-6,experiment=mine,record.picture=false"
    assert len(list(only.glob("*/run.nc"))) == 2


@pytest.mark.parametrize(
    ("overrides", "name"),
    [
        ("law=lagrange_slip", "law=lagrange_slip"),
        ("contact.clearance=1\\ um", "contact.clearance=1_um"),
        ("contact.clearance='2 \u00b5m'", "contact.clearance=2_um"),
        ("law/normal=linear,law=composed", "law-normal=linear,law=composed"),
        ("", "default"),
    ],
)
def test_a_folder_is_named_by_the_overrides(overrides: str, name: str) -> None:
    assert folder_name(overrides) == name


def test_folders_differ_where_their_overrides_do() -> None:
    several = ["a=x/y", "a=x-y", "a=x:y", *(f"a={'x' * 300}{n}" for n in range(9))]
    names = [folder_name(overrides) for overrides in several]
    assert len(set(names)) == len(several)
    assert max(map(len, names)) <= MOST_CHARACTERS
    assert not any(set(name) & set("/:\\ '\"") for name in names)
