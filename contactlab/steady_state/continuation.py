"""Branches of periodic orbits over a parameter, through folds, by pseudo-arclength continuation.

On a branch a multiplier may pass through the unit circle: at +1 it folds or meets another branch, at -1 the
period doubles, as a pair a torus begins. What no multiplier foretells is a grazing, where a contact appears
or goes: there the period map is not smooth, and for a rigid law the branch ends.

Source: Seydel, Practical Bifurcation and Stability Analysis (2010), ch. 4 and 7; di Bernardo et al.,
Piecewise-smooth Dynamical Systems (2008), ch. 6 and 7.
"""

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from enum import IntEnum
from itertools import combinations
from typing import Final, final

import numpy as np
from scipy.optimize import brentq

from contactlab.arrays import Array
from contactlab.engine.state import State
from contactlab.motor.motor import lever_of
from contactlab.progress import tell_progress
from contactlab.steady_state.arrival import RECORDS, SHORTEST_FLIGHT, stretch_of, stretches_of
from contactlab.steady_state.period_map import BrokenOffError, PeriodMap
from contactlab.steady_state.shooting import CLOSED, ROUGH, STEP, Orbit, derivative_of, updated
from contactlab.trajectory import Trajectory

MOST_CORRECTIONS: Final = 10
"""Of a predicted point, before a shorter step is tried."""

LOCATED: Final = 1e-9
"""Length along a branch to which an event is located."""

THROUGH_ZERO: Final = 1e-3
"""What is left of a test function at an event, as a share of its values beside it; it jumps at a grazing."""

SMOOTH: Final = 1e-2
"""Roughness of an orbit up to which its multipliers are believed."""

NEARBY: Final = ROUGH * STEP
"""Part of a state within which the roughness of an orbit looks."""

CLEARLY: Final = 1.2
"""Ratio of speeds that are apart enough for a straight line through them."""

EASY: Final = 4
"""Corrections at most after which the next step may be longer."""

LONGER: Final = 1.5

SHORTEST: Final = 1e-4
"""Step over the first one, below which a branch is taken to end."""

CLOSELY: Final = 1e-2
"""Step over the first one, with which a grazing or a sharp turn is passed."""

LEAST_COSINE: Final = 0.97
"""Of the angle between the tangents of places that follow each other."""

UPRIGHT: Final = 1e-5
"""Share of the parameter in two tangents in a row, below which a branch goes on without it."""

NEAR: Final = 1e-2
"""Share of the range within which a grazing is foretold."""

NEAREST: Final = 0.02
"""Part of a period between a contact and the section, below which another section is chosen."""

MOST_POINTS: Final = 1000
"""Points after which a branch is left as it is."""

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
        """How often tip and rotor touch in a period of the orbit; one that lasts for all of it counts."""
        return self.stretches - (self.orbit.map.touches and self.stretches > 1)

    @property
    def stretches(self) -> int:
        """Number of contacts between a section and the next: one that goes on at both counts twice."""
        return int(self.run.contacts["start_time"].size)

    @property
    def softest(self) -> float:
        """The smallest speed with which they meet [m/s]; 0 where they do not."""
        # A contact that goes on at the section has begun before the run.
        begun = self.run.contacts["start_time"] > (self.run.time[0] if self.orbit.map.touches else -np.inf)
        speeds = np.abs(self.run.contacts["approach_velocity"][begun])
        return float(speeds.min()) if speeds.size else 0.0

    @property
    def velocity(self) -> float:
        """Mean rotor velocity [rad/s]."""
        angle = self.run.series["rotor_angle"]
        return float((angle[-1] - angle[0]) / self.run.duration)

    @property
    def velocity_error(self) -> float:
        """What the orbit's closure leaves of the mean rotor velocity [rad/s]; none of a belt's."""
        if self.orbit.map.belt is not None:
            return 0.0
        # The run is the orbit's period: its end shows how far it is from closed.
        closure = self.orbit.closure(self.orbit.map.end_of(self.run))
        return self.orbit.velocity(self.velocity, closure).error

    @property
    def torque(self) -> float:
        """Mean torque of the contact on the rotor, -R F [N m]; NaN where the contact is flat."""
        return -lever_of(self.run.motor.geometry.rotor_radius) * self.friction_force

    @property
    def friction_force(self) -> float:
        """Mean friction force on the tip [N]."""
        return float(self.run.series["friction_force"][1:].mean())


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
    weights: tuple[float, ...]
    contact: State | None

    def value(self, y: Array) -> float:
        """Return the parameter."""
        return float(self.start + (self.end - self.start) * y[-1])

    def map_at(self, y: Array) -> PeriodMap:
        """Return the period map of the parameter."""
        return replace(
            self.family(self.value(y)),
            phase=self.phase,
            periods=self.periods,
            weights=self.weights,
            contact=self.contact,
        )

    def gap(self, y: Array) -> Array:
        """Return (P(z) - z) / size; endless where the motor does not run from there."""
        z = y[:-1] * self.size
        try:
            return (self.map_at(y)(z) - z) / self.size
        # A rigid law refuses a start inside the rotor, and a configuration some values.
        except (BrokenOffError, ValueError):
            return np.full(z.size, np.inf)

    def stretches(self, y: Array) -> int:
        """Count the contacts until the next section, see `BranchPoint`; -1 where the run breaks off."""
        try:
            return int(self.map_at(y).run(y[:-1] * self.size).contacts["start_time"].size)
        except (BrokenOffError, ValueError):
            return -1

    def moved(self, y: Array, other: "Curve", later: float) -> Array:
        """Return the point at the section of another curve, some periods of the drive later."""
        run = self.map_at(y).run(y[:-1] * self.size, later / self.periods)
        return np.append(other.map_at(y).end_of(run) / self.size, y[-1])


@final
@dataclass(frozen=True)
class Place:
    """A point of a curve with the derivative of `gap`, shape (state, state + 1), and the tangent there."""

    curve: Curve
    y: Array
    point: BranchPoint
    derivative: Array
    tangent: Array

    def ahead(self, length: float) -> tuple[Array, int] | None:
        """Return the point of the curve that lies ahead along the tangent, and its corrections."""
        guess = self.y + length * self.tangent
        return corrected(self.curve.gap, self.derivative, self.tangent, guess, length)

    def further(self, length: float) -> "Place | None":
        """Return the place that lies ahead on the curve."""
        result = self.ahead(length)
        return None if result is None else place_at(self.curve, result[0], self.tangent)

    def count_ahead(self, length: float) -> int:
        """Count how often tip and rotor touch in the period from a point ahead on the tangent."""
        return self.curve.stretches(self.y + length * self.tangent)


def place_at(curve: Curve, y: Array, heading: Array) -> Place:
    """Return the place of a point, its tangent in the direction of the heading."""
    # G_y of (7.8): dP/dz - 1, the same in z and z / size, and beside it the derivative along the parameter.
    section = curve.map_at(y)
    orbit = Orbit.at(section, y[:-1] * curve.size)
    count = orbit.state.size
    along = derivative_of(curve.gap, y, np.eye(count + 1)[-1])
    derivative = np.column_stack([orbit.jacobian - np.eye(count), along])
    # What no row of the derivative sees.
    tangent = np.linalg.svd(derivative)[2][-1]
    # Of both senses the one that goes on.
    tangent = tangent if tangent @ heading >= 0.0 else -tangent
    run = section.run(orbit.state)
    # A map that has run holds tens of megabytes, and a branch has a thousand of them.
    orbit = replace(orbit, map=replace(section))
    return Place(curve, y, BranchPoint(curve.value(y), orbit, run), derivative, tangent)


def corrected(
    gap: Callable[[Array], Array], derivative: Array, tangent: Array, guess: Array, within: float
) -> tuple[Array, int] | None:
    """Bring a predicted point onto the curve, across the tangent; give it and the corrections it took."""
    # Newton's method on (7.8): the gap closes on the plane through the prediction across the tangent.
    y, left = guess, gap(guess)
    for count in range(MOST_CORRECTIONS):
        if not np.all(np.isfinite(left)) or np.linalg.norm(y - guess) > within:
            return None
        if np.linalg.norm(left) <= CLOSED:
            return y, count
        move = -np.linalg.solve(np.vstack([derivative, tangent]), np.append(left, tangent @ (y - guess)))
        y, before = y + move, left
        left = gap(y)
        # Broyden's correction (7.3) in place of a new derivative.
        derivative = updated(derivative, move, left - before)
    return None


@final
@dataclass(frozen=True)
class Followed:
    """The points of a branch in their order, and a sentence on how it ends."""

    points: tuple[BranchPoint, ...]
    end: str


def follow(map_at: MapAt, first: Orbit, value: float, end: float, step: float = 0.02) -> Followed:
    """Follow a branch of periodic orbits from one of them, until the parameter leaves its range.

    Unknown are y = (z / |z_0|, (parameter - value) / (end - value)); the branch is a curve of
    P(z; parameter) = z, followed along its tangent in steps of its length, so that it may turn back. Its
    points are those of the steps and the events between them, each located by bracketing.

    Args:
        map_at: gives the period map of a value of the parameter; section and periods are those of `first`.
        first, value: where the branch begins.
        end: of the parameter's range, which begins at `value`.
        step: length of the first step; a fiftieth of range and state by default. The longest is twice that.
    """
    section, size = first.map, float(np.linalg.norm(first.state))
    start = Curve(map_at, section.phase, section.periods, size, value, end, section.weights, section.contact)
    walk = _walk(start, np.append(first.state / start.size, 0.0), step)
    points: list[BranchPoint] = []
    while len(points) < MOST_POINTS:
        try:
            points.append(next(walk))
            at = points[-1].value
            tell_progress(f"{len(points)} points, the last at {at:.6g}", abs(at - value) / abs(end - value))
        except StopIteration as stop:
            end_text = str(stop.value)
            # Where the map is not smooth, the last contact loses its speed.
            at = without_speed(points) if points[-1].orbit.roughness > SMOOTH else np.nan
            if abs(at - points[-1].value) < NEAR * abs(end - value):
                end_text += f" That contact would be without speed at {at:.7g}: it grazes."
            return Followed(tuple(points), end_text)
    end_text = f"It is left as it is after {MOST_POINTS} points; more of them or longer steps."
    return Followed(tuple(points), end_text)


def _walk(curve: Curve, y: Array, first: float) -> Generator[BranchPoint, None, str]:
    """Yield the points one after another, and in the end the sentence why there are no more."""
    place = place_at(curve, y, np.eye(y.size)[-1])
    step = first
    yield place.point
    while True:
        # One step: a section away from contacts that come near, the next point, the events up to it.
        last = _resectioned(place)
        if (result := _next(last, step, first)) is None:
            return end_of(last, SHORTEST * first, CLOSELY * first)
        place, step = result
        yield from events_between(last, place)
        yield place.point
        if end := _why_it_ends(last, place):
            return end
        # Only short steps lead on, and the map is not smooth here: the branch ends.
        if step < CLOSELY * first and place.point.orbit.roughness > SMOOTH:
            return end_of(place, SHORTEST * first, CLOSELY * first)


def _next(last: Place, step: float, first: float) -> tuple[Place, float] | None:
    """Return the next place and the step to try from there, or None where there is no step to it."""
    # The range of the parameter is 0 to 1 in y; the length to its edge is that along the tangent.
    over = 1.0 if last.tangent[-1] > 0.0 else 0.0
    to_edge = (over - last.y[-1]) / last.tangent[-1] if last.tangent[-1] else np.inf
    while step >= SHORTEST * first:
        if to_edge <= step:
            # At the edge of the range the parameter is held.
            guess = last.y + to_edge * last.tangent
            guess[-1] = over
            edge, within = np.eye(guess.size)[-1], max(to_edge, CLOSED)
            result = corrected(last.curve.gap, last.derivative, edge, guess, within)
        else:
            # Predict along the tangent, correct across it.
            result = last.ahead(step)
        step = min(step, to_edge)
        if result is not None:
            place = place_at(last.curve, result[0], last.tangent)
            # A step is taken if no contact came or went and the tangent turned little. The next is longer
            # after few corrections, at most twice the first one.
            same = last.point.stretches == place.point.stretches
            if same and last.tangent @ place.tangent > LEAST_COSINE:
                return place, min(LONGER * step, 2.0 * first) if result[1] <= EASY else step
            if step < CLOSELY * first:
                # Beside a contact that comes or goes, corrections lead from a rough orbit past what is there,
                # but from one without contact.
                smooth = last.point.orbit.roughness <= SMOOTH or not last.point.contacts
                return (place, step) if same or smooth else None
        step *= 0.5
    return None


def _why_it_ends(last: Place, place: Place) -> str:
    """Return why a branch ends at a place that was reached; nothing where it goes on."""
    at = f"It ends at {place.point.value:.9g}"
    if place.y[-1] in (0.0, 1.0):
        return f"It ends where the range of the parameter does, at {place.point.value:.9g}."
    if not place.point.contacts and last.point.contacts and place.point.orbit.map.belt is None:
        return (
            f"{at} in a grazing: the last contact goes, and a rotor that nothing touches keeps any velocity."
        )
    if max(abs(place.tangent[-1]), abs(last.tangent[-1])) < UPRIGHT:
        return f"{at}, where the touch is so light that the rotor keeps any velocity."
    return ""


def _resectioned(place: Place) -> Place:
    """Return the same point at another section, where a contact or a change of friction came near."""
    curve, section = place.curve, place.point.orbit.map
    # How far along the orbit is a better section?
    later, seen = _another_section(place)
    if not later:
        return place
    end = section.run(place.point.orbit.state, later / curve.periods)
    moved = section.at_end_of(end, curve.phase + later).weighing(seen)
    other = replace(curve, phase=moved.phase, weights=moved.weights, contact=moved.contact)
    # Where the tangent points, at the other section.
    reach = np.sqrt(CLOSED)
    y, beyond = (curve.moved(at, other, later) for at in (place.y, place.y + reach * place.tangent))
    there = place_at(other, y, beyond - y)
    return replace(there, point=replace(there.point, mark=place.point.mark))


def _another_section(place: Place) -> tuple[float, Trajectory]:
    """Return after how many periods of the drive a better section lies, 0 for none, and the run until it."""
    run, section = place.point.run, place.point.orbit.map
    begins = run.contacts["start_time"]
    if not begins.size:
        return 0.0, run
    if not section.touches:
        # In flight: as long as the contacts on either side are far enough, the section stays; else it goes to
        # the middle of the longest flight, if that is one.
        ends = begins + run.contacts["duration"]
        if min(begins[0], run.duration - ends[-1]) >= NEAREST * run.duration:
            return 0.0, run
        flights = np.append(begins[1:], begins[0] + run.duration) - ends
        longest = int(flights.argmax())
        if flights[longest] >= SHORTEST_FLIGHT * run.duration / section.periods:
            later = (ends[longest] + 0.5 * flights[longest]) / run.duration * section.periods
            return float(later % section.periods), run
    run = section.run(place.point.orbit.state, 1.0, RECORDS)
    state = stretches_of(run)
    # In contact: the section stays while the contact has one state for a while before and after it.
    near = int(np.ceil(NEAREST * len(state)))
    if section.touches and np.all(np.roll(state, near, axis=0)[: 2 * near] == state[-1]):
        return 0.0, run
    return stretch_of(run) * section.periods, run


def _tests(place: Place) -> dict[Mark, float]:
    """Return what is zero where a multiplier is +1, where one is -1, and where two have the product 1."""
    multipliers = place.point.orbit.multipliers
    # (7.9): prod (lambda_i - 1), prod (lambda_i + 1), prod (1 - lambda_i lambda_j) over i < j.
    products = [1.0 - a * b for a, b in combinations(multipliers, 2)] or [1.0]
    return {
        Mark.FOLD: float(np.prod(multipliers - 1.0).real),
        Mark.PERIOD_DOUBLING: float(np.prod(multipliers + 1.0).real),
        Mark.NEIMARK_SACKER: float(np.prod(products).real),
    }


def events_between(last: Place, place: Place) -> Iterator[BranchPoint]:
    """Locate what happens between two places of a curve."""
    length = float(last.tangent @ (place.y - last.y))
    result: list[tuple[float, BranchPoint]] = []
    if last.point.stretches != place.point.stretches:
        result.append(_grazing(last, place, length))
    # A test function that changes its sign has a zero between. At +1 the branch folds if it turns back, else
    # another branch crosses it.
    before, after = _tests(last), _tests(place)
    for mark in before:
        if before[mark] * after[mark] < 0.0 and (event := _crossing(last, mark, length, before, after)):
            turns = last.tangent[-1] * place.tangent[-1] < 0.0
            name = Mark.BRANCHING if mark is Mark.FOLD and not turns else mark
            result.append((event[0], replace(event[1], mark=name)))
    for _, event_point in sorted(result, key=lambda pair: pair[0]):
        yield event_point


def _crossing(
    last: Place, mark: Mark, length: float, before: dict[Mark, float], after: dict[Mark, float]
) -> tuple[float, BranchPoint] | None:
    """Locate where a test function passes through zero, if it does and a multiplier is on the circle."""

    def test(ahead: float) -> float:
        if ahead == 0.0:
            return before[mark]
        if ahead == length:
            return after[mark]
        reached = last.further(ahead)
        return np.nan if reached is None else _tests(reached)[mark]

    try:
        # Brent's method on the length along the tangent; each trial is an orbit of its own, or there is none.
        ahead = brentq(test, 0.0, length, xtol=LOCATED)
    except (ValueError, RuntimeError):
        return None
    reached = last.further(float(ahead))
    if reached is None or reached.point.orbit.roughness > SMOOTH:
        return None
    # Little is left of the function at a zero; at a grazing it jumps past it.
    left = abs(_tests(reached)[mark])
    if not left <= THROUGH_ZERO * min(abs(before[mark]), abs(after[mark])):
        return None
    multipliers = reached.point.orbit.multipliers
    pairs = np.abs(np.abs(multipliers) - 1.0) + (np.abs(multipliers.imag) == 0.0)
    # Two real multipliers may have that product too, and then nothing happens.
    if mark is Mark.NEIMARK_SACKER and pairs.min() > THROUGH_ZERO:
        return None
    return float(ahead), reached.point


def _grazing(last: Place, place: Place, length: float) -> tuple[float, BranchPoint]:
    """Locate where the number of contacts changes, by halving."""
    # Lengths along the tangent: up to `low` there are as many contacts as before, at `high` others, counted
    # at the orbits that lie ahead.
    low, high, at = 0.0, length, place.y
    while high - low > LOCATED:
        middle = 0.5 * (low + high)
        reached = last.ahead(middle)
        if reached is None:
            break
        if last.curve.stretches(reached[0]) == last.point.stretches:
            low = middle
        else:
            high, at = middle, reached[0]
    return high, replace(place_at(last.curve, at, last.tangent).point, mark=Mark.GRAZING)


def end_of(place: Place, least: float, reach: float) -> str:
    """Return why a branch goes no further than a place.

    Args:
        place: the last one.
        least: the smallest step that was tried.
        reach: how far ahead on the tangent a grazing is looked for.
    """
    point = place.point
    before = f"{point.contacts} contact{'s' * (point.contacts != 1)} a period"
    # The tangent at a rough orbit leads astray, but for one without contact.
    if point.orbit.roughness <= SMOOTH or not point.contacts:
        low, high = 0.0, least
        # Ahead on the tangent, with steps that double: where does the number of contacts change?
        while (beyond := place.count_ahead(high)) == point.stretches and high < reach:
            low, high = high, 2.0 * high
        if beyond not in (point.stretches, -1):
            # There, by halving.
            while high - low > LOCATED * reach:
                middle = 0.5 * (low + high)
                low, high = (middle, high) if place.count_ahead(middle) == point.stretches else (low, middle)
            value, beyond = place.curve.value(place.y + high * place.tangent), place.count_ahead(high)
            return (
                f"It ends at {value:.9g} in a grazing: it has {before} before and would have {beyond} "
                "beyond, where the map is not smooth."
            )
    if point.orbit.roughness <= SMOOTH:
        return (
            f"It ends at {point.value:.9g}, beyond which no orbit was found near the last one with steps "
            f"down to {least:.1e}."
        )
    # The map is not smooth: what do motions next to the orbit meet?
    others = set()
    length = NEARBY * float(np.linalg.norm(point.orbit.state))
    for move in length * np.vstack([np.eye(point.orbit.state.size), -np.eye(point.orbit.state.size)]):
        with suppress(BrokenOffError, ValueError):
            others.add(int(point.orbit.map.run(point.orbit.state + move).contacts["start_time"].size))
    other = sorted(others - {point.stretches})
    nearby = f", {' or '.join(map(str, other))} within {NEARBY:g} of its state" if other else ""
    softest = f", and the softest begins at {point.softest:.3g} m/s" if point.contacts else ""
    return f"It ends at {point.value:.9g}, where the map is not smooth: it has {before}{nearby}{softest}."


def without_speed(points: Sequence[BranchPoint]) -> float:
    """Return where the softest contact of a branch's last orbits would be without speed; NaN for nowhere."""
    last = points[-1]
    # A straight line through the speeds of the softest contact at the last orbit and at one where it is
    # clearly faster; orbits with another number of contacts say nothing of it.
    for point in reversed(points):
        if point.contacts != last.contacts:
            break
        if point.softest > CLEARLY * last.softest > 0.0:
            return last.value + last.softest * (last.value - point.value) / (point.softest - last.softest)
    return np.nan
