"""Many runs: what becomes of each, and their metrics in one dataset over the parameters."""

from contactlab.sweeps.collection import collect
from contactlab.sweeps.state import Status

__all__ = ["Status", "collect"]
