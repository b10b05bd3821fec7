"""The scorecard as a dataset: every metric of every law, its verdict and its numerical error."""

import json
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from math import nan
from typing import Any, Final

import numpy as np
import xarray
import yaml

from contactlab.comparison.reruns import Refined
from contactlab.metrics import (
    METRICS,
    SENSITIVITIES,
    STEP_METRICS,
    VERDICTS,
    Run,
    assess,
    assess_steps,
    assess_variants,
)
from contactlab.results.provenance import checkout_state, versions

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

_STORED: Final = ("kinetic_energy", "strain_energy", "contact_energy")
_UNITS: Final = "units differ by metric and stand in the coordinate `units`"


def scorecard(laws: Sequence[Refined], notes: Sequence[str] = ()) -> xarray.Dataset:
    """Judge every law.

    Returns:
        A dataset with the dimensions `law`, `metric`, those first that have a threshold, and `term` (of the
        energy flow).
    """
    every = METRICS | STEP_METRICS | SENSITIVITIES
    metrics = sorted(every.values(), key=lambda metric: not metric.threshold)
    values, errors = (
        np.array([[numbers.get(metric.key, nan) for metric in metrics] for numbers in found])
        for found in zip(*map(_judged, laws), strict=True)
    )
    verdicts = [
        [VERDICTS.index(m.verdict(value)) for m, value in zip(metrics, row, strict=True)]
        for row in values
    ]
    both = ("law", "metric")
    flags = {
        "flag_values": np.arange(len(FLAGS), dtype=np.int8),
        "flag_meanings": " ".join(FLAGS),
    }
    texts = {
        name: [getattr(metric, name) for metric in metrics]
        for name in ("symbol", "units", "meaning", "threshold", "reason", "source")
    }
    texts["metric_source"] = texts.pop("source")
    code = versions()
    revision, dirty = checkout_state()
    labels = [law.run.label for law in laws]
    recorded_by = (law.run.attributes.get("contactlab_version", "unknown") for law in laws)
    return xarray.Dataset(
        {
            "value": (both, values, {"long_name": "value of the metric", "comment": _UNITS}),
            "numerical_error": (
                both,
                errors,
                {"long_name": "error of the value by Richardson's estimate", "comment": _UNITS},
            ),
            "verdict": (both, np.array(verdicts, dtype=np.int8), flags),
            "energy": (
                ("law", "term"),
                np.array([list(energy_flow(law.best).values()) for law in laws]),
                {"units": "J", "long_name": "where the work of the drive has gone"},
            ),
            "drive_work": (
                "law",
                np.array([_gain(law.best, "drive_work") for law in laws]),
                {"units": "J", "long_name": "work of the drive on the resonator"},
            ),
        },
        coords={
            "law": _text(labels),
            "metric": _text(metric.key for metric in metrics),
            "term": _text(ENERGY_TERMS),
            **{name: ("metric", _text(words)) for name, words in texts.items()},
            "run": ("law", _text(law.run.source for law in laws)),
            "refined": ("law", _text(map(_refinement, laws))),
            "configuration": ("law", _text(_configuration(law.run) for law in laws)),
            "law_parameters": (
                "law",
                _text(str(law.run.attributes.get("law_parameters", "")) for law in laws),
            ),
        },
        attrs={
            "Conventions": "CF-1.11",
            "title": f"Contact laws compared: {', '.join(labels)}",
            "source": f"contactlab {code['contactlab_version']}, numerical simulation",
            "notes": "\n".join([*notes, *(note for law in laws for note in law.notes)]),
            "recorded_by": json.dumps(dict(zip(labels, map(str, recorded_by), strict=True))),
            **code,
            "git_revision": revision,
            "git_dirty": dirty,
        },
    )


def _judged(law: Refined) -> tuple[Mapping[str, float], Mapping[str, float]]:
    """Give values and numerical errors by metric."""
    found = assess(law.best)
    errors: dict[str, float] = {}
    if law.steps:
        every = {id(run): assess(run) for _, run in law.steps}
        errors = {key: float(law.error(partial(_value, every, key))) for key in found}
        found |= assess_steps(law.steps)
    return found | assess_variants(law.base, basis=law.basis, friction=law.friction), errors


def _value(every: Mapping[int, Mapping[str, float]], key: str, run: Run) -> float:
    return every[id(run)][key]


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


def _configuration(run: Run) -> str:
    return yaml.safe_dump(dict(run.configuration), sort_keys=False)


def _text(words: Iterable[Any]) -> np.ndarray:
    return np.array(list(words), dtype=object)
