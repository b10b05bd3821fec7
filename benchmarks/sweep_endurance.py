"""A hundred thousand runs in one command, killed on the way: the same bits, and memory that stays flat.

    python benchmarks/sweep_endurance.py [--runs N] [--kills N] [--workers N]

The sweep is made twice: once undisturbed, while the resident memory of all its processes is
watched, and once killed with SIGKILL at random moments and started again. The two files must be the same to
the last byte. The status is 1 where they are not.
"""

import argparse
import random
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from time import perf_counter, sleep

import numpy as np

from contactlab.studies.runner import TASKS
from contactlab.studies.sweep.dataset import DATASET

DURATION = 2e-3
LOOK = 0.2
"""Seconds between two looks at the memory."""


def command(runs: int, workers: int, folder: Path) -> list[str]:
    """Return the sweep of some runs over clearance and phase."""
    rows = max(round(np.sqrt(runs)), 1)
    return [
        *(sys.executable, "-m", "contactlab", "-m", "sweep.keep=metrics"),
        *(f"hydra.sweep.dir={folder}", f"sweep.workers={workers}"),
        f"sweep.chunk={max(runs // 100, 1)}",
        f"solver.duration={DURATION}",
        f"contact.clearance=linspace(0,2e-6,{rows})",
        f"drive.phase=linspace(-3,3,{max(runs // rows, 1)})",
    ]


def undisturbed(runs: int, workers: int, folder: Path) -> tuple[float, list[float]]:
    """Time [s], and the memory of all processes of the command [MB] while it ran."""
    start = perf_counter()
    memory = []
    with subprocess.Popen(command(runs, workers, folder), stdout=subprocess.DEVNULL) as running:
        while running.poll() is None:
            # Only while chunks are at work, not while it starts or ends.
            if (folder / TASKS).is_dir():
                memory.append(sum(resident(process) for process in family(running.pid)))
            sleep(LOOK)
    if running.returncode:
        raise SystemExit(f"The sweep ended with status {running.returncode}.")
    return perf_counter() - start, memory


def killed(runs: int, kills: int, workers: int, folder: Path, seconds: float) -> list[int]:
    """Kill the sweep some times, then let it end; the chunks that were finished at each kill."""
    choice = random.Random(0)
    result = []
    for _ in range(kills):
        with subprocess.Popen(command(runs, workers, folder), stdout=subprocess.DEVNULL) as running:
            before = finished(folder)
            while finished(folder) == before and running.poll() is None:
                sleep(0.01)
            sleep(choice.uniform(0.0, 0.5 * seconds / (kills + 1)))
            running.send_signal(signal.SIGKILL)
        result.append(finished(folder))
    subprocess.run(command(runs, workers, folder), check=True, stdout=subprocess.DEVNULL)
    return result


def finished(folder: Path) -> int:
    """Count the finished tasks in the folder of a sweep."""
    return len(list((folder / TASKS).glob("*-*.nc")))


def family(process: int) -> Iterator[int]:
    """A process and all that it started."""
    yield process
    try:
        children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    except OSError:
        return
    for child in children:
        yield from family(int(child))


def resident(process: int) -> float:
    """Memory that a process alone keeps [MB]; 0 for one that has ended."""
    try:
        lines = Path(f"/proc/{process}/smaps_rollup").read_text().splitlines()
    except OSError:
        return 0.0
    # A fork shares most of its memory: its own part of what is shared counts.
    return sum(int(line.split()[1]) for line in lines if line.startswith("Pss:")) / 1024.0


def main() -> int:
    """Make both sweeps and compare them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=100_000)
    parser.add_argument("--kills", type=int, default=3)
    parser.add_argument("--workers", type=int, default=2)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        whole, cut = Path(place) / "whole", Path(place) / "cut"
        seconds, memory = undisturbed(options.runs, options.workers, whole)
        third = max(len(memory) // 3, 1)
        print(
            f"{options.runs} runs of {DURATION:g} s by {options.workers} processes in {seconds:.1f} s, "
            f"{1e3 * seconds / options.runs:.3f} ms each."
        )
        if memory:
            print(
                f"Memory: at most {max(memory[:third]):.0f} MB in the first third, "
                f"{max(memory[-third:]):.0f} MB in the last."
            )
        chunks = killed(options.runs, options.kills, options.workers, cut, seconds)
        print(f"Killed {options.kills} times, with {', '.join(map(str, chunks))} chunks finished.")
        same = (whole / DATASET).read_bytes() == (cut / DATASET).read_bytes()
    print("The two files are the same." if same else "The two files differ.")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
