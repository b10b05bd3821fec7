"""Random motors over every law and part against an independent integrator.

    python tests/tools/judged_motors.py [--motors N] [--first N] [--csv FILE] [--page docs/judged_motors.md]

The integrator is that of the tests (`tests/oracle`): forces, frictions and impacts written again from their
publications in plain Python, flights by a matrix exponential, contacts by SciPy's DOP853 with every switch an
event. Rows that the CSV file already has are not run again, so that a run that was cut goes on. The page has
the worst figure of every law.
"""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parents[1]))

import pandas as pd
from support.judged_motors import (
    DURATION,
    FINE,
    LOOSE,
    QUANTITIES,
    RIGID,
    SLIP_STEP,
    TIGHT,
    TOTAL,
    judged,
    rows,
)

HEADS = ("rotor velocity", "normal impulse", "time in contact", "displacement", "contact work")
LARGE = 1e-6
"""Error of a compliant motor at the fine tolerance from which on it is listed by number."""


def measured(numbers: range, csv: Path) -> pd.DataFrame:
    """Compare the motors with these numbers; rows are written as they come."""
    table = pd.read_csv(csv) if csv.exists() else pd.DataFrame({"number": []})
    for number in numbers:
        if number in set(table["number"]):
            continue
        try:
            outcome = judged(number)
        except (RuntimeError, ValueError) as fault:
            names = rows()
            outcome = {"number": number, "row": names[number % len(names)], "fault": str(fault)}
        table = pd.concat([table, pd.DataFrame([outcome])], ignore_index=True)
        table.to_csv(csv, index=False)
        print(*(f"{k} {v:.1e}" if isinstance(v, float) else v for k, v in outcome.items()), flush=True)
    kept = table[table["number"].isin(numbers)].astype({"number": int})
    return kept.sort_values("number", ignore_index=True)


def cells(*values: object) -> str:
    """A row of a Markdown table."""
    return f"| {' | '.join(map(str, values))} |"


def worst(table: pd.DataFrame, effort: str) -> list[str]:
    """Worst errors by row in Markdown."""
    lines = [
        cells("law or part", "motors", "contacts", "counts that differ", *HEADS, "change of the integrator"),
        cells(*["---"] * (5 + len(HEADS))),
    ]
    for name, group in table.groupby("row", sort=False):
        errors = [group[f"{effort} {quantity}"].max() for quantity in QUANTITIES]
        own = group[[f"judge {quantity}" for quantity in QUANTITIES]].max().max()
        differ = int((group[f"{effort} contacts"] != group["contacts"]).sum())
        text = ["" if error != error else f"{error:.0e}" for error in errors]
        lines.append(cells(name, len(group), int(group["contacts"].sum()), differ, *text, f"{own:.0e}"))
    return lines


def page(table: pd.DataFrame, command: str) -> str:
    """The figures as a Markdown page."""
    faults = table[table["fault"].notna()] if "fault" in table else table.iloc[:0]
    whole = table.drop(faults.index)
    rigid = whole["row"].isin(RIGID)
    fine = [f"{FINE} {quantity}" for quantity in QUANTITIES]
    large = whole[~rigid & (whole[fine].max(axis=1) > LARGE)]
    listed = [
        f"* {row['number']} ({row['row']}): {row[fine].max():.0e}; change of the integrator "
        f"{max(row[f'judge {quantity}'] for quantity in QUANTITIES):.0e}"
        for _, row in large.iterrows()
    ]
    return "\n".join(
        [
            "# Against an independent integrator",
            "",
            f"<!-- Made by {command}. Do not edit. -->",
            "",
            f"{len(table)} random motors, each with a random law, {1e3 * DURATION:g} ms from rest, "
            "solved by the engine and by an integrator that shares no code with it (`tests/oracle`). "
            "A row has the largest error of its motors, each over the scale of its quantity; contact work "
            "is what the contact has taken from the motor. A contact counts from a thousandth of the "
            "largest impulse on. The last column is the change of the integrator itself from the "
            f"tolerance {LOOSE:g} to {TIGHT:g}.",
            "",
            "## Compliant laws at the default tolerance",
            "",
            *worst(whole[~rigid], "default"),
            "",
            "## Compliant laws at the tolerance 1e-10",
            "",
            *worst(whole[~rigid], FINE),
            "",
            f"Motors with an error above {LARGE:g} here: {len(large)}.",
            "",
            *listed,
            *([""] if listed else []),
            "## Rigid laws at the default contact step",
            "",
            "The integrator has no step, so that the error is that of the engine's step. `lagrange_slip` "
            f"has no limit where it sticks: there both sides step by {SLIP_STEP:g} s, and the last column "
            "is the change from twice that step.",
            "",
            *worst(whole[rigid], "default"),
            "",
            "## Rigid laws at a tenth of the default contact step",
            "",
            *worst(whole[rigid], FINE),
            "",
            "Forces, frictions, dampings and impacts are written again from their publications; no kernel "
            "of a law is called. Flights are a matrix exponential, contacts SciPy's DOP853 (Radau for "
            "regularised and rate-and-state friction), and every switch is an event.",
            "",
            f"Motors without a comparison: {len(faults)}.",
            "",
            *(f"* {row['number']} ({row['row']}): {row['fault']}" for _, row in faults.iterrows()),
            *([""] if len(faults) else []),
        ]
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run, write the table and the page; returns the exit status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--motors", type=int, default=TOTAL, help="how many motors")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument(
        "--csv", type=Path, default=Path("judged_motors.csv"), help="the table, which is gone on with"
    )
    parser.add_argument("--page", type=Path, help="the worst figures as a page")
    options = parser.parse_args(arguments)
    table = measured(range(options.first, options.first + options.motors), options.csv)
    if options.page:
        command = f"python tests/tools/judged_motors.py --first {options.first} --motors {options.motors}"
        options.page.write_text(page(table, command), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
