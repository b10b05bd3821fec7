"""Plans of many runs: values, axes, what becomes of each run, and the dataset over the parameters."""

from contactlab.sweeps.state import Status as Status
from contactlab.sweeps.values import SweepError as SweepError
