"""Steady states of a motor: periodic orbits, their stability and branches, and means where there is none."""

from contactlab.orbits.basins import Attractor as Attractor, attractors as attractors
from contactlab.orbits.convergence import Converged as Converged, converged as converged
from contactlab.orbits.period_map import BrokenOffError as BrokenOffError, NoPeriodError as NoPeriodError
from contactlab.orbits.search import Steady as Steady, steady as steady
from contactlab.orbits.settling import NotSettledError as NotSettledError
