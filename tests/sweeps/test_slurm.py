"""A sweep on a cluster: SLURM runs it, a node is lost half-way, and the sweep is whole all the same."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest
import xarray
import yaml
from slurm.cluster import NODES, Cluster, ClusterError, Job, running_cluster
from support.command_line import Command

from contactlab.studies.run_state import Status

LAWS = ("lagrange_stick", "hertz_penalty")
CLEARANCES = ("1e-6", "1.5e-6", "2e-6")

# Some seconds of computing each, so that a job is under way for long enough to be met.
RUN = ("solver.duration=2", "record.interval=1e-3")

PATIENCE = 300.0
"""Seconds for what takes fifty, because the engine may have to be compiled first."""


@contextmanager
def required_cluster() -> Iterator[Cluster]:
    """A cluster; without one the test is skipped, but not where everything must be tested."""
    with ExitStack() as stack:
        try:
            cluster = stack.enter_context(running_cluster())
        except ClusterError as error:
            (pytest.fail if os.environ.get("CI") else pytest.skip)(str(error))
        yield cluster


@pytest.fixture(scope="module")
def cluster() -> Iterator[Cluster]:
    with required_cluster() as cluster:
        yield cluster


@contextmanager
def sweep(cluster: Cluster, folder: Path) -> Iterator[subprocess.Popen[str]]:
    """The command, sweeping on the cluster; it does not outlive its context."""
    arguments = [
        *("-m", "hydra/launcher=submitit_slurm", "hydra.launcher.partition=main"),
        *("hydra.launcher.timeout_min=5", "hydra.launcher.cpus_per_task=1"),
        *(f"law={','.join(LAWS)}", f"contact.clearance={','.join(CLEARANCES)}", *RUN),
        f"hydra.sweep.dir={folder}",
    ]
    process = subprocess.Popen(
        [sys.executable, "-m", "contactlab", *arguments],
        cwd=folder.parent,
        env=cluster.environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def wait_until(happened: Callable[[], bool], process: subprocess.Popen[str] | None = None) -> None:
    """Wait, but not for a process that has ended."""
    patience = time.monotonic() + PATIENCE
    while not happened():
        assert process is None or process.poll() is None, process.communicate()
        assert time.monotonic() < patience
        time.sleep(0.1)


def job_on(cluster: Cluster, node: str) -> Job | None:
    running = (job for job in cluster.jobs() if job.state == "RUNNING" and job.node == node)
    return next(running, None)


def folder_of(job: Job, swept: Path) -> Path | None:
    """Where a job's run goes, once it has begun."""
    index = int(job.id.rpartition("_")[2])
    for path in swept.glob("*/.hydra/hydra.yaml"):
        # Empty while it is being written.
        written = yaml.safe_load(path.read_text())
        if written and written["hydra"]["job"]["num"] == index:
            return path.parents[1]
    return None


@pytest.mark.long
def test_a_sweep_is_complete_though_a_node_is_lost_half_way(
    cluster: Cluster, tmp_path: Path, command: Command
) -> None:
    _, lost = NODES
    swept = tmp_path / "swept"
    with sweep(cluster, swept) as process:
        wait_until(lambda: bool((job := job_on(cluster, lost)) and folder_of(job, swept)), process)
        victim = job_on(cluster, lost)
        assert victim is not None
        cluster.kill(lost)
        folder = folder_of(victim, swept)
        assert folder is not None
        assert not (folder / "run.nc").exists()

        def now() -> Job:
            return next(job for job in cluster.jobs() if job.id == victim.id)

        wait_until(lambda: now().restarts > victim.restarts, process)
        cluster.restart(lost)
        _, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, err
    assert "Traceback" not in err
    # The command has its results a moment before SLURM has done with the jobs.
    wait_until(lambda: all(job.state == "COMPLETED" for job in cluster.jobs()))
    assert [job.id for job in cluster.jobs() if job.restarts] == [victim.id]
    with xarray.open_dataset(swept / "sweep.nc") as collected:
        assert collected.sizes == {"law": len(LAWS), "clearance": len(CLEARANCES)}
        assert collected.attrs["complete"] == 1
        assert (collected["status"] == Status.COMPLETE).all()
        assert collected["final_rotor_velocity"].notnull().all()

    # What was lost and done again is what it would have been.
    overrides = (folder / ".hydra/overrides.yaml").read_text().replace("- ", "").splitlines()
    assert command(*overrides, "hydra.run.dir=undisturbed")[0] == 0
    assert Path("undisturbed/run.nc").read_bytes() == (folder / "run.nc").read_bytes()
