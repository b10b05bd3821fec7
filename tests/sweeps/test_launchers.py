"""A sweep with several processes: the same files, the same statuses, the same end by Ctrl-C."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import ModuleType

import psutil
import pytest
from hydra.core.plugins import Plugins
from support import sweeps
from support.command_line import Command
from support.sweeps import QUICK, ChoosingSweeper, Simulations

from contactlab.studies.run_state import Status
from contactlab.studies.sweep.collection import collect

JOBLIB = ("hydra/launcher=joblib", "hydra.launcher.n_jobs=2")

ENDLESS = ("contact.clearance=1e-6,2e-6", "solver.duration=1e4", "record.interval=1")

PATIENCE = 120.0
"""Seconds for what takes ten, because the engine may have to be compiled first."""

needs_signals = pytest.mark.skipif(
    sys.platform == "win32", reason="Windows has no such signals; run the tests on Linux or macOS."
)


@contextmanager
def endless_sweep(folder: Path) -> Iterator[tuple[subprocess.Popen[str], list[psutil.Process]]]:
    """The command with two workers, both at work, and all the processes it has begun."""
    process = subprocess.Popen(
        [sys.executable, "-m", "contactlab", "-m", *JOBLIB, *ENDLESS, "hydra.sweep.dir=swept"],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    children: list[psutil.Process] = []
    try:
        patience = time.monotonic() + PATIENCE
        while len(list(folder.glob("swept/*/.hydra/overrides.yaml"))) < 2:
            assert process.poll() is None, process.communicate()
            assert time.monotonic() < patience
            time.sleep(0.05)
        children = psutil.Process(process.pid).children(recursive=True)
        yield process, children
    finally:
        process.kill()
        process.communicate()
        for child in children:
            with suppress(psutil.NoSuchProcess):
                child.kill()


def all_end(processes: list[psutil.Process]) -> bool:
    """Whether none of them runs on; the dead may wait for whoever collects them."""
    patience = time.monotonic() + 10.0
    while any(map(runs, processes)):
        if time.monotonic() > patience:
            return False
        time.sleep(0.1)
    return True


def runs(process: psutil.Process) -> bool:
    with suppress(psutil.NoSuchProcess):
        return process.status() != psutil.STATUS_ZOMBIE
    return False


def runs_below(folder: str) -> dict[str, bytes]:
    return {path.parent.name: path.read_bytes() for path in Path(folder).glob("*/run.nc")}


@pytest.mark.long
def test_two_processes_leave_the_same_bits_and_status_as_one(command: Command) -> None:
    # The last voltage drives the tip deep into the rotor, and its run is left incomplete.
    soft = "law.stiffness=1e3"
    swept = ["drive.voltage_1=90,100,1e5", soft, "solver.duration=1 ms"]
    assert command("-m", *swept, "hydra.sweep.dir=one")[0] == 1
    # In a process of its own, with which its workers end.
    two = [sys.executable, "-m", "contactlab", "-m", *JOBLIB, *swept, "hydra.sweep.dir=two"]
    done = subprocess.run(two, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert done.returncode == 1, done.stderr
    expected = runs_below("one")
    assert len(expected) == 3
    assert runs_below("two") == expected


@pytest.mark.long
@needs_signals
@pytest.mark.parametrize("whole_group", [True, False], ids=["terminal", "command_alone"])
def test_ctrl_c_ends_the_command_and_its_workers_with_a_sentence(tmp_path: Path, whole_group: bool) -> None:
    with endless_sweep(tmp_path) as (process, children):
        assert len(children) >= 2
        (os.killpg if whole_group else os.kill)(process.pid, signal.SIGINT)
        _, err = process.communicate(timeout=PATIENCE)
        assert process.returncode == 130, err
        assert "Traceback" not in err
        assert any(line.startswith("Interrupted") for line in err.splitlines())
        assert all_end(children)


@needs_signals
@pytest.mark.long
def test_a_lost_worker_ends_the_sweep_with_a_sentence(tmp_path: Path) -> None:
    with endless_sweep(tmp_path) as (process, children):
        busiest = max(children, key=lambda child: child.memory_info().rss)
        busiest.kill()
        _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 1
    assert "The sweep stopped: TerminatedWorkerError: A worker process" in err
    assert "Traceback" not in err


@pytest.mark.long
def test_runs_of_a_sweeper_that_chooses_its_values_are_resumed_and_collected(
    command: Command, simulations: Simulations, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Where Hydra's plugins live.
    monkeypatch.setattr(ChoosingSweeper, "__module__", "hydra_plugins.choosing")
    Plugins.instance().register(ChoosingSweeper)
    monkeypatch.setitem(sys.modules, "hydra_plugins", ModuleType("hydra_plugins"))
    monkeypatch.setitem(sys.modules, "hydra_plugins.choosing", sweeps)
    sweeper = "hydra.sweeper._target_=hydra_plugins.choosing.ChoosingSweeper"
    for _ in range(2):
        status, out, err = command("-m", "drive.phase=0", sweeper, *QUICK)
        assert status == 2
        assert "contact.clearance is -1e-06 m; it must be at least 0 m" in err
        assert "2 complete\n1 refused\n" in out
        assert "Collected in sweep/sweep.nc: run 3." in out
    assert simulations.seen == [1.0, 2.0]
    result = collect("sweep")
    assert result["status"].values.tolist() == [Status.COMPLETE, Status.COMPLETE, Status.REFUSED]
    assert "contact.clearance is -1e-06 m" in str(result["reason"].values[2])
    assert result["clearance"].values[:2].tolist() == [1e-6, 2e-6]


@pytest.mark.long
def test_the_jobs_of_the_basic_sweeper_lie_below_the_folder_of_the_sweep(
    command: Command, simulations: Simulations
) -> None:
    status, out, err = command("-m", "hydra/sweeper=basic", "contact.clearance=1e-6,2e-6", *QUICK)
    assert (status, err) == (0, "")
    assert "Collected in " in out
    (collected,) = Path().rglob("sweep.nc")
    assert collect(collected.parent)["clearance"].values.tolist() == [1e-6, 2e-6]
    assert {path.parent.parent for path in Path().rglob("run.nc")} == {collected.parent}
