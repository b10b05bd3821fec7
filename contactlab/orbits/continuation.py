"""Branches of periodic orbits over a parameter, through folds, by pseudo-arclength continuation.

On a branch a multiplier may pass through the unit circle: at +1 it folds or meets another branch, at -1 the
period doubles, as a pair a torus begins. What no multiplier foretells is a grazing, where a contact appears
or goes: there the period map is not smooth, and for a rigid law the branch ends.

Source: Seydel, Practical Bifurcation and Stability Analysis (2010), ch. 4 and 7; di Bernardo et al.,
Piecewise-smooth Dynamical Systems (2008), ch. 6 and 7.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from enum import IntEnum
from itertools import combinations
from typing import Final, final

import numpy as np
from scipy.optimize import brentq

from contactlab.arrays import Array
from contactlab.orbits.period_map import BrokenOffError, PeriodMap
from contactlab.orbits.shooting import CLOSED, Orbit, derivative_of, updated
from contactlab.trajectory import Trajectory

MOST_CORRECTIONS: Final = 10
"""Of a predicted point, before a shorter step is tried."""

EASY: Final = 4
"""Corrections at most after which the next step may be longer."""

LONGER: Final = 1.5

SHORTEST: Final = 1e-4
"""Step over the first one, below which a branch is taken to end."""

NEAREST: Final = 0.02
"""Part of a period between a contact and the section, below which another section is chosen."""

LOCATED: Final = 1e-9
"""Length along a branch to which an event is located."""

THROUGH_ZERO: Final = 1e-3
"""What is left of a test function at an event, as a share of its values beside it; it jumps at a grazing."""

MOST_POINTS: Final = 1000

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
class Followed:
    """The points of a branch in their order, and a sentence on how it ends."""

    points: tuple[BranchPoint, ...]
    end: str


def follow(
    map_at: MapAt, first: Orbit, value: float, end: float, step: float = 0.02, most: int = MOST_POINTS
) -> Followed:
    """Follow a branch of periodic orbits from one of them, until the parameter leaves its range.

    Unknown are y = (z / |z_0|, (parameter - value) / (end - value)); the branch is a curve of
    P(z; parameter) = z, followed along its tangent in steps of its length, so that it may turn back. Its
    points are those of the steps and the events between them, each located by bracketing.

    Args:
        map_at: gives the period map of a value of the parameter; section and periods are those of `first`.
        first, value: where the branch begins.
        end: of the parameter's range, which begins at `value`.
        step: length of the first step; a fiftieth of range and state by default. The longest is four times
            that.
        most: points after which it is left as it is.
    """
    start = _Curve(map_at, first.map.phase, first.map.periods, float(np.linalg.norm(first.state)), value, end)
    walk = _walk(start, np.append(first.state / start.size, 0.0), step)
    points: list[BranchPoint] = []
    while len(points) < most:
        try:
            points.append(next(walk))
        except StopIteration as stop:
            return Followed(tuple(points), str(stop.value))
    return Followed(tuple(points), f"It is left as it is after {most} points; more of them or longer steps.")


@final
@dataclass(frozen=True)
class _Curve:
    """The curve P(z; parameter) = z in y at one section."""

    family: MapAt
    phase: float
    periods: int
    size: float
    start: float
    end: float

    def value(self, y: Array) -> float:
        return float(self.start + (self.end - self.start) * y[-1])

    def map_at(self, y: Array) -> PeriodMap:
        return replace(self.family(self.value(y)), phase=self.phase, periods=self.periods)

    def gap(self, y: Array) -> Array:
        """(P(z) - z) / size; endless where the motor does not run from there."""
        z = y[:-1] * self.size
        try:
            return (self.map_at(y)(z) - z) / self.size
        # A rigid law refuses a start inside the rotor, and a configuration some values.
        except (BrokenOffError, ValueError):
            return np.full(z.size, np.inf)

    def contacts(self, y: Array) -> int:
        """How often tip and rotor touch in the period that follows."""
        try:
            return int(self.map_at(y).run(y[:-1] * self.size).contacts["start_time"].size)
        except (BrokenOffError, ValueError):
            return -1

    def moved(self, y: Array, phase: float) -> Array:
        """The point y at another section."""
        section = self.map_at(y)
        part = (phase - self.phase) % 1.0
        z = section.end_of(section.run(y[:-1] * self.size, part / self.periods))
        return np.append(z / self.size, y[-1])


@final
@dataclass(frozen=True)
class _Place:
    """A point of a curve with the derivative of `gap`, shape (state, state + 1), and the tangent there."""

    curve: _Curve
    y: Array
    point: BranchPoint
    derivative: Array
    tangent: Array

    def ahead(self, length: float, corrections: int = MOST_CORRECTIONS) -> tuple[Array, int] | None:
        """The point of the curve that lies ahead, as measured along the tangent, and the corrections."""
        guess = self.y + length * self.tangent
        return _corrected(self.curve.gap, self.derivative, self.tangent, guess, length, corrections)


def _place(curve: _Curve, y: Array, heading: Array) -> _Place:
    """Give the place of a point, its tangent in the direction of the heading."""
    section = curve.map_at(y)
    orbit = Orbit.at(section, y[:-1] * curve.size)
    count = orbit.state.size
    along = derivative_of(curve.gap, y, np.eye(count + 1)[-1])
    derivative = np.column_stack([orbit.jacobian - np.eye(count), along])
    # What no row of the derivative sees.
    tangent = np.linalg.svd(derivative)[2][-1]
    tangent = tangent if tangent @ heading >= 0.0 else -tangent
    return _Place(curve, y, BranchPoint(curve.value(y), orbit, section.run(orbit.state)), derivative, tangent)


def _walk(curve: _Curve, y: Array, step: float) -> Iterator[BranchPoint]:
    """Give the points one after another, and in the end the sentence why there are no more."""
    place = _place(curve, y, np.eye(y.size)[-1])
    longest, least = 4.0 * step, SHORTEST * step
    yield place.point
    while True:
        last = place = _resectioned(place)
        over = 1.0 if place.tangent[-1] > 0.0 else 0.0
        while True:
            to_edge = (over - place.y[-1]) / place.tangent[-1] if place.tangent[-1] else np.inf
            at_edge = to_edge <= step
            found = _at_edge(place, over, to_edge) if at_edge else place.ahead(step)
            if found is not None:
                break
            step = 0.5 * min(step, to_edge)
            if step < least:
                return _end_of(place, least)
        y, count = found
        place = _place(place.curve, y, place.tangent)
        yield from _events(last, place)
        yield place.point
        if at_edge:
            return f"It ends where the range of the parameter does, at {place.point.value:.9g}."
        step = min(LONGER * step, longest) if count <= EASY else step


def _at_edge(place: _Place, over: float, length: float) -> tuple[Array, int] | None:
    """Correct a point at the edge of the range, where the parameter is held."""
    guess = place.y + length * place.tangent
    guess[-1] = over
    edge = np.eye(guess.size)[-1]
    return _corrected(place.curve.gap, place.derivative, edge, guess, max(length, CLOSED))


def _corrected(
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


def _resectioned(place: _Place) -> _Place:
    """Give the same point at a section in the middle of the longest flight, where a contact came near."""
    run, curve = place.point.run, place.curve
    begins = run.contacts["start_time"]
    if not begins.size:
        return place
    ends = begins + run.contacts["duration"]
    if min(begins[0], run.duration - ends[-1]) >= NEAREST * run.duration:
        return place
    flights = np.append(begins[1:], begins[0] + run.duration) - ends
    longest = int(flights.argmax())
    later = (ends[longest] + 0.5 * flights[longest]) / run.duration * curve.periods
    other = replace(curve, phase=(curve.phase + later) % 1.0)
    # Where the tangent points, at the other section.
    reach = np.sqrt(CLOSED)
    y, beyond = (curve.moved(at, other.phase) for at in (place.y, place.y + reach * place.tangent))
    moved = _place(other, y, beyond - y)
    return replace(moved, point=replace(moved.point, mark=place.point.mark))


def _tests(place: _Place) -> dict[Mark, float]:
    """Give what is zero where a multiplier is +1, where one is -1, and where two have the product 1."""
    multipliers = place.point.orbit.multipliers
    products = [1.0 - a * b for a, b in combinations(multipliers, 2)] or [1.0]
    return {
        Mark.FOLD: float(np.prod(multipliers - 1.0).real),
        Mark.PERIOD_DOUBLING: float(np.prod(multipliers + 1.0).real),
        Mark.NEIMARK_SACKER: float(np.prod(products).real),
    }


def _events(last: _Place, place: _Place) -> Iterator[BranchPoint]:
    """Locate what happens between two places of a curve."""
    length = float(last.tangent @ (place.y - last.y))
    found: list[tuple[float, BranchPoint]] = []
    if last.point.contacts != place.point.contacts:
        found.append(_grazing(last, place, length))
    before, after = _tests(last), _tests(place)
    for mark in before:
        if before[mark] * after[mark] < 0.0 and (event := _crossing(last, mark, length, before, after)):
            turns = last.tangent[-1] * place.tangent[-1] < 0.0
            name = Mark.BRANCHING if mark is Mark.FOLD and not turns else mark
            found.append((event[0], replace(event[1], mark=name)))
    for _, event_point in sorted(found, key=lambda pair: pair[0]):
        yield event_point


def _crossing(
    last: _Place, mark: Mark, length: float, before: dict[Mark, float], after: dict[Mark, float]
) -> tuple[float, BranchPoint] | None:
    """Locate where a test function passes through zero, if it does and a multiplier is on the circle."""

    def place_at(ahead: float) -> _Place | None:
        reached = last.ahead(ahead)
        return None if reached is None else _place(last.curve, reached[0], last.tangent)

    def test(ahead: float) -> float:
        if ahead == 0.0:
            return before[mark]
        if ahead == length:
            return after[mark]
        reached = place_at(ahead)
        return np.nan if reached is None else _tests(reached)[mark]

    try:
        ahead = brentq(test, 0.0, length, xtol=LOCATED)
    except (ValueError, RuntimeError):
        return None
    reached = place_at(float(ahead))
    if reached is None:
        return None
    left = abs(_tests(reached)[mark])
    if not left <= THROUGH_ZERO * min(abs(before[mark]), abs(after[mark])):
        return None
    multipliers = reached.point.orbit.multipliers
    pairs = np.abs(np.abs(multipliers) - 1.0) + (np.abs(multipliers.imag) == 0.0)
    # Two real multipliers may have that product too, and then nothing happens.
    if mark is Mark.NEIMARK_SACKER and pairs.min() > THROUGH_ZERO:
        return None
    return float(ahead), reached.point


def _grazing(last: _Place, place: _Place, length: float) -> tuple[float, BranchPoint]:
    """Locate where the number of contacts changes, by halving."""
    low, high, at = 0.0, length, place.y
    while high - low > LOCATED:
        middle = 0.5 * (low + high)
        reached = last.ahead(middle)
        if reached is None:
            break
        if last.curve.contacts(reached[0]) == last.point.contacts:
            low = middle
        else:
            high, at = middle, reached[0]
    return high, replace(_place(last.curve, at, last.tangent).point, mark=Mark.GRAZING)


def _end_of(place: _Place, least: float) -> str:
    """Say why a branch goes no further."""
    here = place.point.contacts
    beyond = place.curve.contacts(place.y + 2.0 * least * place.tangent)
    where = f"It ends at {place.point.value:.9g}"
    if beyond not in (here, -1):
        return (
            f"{where} in a grazing: an orbit has {here} contact{'s' * (here != 1)} before and would have "
            f"{beyond} beyond, where the map is not smooth."
        )
    return f"{where}, beyond which no orbit was found near the last one with steps down to {least:.1e}."
