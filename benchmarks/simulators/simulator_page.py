"""Findings and table of docs/simulators.md from results.json and the exact answers.

python benchmarks/simulators/simulator_page.py
"""

import json
import re
from collections.abc import Callable, Mapping, Sequence
from math import isnan
from pathlib import Path
from textwrap import fill
from typing import Any, Final

from contactlab.parameter import from_cf
from contactlab.variables import Variable
from contactlab_data.studies.bench.questions import CREATED, errors_of, questions

RESULTS: Final = Path(__file__).with_name("results.json")
PAGE: Final = Path(__file__).resolve().parents[2] / "docs" / "simulators.md"

MARKED: Final = re.compile(r"(<!-- result: (\w+) -->\n\n)(.*?)(\n\n<!-- end -->)", re.DOTALL)

Row = Mapping[str, Any]


TIME: Final = "time"
"""The last column of the table on friction."""


def title(variable: Variable) -> str:
    """Return the heading of a column."""
    return variable.long_name + ("" if variable.units == "1" else f" ({from_cf(variable.units)})")


ERRORS: Final = {score.variable: score.question for score in questions()[1]}
KINDS: Final = {case.question: case.kind for case in questions()[0]}

FRICTION: Final = (*(title(x) for x, question in ERRORS.items() if KINDS[question] == "block"), TIME)
"""Columns of the table on friction."""

IMPACTS: Final = (*(title(x) for x, question in ERRORS.items() if KINDS[question] != "block"), title(CREATED))
"""Columns of the table on impacts."""


def columns(row: Row) -> dict[str, float]:
    """Return errors, energy created and time of a setting; NaN without an answer."""
    errors = errors_of(row["values"]).items()
    return {**{title(variable): x for variable, x in errors}, TIME: row["time"]}


def shown(value: float) -> str:
    """Return a number as it stands in the table; round-off is 0, and there is a dash for no answer."""
    if isnan(value):
        return "-"
    return "0" if value < 1e-12 else f"{value:.2g}"


def results() -> dict[str, Any]:
    """Return the content of the file of results."""
    content: dict[str, Any] = json.loads(RESULTS.read_text(encoding="utf-8"))
    return content


def table(names: Sequence[str]) -> str:
    """Return a table of columns: a row for each setting."""
    lines = ["| | " + " | ".join(names) + " |", "|---" * (len(names) + 1) + "|"]
    for row in results()["rows"]:
        cells = [shown(columns(row)[name]) for name in names]
        lines.append(f"| {row['entrant']}: {row['setting']} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def span(values: Mapping[str, float], unit: str) -> str:
    """Return the range of numbers, and the setting of the least where they differ."""
    best, most = min(values, key=values.__getitem__), shown(max(values.values()))
    least = shown(values[best])
    return f"{least}{unit}" if least == most else f"{least} ({best}) to {most}{unit}"


def findings() -> str:
    """Return sentences with ranges over the settings of each entrant."""
    entrants: dict[str, list[Row]] = {}
    for row in results()["rows"]:
        entrants.setdefault(row["entrant"], []).append(row)

    def ranges(column: str, unit: str = "") -> str:
        every = {
            name: {row["setting"]: x for row in rows if not isnan(x := columns(row)[column])}
            for name, rows in entrants.items()
        }
        return "; ".join(f"{name} {span(values, unit)}" for name, values in every.items() if values)

    count = {
        name: sum(case.question == name and case.quantity != "slip" for case in questions()[0])
        for name in ("creep", "rebound", "oblique", "rod", "jam", "kane")
    }
    return "\n".join(
        fill(text, 120, subsequent_indent="  ", break_on_hyphens=False)
        for text in [
            f"* **Stick.** The largest velocity of a block after 1 s, at {count['creep']} loads below the "
            f"cone where 0 is exact: {ranges('creep (m/s)', ' m/s')}.",
            f"* **Drift.** The displacement in 90 cycles of a load that stays in the cone, where 0 is exact: "
            f"{ranges('drift (m)', ' m')}.",
            f"* **Restitution.** The largest error of a coefficient of 0.8 at {count['rebound']} speeds: "
            f"{ranges('restitution')}.",
            f"* **Energy.** The most that one of {count['oblique']} oblique impacts of a ball and "
            f"{count['rod']} of a rod, {count['jam']} of Painleve's rod and, in contactlab alone, "
            f"{count['kane']} of Kane's pendulum has created, over the energy before: "
            f"{ranges('energy created')}.",
            f"* **Jam.** The largest slip of Painleve's rod after an impact at 1 m/s, exactly 0: "
            f"{ranges('slip after a jam (m/s)', ' m/s')}.",
            f"* **Rest.** The error of the time at which a bouncing ball is still, 0.42 s: "
            f"{ranges('coming to rest (s)', ' s')}.",
        ]
    )


def versions() -> str:
    """Return versions of the entrants, and why others are missing."""
    content = results()
    lines = [", ".join(f"{name} {number}" for name, number in content["versions"].items()) + "."]
    lines += [f"Without {name}: {reason}." for name, reason in content["missing"].items()]
    return " ".join(lines)


PARTS: Final[Mapping[str, Callable[[], str]]] = {
    "findings": findings,
    "friction": lambda: table(FRICTION),
    "impacts": lambda: table(IMPACTS),
    "versions": versions,
}


def page() -> str:
    """Return the page with what is made from the results."""
    return MARKED.sub(lambda each: each[1] + PARTS[each[2]]() + each[4], PAGE.read_text(encoding="utf-8"))


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
