"""Random free flights through the engine: not one touch-down missed, late or invented.

    python tests/tools/random_flights.py [--flights N] [--workers N] [--seed N] [--csv FILE]

Every flight is also searched on a dense grid, in closed form (`contactlab.testing.flights`), which knows
nothing of the bound by which the engine passes over stretches of flight. A touch-down is wrong where it
differs from the reference by more than 1e-15 s and what float64 leaves uncertain. The figures depend on
the seed and the number of flights alone. The status is 1 where a flight went wrong;
`contactlab.testing.flights.random_flight(seed, number)` gives such a flight again.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from time import perf_counter

import pandas as pd
from chunks import in_chunks

from contactlab.testing.references import FAULTS, judged, tally

CHUNK = 100
"""Flights a task: a fraction of a second, so that the workers end together."""


def measure(flights: int, workers: int, seed: int) -> pd.DataFrame:
    """Run flights 0 to `flights` - 1 of a seed; gives a row for each, see `judged`."""
    return in_chunks(partial(judged, seed), range(flights), CHUNK, workers)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, print and write the table; returns the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--flights", type=int, default=100_000, help="how many flights")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes")
    parser.add_argument("--seed", type=int, default=0, help="of the random generator")
    parser.add_argument("--csv", type=Path, default=Path("random_flights.csv"), help="the table")
    options = parser.parse_args(arguments)
    # Matrices this small are slower on threads, and the workers take all cores already.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    start = perf_counter()
    flights = measure(options.flights, options.workers, options.seed)
    table = tally(flights)
    print(pd.concat([table, tally(flights.assign(kind="all"))]).to_string(float_format="%.1e"))
    print("error: largest [s]; excess: over round-off [s]; worst: number of the flight that has it")
    table.assign(seed=options.seed).to_csv(options.csv)
    print(f"{perf_counter() - start:.0f} s; written to {options.csv}")
    return int(flights[list(FAULTS)].to_numpy().any())


if __name__ == "__main__":
    sys.exit(main())
