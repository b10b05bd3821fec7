"""The scorecard: every metric of every law with verdict and numerical error, a dataset and its tables."""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isnan, nan
from typing import Final, final

import numpy as np
import pandas
import xarray
import yaml

from contactlab.comparison.reruns import Refined
from contactlab.metrics import (
    METRICS,
    NOT_APPLICABLE,
    REPORTED,
    SENSITIVITIES,
    STEP_METRICS,
    VERDICTS,
    Metric,
    Run,
    assess,
    assess_steps,
    assess_variants,
)
from contactlab.results.provenance import checkout_state, versions

EVERY: Final = METRICS | STEP_METRICS | SENSITIVITIES
"""All that a law is judged by."""

FLAGS: Final = ("not_applicable", "pass", "fail", "reported")
"""`VERDICTS` as words of the CF conventions."""

ENERGY_TERMS: Final = {
    "damping_loss": "viscous damping",
    "friction_loss": "friction",
    "contact_loss": "contact losses",
    "load_work": "load work",
    "stored_energy": "change of stored energy",
    "unaccounted": "unaccounted",
}
"""In the order of the figure; the words are those of figure and table."""

MINUS, PLUS_MINUS = "\u2212", "\u00b1"

_NAMES: Final = ("backslash", "asciitilde", "asciicircum", "less", "greater", "bar", "mu")

LATEX: Final = str.maketrans(
    {sign: rf"\text{name}{{}}" for sign, name in zip("\\~^<>|\u00b5", _NAMES, strict=True)}
    | {sign: rf"\{sign}" for sign in "_%&#{}$"}
)
"""Plain text for LaTeX, by `str.translate`."""

_STORED: Final = ("kinetic_energy", "strain_energy", "contact_energy")
_UNITS: Final = {"comment": "units differ by metric and stand in the coordinate `units`"}


def scorecard(laws: Sequence[Refined], notes: Sequence[str] = ()) -> xarray.Dataset:
    """Judge every law.

    Returns:
        A dataset with the dimensions `law`, `metric`, those first that have a threshold, and `term` (of the
        energy flow).
    """
    metrics = sorted(EVERY.values(), key=lambda metric: not metric.threshold)
    values, errors = (
        [[numbers.get(metric.key, nan) for metric in metrics] for numbers in found]
        for found in zip(*map(_judged, laws), strict=True)
    )
    verdicts = [
        [VERDICTS.index(m.verdict(value)) for m, value in zip(metrics, row, strict=True)]
        for row in values
    ]
    flags = {"flag_values": np.arange(len(FLAGS), dtype=np.int8), "flag_meanings": " ".join(FLAGS)}
    gone = {"units": "J", "long_name": "where the work of the drive has gone"}
    work = {"units": "J", "long_name": "work of the drive on the resonator"}
    error = {"long_name": "error of the value by Richardson's estimate", **_UNITS}
    energy = [list(energy_flow(law.best).values()) for law in laws]
    both = ("law", "metric")
    labels = [law.run.label for law in laws]
    attributes = [law.run.attributes for law in laws]
    recorded_by = [str(given.get("contactlab_version", "unknown")) for given in attributes]
    code = versions()
    revision, dirty = checkout_state()
    return xarray.Dataset(
        {
            "value": (both, values, {"long_name": "value of the metric", **_UNITS}),
            "numerical_error": (both, errors, error),
            "verdict": (both, np.array(verdicts, dtype=np.int8), flags),
            "energy": (("law", "term"), energy, gone),
            "drive_work": ("law", [_gain(law.best, "drive_work") for law in laws], work),
        },
        coords={
            "law": labels,
            "metric": [metric.key for metric in metrics],
            "term": list(ENERGY_TERMS),
            **{
                name: ("metric", [getattr(metric, name) for metric in metrics])
                for name in ("symbol", "units", "meaning", "threshold", "reason")
            },
            "metric_source": ("metric", [metric.source for metric in metrics]),
            "run": ("law", [law.run.source for law in laws]),
            "refined": ("law", [_refinement(law) for law in laws]),
            "configuration": (
                "law",
                [yaml.safe_dump(dict(law.run.configuration), sort_keys=False) for law in laws],
            ),
            "law_parameters": ("law", [str(a.get("law_parameters", "")) for a in attributes]),
        },
        attrs={
            "Conventions": "CF-1.11",
            "title": f"Contact laws compared: {', '.join(labels)}",
            "source": f"contactlab {code['contactlab_version']}, numerical simulation",
            "notes": "\n".join([*notes, *(note for law in laws for note in law.notes)]),
            "recorded_by": json.dumps(dict(zip(labels, recorded_by, strict=True))),
            **code,
            "git_revision": revision,
            "git_dirty": dirty,
        },
    )


def _judged(law: Refined) -> tuple[Mapping[str, float], Mapping[str, float]]:
    """Give values and numerical errors by metric."""
    steps = [assess(run) for _, run in law.steps]
    found = steps[-1] if steps else assess(law.run)
    errors = {key: float(law.error([each[key] for each in steps])) for key in found if steps}
    found = found | (assess_steps(law.steps) if steps else {})
    return found | assess_variants(law.base, law.basis, law.friction), errors


def energy_flow(run: Run) -> dict[str, float]:
    """Give where the work of the drive has gone by the end of a run [J]; the terms add up to it.

    The ledger is E(t) - E(0) = drive_work - losses - load_work + energy_residual, so that the residual
    counts as energy that has gone nowhere with its sign turned. A run that lacks a series of the ledger
    has no flow: NaN.
    """
    terms = {name: _gain(run, name) for name in ENERGY_TERMS}
    terms["stored_energy"] = sum(_gain(run, name) for name in _STORED)
    terms["unaccounted"] = -_gain(run, "energy_residual")
    whole = np.isfinite([*terms.values(), _gain(run, "drive_work")]).all()
    return terms if whole else dict.fromkeys(terms, nan)


def _gain(run: Run, name: str) -> float:
    values = run.columns.get(name, np.array([nan]))
    return float(values[-1]) - float(values[0])


def _refinement(law: Refined) -> str:
    """Say what the law's values were found at."""
    if not law.steps:
        return "as recorded"
    units = " s" if law.control == "contact_step" else ""
    return f"{law.control} {', '.join(f'{value:.3g}' for value, _ in law.steps)}{units}"


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
    labels = [str(label).translate(LATEX) for label in data["law"].values]
    lines = [["", "must be", *labels], *(_latex_row(*row) for row in rows(data))]
    head, *body = (" & ".join(line) + r" \\" for line in lines)
    return "\n".join(
        [
            r"% \usepackage{booktabs} in the preamble.",
            rf"\begin{{tabular}}{{p{{0.3\textwidth}}l{'r' * len(labels)}}}",
            r"\toprule",
            head,
            r"\midrule",
            *body,
            r"\bottomrule",
            "\\end{tabular}\n",
        ]
    )


def _latex_row(metric: Metric, cells: dict[str, Cell]) -> list[str]:
    # CF units such as N m-1.
    units = re.sub(r"(-?\d+)(?= |$)", r"$^{\1}$", metric.units.translate(LATEX)).replace(" ", r"\,")
    limit = rf"$\le {_power(f'{metric.bound:g}')}$" if metric.threshold else ""
    numbers = (
        NOT_APPLICABLE if isnan(c.value) else f"${_power(f'{c.value:.3g}')}$ {c.word}".rstrip()
        for c in cells.values()
    )
    return [metric.brief.translate(LATEX) + (f" [{units}]" if metric.unit else ""), limit, *numbers]


def _power(number: str) -> str:
    """Write 1e-06 as a power of ten."""
    mantissa, _, exponent = number.partition("e")
    return rf"{mantissa} \times 10^{{{int(exponent)}}}" if exponent else mantissa
