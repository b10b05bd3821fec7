"""The scorecard as a dataset: every metric of every law, its verdict and its numerical error."""

import json
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
import xarray
import yaml

from contactlab.comparison.energy import ENERGY_TERMS, drive_work, energy_flow
from contactlab.comparison.reruns import Refined
from contactlab.metrics import (
    FAIL,
    METRICS,
    NOT_APPLICABLE,
    PASS,
    REPORTED,
    SENSITIVITIES,
    STEP_METRICS,
    Metric,
    assess,
    assess_steps,
    assess_variants,
)
from contactlab.results.provenance import checkout_state, versions

VERDICTS: Final = (NOT_APPLICABLE, PASS, FAIL, REPORTED)
"""In the order of their flags."""

FLAGS: Final = ("not_applicable", "pass", "fail", "reported")
"""The same as words of the CF conventions."""


def every_metric() -> dict[str, Metric]:
    """All rows of a scorecard, those that are judged first."""
    every = {**METRICS, **STEP_METRICS, **SENSITIVITIES}
    return dict(sorted(every.items(), key=lambda entry: not entry[1].relation))


def scorecard(laws: Sequence[Refined], notes: Sequence[str] = ()) -> xarray.Dataset:
    """Judge every law.

    Returns:
        A dataset with the dimensions `law`, `metric` and `term` (of the energy flow).
    """
    metrics = every_metric()
    values = np.full((len(laws), len(metrics)), np.nan)
    errors = np.full_like(values, np.nan)
    for i, law in enumerate(laws):
        found, spread = _judged(law)
        values[i] = [found.get(key, np.nan) for key in metrics]
        errors[i] = [spread.get(key, np.nan) for key in metrics]
    verdicts = [
        [
            VERDICTS.index(metric.verdict(value))
            for metric, value in zip(metrics.values(), row, strict=True)
        ]
        for row in values
    ]
    both = ("law", "metric")
    return xarray.Dataset(
        {
            "value": (both, values, {"long_name": "value of the metric", "comment": _UNITS}),
            "numerical_error": (
                both,
                errors,
                {"long_name": "error of the value by Richardson's estimate", "comment": _UNITS},
            ),
            "verdict": (
                both,
                np.array(verdicts, dtype=np.int8),
                {
                    "flag_values": np.arange(len(FLAGS), dtype=np.int8),
                    "flag_meanings": " ".join(FLAGS),
                },
            ),
            "energy": (
                ("law", "term"),
                np.array([list(energy_flow(law.best).values()) for law in laws]),
                {"units": "J", "long_name": "where the work of the drive has gone"},
            ),
            "drive_work": (
                "law",
                np.array([drive_work(law.best) for law in laws]),
                {"units": "J", "long_name": "work of the drive on the resonator"},
            ),
        },
        coords=_coordinates(laws, metrics),
        attrs=_attributes(laws, notes),
    )


_UNITS: Final = "units differ by metric and stand in the coordinate `units`"


def _judged(law: Refined) -> tuple[dict[str, float], dict[str, float]]:
    """Values and numerical errors by metric."""
    found = assess(law.best)
    errors: dict[str, float] = {}
    if law.steps:
        every = {id(tree): assess(tree) for _, tree in law.steps}
        errors = {key: _error(law, every, key) for key in found}
        found |= assess_steps(law.steps)
    found |= assess_variants(law.base, basis=law.basis, friction=law.friction)
    return found, errors


def _error(law: Refined, every: Mapping[int, Mapping[str, float]], key: str) -> float:
    """Numerical error of one metric of the finest rerun."""
    return float(law.error(lambda tree: every[id(tree)][key]))


def _coordinates(laws: Sequence[Refined], metrics: Mapping[str, Metric]) -> dict[str, object]:
    def text(words: Sequence[str]) -> np.ndarray:
        return np.array(words, dtype=object)

    rows = metrics.values()
    return {
        "law": text([law.run.label for law in laws]),
        "metric": text(list(metrics)),
        "term": text(list(ENERGY_TERMS)),
        "symbol": ("metric", text([m.symbol for m in rows])),
        "units": ("metric", text([m.units for m in rows])),
        "meaning": ("metric", text([m.meaning for m in rows])),
        "threshold": ("metric", text([threshold(m) for m in rows])),
        "reason": ("metric", text([m.reason for m in rows])),
        "metric_source": ("metric", text([m.source for m in rows])),
        "run": ("law", text([law.run.source for law in laws])),
        "refined": ("law", text([_refinement(law) for law in laws])),
        "configuration": (
            "law",
            text([yaml.safe_dump(dict(law.run.configuration), sort_keys=False) for law in laws]),
        ),
        "law_parameters": (
            "law",
            text([str(law.run.tree.attrs.get("law_parameters", "")) for law in laws]),
        ),
    }


def threshold(metric: Metric) -> str:
    """Relation and bound; empty for a metric without."""
    return f"{metric.relation} {metric.bound:g}" if metric.relation else ""


def _refinement(law: Refined) -> str:
    """What the law's values were found at."""
    if not law.steps:
        return "as recorded"
    units = " s" if law.control == "contact_step" else ""
    return f"{law.control} {', '.join(f'{value:.3g}' for value, _ in law.steps)}{units}"


def _attributes(laws: Sequence[Refined], notes: Sequence[str]) -> dict[str, object]:
    code = versions()
    revision, dirty = checkout_state()
    recorded_by = {
        law.run.label: str(law.run.tree.attrs.get("contactlab_version", "unknown")) for law in laws
    }
    return {
        "Conventions": "CF-1.11",
        "title": f"Contact laws compared: {', '.join(law.run.label for law in laws)}",
        "source": f"contactlab {code['contactlab_version']}, numerical simulation",
        "notes": "\n".join([*notes, *(note for law in laws for note in law.notes)]),
        "recorded_by": json.dumps(recorded_by),
        **code,
        "git_revision": revision,
        "git_dirty": dirty,
    }
