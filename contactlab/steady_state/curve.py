"""The curve of periodic orbits over a parameter: its points, its tangent, and the way back onto it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.steady_state.period_map import BrokenOffError, PeriodMap
from contactlab.steady_state.shooting import CLOSED, Orbit, derivative_of, updated
from contactlab.trajectory import Trajectory

MOST_CORRECTIONS: Final = 10
"""Of a predicted point, before a shorter step is tried."""

MapAt = Callable[[float], PeriodMap]


class Mark(IntEnum):
    """What happens at a point of a branch."""

    NONE = 0
    FOLD = 1
    """A multiplier passes through +1 and the branch turns back."""
    BRANCHING = 2
    """A multiplier passes through +1 and the branch goes on: another one crosses it."""
    PERIOD_DOUBLING = 3
    """A multiplier passes through -1."""
    NEIMARK_SACKER = 4
    """A pair of multipliers passes through the circle."""
    GRAZING = 5
    """A contact appears or goes."""


@final
@dataclass(frozen=True)
class BranchPoint:
    """An orbit of a branch, the value of the parameter there, and a run over its period."""

    value: float
    orbit: Orbit
    run: Trajectory
    mark: Mark = Mark.NONE

    @property
    def contacts(self) -> int:
        """How often tip and rotor touch in a period of the orbit."""
        return int(self.run.contacts["start_time"].size)

    @property
    def softest(self) -> float:
        """The smallest speed with which they meet [m/s]; 0 where they do not."""
        speeds = np.abs(self.run.contacts["approach_velocity"])
        return float(speeds.min()) if speeds.size else 0.0

    @property
    def velocity(self) -> float:
        """Mean rotor velocity [rad/s]."""
        angle = self.run.series["rotor_angle"]
        return float((angle[-1] - angle[0]) / self.run.duration)

    @property
    def torque(self) -> float:
        """Mean torque of the contact on the rotor, -R F [N m]."""
        radius = self.run.motor.geometry.rotor_radius
        return float(-radius * self.run.series["friction_force"][1:].mean())


@final
@dataclass(frozen=True)
class Curve:
    """The curve P(z; parameter) = z in y at one section."""

    family: MapAt
    phase: float
    periods: int
    size: float
    start: float
    end: float
    weights: tuple[float, ...] = ()

    def value(self, y: Array) -> float:
        """Return the parameter."""
        return float(self.start + (self.end - self.start) * y[-1])

    def map_at(self, y: Array) -> PeriodMap:
        """Return the period map of the parameter."""
        return replace(
            self.family(self.value(y)), phase=self.phase, periods=self.periods, weights=self.weights
        )

    def gap(self, y: Array) -> Array:
        """Return (P(z) - z) / size; endless where the motor does not run from there."""
        z = y[:-1] * self.size
        try:
            return (self.map_at(y)(z) - z) / self.size
        # A rigid law refuses a start inside the rotor, and a configuration some values.
        except (BrokenOffError, ValueError):
            return np.full(z.size, np.inf)

    def contacts(self, y: Array) -> int:
        """Count how often tip and rotor touch in the period that follows; -1 where it breaks off."""
        try:
            return int(self.map_at(y).run(y[:-1] * self.size).contacts["start_time"].size)
        except (BrokenOffError, ValueError):
            return -1

    def moved(self, y: Array, phase: float) -> Array:
        """Return the point at another section."""
        section = self.map_at(y)
        part = (phase - self.phase) % 1.0
        z = section.end_of(section.run(y[:-1] * self.size, part / self.periods))
        return np.append(z / self.size, y[-1])


@final
@dataclass(frozen=True)
class Place:
    """A point of a curve with the derivative of `gap`, shape (state, state + 1), and the tangent there."""

    curve: Curve
    y: Array
    point: BranchPoint
    derivative: Array
    tangent: Array

    def ahead(self, length: float, corrections: int = MOST_CORRECTIONS) -> tuple[Array, int] | None:
        """Return the point of the curve that lies ahead along the tangent, and its corrections."""
        guess = self.y + length * self.tangent
        return corrected(self.curve.gap, self.derivative, self.tangent, guess, length, corrections)

    def further(self, length: float) -> "Place | None":
        """Return the place that lies ahead on the curve."""
        result = self.ahead(length)
        return None if result is None else place_at(self.curve, result[0], self.tangent)

    def count_ahead(self, length: float) -> int:
        """Count how often tip and rotor touch in the period from a point ahead on the tangent."""
        return self.curve.contacts(self.y + length * self.tangent)


def place_at(curve: Curve, y: Array, heading: Array) -> Place:
    """Return the place of a point, its tangent in the direction of the heading."""
    section = curve.map_at(y)
    orbit = Orbit.at(section, y[:-1] * curve.size)
    count = orbit.state.size
    along = derivative_of(curve.gap, y, np.eye(count + 1)[-1])
    derivative = np.column_stack([orbit.jacobian - np.eye(count), along])
    # What no row of the derivative sees.
    tangent = np.linalg.svd(derivative)[2][-1]
    tangent = tangent if tangent @ heading >= 0.0 else -tangent
    return Place(curve, y, BranchPoint(curve.value(y), orbit, section.run(orbit.state)), derivative, tangent)


def corrected(
    gap: Callable[[Array], Array],
    derivative: Array,
    tangent: Array,
    guess: Array,
    within: float,
    most: int = MOST_CORRECTIONS,
) -> tuple[Array, int] | None:
    """Bring a predicted point onto the curve, across the tangent; give it and the corrections it took."""
    y, left = guess, gap(guess)
    for count in range(most):
        if not np.all(np.isfinite(left)) or np.linalg.norm(y - guess) > within:
            return None
        if np.linalg.norm(left) <= CLOSED:
            return y, count
        move = -np.linalg.solve(np.vstack([derivative, tangent]), np.append(left, tangent @ (y - guess)))
        y, before = y + move, left
        left = gap(y)
        derivative = updated(derivative, move, left - before)
    return None
