from contactlab.steady_state.arrival import (
    NotSettledError as NotSettledError,
    UnboundedError as UnboundedError,
)
from contactlab.steady_state.basins import Attractor as Attractor, attractors as attractors
from contactlab.steady_state.branches import (
    Branch as Branch,
    NoBranchError as NoBranchError,
    branch as branch,
)
from contactlab.steady_state.period_map import (
    BrokenOffError as BrokenOffError,
    NoPeriodError as NoPeriodError,
)
from contactlab.steady_state.search import (
    Converged as Converged,
    Steady as Steady,
    converged as converged,
    orbit as orbit,
    steady as steady,
)
