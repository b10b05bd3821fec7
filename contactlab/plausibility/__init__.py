"""What a dataset says of its contact law: metrics with thresholds, from the recorded numbers alone."""

from contactlab.plausibility.assessment import (
    INVARIANTS,
    METRICS,
    SENSITIVITIES,
    STEP_METRICS,
    assess,
    assess_steps,
    assess_variants,
)
from contactlab.plausibility.metric import FAIL, NOT_APPLICABLE, PASS, REPORTED, Metric
from contactlab.plausibility.reading import configuration_of, is_complete, read_run
from contactlab.plausibility.record import Record

__all__ = [
    "FAIL",
    "INVARIANTS",
    "METRICS",
    "NOT_APPLICABLE",
    "PASS",
    "REPORTED",
    "SENSITIVITIES",
    "STEP_METRICS",
    "Metric",
    "Record",
    "assess",
    "assess_steps",
    "assess_variants",
    "configuration_of",
    "is_complete",
    "read_run",
]
