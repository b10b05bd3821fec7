"""Steady states of a motor: periodic orbits, their stability and branches, and means where there is none."""

from contactlab.orbits.arrival import NotSettledError as NotSettledError, UnboundedError as UnboundedError
from contactlab.orbits.basins import Basins as Basins, basins as basins
from contactlab.orbits.branches import Branch as Branch, NoBranchError as NoBranchError, branch as branch
from contactlab.orbits.coexisting import Attractor as Attractor, attractors as attractors
from contactlab.orbits.convergence import Converged as Converged, converged as converged
from contactlab.orbits.period_map import BrokenOffError as BrokenOffError, NoPeriodError as NoPeriodError
from contactlab.orbits.search import Steady as Steady, steady as steady
