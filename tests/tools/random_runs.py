"""Random motors through the command's own configuration, judged from their results alone.

    python tests/tools/random_runs.py [--motors N] [--workers N] [--seed N] [--first N] [--csv FILE]
                                      [--page docs/random_runs.md]

Every configuration is far wider than a workshop's (`random_configuration`). A run that does not end as
complete must say why; one that does must keep every invariant (`contactlab.metrics.INVARIANTS`): closed
ledgers of energy, momentum and impulse, no contact without length, none missed, no release while the gap
closes, peaks and depths that no record exceeds. What a law promises of friction and tension is reported
beside it. The table has the worst figure of every law. The status is 1 where an invariant is broken; the
command line of every such run is printed.
"""

import argparse
import json
import os
import shlex
import sys
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache, partial
from pathlib import Path
from time import perf_counter
from typing import Any, Final

import pandas as pd
from chunks import in_chunks
from random_configuration import COMPOSED, random_configuration

import contactlab as cl
from contactlab.config import compose
from contactlab.config.nesting import flat, nested
from contactlab.metrics import FAIL, INVARIANTS, METRICS, assess

FIGURES: Final = (
    *INVARIANTS,
    *("tension", "cone_excess", "friction_gain", "normal_gain", "contact_gain", "stick_slip"),
)
"""The invariants, and metrics of what most laws promise; some declare that they break them."""

CHUNK: Final = 20
"""Motors a task."""

COMPLETE, REFUSED = "complete", "refused"


@lru_cache
def _base(groups: frozenset[tuple[str, str]]) -> dict[str, Any]:
    """The values by full key where these options are chosen."""
    return flat(compose([f"{group}={option}" for group, option in sorted(groups)]))


def outcome_of(number: int, seed: int = 0) -> dict[str, Any]:
    """Run one random configuration.

    Returns:
        Its `number`, its `law` with the friction's name of a composed one, the `ending` of the run or
        REFUSED, the `message` why it did not reach its end, `contacts`, `steps` of the solver with the
        rejected ones, `seconds` that it took, and its figures.
    """
    groups, values = random_configuration(number, seed)
    law = groups["law"]
    name = f"{law}, {groups['law/friction']}" if law == COMPOSED else law
    started = perf_counter()
    try:
        setup = cl.build(nested(_base(frozenset(groups.items())) | values))
    except cl.ConfigurationError as fault:
        outcome = {"ending": REFUSED, "message": str(fault), "contacts": 0, "steps": 0}
        return {"number": number, "law": name, "seconds": 0.0, **outcome}
    run = cl.simulate(setup, record_interval=min(setup.record_interval, setup.duration))
    statistics = json.loads(run.tree.attrs["solver_statistics"])
    steps = ("flight_steps", "contact_steps", "rejected_steps")
    return {
        "number": number,
        "law": name,
        "seconds": perf_counter() - started,
        "ending": run.ending.name.lower(),
        "message": run.message,
        "contacts": run.contacts.start_time.size,
        "steps": sum(statistics[name] for name in steps),
        **assess(run.tree, set(FIGURES)),
    }


def broken(outcome: Mapping[str, Any]) -> list[str]:
    """Name the invariants that a complete run breaks."""
    judged = INVARIANTS if outcome["ending"] == COMPLETE else {}
    return [key for key, metric in judged.items() if metric.verdict(outcome[key]) == FAIL]


def outcomes_of(numbers: Sequence[int], seed: int = 0) -> pd.DataFrame:
    """Run some configurations, one after the other; gives a row for each, see `outcome_of`."""
    rows = pd.DataFrame([outcome_of(number, seed) for number in numbers])
    return rows.reindex(columns=rows.columns.union(FIGURES, sort=False))


def table(outcomes: pd.DataFrame) -> pd.DataFrame:
    """Return a row a law: how its runs end, and the worst of every figure among the complete ones."""
    by_law = outcomes.groupby("law")
    rows = by_law.agg(
        motors=("number", "size"),
        contacts=("contacts", "sum"),
        endings=("ending", lambda e: ", ".join(f"{n} {w}" for w, n in e.value_counts().items())),
        longest=("seconds", "max"),
    )
    complete = outcomes[outcomes["ending"] == COMPLETE]
    return rows.join(complete.groupby("law")[list(FIGURES)].max())


def page(outcomes: pd.DataFrame, command: str) -> str:
    """Return the table as Markdown: laws in rows, the worst figures of their complete runs in columns."""
    rows = table(outcomes).reset_index()
    heads = ["law", "motors", "contacts", "endings"]
    faults = sum(bool(broken(outcome)) for outcome in outcomes.to_dict("records"))
    return "\n".join(
        [
            "# Random motors",
            "",
            f"<!-- Made by {command}. Do not edit. -->",
            "",
            f"{len(outcomes)} random configurations of the command, numbers {outcomes['number'].min()} to "
            f"{outcomes['number'].max()}, judged from their results alone (`tests/tools/random_runs.py`). "
            "The second table has the worst figure of every invariant among the complete runs; "
            "[plausibility.md](plausibility.md) has their meaning and the reason for their bounds.",
            "",
            _cells(heads),
            _cells(["---"] * len(heads)),
            *(_cells(row) for row in rows[heads].itertuples(index=False)),
            "",
            _cells(["worst of", *INVARIANTS]),
            _cells(["---"] * (1 + len(INVARIANTS))),
            _cells(["bound", *(f"{metric.bound:g}" for metric in INVARIANTS.values())]),
            *(
                _cells([row["law"], *(f"{row[key]:.1e}" for key in INVARIANTS)])
                for row in rows.to_dict("records")
            ),
            "",
            f"Complete runs that break an invariant: {faults}.",
            "",
        ]
    )


def _cells(cells: Iterable[object]) -> str:
    return f"| {' | '.join(map(str, cells))} |"


def command_line(number: int, seed: int = 0) -> str:
    """Return the command that runs a configuration."""
    groups, values = random_configuration(number, seed)
    text = [f"{group}={option}" for group, option in groups.items()]
    text += [f"{key}={'null' if value is None else value}" for key, value in values.items()]
    return shlex.join(["contactlab", *text])


def show(outcomes: pd.DataFrame, seed: int) -> None:
    """Print the table, how runs ended that are not complete, and every broken invariant."""
    rows = table(outcomes)
    print(rows[["motors", "contacts", "longest", "endings"]].to_string(float_format="%.1f s"))
    print("\nWorst figure of the runs that say complete:")
    worst = rows[list(FIGURES)].T.assign(bound=[METRICS[key].bound for key in FIGURES])
    print(worst.to_string(float_format="%.1e"))
    for outcome in outcomes.to_dict("records"):
        text = f"{outcome['number']} {outcome['law']}"
        if outcome["ending"] not in {COMPLETE, REFUSED}:
            print(f"\n{text}: {outcome['ending']}. {outcome['message']}")
        if faults := broken(outcome):
            print(f"\nBroken: {text}: {', '.join(f'{key} {outcome[key]:.3g}' for key in faults)}")
            print(f"  {command_line(outcome['number'], seed)}")


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
    outcomes = in_chunks(partial(outcomes_of, seed=options.seed), numbers, CHUNK, options.workers)
    show(outcomes, options.seed)
    table(outcomes).to_csv(options.csv)
    if options.page:
        script = "python tests/tools/random_runs.py"
        command = f"{script} --first {options.first} --motors {options.motors} --seed {options.seed}"
        options.page.write_text(page(outcomes, command), encoding="utf-8")
    return int(any(broken(outcome) for outcome in outcomes.to_dict("records")))


if __name__ == "__main__":
    sys.exit(main())
