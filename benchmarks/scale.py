"""How the largest jobs grow: Dask workers, sweeps and their cells, records, seconds of motor, laws of a page.

    python benchmarks/scale.py [--load SECONDS] [--cells N] [--only TEXT] [--output CSV]

The table of docs/howto/sweep.md is `--output benchmarks/scale.csv`.

Load is simulated where the runs themselves are not the question: a task of the workers sleeps, so that more
workers than processors measure what the scheduler and contactlab add; a cell of the sweep has numbers
at once. Each job is a process of its own, whose greatest memory, or that of a process it starts, is given.
With `--only` the jobs are those whose names contain the text, and rows of the table take the place of theirs.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter, process_time, sleep
from typing import Any, ClassVar, final
from unittest import mock

import pandas as pd
import xarray

import contactlab as cl
from contactlab.estimate import Estimate
from contactlab.laws import LAWS
from contactlab.metrics import METRICS
from contactlab.studies.run_state import Status
from contactlab.studies.study import Part, Setups, Study, Task, run
from contactlab.studies.sweep.dataset import Outcome

WORKERS = 1, 2, 4, 8
TASKS_OF_A_WORKER = 50

RUNS = {
    "run of 100 s, 100 001 records": ["solver.duration=100", "record.interval=1e-3"],
    "run of 9.99 s, 9 990 001 records": ["solver.duration=9.99", "record.interval=1e-6"],
}
"""Overrides of runs, by what they are."""

SWEEPS = {
    "100 000 runs of 2 ms": [
        "-m",
        "drive.phase=linspace(-3,3,100000)",
        "solver.duration=2e-3",
        "sweep.keep=metrics",
    ],
    "10 000 steady states": [
        "steady",
        "-m",
        "study.refine=false",
        "drive.phase=linspace(-3,3,10000)",
        "sweep.keep=metrics",
    ],
}
"""Arguments of sweeps of the default motor, by what they are."""

BY = {"1 worker": (1, False), "2 workers": (2, False), "2 Dask workers": (2, True)}
"""Who does a sweep: how many processes, and whether a Dask scheduler gives them their tasks."""

JOB = "job"
HEADS = {
    "wall_s": "wall (s)",
    "efficiency": "efficiency",
    "processor_s": "processor (s)",
    "memory_MB": "memory (MB)",
}

LAWS_OF_A_PAGE = 30
NORMALS = "hertz_point", "linear", "jkr", "lining", "prony"
FRICTIONS = "coulomb", "stribeck", "mindlin", "bouc_wen"


def sleeping(seconds: float) -> Part:
    """Take some seconds [s] of nobody's processor."""
    sleep(seconds)
    return Part(xarray.DataTree(xarray.Dataset({"waited": seconds})))


@final
@dataclass(frozen=True, kw_only=True)
class Sleeping(Study):
    """How long do tasks take that do nothing?"""

    name: ClassVar[str] = "sleeping"
    seconds: float
    count: int

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return the tasks."""
        del setups
        return [Task(f"{k}", sleeping, (self.seconds,)) for k in range(self.count)]

    def combine(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> xarray.DataTree:
        """Return how many were done."""
        del setups
        return xarray.DataTree(xarray.Dataset({"done": len(parts)}))

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return none."""
        del data
        return {}


def dask_load(count: int, load: float) -> dict[str, float]:
    """Return how much of some Dask workers' time is load."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None) as cluster:
        address = cluster.scheduler_address
        # Workers import contactlab with their first task.
        run(Sleeping(seconds=2.0, count=2 * count, scheduler=address), {})
        study = Sleeping(seconds=load, count=TASKS_OF_A_WORKER * count, scheduler=address)
        start = perf_counter()
        run(study, {})
        wall = perf_counter() - start
    return {"wall_s": wall, "efficiency": TASKS_OF_A_WORKER * load / wall}


def at_once(*_: object) -> Outcome:
    """Return the outcome of a run that was not made."""
    return Outcome(Status.COMPLETE, numbers={key: 1.0 for key, each in METRICS.items() if each.usual})


def cells(count: int) -> None:
    """Plan and collect a grid of phases and clearances without its runs."""
    side = round(count**0.5)
    over = {"drive.phase": f"linspace(-3, 3, {side})", "contact.clearance": f"linspace(0, 2e-6, {side})"}
    with (
        tempfile.TemporaryDirectory() as folder,
        mock.patch("contactlab.studies.sweep.study._outcome", at_once),
    ):
        swept = cl.sweep(over, ["solver.duration=2e-3"], output=Path(folder) / "sweep", workers=1)
    assert swept.attrs["runs_complete"] == side**2


def page(count: int) -> None:
    """Compare some laws in four motors drawn, and write the page."""
    named = [[f"law={law}"] for law in LAWS if law not in ("archard", "composed")]
    parts = [["law=composed", f"law/normal={n}", f"law/friction={f}"] for n in NORMALS for f in FRICTIONS]
    with tempfile.TemporaryDirectory() as folder:
        cl.compare(
            [cl.build(each) for each in [*named, *parts][:count]],
            samples=4,
            starts=2,
            workers=1,
            output=folder,
        )


def command(*arguments: str) -> None:
    """Run the command, in a folder that is removed afterwards."""
    with tempfile.TemporaryDirectory() as folder:
        places = [f"hydra.run.dir={folder}/run", f"hydra.sweep.dir={folder}/sweep"]
        line = [sys.executable, "-m", "contactlab", *arguments, *places]
        subprocess.run(line, check=True, stdout=subprocess.DEVNULL)


def whole_sweep(line: list[str], workers: int, dask: bool) -> None:
    """Run every cell of a sweep by some processes, with or without a Dask scheduler that gives them tasks."""
    if not dask:
        command(*line, f"sweep.workers={workers}")
        return
    from distributed import LocalCluster

    with LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster:
        command(*line, f"study.scheduler={cluster.scheduler_address}")


def measured(task: Callable[..., object], *arguments: Any) -> dict[str, float]:
    """Return time and greatest memory of a task, in a process of its own with its children."""
    start, clock = perf_counter(), process_time()
    task(*arguments)
    usage = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    children = usage[1].ru_utime + usage[1].ru_stime
    return {
        "wall_s": perf_counter() - start,
        "processor_s": process_time() - clock + children,
        "memory_MB": max(each.ru_maxrss for each in usage) / 1024.0,
    }


def alone(task: Callable[..., object], *arguments: Any) -> dict[str, float]:
    """Measure a task in a fresh process."""
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        return pool.submit(measured, task, *arguments).result()


def main() -> None:
    """Measure, and print a row at a time."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--load", type=float, default=0.2)
    parser.add_argument("--cells", type=int, default=1_000_000)
    parser.add_argument("--only", default="", help="jobs whose names contain this")
    parser.add_argument("--output", type=Path)
    options = parser.parse_args()
    jobs: dict[str, Callable[[], Mapping[str, float]]] = {
        f"{count} Dask worker{'s' * (count > 1)}, tasks of {options.load:g} s": partial(
            dask_load, count, options.load
        )
        for count in WORKERS
    }
    for count in (options.cells // 100, options.cells // 10, options.cells):
        jobs[f"sweep of {count} cells, without its runs"] = partial(alone, cells, count)
    for what, line in SWEEPS.items():
        for who, processes in BY.items():
            jobs[f"sweep of {what}, {who}"] = partial(alone, whole_sweep, line, *processes)
    for what, values in RUNS.items():
        jobs[what] = partial(alone, command, *values)
    jobs[f"page of {LAWS_OF_A_PAGE} laws, 4 draws"] = partial(alone, page, LAWS_OF_A_PAGE)
    rows = {}
    for what, job in jobs.items():
        if options.only in what:
            rows[what] = job()
            print(
                f"{what}: " + ", ".join(f"{name} {value:.3g}" for name, value in rows[what].items()),
                flush=True,
            )
    if options.output:
        kept = pd.read_csv(options.output, index_col=JOB) if options.output.exists() else pd.DataFrame()
        table = pd.DataFrame.from_dict(rows, orient="index").rename(columns=HEADS).combine_first(kept)
        ordered = table.loc[[what for what in jobs if what in table.index], [*HEADS.values()]]
        ordered.to_csv(options.output, index_label=JOB, float_format="%.3g")


if __name__ == "__main__":
    main()
