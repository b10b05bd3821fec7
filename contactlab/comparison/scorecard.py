"""The scorecard: every metric of every law with verdict and numerical error, a dataset and its tables."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan, nan
from typing import Final, final

import numpy as np
import pandas
import xarray
from yaml import safe_dump

from contactlab import metrics
from contactlab.comparison.measured import with_measurements
from contactlab.comparison.measurements import Judged, row
from contactlab.comparison.reruns import Refined
from contactlab.comparison.settled import QUANTITIES
from contactlab.metrics import NOT_APPLICABLE, REPORTED, VERDICTS, Metric, NotApplicableError, Run
from contactlab.metrics.balances import SPENT, STORED
from contactlab.results.provenance import code_attributes

EVERY: Final = metrics.METRICS | metrics.STEP_METRICS | metrics.SENSITIVITIES
FLAGS: Final = "not_applicable pass fail reported settled not_settled cannot_tell"
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

LATEX: Final = str.maketrans(
    {sign: rf"\{sign}" for sign in "_%&#{}$"}
    | {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
    | {"<": r"\textless{}", ">": r"\textgreater{}", "|": r"\textbar{}", "\u00b5": r"\textmu{}"}
)
"""Plain text for LaTeX, by `str.translate`."""


def scorecard(
    laws: Sequence[Refined], notes: Sequence[str] = (), measured: Sequence[Judged] = ()
) -> xarray.Dataset:
    """Judge every law.

    Returns:
        A dataset with the dimensions `law`, `metric`, those first that have a threshold and those last that
        come from measurements, and `term` (of the energy flow).
    """
    own = sorted(EVERY.values(), key=lambda metric: not metric.threshold)
    every = [*own, *(metric for one in measured for metric in one.rows)]
    runs, judged = [law.run for law in laws], [_judged(law) for law in laws]
    values = [[found.get(metric.key, nan) for metric in own] for found, _ in judged]
    errors = [[error.get(metric.key, nan) for metric in own] for _, error in judged]
    for one in measured:
        values = [[*line, *more] for line, more in zip(values, one.values.T.tolist(), strict=True)]
        errors = [[*line, *more] for line, more in zip(errors, one.errors.T.tolist(), strict=True)]
    notes = [*notes, *(note for one in measured for note in one.notes)]
    verdicts = [
        [VERDICTS.index(metric.verdict(x)) for metric, x in zip(every, row, strict=True)] for row in values
    ]
    configurations = [dict(run.configuration) for run in runs]
    settled = any(law.means for law in laws)
    flows = [energy_flow(law.best, law.period if settled else 0.0) for law in laws]
    gone = [[flow[term] for term in ENERGY_TERMS] for flow in flows]
    flags = {"flag_values": np.arange(len(VERDICTS), dtype=np.int8), "flag_meanings": FLAGS}
    both, units = ("law", "metric"), {"comment": "units differ by metric, see `units`"}
    # Of impacts that were measured it is what resampling them leaves open.
    error = {"long_name": "error of the value: Richardson's, or half of a 95 % bootstrap interval", **units}
    energy = {"units": "J", "long_name": "where the work of the drive has gone"}
    work = {"units": "J", "long_name": "work of the drive on the resonator"}
    card = xarray.Dataset(
        {
            "value": (both, values, {"long_name": "value of the metric", **units}),
            "numerical_error": (both, errors, error),
            "verdict": (both, np.array(verdicts, dtype=np.int8), flags),
            "energy": (("law", "term"), gone, energy),
            "drive_work": ("law", [flow["drive_work"] for flow in flows], work),
        },
        coords={
            "law": [run.label for run in runs],
            "metric": [metric.key for metric in every],
            "term": list(ENERGY_TERMS),
            **{
                name: ("metric", [getattr(metric, name) for metric in every])
                for name in ("symbol", "units", "meaning", "threshold", "reason")
            },
            "metric_source": ("metric", [metric.source for metric in every]),
            "run": ("law", [run.source for run in runs]),
            "refined": ("law", [_refinement(law) for law in laws]),
            "configuration": ("law", [safe_dump(c, sort_keys=False) for c in configurations]),
            **{
                name: ("law", [str(run.attributes.get(name, "")) for run in runs])
                for name in ("law_parameters", "contactlab_version")
            },
        },
        attrs={
            **code_attributes(),
            "title": f"Contact laws compared: {', '.join(run.label for run in runs)}",
            "notes": "\n".join([*notes, *(note for law in laws for note in law.notes)]),
        },
    )
    return with_measurements(card, measured)


def _judged(law: Refined) -> tuple[dict[str, float], dict[str, float]]:
    """Give values and numerical errors by metric."""
    if not law.steps:
        means = dict(zip(QUANTITIES, law.means[-1].values.tolist(), strict=True)) if law.means else {}
        return metrics.assess(law.best) | means, {}
    steps = [metrics.assess(run) for _, run in law.steps]
    errors = {key: float(law.error([each[key] for each in steps])) for key in steps[-1]}
    found = steps[-1] | metrics.assess_steps(law.steps)
    if law.means:
        error = law.error([each.values for each in law.means], each=True) + law.means[-1].errors
        found |= dict(zip(QUANTITIES, law.means[-1].values.tolist(), strict=True))
        errors |= dict(zip(QUANTITIES, error.tolist(), strict=True))
    return found | metrics.assess_variants(law.base, **law.variants), errors


def _refinement(law: Refined) -> str:
    """Say what the law's values were found at."""
    if not law.steps:
        return "the settled motor, steps as recorded" if law.means else "as recorded"
    said = f"{law.control} {', '.join(f'{step:.3g}' for step, _ in law.steps)}"
    return f"the settled motor, {said}" if law.means else said


def energy_flow(run: Run, period: float = 0.0) -> dict[str, float]:
    """Give the work of the drive and where it has gone by the end of a run [J]; the terms add up to it.

    A period [s] makes it the mean over times as long.

    The ledger is E(t) - E(0) = drive_work - losses - load_work + energy_residual, so that the residual
    counts as energy that has gone nowhere with its sign turned. A run that lacks a series of the ledger
    has no flow: NaN.
    """
    names = ("drive_work", "energy_residual", *STORED, *SPENT)
    try:
        share = period / run.gain("time") if period else 1.0
        gain = {name: share * run.gain(name) for name in names}
    except NotApplicableError:
        return dict.fromkeys(("drive_work", *ENERGY_TERMS), nan)
    flow = {name: gain[name] for name in ("drive_work", *SPENT)}
    stored = sum(gain[name] for name in STORED)
    return flow | {"stored_energy": stored, "unaccounted": -gain["energy_residual"]}


@final
@dataclass(frozen=True)
class Cell:
    """One law under one metric."""

    value: float
    error: float
    verdict: str

    @property
    def number(self) -> str:
        """The value with its error, n/a or the like where there is none."""
        if isnan(self.value):
            return self.verdict
        error = f" {PLUS_MINUS} {self.error:.1g}" if self.error > 0.0 else ""
        return f"{self.value:.4g}{error}".replace("-", MINUS)

    @property
    def word(self) -> str:
        """The verdict, empty where nothing is judged or the number says it."""
        return "" if self.verdict == REPORTED or isnan(self.value) else self.verdict


def rows(data: xarray.Dataset) -> list[tuple[Metric, dict[str, Cell]]]:
    """Take a scorecard apart: every metric with a cell for every law."""
    names, laws = ("value", "numerical_error", "verdict"), list(map(str, data["law"].values))
    table = []
    for key, *line in zip(data["metric"].values, *(data[n].values.T for n in names), strict=True):
        cells = (Cell(x, error, VERDICTS[flag]) for x, error, flag in zip(*line, strict=True))
        table.append((_metric(data, str(key)), dict(zip(laws, cells, strict=True))))
    return table


def _metric(data: xarray.Dataset, key: str) -> Metric:
    """Give the metric of a row; one that is measured is as the dataset has it."""
    if key in EVERY:
        return EVERY[key]
    one = data.sel(metric=key)
    return row(key, *(str(one[name].item()) for name in ("symbol", "meaning", "units", "metric_source")))


def as_text(data: xarray.Dataset) -> str:
    """Write the table for a terminal, plain ASCII."""
    width = max(len(threshold) for threshold in data["threshold"].values)
    lines = {
        metric.key + metric.bracketed: {"must be": metric.threshold.ljust(width)}
        | {label: f"{cell.number} {cell.word}".rstrip() for label, cell in cells.items()}
        for metric, cells in rows(data)
    }
    frame = pandas.DataFrame.from_dict(lines, orient="index").rename_axis(columns="metric")
    return str(frame.replace({MINUS: "-", PLUS_MINUS: "+-"}, regex=True).to_string())


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
    lines = [["", "must be", *labels]]
    for metric, cells in rows(data):
        # CF units such as N m-1.
        units = re.sub(r"-?[\d.]+", r"$^{\g<0>}$", metric.units).replace(" ", r"\,")
        name = metric.brief.translate(LATEX) + (f" [{units}]" if metric.unit else "")
        limit = rf"$\le {_power(f'{metric.bound:g}')}$" if metric.threshold else ""
        lines.append([name, limit])
        for c in cells.values():
            number = f"${_power(f'{c.value:.3g}')}$ {c.word}".rstrip()
            lines[-1].append(c.verdict if isnan(c.value) else number)
    head, *body = (" & ".join(line) + r" \\" for line in lines)
    start = rf"\begin{{tabular}}{{p{{0.3\textwidth}}l{'r' * len(labels)}}}"
    rules = (r"% \usepackage{booktabs} in the preamble.", start, r"\toprule", head, r"\midrule")
    return "\n".join([*rules, *body, r"\bottomrule", "\\end{tabular}\n"])


def _power(number: str) -> str:
    """Write 1e-06 as a power of ten."""
    mantissa, _, exponent = number.partition("e")
    return rf"{mantissa} \times 10^{{{int(exponent)}}}" if exponent else mantissa
