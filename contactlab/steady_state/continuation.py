"""Branches of periodic orbits over a parameter, through folds, by pseudo-arclength continuation.

On a branch a multiplier may pass through the unit circle: at +1 it folds or meets another branch, at -1 the
period doubles, as a pair a torus begins. What no multiplier foretells is a grazing, where a contact appears
or goes: there the period map is not smooth, and for a rigid law the branch ends.

Source: Seydel, Practical Bifurcation and Stability Analysis (2010), ch. 4 and 7; di Bernardo et al.,
Piecewise-smooth Dynamical Systems (2008), ch. 6 and 7.
"""

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.steady_state.bifurcations import SMOOTH, end_of, events_between, without_speed
from contactlab.steady_state.curve import BranchPoint, Curve, MapAt, Place, corrected, place_at
from contactlab.steady_state.shooting import CLOSED, Orbit

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
        step: length of the first step; a fiftieth of range and state by default. The longest is twice that.
        most: points after which it is left as it is.
    """
    section, size = first.map, float(np.linalg.norm(first.state))
    start = Curve(map_at, section.phase, section.periods, size, value, end, section.weights)
    walk = _walk(start, np.append(first.state / start.size, 0.0), step)
    points: list[BranchPoint] = []
    while len(points) < most:
        try:
            points.append(next(walk))
        except StopIteration as stop:
            return Followed(tuple(points), str(stop.value) + _where_it_grazes(points, end - value))
    return Followed(tuple(points), f"It is left as it is after {most} points; more of them or longer steps.")


def _where_it_grazes(points: Sequence[BranchPoint], span: float) -> str:
    """Return where a contact of a branch that ends where the map is not smooth would be without speed."""
    at = without_speed(points) if points[-1].orbit.roughness > SMOOTH else np.nan
    if not abs(at - points[-1].value) < NEAR * abs(span):
        return ""
    return f" That contact would be without speed at {at:.7g}: it grazes."


def _walk(curve: Curve, y: Array, first: float) -> Generator[BranchPoint, None, str]:
    """Yield the points one after another, and in the end the sentence why there are no more."""
    place = place_at(curve, y, np.eye(y.size)[-1])
    step = first
    yield place.point
    while True:
        last = _resectioned(place)
        if (result := _next(last, step, first)) is None:
            return end_of(last, SHORTEST * first, CLOSELY * first)
        place, step = result
        yield from events_between(last, place)
        yield place.point
        if end := _why_it_ends(last, place):
            return end
        if step < CLOSELY * first and place.point.orbit.roughness > SMOOTH:
            return end_of(place, SHORTEST * first, CLOSELY * first)


def _next(last: Place, step: float, first: float) -> tuple[Place, float] | None:
    """Return the next place and the step to try from there, or None where there is no step to it."""
    over = 1.0 if last.tangent[-1] > 0.0 else 0.0
    to_edge = (over - last.y[-1]) / last.tangent[-1] if last.tangent[-1] else np.inf
    while step >= SHORTEST * first:
        result = _at_edge(last, over, to_edge) if to_edge <= step else last.ahead(step)
        step = min(step, to_edge)
        if result is not None:
            place = place_at(last.curve, result[0], last.tangent)
            if _is_near(last, place):
                return place, min(LONGER * step, 2.0 * first) if result[1] <= EASY else step
            if step < CLOSELY * first:
                # Beside a contact that comes or goes, corrections lead from a rough orbit past what is there.
                same = last.point.contacts == place.point.contacts
                return (place, step) if same or last.point.orbit.roughness <= SMOOTH else None
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


def _is_near(last: Place, place: Place) -> bool:
    """Return whether two places follow each other without a contact or a sharp turn between."""
    return last.point.contacts == place.point.contacts and bool(last.tangent @ place.tangent > LEAST_COSINE)


def _at_edge(place: Place, over: float, length: float) -> tuple[Array, int] | None:
    """Correct a point at the edge of the range, where the parameter is held."""
    guess = place.y + length * place.tangent
    guess[-1] = over
    edge = np.eye(guess.size)[-1]
    return corrected(place.curve.gap, place.derivative, edge, guess, max(length, CLOSED))


def _resectioned(place: Place) -> Place:
    """Return the same point at a section in the middle of the longest flight, where a contact came near."""
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
    moved = place_at(other, y, beyond - y)
    return replace(moved, point=replace(moved.point, mark=place.point.mark))
