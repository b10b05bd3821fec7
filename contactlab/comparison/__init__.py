"""Several contact laws in one motor: every law brought to its own convergence, judged and drawn."""

from contactlab.comparison.report import compare
from contactlab.comparison.runs import ComparisonError

__all__ = ["ComparisonError", "compare"]
