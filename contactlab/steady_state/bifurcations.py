"""What happens along a branch of periodic orbits, and why it ends."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import combinations
from typing import Final

import numpy as np
from scipy.optimize import brentq

from contactlab.steady_state.curve import BranchPoint, Mark, Place, place_at
from contactlab.steady_state.period_map import BrokenOffError
from contactlab.steady_state.shooting import ROUGH, STEP, Orbit

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


def _tests(place: Place) -> dict[Mark, float]:
    """Return what is zero where a multiplier is +1, where one is -1, and where two have the product 1."""
    multipliers = place.point.orbit.multipliers
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
    if last.point.contacts != place.point.contacts:
        result.append(_grazing(last, place, length))
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
        ahead = brentq(test, 0.0, length, xtol=LOCATED)
    except (ValueError, RuntimeError):
        return None
    reached = last.further(float(ahead))
    if reached is None or reached.point.orbit.roughness > SMOOTH:
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


def _grazing(last: Place, place: Place, length: float) -> tuple[float, BranchPoint]:
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
        while (beyond := place.count_ahead(high)) == point.contacts and high < reach:
            low, high = high, 2.0 * high
        if beyond not in (point.contacts, -1):
            while high - low > LOCATED * reach:
                middle = 0.5 * (low + high)
                low, high = (middle, high) if place.count_ahead(middle) == point.contacts else (low, middle)
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
    other = sorted(_contacts_nearby(point.orbit) - {point.contacts})
    nearby = f", {' or '.join(map(str, other))} within {NEARBY:g} of its state" if other else ""
    softest = f", and the softest begins at {point.softest:.3g} m/s" if point.contacts else ""
    return f"It ends at {point.value:.9g}, where the map is not smooth: it has {before}{nearby}{softest}."


def _contacts_nearby(orbit: Orbit) -> set[int]:
    """Return the numbers of contacts in the periods that begin near an orbit."""
    length = NEARBY * float(np.linalg.norm(orbit.state))
    result = set()
    for direction in np.eye(orbit.state.size):
        for side in (-length, length):
            with suppress(BrokenOffError, ValueError):
                result.add(int(orbit.map.run(orbit.state + side * direction).contacts["start_time"].size))
    return result


def without_speed(points: Sequence[BranchPoint]) -> float:
    """Return where the softest contact of a branch's last orbits would be without speed; NaN for nowhere."""
    last = points[-1]
    for point in reversed(points):
        if point.contacts != last.contacts:
            break
        if point.softest > CLEARLY * last.softest > 0.0:
            return last.value + last.softest * (last.value - point.value) / (point.softest - last.softest)
    return np.nan
