"""What a dataset says of its contact law: metrics with thresholds, from the recorded numbers alone."""

from contactlab.metrics.assessment import (
    INVARIANTS,
    METRICS,
    SENSITIVITIES,
    STEP_METRICS,
    assess,
    assess_steps,
    assess_variants,
)
from contactlab.metrics.metric import FAIL, NOT_APPLICABLE, PASS, REPORTED, Metric
from contactlab.metrics.reading import is_complete, read_run
from contactlab.metrics.record import Record
from contactlab.results.netcdf import configuration_of

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
