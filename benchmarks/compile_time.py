"""Time that the compiler takes for a first run, in two checkouts in turn.

    python benchmarks/compile_time.py BEFORE AFTER [--repeats 3] [--most 1.1]

BEFORE and AFTER are folders of a checkout each, such as a work tree of the parent commit and this one. A
compliant and a rigid law run for the first time, with nothing compiled before; the least processor time of
the repeats is compared, and the number of functions that are compiled. With `--most` the exit status is 1
where AFTER takes more than so many times as long as BEFORE.
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
import json, sys, time
from numba.core import event
import contactlab as cl

compiled = []

class Counter(event.Listener):
    def on_start(self, _): pass
    def on_end(self, made): compiled.append(made.data["dispatcher"].__name__)

setup = cl.build([f"law={sys.argv[1]}", "solver.duration=1 ms"])
began = time.process_time()
with event.install_listener("numba:compile", Counter()):
    cl.simulate(setup)
print(json.dumps([time.process_time() - began, len(compiled)]))
"""


def first_run(checkout: Path, law: str) -> tuple[float, int]:
    """Return processor time [s] and number of compiled functions of a first run."""
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-c", RUN, law],
            cwd=checkout,
            env={**os.environ, "NUMBA_CACHE_DIR": folder, "PYTHONPATH": str(checkout.resolve())},
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        )
    seconds, functions = json.loads(done.stdout)
    return seconds, functions


def main() -> int:
    """Print both times, their ratio and the number of functions by family of laws."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("checkouts", metavar="CHECKOUT", type=Path, nargs=2)
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument(
        "--most", type=float, default=float("inf"), help="ratio above which the exit status is 1"
    )
    read = parser.parse_args()
    print("family       before      after  ratio  functions")
    status = 0
    for family, law in LAWS.items():
        runs = [[first_run(checkout, law) for checkout in read.checkouts] for _ in range(read.repeats)]
        # In turn, so that both meet the same load; what is least has met none.
        (before, earlier), (after, later) = (min(times) for times in zip(*runs, strict=True))
        print(
            f"{family:9}{before:8.1f} s{after:9.1f} s{after / before:7.3f}  {earlier} -> {later}", flush=True
        )
        status = max(status, int(after > read.most * before))
    return status


if __name__ == "__main__":
    sys.exit(main())
