"""Findings and table of docs/simulators.md from results.json and the exact answers.

python benchmarks/simulators/simulator_page.py
"""

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import Any, Final

from questions import Question, questions

RESULTS: Final = Path(__file__).with_name("results.json")
PAGE: Final = Path(__file__).resolve().parents[2] / "docs" / "simulators.md"

MARKED: Final = re.compile(r"(<!-- result: (\w+) -->\n\n)(.*?)(\n\n<!-- end -->)", re.DOTALL)

Row = Mapping[str, Any]


def pairs(row: Row, name: str, quantity: str) -> list[tuple[Question, float]] | None:
    """Return a question at each of its numbers with the value of an entrant; None where one is missing."""
    values = row["values"].get(name, {}).get(quantity, [None])
    if None in values:
        return None
    return [*zip((each for each in questions() if each.name == name), values, strict=True)]


def error(row: Row, name: str, quantity: str, relative: bool = False) -> float | None:
    """Return the largest error of a quantity, relative to the exact value if wanted; None without values."""
    seen = pairs(row, name, quantity)
    if seen is None:
        return None
    return max(abs(x - q.exact[quantity]) / (abs(q.exact[quantity]) if relative else 1.0) for q, x in seen)


def created(row: Row) -> float | None:
    """Return the most energy that an impact has created, as a share of that before [1]."""
    ratios = [pairs(row, name, "energy") for name in ("oblique", "rod")]
    return None if None in ratios else max(0.0, *(x - 1.0 for seen in ratios for _, x in seen or ()))


COLUMNS: Final[Mapping[str, Callable[[Row], float | None]]] = {
    "creep (m/s)": lambda row: error(row, "creep", "velocity"),
    "sliding velocity": lambda row: error(row, "slide", "velocity", relative=True),
    "drift (m)": lambda row: error(row, "drift", "drift"),
    "stick-slip amplitude": lambda row: error(row, "belt", "amplitude", relative=True),
    "stick-slip period": lambda row: error(row, "belt", "period", relative=True),
    "restitution": lambda row: error(row, "rebound", "rebound"),
    "energy after an oblique impact": lambda row: error(row, "oblique", "energy"),
    "energy created": created,
    "coming to rest (s)": lambda row: error(row, "rest", "time"),
    "speed at rest (m/s)": lambda row: error(row, "rest", "speed"),
    "time": lambda row: row["time"],
}
"""Columns of the tables: errors but for the last."""

FRICTION: Final = (
    *("creep (m/s)", "sliding velocity", "drift (m)", "stick-slip amplitude", "stick-slip period", "time"),
)
"""Those of the table on friction; the other has the rest."""


def shown(value: float | None) -> str:
    """Return a number as it stands in the table; round-off is 0, and there is a dash for no answer."""
    if value is None:
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
        cells = [shown(COLUMNS[name](row)) for name in names]
        lines.append(f"| {row['entrant']}: {row['setting']} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def span(values: Iterable[float | None]) -> str:
    """Return the range of numbers, without those that are missing."""
    known = sorted(value for value in values if value is not None)
    least, most = shown(known[0]), shown(known[-1])
    return least if least == most else f"{least} to {most}"


def findings() -> str:
    """Return sentences with ranges over the settings of each entrant."""
    entrants: dict[str, list[Row]] = {}
    for row in results()["rows"]:
        entrants.setdefault(row["entrant"], []).append(row)

    def ranges(column: str, unit: str = "") -> str:
        values = {name: [COLUMNS[column](row) for row in rows] for name, rows in entrants.items()}
        known = {name: span(each) for name, each in values.items() if {*each} != {None}}
        return ", ".join(f"{name} {each}{unit}" for name, each in known.items())

    count = {
        name: sum(q.name == name for q in questions()) for name in ("creep", "rebound", "oblique", "rod")
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
            f"{count['rod']} of a rod has created, over the energy before: {ranges('energy created')}.",
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
    "impacts": lambda: table([name for name in COLUMNS if name not in FRICTION]),
    "versions": versions,
}


def page() -> str:
    """Return the page with what is made from the results."""
    return MARKED.sub(lambda each: each[1] + PARTS[each[2]]() + each[4], PAGE.read_text(encoding="utf-8"))


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
