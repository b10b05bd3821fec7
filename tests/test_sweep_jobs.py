"""The jobs of a sweep: skipped when complete, run again otherwise, and none harmed by another."""

import dataclasses
import os
import signal
import subprocess
import sys
import time
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np
import pytest
import xarray
from command_line import Command
from conf_files import composed
from hydra._internal.core_plugins import basic_launcher
from packages import Elsewhere
from sweeps import QUICK, Simulations, folder, state_of

from contactlab import engine
from contactlab.command import composition
from contactlab.command.directories import MOST_CHARACTERS, folder_name
from contactlab.config import build
from contactlab.output import provenance
from contactlab.sweep import job
from contactlab.trajectory import Ending

THREE = ("-m", "contact.clearance=1e-6,2e-6,3e-6", *QUICK)


@pytest.fixture
def simulations(monkeypatch: pytest.MonkeyPatch) -> Simulations:
    made = Simulations()
    monkeypatch.setattr(engine, "simulate", made)
    return made


def test_a_sweep_run_again_skips_all_and_says_so(
    command: Command, simulations: Simulations
) -> None:
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


def test_what_failed_is_run_again_and_the_others_are_not(
    command: Command, simulations: Simulations
) -> None:
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
    assert state_of(failed) | {"size": 0, "job": 0} == {
        "state": "complete", "reason": "", "size": 0, "job": 0,
    }  # fmt: skip


def test_a_sweep_with_more_values_runs_those_alone(
    command: Command, simulations: Simulations
) -> None:
    assert command("-m", "contact.clearance=1e-6,2e-6", *QUICK)[0] == 0
    status, out, _ = command("-m", "contact.clearance=2e-6,1e-6,0.5e-6", *QUICK)
    assert status == 0
    assert "3 runs: 2 are complete and skipped; 1 is new: this runs." in out
    assert simulations.seen == [1.0, 2.0, 0.5]


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


def test_runs_of_another_version_code_or_law_are_run_again(
    command: Command, simulations: Simulations, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = ("-m", "contact.clearance=1e-6", *QUICK)
    assert command(*one)[0] == 0
    found = provenance.versions() | {"contactlab_version": "99"}
    changes = {
        "versions": lambda: found,
        "code_digest": lambda: "0",
        "provenance": lambda _: "example-law 1.2.4",
    }
    for number, (name, change) in enumerate(changes.items(), 2):
        monkeypatch.setattr(job, name, change)
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


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGKILL.")
def test_a_run_that_was_killed_is_run_again(
    command: Command, simulations: Simulations, tmp_path: Path
) -> None:
    long_run = ["-m", "contact.clearance=1e-6,2e-6", "solver.duration=1e4", "record.interval=1e-2"]
    place = tmp_path / folder("1e-06", "record.interval=0.01", "solver.duration=10000.0")
    process = subprocess.Popen(
        [sys.executable, "-m", "contactlab", *long_run, *QUICK],
        cwd=tmp_path,
        stdout=subprocess.DEVNULL,
    )
    patience = time.monotonic() + 60.0
    while not (place / "state.json").exists() and process.poll() is None:
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


def test_ctrl_c_stops_a_sweep_and_the_next_goes_on(
    command: Command, simulations: Simulations
) -> None:
    simulations.endings = {2.0: Ending.INTERRUPTED}
    assert command(*THREE)[0] == 130
    assert not Path("sweep/collected.nc").exists()
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
    def broken(*_: object, **__: object) -> None:
        raise RuntimeError("the cluster is gone")

    monkeypatch.setattr(basic_launcher, "run_job", broken)
    status, out, err = command(*THREE)
    assert status == 1
    assert "The sweep stopped: RuntimeError: the cluster is gone." in err
    assert "Traceback" not in err
    assert "the cluster is gone" in Path("sweep/run.log").read_text(encoding="utf-8")
    assert "3 absent" in out


def test_a_folder_that_is_named_by_numbers_keeps_them(
    command: Command, simulations: Simulations
) -> None:
    numbered = [*THREE, "hydra.sweep.subdir=${hydra.job.num}"]
    simulations.endings = {1.0: RuntimeError("no luck"), 3.0: RuntimeError("no luck")}
    assert command(*numbered)[0] == 1
    simulations.endings = {}
    assert command(*numbered)[0] == 0
    assert simulations.seen == [1.0, 2.0, 3.0, 1.0, 3.0]
    assert [state_of(Path("sweep") / str(n))["state"] for n in range(3)] == ["complete"] * 3


def test_a_sweep_without_a_folder_finds_its_own_again(
    command: Command, simulations: Simulations
) -> None:
    values = "contact.clearance=1 um,2 um"
    assert command("-m", "law=hertz_penalty", values, "record.picture=false")[0] == 0
    status, out, _ = command("-m", "record.picture=false", values, "law=hertz_penalty")
    assert status == 0
    assert "2 runs: all are complete and skipped." in out
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


def test_batches_are_taken_one_after_the_other(command: Command, simulations: Simulations) -> None:
    status, out, err = command(*THREE, "hydra.sweeper.max_batch_size=2")
    assert status == 0, err
    assert "Launching 2 jobs locally" in out
    assert "Launching 1 jobs locally" in out
    assert simulations.seen == [1.0, 2.0, 3.0]


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


def test_a_value_that_is_given_twice_is_refused(command: Command) -> None:
    status, _, err = command("-m", "contact.clearance=1e-6,1e-6", *QUICK)
    assert status == 2
    assert "to 2 jobs" in err
    assert "give every value once" in err


def test_a_change_of_any_source_that_a_run_depends_on_changes_the_digest(tmp_path: Path) -> None:
    for name in ("engine/loop.py", "comparison/report.py"):
        (tmp_path / name).parent.mkdir()
        (tmp_path / name).write_bytes(b"x = 1\n")
    first = provenance.digest_of(tmp_path)
    (tmp_path / "comparison/report.py").write_bytes(b"x = 2\n")
    (tmp_path / "engine/loop.py").write_bytes(b"x = 1\r\n")
    assert provenance.digest_of(tmp_path) == first
    (tmp_path / "engine/loop.py").write_bytes(b"x = 2\n")
    changed = provenance.digest_of(tmp_path)
    (tmp_path / "engine/loop.py").rename(tmp_path / "engine/other.py")
    assert len({first, changed, provenance.digest_of(tmp_path)}) == 3


FRAGILE = """
from dataclasses import dataclass
from typing import ClassVar
from contactlab.laws import PenaltyLaw

@dataclass(frozen=True)
class Fragile(PenaltyLaw):
    name: ClassVar[str] = "fragile"
    equation: ClassVar[str] = "none"
    source: ClassVar[str] = "a test"
    default_contact_step: ClassVar[float] = 4e-6

    @staticmethod
    def force(gap, gap_rate, slip, approach, parameters):
        return {"text": [f"{gap}"]}["FOUND"], 0.0, 0.0, 0.0
"""


def test_a_law_that_raises_harms_no_other_and_is_run_again_when_it_is_mended(
    tmp_path: Path,
) -> None:
    elsewhere = Elsewhere(tmp_path / "packages", tmp_path)
    law = {"fragile": "fragile:Fragile"}
    elsewhere.install("fragile-law", "0.1", law, {"fragile": FRAGILE})
    lines = ("-m", "law=fragile,hertz_penalty", "solver.duration=0.5 ms", *QUICK)
    status, out, err = elsewhere.command(*lines)
    assert status == 1
    assert "The run ended because the law fragile raised KeyError: 'FOUND'" in err
    assert "Traceback" not in err
    assert "1 complete\n1 failed\n" in out
    place = tmp_path / "sweep/law=fragile,record.picture=False,solver.duration=0.5_ms"
    assert "KeyError: 'FOUND'" in (place / "run.log").read_text(encoding="utf-8")
    with xarray.open_dataset(tmp_path / "sweep/collected.nc") as found:
        assert found["status"].sel(law="fragile") == 4
        assert "raised KeyError: 'FOUND'" in str(found["reason"].sel(law="fragile").values)
        assert np.isfinite(found["rotor_velocity"].sel(law="hertz_penalty"))
        assert np.isnan(found["rotor_velocity"].sel(law="fragile"))
    # The same version of the package with other code in it.
    mended = elsewhere.packages / "fragile.py"
    mended.write_text(mended.read_text().replace('{"text": [f"{gap}"]}["FOUND"]', "-1e7 * gap"))
    status, out, err = elsewhere.command(*lines)
    assert status == 0, err
    assert "2 runs: 1 is complete and skipped; 1 failed: this runs." in out
    assert not (place / "run.log").exists()


def test_the_key_of_a_law_of_another_package_follows_its_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    setup = build(composed())
    keys = []
    for text in (FRAGILE, FRAGILE, FRAGILE.replace("FOUND", "text")):
        (tmp_path / "fragile.py").write_text(text)
        spec = spec_from_file_location("fragile", tmp_path / "fragile.py")
        assert spec is not None
        assert spec.loader is not None
        module = module_from_spec(spec)
        monkeypatch.setitem(sys.modules, "fragile", module)
        spec.loader.exec_module(module)
        keys.append(job.key_of(dataclasses.replace(setup, law=module.Fragile())))
    assert keys[0] == keys[1] != keys[2]
    assert job.key_of(setup) == job.key_of(build(setup.configuration))


def test_the_jobs_of_a_sweep_are_composed_as_hydra_composes_them(
    command: Command, simulations: Simulations, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The key that the check finds is the one that the job itself finds."""
    plans = []

    def remember(*arguments: object) -> composition.Plan:
        plans.append(composition.check(*arguments))  # type: ignore[arg-type]
        return plans[-1]

    monkeypatch.setattr("contactlab.app.check", remember)
    groups = ("law=composed", "law/normal=linear,hertz_point", "placement=placement_1,placement_2")
    status, _, err = command("-m", *groups, "drive.phase=-36 deg", *QUICK)
    assert status == 0, err
    assert len(plans[0].jobs) == 4
    for planned in plans[0].jobs:
        state = job.read_state(planned.folder)
        assert state is not None
        assert state.job == planned.job
