"""Time that the compiler takes for a first run, in two checkouts in turn.

    python benchmarks/compile_time.py BEFORE AFTER [--repeats 3] [--most 1.1]

BEFORE and AFTER are folders of a checkout each, such as a work tree of the parent commit and this one. A
compliant and a rigid law run for the first time, with nothing compiled before; the least processor time of
the repeats is compared, that of all processes that share the work, and so is that of the run's own process
alone, for which one waits where there is a processor for each. With `--most` the exit status is 1 where AFTER
takes more than so many times as long as BEFORE.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Final

LAWS: Final = {"compliant": "hertz_penalty", "rigid": "newton"}
"""A law by family."""

RUN: Final = """
import json, os, sys, time
import contactlab as cl

setup = cl.build([f"law={sys.argv[1]}", "solver.duration=1 ms"])
began = time.process_time()
cl.simulate(setup)
own, others = time.process_time() - began, sum(os.times()[2:4])
print(json.dumps([own + others, own]))
"""


def first_run(checkout: Path, law: str) -> tuple[float, float]:
    """Return processor times [s] of a first run: of all its processes, and of its own."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-c", RUN, law],
            cwd=checkout,
            env={**os.environ, "NUMBA_CACHE_DIR": folder, "PYTHONPATH": str(checkout.resolve())},
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        )
    every, own = json.loads(done.stdout)
    return every, own


def main() -> int:
    """Print both times, their ratio and the number of functions by family of laws."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("checkouts", metavar="CHECKOUT", type=Path, nargs=2)
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument(
        "--most", type=float, default=float("inf"), help="ratio above which the exit status is 1"
    )
    read = parser.parse_args()
    print("family       before      after  ratio  own process")
    status = 0
    for family, law in LAWS.items():
        runs = [[first_run(checkout, law) for checkout in read.checkouts] for _ in range(read.repeats)]
        # In turn, so that both meet the same load; what is least has met none.
        (before, earlier), (after, later) = (min(times) for times in zip(*runs, strict=True))
        own = f"{earlier:.1f} s -> {later:.1f} s"
        print(f"{family:9}{before:8.1f} s{after:9.1f} s{after / before:7.3f}  {own}", flush=True)
        status = max(status, int(after > read.most * before))
    return status


if __name__ == "__main__":
    sys.exit(main())
