"""The scorecard as text for the terminal, as CSV and as a LaTeX table."""

import csv
import io
import re
from dataclasses import dataclass
from math import isnan
from typing import Final, final

import xarray

from contactlab.comparison.scorecard import VERDICTS
from contactlab.metrics import NOT_APPLICABLE, REPORTED


@final
@dataclass(frozen=True)
class Cell:
    """One law under one metric."""

    value: float
    error: float
    verdict: str

    @property
    def number(self) -> str:
        """The value with its numerical error, n/a where there is none."""
        if isnan(self.value):
            return NOT_APPLICABLE
        error = f" \u00b1 {self.error:.1g}" if self.error > 0.0 else ""
        return f"{self.value:.4g}{error}".replace("-", "\u2212")

    @property
    def word(self) -> str:
        """The verdict, empty where nothing is judged or the number says it."""
        return "" if self.verdict in (REPORTED, NOT_APPLICABLE) else self.verdict


@final
@dataclass(frozen=True)
class Row:
    """One metric."""

    key: str
    meaning: str
    units: str
    threshold: str
    reason: str
    cells: dict[str, Cell]

    @property
    def brief(self) -> str:
        """The meaning without what explains it."""
        return re.split(r"[:;]|\. ", self.meaning)[0]

    @property
    def unit(self) -> str:
        """The unit in brackets, with a space before it; nothing without one."""
        return "" if self.units == "1" else f" [{slashed(self.units)}]"


def slashed(units: str) -> str:
    """CF units as they are read: rad/s for rad s-1."""
    return re.sub(r" (\w+)-1$", r"/\1", units)


def rows(data: xarray.Dataset) -> list[Row]:
    """The scorecard's rows."""
    labels = [str(law) for law in data["law"].values]
    found = []
    for j, key in enumerate(data["metric"].values):
        cells = {
            label: Cell(
                float(data["value"].values[i, j]),
                float(data["numerical_error"].values[i, j]),
                VERDICTS[int(data["verdict"].values[i, j])],
            )
            for i, label in enumerate(labels)
        }
        said = {name: str(data[name].values[j]) for name in _SAID}
        found.append(Row(str(key), cells=cells, **said))
    return found


_SAID: Final = ("meaning", "units", "threshold", "reason")


def as_text(data: xarray.Dataset) -> str:
    """The table for a terminal, plain ASCII."""
    labels = [str(law) for law in data["law"].values]
    lines = [["metric", "must be", *labels]]
    for row in rows(data):
        cells = [f"{cell.number} {cell.word}".rstrip() for cell in row.cells.values()]
        lines.append([row.key + row.unit, row.threshold, *cells])
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    text = "\n".join(
        "  ".join(
            [line[0].ljust(widths[0]), line[1].ljust(widths[1])]
            + [cell.rjust(width) for cell, width in zip(line[2:], widths[2:], strict=True)]
        ).rstrip()
        for line in lines
    )
    return text.replace("\u2212", "-").replace("\u00b1", "+-")


def as_csv(data: xarray.Dataset) -> str:
    """One row a metric; value, numerical error and verdict of every law."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    labels = [str(law) for law in data["law"].values]
    columns = [
        f"{label}{what}" for label in labels for what in ("", " numerical error", " verdict")
    ]
    writer.writerow(["metric", "meaning", "units", "must be", *columns])
    for row in rows(data):
        cells = [
            entry
            for cell in row.cells.values()
            for entry in (_exact(cell.value), _exact(cell.error), cell.verdict)
        ]
        writer.writerow([row.key, row.meaning, row.units, row.threshold, *cells])
    return text.getvalue()


def _exact(value: float) -> str:
    return NOT_APPLICABLE if isnan(value) else f"{value:.9g}"


def as_latex(data: xarray.Dataset) -> str:
    """A tabular that stands in any document that loads booktabs."""
    labels = [str(law) for law in data["law"].values]
    head = " & ".join(["", "must be", *(latex(label) for label in labels)])
    body = []
    for row in rows(data):
        cells = [_latex_cell(cell) for cell in row.cells.values()]
        limit = _latex_threshold(row.threshold)
        unit = "" if row.units == "1" else f" [{_latex_units(row.units)}]"
        body.append(" & ".join([latex(row.brief) + unit, limit, *cells]) + r" \\")
    return "\n".join(
        [
            r"% \usepackage{booktabs} in the preamble.",
            rf"\begin{{tabular}}{{p{{0.3\textwidth}}l{'r' * len(labels)}}}",
            r"\toprule",
            head + r" \\",
            r"\midrule",
            *body,
            r"\bottomrule",
            r"\end{tabular}",
            "",
        ]
    )


def latex(text: str) -> str:
    """Plain text for LaTeX."""
    return "".join(_SPECIAL.get(letter, letter) for letter in text)


_SPECIAL: Final = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "\u00b5": r"\textmu{}",
    **{letter: f"\\{letter}" for letter in "_%&#{}$"},
}


def _latex_units(units: str) -> str:
    """CF units such as N m-1."""
    return re.sub(r"(-?\d+)(?= |$)", r"$^{\1}$", latex(units)).replace(" ", r"\,")


def _latex_threshold(threshold: str) -> str:
    relation, _, bound = threshold.partition(" ")
    if not bound:
        return ""
    sign = {"<=": r"\le", ">=": r"\ge"}[relation]
    return f"${sign} {_latex_number(bound)}$"


def _latex_number(text: str) -> str:
    mantissa, _, exponent = text.partition("e")
    return rf"{mantissa} \times 10^{{{int(exponent)}}}" if exponent else mantissa


def _latex_cell(cell: Cell) -> str:
    if isnan(cell.value):
        return NOT_APPLICABLE
    number = f"${_latex_number(f'{cell.value:.3g}')}$".replace("inf", r"\infty")
    return f"{number} {cell.word}".rstrip()
