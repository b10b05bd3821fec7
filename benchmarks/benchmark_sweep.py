"""What a run costs alone, in a batch, and as a job of a sweep: the table of docs/howto/sweep.md.

    python benchmarks/benchmark_sweep.py [--runs N] [--jobs N] [--repeats N]

Work: runs of 2 ms of the default motor over clearance and phase, each from its own configuration. The bare
engine simulates motors that are built already and keeps the last record; a batch builds each from its
configuration, runs it and takes the usual metrics. Batches and bare engine take turns. A job of a sweep
writes its folder, without picture; what a command needs to start is taken off by the difference of a long
and a short sweep.
"""

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from importlib.metadata import distributions
from pathlib import Path
from time import perf_counter

import numpy as np

from contactlab.config import Setup
from contactlab.processes import forked_pool
from contactlab.studies.study import run
from contactlab.studies.sweep.plan import Outputs, Plan, planned
from contactlab.studies.sweep.study import Sweep, composing

SETUPS: list[Setup] = []
"""What the bare engine runs; processes that are forked later have it too."""

DURATION = 2e-3
BLOCK = 500
"""Runs between two changes of the way."""


@dataclass(frozen=True)
class Row:
    """A way to run, and the time that a run takes [s]."""

    way: str
    seconds: float


def plan_with(runs: int) -> Plan:
    """Some runs over clearance and phase."""
    rows = max(round(np.sqrt(runs)), 1)
    over = {
        "contact.clearance": [f"linspace(0,2e-6,{rows})"],
        "drive.phase": [f"linspace(-3,3,{max(runs // rows, 1)})"],
    }
    return planned(composing([f"solver.duration={DURATION}"]), over, Outputs())


def bare(cells: range) -> None:
    """Run cells by the engine alone."""
    for setup in (SETUPS[cell] for cell in cells):
        setup.run(record_interval=setup.duration)


def in_batches(plan: Plan, repeats: int) -> list[Row]:
    """Bare engine and batch, on one processor and on two, in turns.

    Every way runs the same block of runs one after the other, and its shortest time for a block counts: what
    else the machine does only ever makes it longer.
    """
    SETUPS[:] = [plan.setup_at(cell) for cell in range(plan.cells)]
    blocks = [range(i, min(i + BLOCK, plan.cells)) for i in range(0, plan.cells, BLOCK)]

    def swept(workers: int, cells: range) -> None:
        run(Sweep(plan=replace(plan.rows(cells), chunk=plan.chunk), workers=workers), {})

    Sweep.delay = 0.0
    with forked_pool(2) as independent:
        ways: dict[str, Callable[[range], object]] = {
            "bare engine": bare,
            "batch, one process": partial(swept, 1),
            "batch, two processes": partial(swept, 2),
            "bare engine, two independent processes": lambda cells: independent.map(
                bare, [cells[0::2], cells[1::2]]
            ),
        }
        # The first time is for the compiler and for the workers to start.
        for work in ways.values():
            work(blocks[0])
        times = np.array(
            [[[timed(work, cells) for work in ways.values()] for cells in blocks] for _ in range(repeats)]
        )
    shortest = times.min(axis=0).sum(axis=0) / plan.cells
    return [Row(way, float(took)) for way, took in zip(ways, shortest, strict=True)]


def timed(work: Callable[[range], object], cells: range) -> float:
    """Time of some runs [s]."""
    start = perf_counter()
    work(cells)
    return perf_counter() - start


def in_sweeps(jobs: int, repeats: int) -> list[Row]:
    """A job of a sweep by Hydra's launchers, as whole commands."""
    launchers = {"job of -m, basic launcher": []}
    if "hydra-joblib-launcher" in {result.name for result in distributions()}:
        launchers["job of -m, joblib with two workers"] = ["hydra/launcher=joblib", "hydra.launcher.n_jobs=2"]
    few = max(jobs // 4, 1)
    return [
        Row(way, min((sweep(arguments, jobs + few) - sweep(arguments, few)) / jobs for _ in range(repeats)))
        for way, arguments in launchers.items()
    ]


def sweep(arguments: list[str], jobs: int) -> float:
    """Time of a whole sweep [s]."""
    phases = ",".join(f"{phase:.6g}" for phase in np.linspace(-3.0, 3.0, jobs))
    own = [f"drive.phase={phases}", f"solver.duration={DURATION}", "record.picture=false"]
    with tempfile.TemporaryDirectory() as folder:
        start = perf_counter()
        subprocess.run(
            [sys.executable, "-m", "contactlab", "-m", *own, *arguments, "hydra.sweep.dir=sweep"],
            cwd=Path(folder),
            check=True,
            stdout=subprocess.DEVNULL,
        )
        return perf_counter() - start


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=2000, help="in a batch")
    parser.add_argument("--jobs", type=int, default=16, help="of a sweep")
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    batches = in_batches(plan_with(options.runs), options.repeats)
    alone, item, two, ceiling = (row.seconds for row in batches)
    print("| way | time a run | runs a second |\n|---|---|---|")
    for row in (*batches, *in_sweeps(options.jobs, max(options.repeats // 2, 1))):
        print(f"| {row.way} | {1e3 * row.seconds:.3g} ms | {1.0 / row.seconds:.3g} |")
    print(
        f"\nA run in a batch takes {item / alone:.3f} times as long as alone. Two processes of a batch are "
        f"{item / two:.2f} times as quick as one; this machine lets two independent processes of the bare "
        f"engine be {alone / ceiling:.2f} times as quick."
    )


if __name__ == "__main__":
    main()
