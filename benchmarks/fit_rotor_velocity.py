"""Friction and stiffness of a Hertz contact from the rotor's velocity with 1 % noise: how well, and how long.

    python benchmarks/fit_rotor_velocity.py [--output DIR]

The data are made by `contactlab synthetic`, 2 ms of the default motor at 100 kHz. The fit is the
command as anybody gives it, its start, least squares, nested sampling, pictures and page included; what is
timed is the whole process.
"""

import argparse
import subprocess
import sys
from os import getloadavg
from pathlib import Path
from time import perf_counter

from contactlab.processes import processors

COMMAND = (sys.executable, "-m", "contactlab")
TRUTH = ("law=hertz_penalty", "law.stiffness=1e10", "contact.friction_coefficient=0.3")
RUN = ("solver.duration=2e-3", "record.interval=1e-5")
FREE = ("law.stiffness=1e9..1e11", "contact.friction_coefficient=0.1..0.5")
LONGEST = 60.0
"""Seconds that it may take."""


def timed(*text: str) -> float:
    """Run the command to its end, and give how long it took [s]."""
    began = perf_counter()
    subprocess.run([*COMMAND, *text], check=True)
    return perf_counter() - began


def main() -> int:
    """Make the data, fit them and tell the time; the exit status is 1 where it took too long."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--output", type=Path, default=Path("outputs/fit_rotor_velocity"))
    folder = parser.parse_args().output
    # What is compiled for the first time is compiled here.
    timed("synthetic", *TRUTH, *RUN, "noise=0.01", "--output", str(folder))
    seconds = timed("fit", str(folder / "synthetic.nc"), *FREE, "--output", str(folder))
    word = "under" if seconds < LONGEST else "OVER"
    print(
        f"\n{seconds:.1f} s for the whole process, {word} {LONGEST:.0f} s, on {processors()} processors with "
        f"a load of {getloadavg()[0]:.1f}."
    )
    return int(seconds >= LONGEST)


if __name__ == "__main__":
    sys.exit(main())
