"""The scorecard row by row, and as text for the terminal, as CSV and as a LaTeX table."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from math import isnan
from typing import Final, final

import pandas
import xarray

from contactlab.metrics import (
    METRICS,
    NOT_APPLICABLE,
    REPORTED,
    SENSITIVITIES,
    STEP_METRICS,
    VERDICTS,
    Metric,
)

EVERY: Final = METRICS | STEP_METRICS | SENSITIVITIES
"""All that a law is judged by."""

MINUS, PLUS_MINUS = "\u2212", "\u00b1"


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
        error = f" {PLUS_MINUS} {self.error:.1g}" if self.error > 0.0 else ""
        return f"{self.value:.4g}{error}".replace("-", MINUS)

    @property
    def word(self) -> str:
        """The verdict, empty where nothing is judged or the number says it."""
        return "" if self.verdict in (REPORTED, NOT_APPLICABLE) else self.verdict


def rows(data: xarray.Dataset) -> list[tuple[Metric, dict[str, Cell]]]:
    """Take a scorecard apart: every metric with a cell for every law."""
    names = ("value", "numerical_error", "verdict")
    lines = zip(*(data[name].transpose("metric", "law").values for name in names), strict=True)
    return [
        (
            EVERY[str(key)],
            {
                str(label): Cell(value, error, VERDICTS[flag])
                for label, value, error, flag in zip(data["law"].values, *line, strict=True)
            },
        )
        for key, line in zip(data["metric"].values, lines, strict=True)
    ]


def as_text(data: xarray.Dataset) -> str:
    """Write the table for a terminal, plain ASCII."""
    table = rows(data)
    width = max(len(metric.threshold) for metric, _ in table)
    lines = {
        metric.key + metric.bracketed: {"must be": metric.threshold.ljust(width)}
        | {label: f"{cell.number} {cell.word}".rstrip() for label, cell in cells.items()}
        for metric, cells in table
    }
    frame = pandas.DataFrame.from_dict(lines, orient="index")
    frame = frame.replace({MINUS: "-", PLUS_MINUS: "+-"}, regex=True)
    return str(frame.rename_axis(columns="metric").to_string())


def as_csv(data: xarray.Dataset) -> str:
    """Write one row a metric; value, numerical error and verdict of every law."""
    names = {"metric": "metric", "meaning": "meaning", "units": "units", "must be": "threshold"}
    frame = pandas.DataFrame({title: data[name].values for title, name in names.items()})
    for label in data["law"].values:
        one = data.sel(law=label)
        frame[label] = one["value"].values
        frame[f"{label} numerical error"] = one["numerical_error"].values
        frame[f"{label} verdict"] = [VERDICTS[flag] for flag in one["verdict"].values]
    form = {"float_format": "%.9g", "na_rep": NOT_APPLICABLE, "lineterminator": "\n"}
    return str(frame.to_csv(index=False, **form))


def as_latex(data: xarray.Dataset) -> str:
    """Write a tabular that stands in any document that loads booktabs."""
    labels = [latex(str(label)) for label in data["law"].values]
    return "\n".join(
        [
            r"% \usepackage{booktabs} in the preamble.",
            rf"\begin{{tabular}}{{p{{0.3\textwidth}}l{'r' * len(labels)}}}",
            r"\toprule",
            " & ".join(["", "must be", *labels]) + r" \\",
            r"\midrule",
            *(_latex_row(metric, cells.values()) for metric, cells in rows(data)),
            r"\bottomrule",
            r"\end{tabular}",
            "",
        ]
    )


def latex(text: str) -> str:
    """Write plain text for LaTeX."""
    return text.translate(_SPECIAL)


_NAMES: Final = ("backslash", "asciitilde", "asciicircum", "less", "greater", "bar", "mu")
_SPECIAL: Final = str.maketrans(
    {sign: rf"\text{name}{{}}" for sign, name in zip("\\~^<>|\u00b5", _NAMES, strict=True)}
    | {sign: rf"\{sign}" for sign in "_%&#{}$"}
)


def _latex_row(metric: Metric, cells: Iterable[Cell]) -> str:
    # CF units such as N m-1.
    units = re.sub(r"(-?\d+)(?= |$)", r"$^{\1}$", latex(metric.units)).replace(" ", r"\,")
    name = latex(metric.brief) + (f" [{units}]" if metric.unit else "")
    limit = rf"$\le {_power(f'{metric.bound:g}')}$" if metric.threshold else ""
    return " & ".join([name, limit, *map(_latex_cell, cells)]) + r" \\"


def _latex_cell(cell: Cell) -> str:
    if isnan(cell.value):
        return NOT_APPLICABLE
    return f"${_power(f'{cell.value:.3g}')}$ {cell.word}".rstrip()


def _power(number: str) -> str:
    """Write 1e-06 as a power of ten."""
    mantissa, _, exponent = number.partition("e")
    return rf"{mantissa} \times 10^{{{int(exponent)}}}" if exponent else mantissa
