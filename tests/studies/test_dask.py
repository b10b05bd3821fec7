"""A study on the workers of a Dask scheduler: real processes, one of them killed on the way."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from support.sweeps import begun

import contactlab as cl
from contactlab.studies.runner import TASKS, _by_dask
from contactlab.studies.study import run
from contactlab.studies.sweep.dataset import DATASET
from contactlab.studies.sweep.study import continued

dask = pytest.importorskip("dask")
distributed = pytest.importorskip("distributed")
ROOT = Path(__file__).parents[2]


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """The address of a scheduler, and its process and those of its two workers."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "tests")])}
    file = tmp_path / "scheduler.json"
    options = ["--no-dashboard", "--scheduler-file", str(file)]

    def begin(name: str, *more: str) -> "subprocess.Popen[bytes]":
        module = f"distributed.cli.dask_{name}"
        return subprocess.Popen(
            [sys.executable, "-m", module, *options, *more],
            env=environment,
            cwd=tmp_path,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )

    every = [begin("scheduler", "--port", "0")]
    try:
        deadline = time.monotonic() + 60.0
        while not file.exists():
            assert time.monotonic() < deadline
            time.sleep(0.1)
        every += [begin("worker", "--nthreads", "1", "--no-nanny") for _ in range(2)]
        with distributed.Client(scheduler_file=str(file), set_as_default=False) as client:
            client.wait_for_workers(2, timeout=90)
            yield client.scheduler.address, every
    finally:
        for process in every:
            process.kill()
            process.wait()


@pytest.mark.long
def test_a_worker_that_dies_loses_nothing_and_changes_no_bit(
    cluster: tuple[str, list["subprocess.Popen[bytes]"]], tmp_path: Path
) -> None:
    address, (_, *workers) = cluster
    setups = {"": cl.build(["law=newton", "solver.duration=5e-3"])}
    from support.slow_study import Slow

    here = run(Slow(), setups)
    counts: list[int] = []

    def kill_a_worker(done: int, total: int) -> None:
        counts.append(done)
        if done == 3:
            workers[0].send_signal(signal.SIGKILL)

    there = run(Slow(scheduler=address), setups, tmp_path / "there", kill_a_worker)
    assert counts == [*range(13)]
    assert there.data.identical(here.data)


@pytest.mark.long
def test_a_scheduler_that_is_lost_ends_the_study_and_keeps_what_is_finished(
    cluster: tuple[str, list["subprocess.Popen[bytes]"]], tmp_path: Path
) -> None:
    address, (scheduler, *_) = cluster
    setups = {"": cl.build(["law=newton", "solver.duration=5e-3"])}
    from support.slow_study import Slow

    def kill_the_scheduler(done: int, total: int) -> None:
        if done == 3:
            scheduler.send_signal(signal.SIGKILL)

    # Time for which a client tries to connect again.
    with dask.config.set({"distributed.comm.timeouts.connect": "2s"}), pytest.raises(cl.WorkerError):
        run(Slow(scheduler=address), setups, tmp_path, kill_the_scheduler)
    assert len(list((tmp_path / TASKS).iterdir())) >= 3
    with pytest.raises(ValueError, match="scheduler"):
        run(Slow(scheduler=address), setups, tmp_path)


@pytest.mark.long
def test_a_sweep_on_a_scheduler_leaves_the_same_bytes(
    cluster: tuple[str, list["subprocess.Popen[bytes]"]], tmp_path: Path
) -> None:
    for name, scheduler in (("here", None), ("there", cluster[0])):
        sweep = begun(tmp_path / name, finished=1)
        continued(replace(sweep, scheduler=scheduler), tmp_path / name)
    assert (tmp_path / "here" / DATASET).read_bytes() == (tmp_path / "there" / DATASET).read_bytes()


def test_a_scheduler_without_a_worker_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    for workers in (0, 1):
        options = {"processes": False, "dashboard_address": None}
        with distributed.LocalCluster(n_workers=workers, **options) as cluster:
            assert not [*_by_dask(cluster.scheduler_address, [])]
        assert (capsys.readouterr().err != "") == (workers == 0)
