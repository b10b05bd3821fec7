"""A metric and how its value is found."""

from collections.abc import Callable, Container, Iterable
from dataclasses import dataclass
from math import isfinite, nan
from typing import Generic, TypeVar, final

import numpy as np

from contactlab.metrics.metric import Metric
from contactlab.metrics.record import NotApplicableError

Subject = TypeVar("Subject")


@final
@dataclass(frozen=True)
class Measure(Generic[Subject]):
    """A metric with the function that measures it.

    Args:
        metric: what is measured.
        value: gives the number, or stops with `NotApplicableError`.
    """

    metric: Metric
    value: Callable[[Subject], float]


def table(measures: Iterable[Measure[Subject]]) -> dict[str, Metric]:
    """The metrics by key, in their order."""
    return {measure.metric.key: measure.metric for measure in measures}


def measured(
    measures: Iterable[Measure[Subject]], subject: Subject, keys: Container[str] | None = None
) -> dict[str, float]:
    """Every metric's value, or those of some keys; NaN where it is not applicable or not a number."""
    # Numbers of a user's own may overflow on the way; the result says so.
    with np.errstate(all="ignore"):
        return {
            measure.metric.key: _value(measure, subject)
            for measure in measures
            if keys is None or measure.metric.key in keys
        }


def _value(measure: Measure[Subject], subject: Subject) -> float:
    try:
        value = float(measure.value(subject))
    except NotApplicableError:
        return nan
    return value if isfinite(value) else nan
