"""Random free flights through the engine: not one touch-down missed, late or invented.

    python experiments/random_flights.py [--flights N] [--workers N] [--seed N] [--csv FILE]

Every flight is also searched on a dense grid, in closed form (`contactlab.testing.flights.closed`), which
knows nothing of the bound by which the engine passes over stretches of flight. A touch-down is wrong
where it differs from the reference by more than 1e-15 s and what float64 leaves uncertain. The figures
depend on the seed and the number of flights alone. The status is 1 where a flight went wrong;
`contactlab.testing.flights.randomly.random_flight(seed, number)` gives such a flight again.
"""

import argparse
import csv
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, fields
from functools import reduce
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter

from tqdm import tqdm

from contactlab.testing.flights.randomly import KINDS, Tally, added, fly

CHUNK = 100
"""Flights a task: a fraction of a second, so that the workers end together."""


def measure(flights: int, workers: int, seed: int) -> dict[str, Tally]:
    """Run flights 0 to `flights` - 1 of a seed; returns a tally for every kind."""
    chunks = [range(i, min(i + CHUNK, flights)) for i in range(0, flights, CHUNK)]
    tallies = {kind: Tally() for kind in KINDS}
    # Started afresh, workers are the same on every system; each loads the compiled engine once.
    with (
        ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool,
        tqdm(total=flights, unit=" flights", disable=None) as bar,
    ):
        tasks = {pool.submit(fly, seed, chunk): len(chunk) for chunk in chunks}
        for task in as_completed(tasks):
            tallies = {kind: added(tallies[kind], part) for kind, part in task.result().items()}
            bar.update(tasks[task])
    return tallies


def write_table(tallies: dict[str, Tally], seed: int, path: Path) -> None:
    """One row a kind, SI units."""
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["seed", "kind", *(item.name for item in fields(Tally))])
        for kind, tally in tallies.items():
            writer.writerow([seed, kind, *asdict(tally).values()])


def show(tallies: dict[str, Tally]) -> None:
    """Print one row a kind and one for all."""
    heads = ("flights", "touched", "missed", "invented", "late", "error", "excess", "worst")
    print(f"{'kind':14s}" + "".join(f"{head:>10s}" for head in heads))
    rows = {**tallies, "all": reduce(added, tallies.values())}
    for kind, t in rows.items():
        counts = (t.flights, t.touched, t.missed, t.invented, t.late)
        times = (t.largest_error, t.largest_excess)
        cells = [*(f"{n:10d}" for n in counts), *(f"{s:10.1e}" for s in times), f"{t.worst:10d}"]
        print(f"{kind:14s}" + "".join(cells))
    print(
        "error: largest [s]; excess: over round-off [s]; worst: number of the flight it belongs to"
    )


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
    tallies = measure(options.flights, options.workers, options.seed)
    show(tallies)
    write_table(tallies, options.seed, options.csv)
    print(f"{perf_counter() - start:.0f} s; written to {options.csv}")
    return 1 if any(tally.faults for tally in tallies.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
