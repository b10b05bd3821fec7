"""Random motors over laws and parts, those of `random_motors`, against an independent integrator.

    python validation/judged_motors.py [--motors N] [--first N] [--csv FILE] [--page docs/judged_motors.md]

The integrator is independent (`validation/oracle`): forces, frictions and impacts written again from their
publications in plain Python, flights by a matrix exponential, contacts by SciPy's DOP853 with every switch an
event. What the CSV file already has of the integrator, which does not depend on the engine, is not run again.
The page has the worst figure of every law.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import pandas as pd
from random_motors import (
    DEFAULT,
    DURATION,
    FINE,
    LOOSE,
    QUANTITIES,
    RIGID,
    TIGHT,
    TOTAL,
    judged,
    judgement,
    kind_of,
    rows,
)

HEADS = ("rotor velocity", "normal impulse", "time in contact", "tip", "contact work")
LARGE = 1e-6
"""Error of a motor at the fine tolerance from which on it is listed by number."""


def judgements(numbers: range, csv: Path) -> dict[int, dict[str, float]]:
    """Return what the integrator says of the motors with these numbers; rows are written as they come."""
    table = pd.read_csv(csv) if csv.exists() else pd.DataFrame({"number": []})
    for number in sorted(set(numbers) - set(table["number"])):
        try:
            outcome: dict[str, float | str] = {"fault": "", **judgement(number)}
        except (RuntimeError, ValueError) as fault:
            outcome = {"fault": str(fault)}
        table = pd.concat([table, pd.DataFrame([{"number": number, **outcome}])], ignore_index=True)
        table.to_csv(csv, index=False)
        print(number, outcome["fault"], flush=True)
    return {int(row["number"]): row for row in table.to_dict("records")}


def measured(numbers: range, csv: Path) -> pd.DataFrame:
    """Compare the motors with these numbers."""
    known, names, outcomes = judgements(numbers, csv), rows(), []
    for number in numbers:
        outcome = {"number": number, "row": names[number % len(names)], "kind": kind_of(number)}
        fault = known[number]["fault"]
        if isinstance(fault, str) and fault:
            outcome["fault"] = fault
        else:
            try:
                outcome = judged(number, known=known[number])
            except (RuntimeError, ValueError) as fault:
                outcome["fault"] = str(fault)
        outcomes.append(outcome)
        print(*(f"{k} {v:.1e}" if isinstance(v, float) else v for k, v in outcome.items()), flush=True)
    return pd.DataFrame(outcomes)


def cells(*values: object) -> str:
    """A row of a Markdown table."""
    return f"| {' | '.join(map(str, values))} |"


def worst(table: pd.DataFrame, effort: str, by: str = "row") -> list[str]:
    """Worst errors in Markdown, by row or by kind."""
    lines = [
        cells(
            {"row": "law or part", "kind": "motor"}[by], "motors", "contacts (that differ)", *HEADS, "judge"
        ),
        cells(*["---"] * (4 + len(HEADS))),
    ]
    for name, group in table.groupby(by, sort=False):
        errors = [group[f"{effort} {quantity}"].max() for quantity in QUANTITIES]
        own = group[[f"judge {quantity}" for quantity in QUANTITIES]].max().max()
        differ = int((group[f"{effort} contacts"] != group["contacts"]).sum())
        text = ["" if error != error else f"{error:.0e}" for error in errors]
        contacts = f"{int(group['contacts'].sum())} ({differ})"
        lines.append(cells(name, len(group), contacts, *text, f"{own:.0e}"))
    return lines


def page(table: pd.DataFrame, command: str) -> str:
    """The figures as a Markdown page."""
    faults = table[table["fault"].notna()] if "fault" in table else table.iloc[:0]
    whole = table.drop(faults.index)
    rigid = whole["row"].isin(RIGID)
    fine = [f"{FINE} {quantity}" for quantity in QUANTITIES]
    large = whole[whole[fine].max(axis=1) > LARGE]
    listed = [
        f"* {row['number']} ({row['row']}, {row['kind']}): {row[fine].max():.0e}; change of the integrator "
        f"{max(row[f'judge {quantity}'] for quantity in QUANTITIES):.0e}"
        for _, row in large.iterrows()
    ]
    tables = [
        ("Kinds of motors at the default tolerance", whole, DEFAULT, "kind"),
        ("Compliant laws at the default tolerance", whole[~rigid], DEFAULT, "row"),
        ("Rigid laws at the default tolerance", whole[rigid], DEFAULT, "row"),
        ("Compliant laws at the tolerance 1e-10", whole[~rigid], FINE, "row"),
        ("Rigid laws at the tolerance 1e-10", whole[rigid], FINE, "row"),
    ]
    return "\n".join(
        [
            "# Against an independent integrator",
            "",
            f"<!-- Made by {command}. Do not edit. -->",
            "",
            f"{len(table)} random motors, each with a random law, {1e3 * DURATION:g} ms from rest, "
            "solved by the engine and by an integrator that shares no code with it (`validation/oracle`). Of "
            "four motors of a law, one is plain, one has its rotor on a bearing, pressed on the tip, one "
            "changes while it runs (voltage, load, damping, preload; once or twice), and one has both; under "
            "johnson, whose slow rebounds lose nothing, none has a bearing. "
            "A row has the largest error of its motors, each over the scale of its quantity; contact work "
            "is what the contact has taken from the motor, *tip* its displacement from the rotor. A contact "
            "counts from a thousandth of the largest impulse on; in brackets stand the motors in which the "
            "two solvers count another number. *Judge* is the change of "
            f"the integrator itself from the tolerance {LOOSE:g} to {TIGHT:g}.",
            "",
            "Rigid laws run in their limit of no step: impacts are maps, and what lasts is held by its "
            "forces. Bounces that die out end at 1e-7 m/s in the integrator, and count as time in contact "
            "from there. The stepping of the paper tends to this limit with first order, see "
            "[accuracy](accuracy.md).",
            "",
            *(
                line
                for title, rows_of, effort, by in tables
                for line in [f"## {title}", "", *worst(rows_of, effort, by), ""]
            ),
            f"Motors with an error above {LARGE:g} at the tolerance 1e-10: {len(large)}.",
            "",
            *listed,
            *([""] if listed else []),
            "Forces, frictions, dampings and impacts are written again from their publications; no kernel "
            "of a law is called. Flights are a matrix exponential, contacts SciPy's DOP853 (Radau for "
            "regularised and rate-and-state friction), and every switch is an event.",
            "",
            f"Motors without a comparison: {len(faults)}.",
            "",
            *(
                f"* {row['number']} ({row['row']}, {row['kind']}): {row['fault']}"
                for _, row in faults.iterrows()
            ),
            *([""] if len(faults) else []),
        ]
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, write the table and the page; returns the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--motors", type=int, default=TOTAL, help="how many motors")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument(
        "--csv", type=Path, default=Path("judged_motors.csv"), help="what the integrator says, gone on with"
    )
    parser.add_argument("--page", type=Path, help="the worst figures as a page")
    options = parser.parse_args(arguments)
    table = measured(range(options.first, options.first + options.motors), options.csv)
    if options.page:
        command = f"python validation/judged_motors.py --first {options.first} --motors {options.motors}"
        options.page.write_text(page(table, command), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
