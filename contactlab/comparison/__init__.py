"""Several contact laws in one motor: every law brought to its own convergence, judged and drawn."""

from contactlab.comparison.comparing import compare
from contactlab.comparison.faults import ComparisonError

__all__ = ["ComparisonError", "compare"]
