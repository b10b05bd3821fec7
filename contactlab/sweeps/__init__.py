"""Many runs: what becomes of each, and their metrics in one dataset over the parameters."""

from contactlab.sweeps.batch import WorkerError
from contactlab.sweeps.collection import collect
from contactlab.sweeps.state import Status
from contactlab.sweeps.sweep import sweep
from contactlab.sweeps.values import SweepError

__all__ = ["Status", "SweepError", "WorkerError", "collect", "sweep"]
