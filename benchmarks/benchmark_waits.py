"""What users wait for: processor time of commands, first runs, records, motors and batches.

    python benchmarks/benchmark_waits.py [repeats] [--other PYTHON]... [--only TEXT] [--keep]

Every row is a process of its own, timed from outside (user and system time with its children), the median of
some repeats. With other environments' interpreters, as those of earlier versions, all run in turn, and a
ratio is that of the medians, this version's over another's; a row that another cannot run is not a number.
Commands are warm; *first run* begins with an empty folder of compiled code.
`--keep` puts the rows into waits.csv, from which experiments/results_pages.py writes docs/accuracy.md. A page
has differences of two rows, without what a process does once: it starts, and loads compiled code.
"""

import argparse
import csv
import os
import resource
import subprocess
import sys
import tempfile
from math import nan
from pathlib import Path
from statistics import median

MOTOR = "import contactlab as cl; s = cl.build(['law={law}', 'record.picture=false']); m = s.motor; "
RUN = "[cl.simulate(m, s.law, duration={duration}, record_interval={interval}) for _ in range({times})]"

COMMANDS = {
    "import contactlab": ["-c", "import contactlab"],
    "help": ["-m", "contactlab", "help"],
    "laws": ["-m", "contactlab", "laws"],
    "--help": ["-m", "contactlab", "--help"],
    "run of 20 ms, with picture": ["-m", "contactlab", "hydra.run.dir=run"],
    "run of 20 ms, without": ["-m", "contactlab", "hydra.run.dir=run", "record.picture=false"],
    "steady": ["-m", "contactlab", "steady", "hydra.run.dir=steady"],
    "10 jobs of -m": ["-m", "contactlab", "-m", "drive.phase=linspace(-1,1,10)", "record.picture=false",
                      "solver.duration=2e-3", "hydra.sweep.dir=jobs"],
    "collect of these": ["-m", "contactlab", "collect", "jobs"],
    "compare, at most 8 draws": ["-m", "contactlab", "compare", "law=newton,hertz_penalty", "samples=8",
                         "output=comparison"],
}  # fmt: skip

LAWS = ("hertz_penalty", "lagrange_stick", "newton")

KEPT = Path(__file__).with_name("waits.csv")
"""Processor time by row [s], as the page has it."""

FEW, MANY = 20, 2000
"""Runs of two sweeps, whose difference is that of the runs."""


def rows() -> dict[str, list[str]]:
    """Return the arguments of an interpreter by row."""
    result = dict(COMMANDS)
    for law in (*LAWS, "lagrange_ageing"):
        short = RUN.format(duration=2e-3, interval=2e-3, times=1)
        result[f"first run, {law}"] = ["-c", MOTOR.format(law=law) + short]
    for law in LAWS:
        for times in (1, 6):
            second = RUN.format(duration=1.0, interval=1.0, times=times)
            result[f"{times} motor seconds, {law}"] = ["-c", MOTOR.format(law=law) + second]
        dense = RUN.format(duration=0.2, interval=1e-6, times=1)
        result[f"0.2 s at 1 us, {law}"] = ["-c", MOTOR.format(law=law) + dense]
        for times in (1, 501):
            brief = RUN.format(duration=2e-3, interval=2e-3, times=times)
            result[f"{times} runs of 2 ms, {law}"] = ["-c", MOTOR.format(law=law) + brief]
        for count in (FEW, MANY):
            line = f"law={law} drive.phase=linspace(-1,1,{count}) solver.duration=2e-3 sweep.keep=metrics"
            swept = ["-m", "contactlab", "-m", *line.split(), "sweep.workers=1"]
            result[f"{count} runs of a sweep, {law}"] = swept
    for law in (*LAWS, "lagrange_slip"):
        for times in (1, 101):
            states = f"[cl.steady(s) for _ in range({times})]"
            result[f"{times} steady states, {law}"] = ["-c", MOTOR.format(law=law) + states]
    return result


def seconds(python: str, name: str, arguments: list[str], folder: str) -> float:
    """Return the processor time of a process [s]; a sweep or a comparison is run anew.

    An earlier version may lack what a row asks of it: then the time is not a number.
    """
    environment = dict(os.environ)
    if name.startswith("first run"):
        environment["NUMBA_CACHE_DIR"] = tempfile.mkdtemp(dir=folder)
    if name.startswith(("10 jobs", "compare")) or "of a sweep" in name:
        subprocess.run(["rm", "-rf", "jobs", "multirun", "comparison"], cwd=folder, check=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [python, *arguments], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode and python != sys.executable:
        return nan
    if done.returncode:
        raise RuntimeError(f"{name}: {done.stderr[-500:]}")
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def kept() -> dict[str, float]:
    """Return the processor times that were kept by row [s]."""
    with KEPT.open(encoding="utf-8", newline="") as file:
        return {row["row"]: float(row["processor time (s)"]) for row in csv.DictReader(file)}


def keep(times: dict[str, float]) -> None:
    """Put processor times [s] into the file in place of those of the same rows, in the order of all rows."""
    times = (kept() if KEPT.exists() else {}) | times
    with KEPT.open("w", encoding="utf-8", newline="") as file:
        lines = ((name, f"{times[name]:.4g}") for name in rows() if name in times)
        csv.writer(file, lineterminator="\n").writerows([("row", "processor time (s)"), *lines])


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("repeats", nargs="?", type=int, default=3)
    parser.add_argument("--other", action="append", default=[], help="interpreter of another environment")
    parser.add_argument("--only", default="", help="rows whose names contain this")
    parser.add_argument("--keep", action="store_true", help=f"put the rows into {KEPT.name}")
    arguments = parser.parse_args()
    measured: dict[str, float] = {}
    pythons = [sys.executable, *arguments.other]
    with tempfile.TemporaryDirectory() as root:
        folders = [tempfile.mkdtemp(dir=root) for _ in pythons]
        for name, line in rows().items():
            if arguments.only not in name:
                continue
            cold = name.startswith("first run")
            taken: list[list[float]] = [[] for _ in pythons]
            # The first of each warms up what is on the disk.
            for repeat in range(1 if cold else arguments.repeats + 1):
                for times, python, folder in zip(taken, pythons, folders, strict=True):
                    spent = seconds(python, name, line, folder)
                    if repeat or cold:
                        times.append(spent)
            figures = [median(times) for times in taken]
            ratios = "".join(f"  {figures[0] / other:6.3f}" for other in figures[1:])
            measured[name] = figures[0]
            print(f"{name:35}" + "".join(f"{figure:9.2f} s" for figure in figures) + ratios, flush=True)
    if arguments.keep:
        keep(measured)


if __name__ == "__main__":
    main()
