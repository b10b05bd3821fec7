"""One path of tables: a pandas frame as text, CSV, LaTeX and HTML, with units and errors.

A cell is a text, a number, an `Estimate` or an `AtMost`. In a row with a unit all of them but whole numbers
are in that unit, and are written in the same one with a prefix. `frame.attrs["units"]` has the units of
columns in the words of the CF conventions and `frame.attrs["caption"]` a sentence; `frame.attrs["reference"]`
marks a table of long texts, which stands at the end of the page; `frame.attrs["digits"]` is what is uncertain
beside the errors: no number is shown with more digits. All may be missing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from html import escape
from itertools import zip_longest
from textwrap import wrap
from typing import TYPE_CHECKING, Any, Final, NamedTuple, final

import numpy as np

from contactlab.estimate import Estimate, exact
from contactlab.parameter import from_cf
from contactlab.results.summary import prefixed_unit
from contactlab.variables import Variable

if TYPE_CHECKING:
    import pandas

UNIT: Final = "unit"
"""Column of the units of rows, in the words of the CF conventions."""

WITHOUT_PREFIX: Final = ("rad/s", "1", "1/m", "V A")
"""Units that are read as they are."""

MOST_COLUMNS: Final = 12
"""Columns of a table on a page, beyond which every row is a block of its own."""


GAP: Final = 2
"""Spaces between two columns of a table that is fitted to a terminal."""


@final
class AtMost(NamedTuple):
    """A bound of a quantity, in its unit."""

    bound: float

    @classmethod
    def of_text(cls, text: str) -> AtMost | str:
        """Return the bound of a text "<= 0.01", or the text if it is something else."""
        relation, _, number = text.partition(" ")
        return cls(float(number)) if relation == "<=" else text


def table(rows: Any, *, units: Mapping[str, str] | None = None, caption: str = "") -> pandas.DataFrame:
    """Return a table from rows (mappings), with units by column and a caption."""
    # Imported here, as below: studies are declared without.
    import pandas

    frame = pandas.DataFrame(rows)
    frame.attrs = {"units": dict(units or {}), "caption": caption}
    return frame


def table_of_quantities(
    quantities: Iterable[Variable], columns: Mapping[str, Mapping[str, Estimate]], caption: str = ""
) -> pandas.DataFrame:
    """Return a table with a row for each quantity, in SI, and a column of numbers for each label."""
    rows = [
        {"quantity": q.name.replace("_", " "), UNIT: q.units}
        | {label: numbers[q.name] for label, numbers in columns.items()}
        for q in quantities
    ]
    return table(rows, caption=caption)


def shown(cell: object, plus_minus: str = "+-", digits: int | None = None) -> str:
    """Return a cell as text, with so many digits at most; see `Estimate.text`.

    >>> shown(Estimate(-2.19118, 0.00213)), shown(0.1 + 0.2), shown(float("nan"))
    ('-2.1912 +- 0.0021', '0.3', '')
    >>> shown(Estimate(-2.19118, 0.00213), digits=3), shown(Estimate(2.0, 0.3), digits=3)
    ('-2.19', '2.00 +- 0.30')
    """
    match cell:
        case Estimate():
            return cell.text(plus_minus, digits)
        case float() | np.floating():
            return exact(float(cell), digits)
        case AtMost(bound):
            return f"<= {bound:g}"
        case None:
            return ""
    return str(cell)


def heads(frame: pandas.DataFrame) -> list[str]:
    """Return the heads of columns, units in parentheses."""
    units = frame.attrs.get("units", {})
    return [
        f"{name} ({from_cf(units[name])})" if units.get(name, "1") != "1" else str(name) for name in frame
    ]


def _as_written(frame: pandas.DataFrame, write: Callable[[object], str]) -> pandas.DataFrame:
    """Return a frame of texts; rows with a unit get one of a handy size."""
    rows = frame.to_dict("records")
    import pandas

    texts = [[write(cell) for cell in (_prefixed(row) if UNIT in row else row).values()] for row in rows]
    return pandas.DataFrame(texts, columns=heads(frame), dtype=object)


def _prefixed(row: Mapping[Any, Any]) -> dict[Any, Any]:
    """Return a row with the prefix of its unit that suits its largest number.

    Numbers that are not larger than their errors count only where there is no other.
    """
    shown, bounds = [0.0], [0.0]
    for cell in row.values():
        match cell:
            case Estimate(value, error) if 0.0 < error < np.inf and error >= abs(value):
                bounds.append(abs(value) + error)
            case Estimate(value, _) | (float() as value):
                shown.append(abs(value))
    largest = max(x for x in shown if np.isfinite(x)) or max(bounds)
    unit, scale = unit_for(largest, row[UNIT])
    return {name: _scaled(cell, scale) for name, cell in row.items()} | {UNIT: unit}


def unit_for(largest: float, units: str) -> tuple[str, float]:
    """Return the unit in which a number is handy, empty for none, and its size in SI."""
    unit, scale = from_cf(units), 1.0
    if unit not in WITHOUT_PREFIX and largest > 0.0:
        unit, scale = prefixed_unit(largest, unit)
    return "" if unit == "1" else unit.replace("\u00b5", "u"), scale


def _scaled(cell: object, scale: float) -> object:
    """Return a cell whose numbers are divided by a scale."""
    match cell:
        case Estimate(value, error):
            return Estimate(value / scale, error / scale)
        case AtMost(bound):
            return AtMost(bound / scale)
        case float():
            return cell / scale
    return cell


def with_unit(number: Estimate | float, units: str) -> str:
    """Return a number, with its error if it has one, and a unit of a handy size.

    >>> with_unit(Estimate(2.007e10, 1.7e8), "N m-1.5"), with_unit(Estimate(0.82, 0.01), "1")
    ('20.07 +- 0.17 GN/m^1.5', '0.820 +- 0.010')
    """
    row = _prefixed({UNIT: units, "number": number})
    return f"{shown(row['number'])} {row[UNIT]}".rstrip()


def as_text(frame: pandas.DataFrame, width: int = 0) -> str:
    """Return a table for a terminal of so many columns; of any where width is 0.

    A table that is wider has its texts on several lines, and where that does not do, columns in several
    blocks, each with the first column.
    """
    written = _as_written(frame, lambda cell: shown(cell, digits=frame.attrs.get("digits")))
    text = str(written.to_string(index=False))
    if not width or max(map(len, text.splitlines())) <= width:
        return text
    cells = [[str(head), *map(str, column)] for head, column in written.items()]
    label, *others = cells
    least = min(max(map(len, label)), max(width // 3, 1))
    groups: list[list[list[list[str]]]] = []
    room = 0
    for column in others:
        lines = [wrap(cell, max(width - least - GAP, 1)) for cell in column]
        size = GAP + max(len(line) for cell in lines for line in cell)
        if not groups or size > room:
            groups.append([])
            room = width - least
        groups[-1].append(lines)
        room -= size
    blocks = []
    for group in groups or [[]]:
        sizes = [max(len(line) for cell in column for line in cell) for column in group]
        own = [wrap(cell, width - sum(sizes) - GAP * len(sizes)) for cell in label]
        first = max(len(line) for cell in own for line in cell)
        grid = (line for row in zip(own, *group, strict=True) for line in zip_longest(*row, fillvalue=""))
        texts = ([head.ljust(first), *map(str.rjust, rest, sizes)] for head, *rest in grid)
        blocks.append("\n".join((" " * GAP).join(row).rstrip() for row in texts))
    return "\n\n".join(blocks)


def as_csv(frame: pandas.DataFrame) -> str:
    """Return a table as CSV with all digits; an error is a column of its own behind its number's."""
    import pandas

    columns: dict[str, list[Any]] = {}
    for name, head in zip(frame, heads(frame), strict=True):
        cells = [*frame[name]]
        columns[head] = [
            cell.value if isinstance(cell, Estimate) else shown(cell) if isinstance(cell, AtMost) else cell
            for cell in cells
        ]
        errors = [cell.error if isinstance(cell, Estimate) else np.nan for cell in cells]
        if any(isinstance(cell, Estimate) for cell in cells):
            columns[f"error of {head}"] = errors
    return str(pandas.DataFrame(columns).to_csv(index=False, lineterminator="\n"))


def as_latex(frame: pandas.DataFrame) -> str:
    """Return a table as a LaTeX tabular with booktabs rules."""
    special = str.maketrans({**{sign: f"\\{sign}" for sign in "&%$#_{}"}, "^": r"\^{}", "~": r"\~{}"})

    def write(cell: object) -> str:
        return shown(cell, "\0", frame.attrs.get("digits")).translate(special).replace("\0", r"$\pm$")

    written = _as_written(frame, write)
    lines = [" & ".join(row) + r" \\" for row in written.itertuples(index=False, name=None)]
    head = " & ".join(head.translate(special) for head in written)
    rules = [rf"\begin{{tabular}}{{{'l' * len(written.columns)}}}", r"\toprule", rf"{head} \\", r"\midrule"]
    return "\n".join([*rules, *lines, r"\bottomrule", r"\end{tabular}", ""])


def as_html(frame: pandas.DataFrame) -> str:
    """Return a table as HTML; cells know their heads, for a page too narrow for columns."""
    written = _as_written(frame, lambda cell: shown(cell, "\u00b1", frame.attrs.get("digits")))
    head = [escape(str(name), quote=True) for name in written]
    kinds = ["reference"] * bool(frame.attrs.get("reference")) + ["wide"] * (len(head) > MOST_COLUMNS)
    lines = [f'<table class="{" ".join(kinds)}">', "<thead><tr>", *(f"<th>{name}</th>" for name in head)]
    lines += ["</tr></thead>", "<tbody>"]
    for row in written.itertuples(index=False, name=None):
        cells = zip(head, map(escape, row), strict=True)
        lines += ["<tr>", *(f'<td data-head="{name}">{cell}</td>' for name, cell in cells), "</tr>"]
    return "\n".join([*lines, "</tbody>", "</table>", ""])
