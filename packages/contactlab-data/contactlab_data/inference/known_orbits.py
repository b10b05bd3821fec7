"""Steady states that are followed from those of nearby numbers, where they would be reached from rest.

The answer of a search then depends on what was evaluated before it: the branch of a known orbit is followed,
and from rest a motor with several motions may come to another. A search checks its result from rest, see
`maximum_likelihood`.
"""

from collections import defaultdict, deque
from dataclasses import replace
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.steady_state import steady
from contactlab.steady_state.arrival import followed, is_followed
from contactlab.steady_state.search import LONGEST
from contactlab.steady_state.shooting import Orbit
from contactlab.steady_state.state import Steady

KEPT: Final = 32
"""Orbits of an operating point that are kept, the latest."""


@final
class KnownOrbits:
    """Orbits of operating points, by the numbers that they were found at."""

    def __init__(self) -> None:
        self._orbits = defaultdict[int, deque[tuple[Array, Orbit]]](lambda: deque(maxlen=KEPT))
        self._complete = False

    def complete(self) -> None:
        """Keep no further orbit: a steady state then depends on its own numbers alone."""
        self._complete = True

    def steady(self, point: int, shares: Array, setup: Setup, longest: int = LONGEST) -> Steady:
        """Return the steady state that follows the nearest known orbit, or the one that is reached from rest.

        Args:
            point: number of the operating point.
            shares: its free numbers in the unit cube, shape (parameter,).
            setup: of the motor at this point.
            longest: run from rest without an orbit [periods].

        Raises:
            NotSettledError, BrokenOffError: as of `contactlab.steady`.
        """
        known, state = self._orbits[point], None
        if known:
            _, nearest = min(known, key=lambda each: float(np.linalg.norm(each[0] - shares)))
            state = followed(setup, nearest)
        found = steady(setup, longest=longest) if state is None else state
        orbit = found.orbit
        if orbit is not None and not self._complete and (state is not None or is_followed(orbit)):
            # A map that has run holds tens of megabytes.
            known.append((shares, replace(orbit, map=replace(orbit.map))))
        return found
