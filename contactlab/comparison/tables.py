"""The scorecard as text for the terminal, as CSV and as a LaTeX table."""

import re
from dataclasses import dataclass, fields
from math import isnan
from typing import Final, final

import pandas
import xarray

from contactlab.metrics import NOT_APPLICABLE, REPORTED, VERDICTS


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
    """One metric, with the words of its declaration and a cell for every law."""

    metric: str
    symbol: str
    units: str
    meaning: str
    threshold: str
    reason: str
    metric_source: str
    cells: dict[str, Cell]

    @property
    def brief(self) -> str:
        """The meaning without what explains it."""
        return re.split(r"[:;]|\. ", self.meaning)[0]

    @property
    def unit(self) -> str:
        """The unit as it is read, rad/s for rad s-1, with a space before it; nothing without one."""
        return "" if self.units == "1" else " " + re.sub(r" (\w+)-1$", r"/\1", self.units)

    @property
    def bracketed(self) -> str:
        """The same in brackets."""
        return self.unit and f" [{self.unit[1:]}]"


def rows(data: xarray.Dataset) -> list[Row]:
    """Take a scorecard apart."""
    found = []
    for key in data["metric"].values:
        one = data.sel(metric=key)
        words = {f.name: str(one[f.name].item()) for f in fields(Row) if f.name != "cells"}
        columns = (one[name].values for name in ("law", "value", "numerical_error", "verdict"))
        cells = {
            str(label): Cell(float(value), float(error), VERDICTS[flag])
            for label, value, error, flag in zip(*columns, strict=True)
        }
        found.append(Row(**words, cells=cells))
    return found


def as_text(data: xarray.Dataset) -> str:
    """Write the table for a terminal, plain ASCII."""
    table = rows(data)
    width = max(len(row.threshold) for row in table)
    lines = [
        {"must be": row.threshold.ljust(width)}
        | {label: f"{cell.number} {cell.word}".rstrip() for label, cell in row.cells.items()}
        for row in table
    ]
    frame = pandas.DataFrame(lines, index=[row.metric + row.bracketed for row in table])
    frame = frame.replace({"\u2212": "-", "\u00b1": "+-"}, regex=True)
    return str(frame.rename_axis(columns="metric").to_string())


def as_csv(data: xarray.Dataset) -> str:
    """Write one row a metric; value, numerical error and verdict of every law."""
    names = {"metric": "metric", "meaning": "meaning", "units": "units", "must be": "threshold"}
    frame = pandas.DataFrame({title: data[name].values for title, name in names.items()})
    for label in data["law"].values:
        one = data.sel(law=label)
        frame[label] = [_exact(value) for value in one["value"].values]
        frame[f"{label} numerical error"] = [_exact(e) for e in one["numerical_error"].values]
        frame[f"{label} verdict"] = [VERDICTS[flag] for flag in one["verdict"].values]
    return str(frame.to_csv(index=False, lineterminator="\n"))


def _exact(value: float) -> str:
    return NOT_APPLICABLE if isnan(value) else f"{value:.9g}"


def as_latex(data: xarray.Dataset) -> str:
    """Write a tabular that stands in any document that loads booktabs."""
    labels = [latex(str(label)) for label in data["law"].values]
    body = []
    for row in rows(data):
        # CF units such as N m-1.
        units = re.sub(r"(-?\d+)(?= |$)", r"$^{\1}$", latex(row.units)).replace(" ", r"\,")
        unit = "" if row.units == "1" else f" [{units}]"
        bound = row.threshold.removeprefix("<= ")
        limit = rf"$\le {_power(bound)}$" if bound else ""
        cells = map(_latex_cell, row.cells.values())
        body.append(" & ".join([latex(row.brief) + unit, limit, *cells]) + r" \\")
    return "\n".join(
        [
            r"% \usepackage{booktabs} in the preamble.",
            rf"\begin{{tabular}}{{p{{0.3\textwidth}}l{'r' * len(labels)}}}",
            r"\toprule",
            " & ".join(["", "must be", *labels]) + r" \\",
            r"\midrule",
            *body,
            r"\bottomrule",
            r"\end{tabular}",
            "",
        ]
    )


def latex(text: str) -> str:
    """Write plain text for LaTeX."""
    return text.translate(_SPECIAL)


_SPECIAL: Final = str.maketrans(
    {
        "\\": r"\textbackslash{}",
        "~": r"\textasciitilde{}",
        "^": r"\textasciicircum{}",
        "<": r"\textless{}",
        ">": r"\textgreater{}",
        "|": r"\textbar{}",
        "\u00b5": r"\textmu{}",
        **{letter: f"\\{letter}" for letter in "_%&#{}$"},
    }
)


def _power(number: str) -> str:
    """Write 1e-06 as a power of ten."""
    mantissa, _, exponent = number.partition("e")
    return rf"{mantissa} \times 10^{{{int(exponent)}}}" if exponent else mantissa


def _latex_cell(cell: Cell) -> str:
    if isnan(cell.value):
        return NOT_APPLICABLE
    number = f"${_power(f'{cell.value:.3g}')}$".replace("inf", r"\infty")
    return f"{number} {cell.word}".rstrip()
