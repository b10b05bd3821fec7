"""A study on Dask workers that SLURM starts, by dask-jobqueue."""

import os
import sys
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import pytest
from slurm.cluster import ClusterError, running_cluster
from support.slow_study import Slow
from support.sweeps import begun

import contactlab as cl
from contactlab.studies.study import run
from contactlab.studies.sweep.dataset import DATASET
from contactlab.studies.sweep.study import continued

dask_jobqueue = pytest.importorskip("dask_jobqueue")
ROOT = Path(__file__).parents[2]


@pytest.mark.long
# It warns that no network interface was found by name, and how its own event loop ends.
@pytest.mark.filterwarnings("ignore")
def test_workers_that_slurm_starts_leave_the_same_bits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    setups = {"": cl.build(["law=newton", "solver.duration=5e-3"])}
    here = run(Slow(), setups)
    with ExitStack() as stack:
        try:
            nodes = stack.enter_context(running_cluster())
        except ClusterError as error:
            (pytest.fail if os.environ.get("CI") else pytest.skip)(str(error))
        for name, value in nodes.environment.items():
            monkeypatch.setenv(name, value)
        monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT), str(ROOT / "tests")]))
        workers = dask_jobqueue.SLURMCluster(
            queue="main",
            cores=1,
            processes=1,
            memory="1GB",
            interface="lo",
            walltime="00:10:00",
            python=sys.executable,
            log_directory=str(tmp_path),
            # The nodes of the tests have no memory to manage.
            job_directives_skip=["--mem"],
            scheduler_options={"dashboard_address": None},
        )
        stack.enter_context(workers).scale(jobs=2)
        there = run(Slow(scheduler=workers.scheduler_address), setups, tmp_path / "there")
        # A sweep that keeps numbers alone.
        for name, scheduler in (("alone", None), ("shared", workers.scheduler_address)):
            continued(replace(begun(tmp_path / name, finished=1), scheduler=scheduler), tmp_path / name)
    assert there.data.identical(here.data)
    assert (tmp_path / "alone" / DATASET).read_bytes() == (tmp_path / "shared" / DATASET).read_bytes()
