"""Branches of periodic orbits over a parameter, through folds, by pseudo-arclength continuation.

Source: Seydel, Practical Bifurcation and Stability Analysis (2010), ch. 4.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.orbits.period_map import BrokenOffError, PeriodMap
from contactlab.orbits.shooting import CLOSED, Orbit, derivative_of, updated

MOST_CORRECTIONS: Final = 10
"""Of a predicted point, before a shorter step is tried."""

EASY: Final = 4
"""Corrections at most after which the next step may be longer."""

LONGER: Final = 1.5

SHORTEST: Final = 1e-4
"""Step over the first one, below which a branch is taken to end: where a contact begins to graze, no orbit
goes on smoothly."""


@final
@dataclass(frozen=True)
class BranchPoint:
    """An orbit of a branch, and the value of the parameter there."""

    value: float
    orbit: Orbit


def branch(
    map_at: Callable[[float], PeriodMap], first: Orbit, value: float, end: float, step: float = 0.02
) -> Iterator[BranchPoint]:
    """Follow a branch of periodic orbits from one of them, until the parameter leaves its range.

    Unknown are y = (z / |z_0|, (parameter - value) / (end - value)); the branch is a curve of
    P(z; parameter) = z, followed along its tangent in steps of its length, so that it may turn back.

    Args:
        map_at: gives the period map of a value of the parameter.
        first, value: where the branch begins.
        end: of the parameter's range, which begins at `value`.
        step: length of the first step; a fiftieth of range and state by default.

    Yields:
        The orbits, stable or not, the first one included.
    """
    size, span = float(np.linalg.norm(first.state)), end - value

    def gap_of(y: Array) -> Array:
        z = y[:-1] * size
        try:
            return (map_at(float(value + span * y[-1]))(z) - z) / size
        # A rigid law refuses a start inside the rotor.
        except (BrokenOffError, ValueError):
            return np.full(z.size, np.inf)

    y = np.append(first.state / size, 0.0)
    orbit, tangent, longest = first, np.append(np.zeros(first.state.size), 1.0), 4.0 * step
    least = SHORTEST * step
    yield BranchPoint(value, first)
    while True:
        along = derivative_of(gap_of, y, np.eye(y.size)[-1])
        jacobian = np.column_stack([orbit.jacobian - np.eye(y.size - 1), along])
        # What no row of the derivative sees, on the way that led here.
        ahead = np.linalg.svd(jacobian)[2][-1]
        tangent = ahead if ahead @ tangent >= 0.0 else -ahead
        while (found := _corrected(gap_of, jacobian, tangent, y + step * tangent, step)) is None:
            step *= 0.5
            if step < least:
                return
        y, count = found
        at = float(value + span * y[-1])
        orbit = Orbit.at(map_at(at), y[:-1] * size)
        yield BranchPoint(at, orbit)
        if not 0.0 <= y[-1] <= 1.0:
            return
        step = min(LONGER * step, longest) if count <= EASY else step


def _corrected(
    gap_of: Callable[[Array], Array], jacobian: Array, tangent: Array, guess: Array, reach: float
) -> tuple[Array, int] | None:
    """Bring a predicted point onto the branch, across the tangent; give it and the corrections it took."""
    y, left = guess, gap_of(guess)
    for count in range(MOST_CORRECTIONS):
        if not np.all(np.isfinite(left)) or np.linalg.norm(y - guess) > reach:
            return None
        if np.linalg.norm(left) <= CLOSED:
            return y, count
        move = -np.linalg.solve(np.vstack([jacobian, tangent]), np.append(left, tangent @ (y - guess)))
        y, before = y + move, left
        left = gap_of(y)
        jacobian = updated(jacobian, move, left - before)
    return None
