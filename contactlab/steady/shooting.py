"""Periodic orbits by shooting: a state that the period map leaves where it is.

Newton's method on P(z) - z = 0, with the derivative of the period map by central differences, which are good
to 1e-8 where the map is smooth; Broyden's rank-one corrections spare it between. A step never leaves the
ball in which the last one was worth its price (Conn, Gould, Toint: Trust-Region Methods, 2000).
"""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.steady.period_map import BrokenOffError, PeriodMap

STEP: Final = 1e-6
"""Of the differences, in parts of |z|."""

CLOSED: Final = 1e-10
"""|P(z) - z| over |z| at which an orbit counts as closed."""

MOST_ITERATIONS: Final = 40

WORTH: Final = 0.5
"""Share of |P(z) - z| that a step may leave without a new derivative."""


class NoOrbitError(RuntimeError):
    """No orbit was found; the message is a sentence that goes on from 'no periodic orbit'."""


@final
@dataclass(frozen=True)
class Orbit:
    """A closed orbit of the period map.

    Args:
        map: whose fixed point it is.
        state: z at the section.
        closure: |P(z) - z| over |z|.
        jacobian: dP/dz there.
        roughness: relative change of the derivative along one direction when the step of its difference is a
            hundred times as long; large where the map is not smooth.
    """

    map: PeriodMap
    state: Array
    closure: float
    jacobian: Array
    roughness: float

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet multipliers, eigenvalues of dP/dz, the largest first [1]."""
        found = np.linalg.eigvals(self.jacobian).astype(complex)
        return found[np.argsort(-np.abs(found), kind="stable")]

    @property
    def stable(self) -> bool:
        """Whether every multiplier lies inside the unit circle."""
        return bool(abs(self.multipliers[0]) < 1.0)

    @property
    def settling_time(self) -> float:
        """Time in which a small deviation falls by e [s]; infinite for an orbit that is not stable."""
        largest = float(abs(self.multipliers[0]))
        return -self.map.period / np.log(largest) if 0.0 < largest < 1.0 else np.inf


def orbit_from(section: PeriodMap, z: Array) -> Orbit:
    """Find the periodic orbit near a state.

    Raises:
        NoOrbitError: there is none near it.
        KeyboardInterrupt: as it comes.
    """
    image = section(z)
    residual, jacobian = image - z, section.rough_jacobian(z, image, STEP)
    fresh, radius = True, 0.5 * float(np.linalg.norm(z))
    for _ in range(MOST_ITERATIONS):
        if np.linalg.norm(residual) <= CLOSED * np.linalg.norm(z):
            break
        step = np.linalg.solve(np.eye(z.size) - jacobian, residual)
        length = float(np.linalg.norm(step))
        if length > radius:
            step *= radius / length
        left = _residual(section, z + step)
        share = np.linalg.norm(left) / np.linalg.norm(residual)
        if share < 1.0:
            # Broyden: the derivative that would have foretold what the step has left.
            jacobian = jacobian + np.outer(left - residual + step - jacobian @ step, step) / (step @ step)
            z, residual = z + step, left
            radius = max(radius, 2.0 * float(np.linalg.norm(step)))
            fresh = False
        if share > WORTH:
            if fresh:
                radius = 0.25 * min(radius, length)
                if radius < STEP * np.linalg.norm(z):
                    raise NoOrbitError(f"steps shrink to {radius:.1e} and lead no further")
            else:
                jacobian, fresh = section.rough_jacobian(z, residual + z, STEP), True
    else:
        left = np.linalg.norm(residual) / np.linalg.norm(z)
        raise NoOrbitError(f"{MOST_ITERATIONS} steps leave a gap of {left:.1e} of the state")
    jacobian, along = section.jacobian(z, STEP), np.ones(z.size) / np.sqrt(z.size)
    fine, coarse = jacobian @ along, section.derivative(z, along, 100.0 * STEP)
    return Orbit(
        map=section,
        state=z,
        closure=float(np.linalg.norm(residual) / np.linalg.norm(z)),
        jacobian=jacobian,
        roughness=float(np.linalg.norm(coarse - fine) / np.linalg.norm(fine)),
    )


def _residual(section: PeriodMap, z: Array) -> Array:
    """Give P(z) - z; endless where the motor does not run from there."""
    try:
        return section(z) - z
    # A rigid law refuses a start inside the rotor.
    except (BrokenOffError, ValueError):
        return np.full(z.size, np.inf)
