"""Random motors through the command's own configuration, judged from their results alone.

    python experiments/random_runs.py [--motors N] [--workers N] [--seed N] [--first N] [--csv FILE]
                                      [--page docs/random_runs.md]

Every configuration is far wider than a workshop's (`random_configuration`). A run that does not end as
complete must say why; one that does must keep every invariant (`contactlab.metrics.INVARIANTS`): closed
ledgers of energy, momentum and impulse, no contact without length, none missed, no release while the gap
closes, peaks and depths that no record exceeds. What a law promises of friction and tension is reported
beside it. The table has the worst figure of every law. The status is 1 where an invariant is broken; the
command line of every such run is printed.
"""

import argparse
import csv
import os
import shlex
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import lru_cache
from math import isnan, nan
from multiprocessing import get_context
from pathlib import Path
from time import perf_counter
from typing import Any, Final

from harness import with_values
from random_configuration import COMPOSED, random_configuration
from tqdm import tqdm

from contactlab.config import ConfigurationError, build, compose
from contactlab.engine import simulate
from contactlab.metrics import FAIL, INVARIANTS, METRICS, Run, assess

LAWFUL: Final = (
    "tension",
    "cone_excess",
    "friction_gain",
    "normal_gain",
    "contact_gain",
    "stick_slip",
)
"""Metrics of what most laws promise; some declare that they break them."""

CHUNK: Final = 20
"""Motors a task."""

REFUSED: Final = "refused"


@dataclass(frozen=True)
class Outcome:
    """What became of one configuration.

    Args:
        number: of the configuration.
        law: the law's name, with the friction's of a composed one.
        ending: of the run, or REFUSED.
        message: why it did not reach its end.
        contacts: how many.
        steps: of the solver, rejected ones included.
        seconds: that it took.
        figures: metrics by key.
    """

    number: int
    law: str
    ending: str
    message: str = ""
    contacts: int = 0
    steps: int = 0
    seconds: float = 0.0
    figures: Mapping[str, float] | None = None

    @property
    def broken(self) -> list[str]:
        """Invariants that a complete run breaks."""
        figures = self.figures or {}
        judged = self.ending == "complete"
        return [k for k, m in INVARIANTS.items() if judged and m.verdict(figures[k]) == FAIL]


@lru_cache
def _base(groups: frozenset[tuple[str, str]]) -> dict[str, Any]:
    return compose([f"{group}={option}" for group, option in sorted(groups)])


def outcome_of(number: int, seed: int = 0) -> Outcome:
    """Run one random configuration and take its figures."""
    groups, values = random_configuration(number, seed)
    law = groups["law"]
    name = f"{law}, {groups['law/friction']}" if law == COMPOSED else law
    started = perf_counter()
    try:
        setup = build(with_values(_base(frozenset(groups.items())), values))
    except ConfigurationError as fault:
        return Outcome(number, name, REFUSED, str(fault))
    run = simulate(
        setup.motor,
        setup.law,
        duration=setup.duration,
        record_interval=min(setup.record_interval, setup.duration),
        contact_step=setup.contact_step,
        tolerance=setup.tolerance,
    )
    record = Run.of_trajectory(run, setup.configuration)
    steps = ("flight_steps", "contact_steps", "rejected_steps")
    return Outcome(
        number=number,
        law=name,
        ending=run.ending.name.lower(),
        message=run.message,
        contacts=len(run.contacts["start_time"]),
        steps=sum(run.statistics[name] for name in steps),
        seconds=perf_counter() - started,
        figures=assess(record, {*INVARIANTS, *LAWFUL}),
    )


def outcomes_of(numbers: Iterable[int], seed: int = 0) -> list[Outcome]:
    """Run some configurations, one after the other."""
    return [outcome_of(number, seed) for number in numbers]


def search(numbers: range, workers: int, seed: int) -> list[Outcome]:
    """Run configurations in several processes; the outcomes in order of their numbers."""
    chunks = [numbers[i : i + CHUNK] for i in range(0, len(numbers), CHUNK)]
    found: list[Outcome] = []
    with (
        ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool,
        tqdm(total=len(numbers), unit=" motors", disable=None) as bar,
    ):
        tasks = {pool.submit(outcomes_of, chunk, seed): len(chunk) for chunk in chunks}
        for task in as_completed(tasks):
            found += task.result()
            bar.update(tasks[task])
    return sorted(found, key=lambda outcome: outcome.number)


def worst(outcomes: Sequence[Outcome], key: str) -> float:
    """Largest figure of the runs that say complete; NaN where none has it."""
    figures = [o.figures[key] for o in outcomes if o.figures and o.ending == "complete"]
    return max((figure for figure in figures if not isnan(figure)), default=nan)


def table(outcomes: Sequence[Outcome]) -> list[dict[str, object]]:
    """One row a law: how its runs end, and the worst of every figure among the complete ones."""
    rows: list[dict[str, object]] = []
    for law in sorted({o.law for o in outcomes}):
        of_law = [o for o in outcomes if o.law == law]
        endings = Counter(o.ending for o in of_law)
        row: dict[str, object] = {
            "law": law,
            "motors": len(of_law),
            "contacts": sum(o.contacts for o in of_law),
            "endings": ", ".join(f"{count} {ending}" for ending, count in endings.most_common()),
            "longest": max(o.seconds for o in of_law),
        }
        rows.append(row | {key: worst(of_law, key) for key in (*INVARIANTS, *LAWFUL)})
    return rows


def page(outcomes: Sequence[Outcome], command: str) -> str:
    """The table as Markdown: laws in rows, the worst figures of their complete runs in columns."""
    rows = table(outcomes)
    heads = ["law", "motors", "contacts", "endings"]
    lines = [
        "# Random motors",
        "",
        f"<!-- Made by {command}. Do not edit. -->",
        "",
        f"{len(outcomes)} random configurations of the command, far wider than a workshop's, judged from "
        "their results alone (`experiments/random_runs.py`). A refused configuration was told so in a "
        "sentence before it ran; a run that is not complete says why. The second table has the worst figure "
        "of every invariant among the complete runs; what each means and why its bound is what it is stands "
        "in [plausibility.md](plausibility.md). `contactlab verify RUN` holds any recorded run to them.",
        "",
        _cells(heads),
        _cells(["---"] * len(heads)),
        *(_cells([row[head] for head in heads]) for row in rows),
        "",
        _cells(["worst of", *INVARIANTS]),
        _cells(["---"] * (1 + len(INVARIANTS))),
        _cells(["bound", *(f"{metric.bound:g}" for metric in INVARIANTS.values())]),
        *(_cells([row["law"], *(f"{row[key]:.1e}" for key in INVARIANTS)]) for row in rows),
        "",
    ]
    broken = sum(bool(outcome.broken) for outcome in outcomes)
    lines += [f"Complete runs that break an invariant: {broken}.", ""]
    return "\n".join(lines)


def _cells(cells: Iterable[object]) -> str:
    return f"| {' | '.join(map(str, cells))} |"


def command_line(number: int, seed: int = 0) -> str:
    """The command that runs a configuration."""
    groups, values = random_configuration(number, seed)
    words = [f"{group}={option}" for group, option in groups.items()]
    words += [f"{key}={'null' if value is None else value}" for key, value in values.items()]
    return shlex.join(["contactlab", *words])


def show(outcomes: Sequence[Outcome], seed: int) -> None:
    """Print the table, how runs ended that are not complete, and every broken invariant."""
    rows = table(outcomes)
    width = max(len(str(row["law"])) for row in rows)
    print(f"{'law':{width}} {'motors':>7} {'contacts':>9} {'longest':>8}  endings")
    for row in rows:
        counts = f"{row['motors']:>7} {row['contacts']:>9} {row['longest']:7.1f}s"
        print(f"{row['law']:{width}} {counts}  {row['endings']}")
    print("\nWorst figure of the runs that say complete:")
    for key in (*INVARIANTS, *LAWFUL):
        print(f"\n{key} (<= {METRICS[key].bound:g})")
        print(*(f"{row['law']:{width}} {row[key]:.1e}" for row in rows), sep="\n")
    for outcome in outcomes:
        if outcome.ending not in {"complete", REFUSED}:
            print(f"\n{outcome.number} {outcome.law}: {outcome.ending}. {outcome.message}")
    for outcome in outcomes:
        if outcome.broken:
            figures = outcome.figures or {}
            said = ", ".join(f"{key} {figures[key]:.3g}" for key in outcome.broken)
            print(f"\nBroken: {outcome.number} {outcome.law}: {said}")
            print(f"  {command_line(outcome.number, seed)}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, print and write the table; returns the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--motors", type=int, default=10_000, help="how many motors")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes")
    parser.add_argument("--seed", type=int, default=0, help="of the random generator")
    parser.add_argument("--csv", type=Path, default=Path("random_runs.csv"), help="the table")
    parser.add_argument("--page", type=Path, help="the table as a page")
    options = parser.parse_args(arguments)
    # Matrices this small are slower on threads, and the workers take all cores already.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    numbers = range(options.first, options.first + options.motors)
    outcomes = search(numbers, options.workers, options.seed)
    show(outcomes, options.seed)
    with options.csv.open("w", newline="") as file:
        rows = table(outcomes)
        writer = csv.DictWriter(file, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
    if options.page:
        command = (
            f"python experiments/random_runs.py --motors {options.motors} --seed {options.seed}"
        )
        options.page.write_text(page(outcomes, command), encoding="utf-8")
    return 1 if any(outcome.broken for outcome in outcomes) else 0


if __name__ == "__main__":
    sys.exit(main())
