"""One number by which a run is judged: what it means, what it must be, and why."""

from dataclasses import dataclass
from math import isnan
from typing import Final, final

PASS, FAIL, NOT_APPLICABLE, REPORTED = "pass", "fail", "n/a", "-"
"""Verdicts; a metric without a threshold is only reported."""

ROUND_OFF: Final = 1e-6
"""What separates numbers that are equal in theory: single precision, in which a file may be kept, has seven
digits. A law that breaks an identity misses it by a share of the order of one."""


@final
@dataclass(frozen=True)
class Metric:
    """A metric.

    Args:
        key: its name everywhere: in files, tables and code.
        symbol: as in its definition.
        units: SI, in the words of the CF conventions; "1" without.
        meaning: what it is, in a few words.
        relation: "<=" or ">=" of value to bound; empty for a number that is only reported.
        bound: the threshold.
        reason: why the threshold is what it is.
        source: where the metric is from.
    """

    key: str
    symbol: str
    units: str
    meaning: str
    relation: str = ""
    bound: float = 0.0
    reason: str = ""
    source: str = ""

    def verdict(self, value: float) -> str:
        """PASS, FAIL, NOT_APPLICABLE for a NaN, or REPORTED."""
        if isnan(value):
            return NOT_APPLICABLE
        if not self.relation:
            return REPORTED
        held = value <= self.bound if self.relation == "<=" else value >= self.bound
        return PASS if held else FAIL
