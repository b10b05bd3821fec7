"""What a dataset says of its contact law: metrics with thresholds, from the recorded numbers alone."""

from contactlab.plausibility.metric import FAIL, NOT_APPLICABLE, PASS, REPORTED, Metric

__all__ = ["FAIL", "NOT_APPLICABLE", "PASS", "REPORTED", "Metric"]
