"""The speed-torque curve of a motor at few prescribed speeds: its shape, best points and root."""

from collections.abc import Iterable
from itertools import pairwise
from typing import Final

import numpy as np

from contactlab.config import Setup
from contactlab.estimate import Estimate
from contactlab.progress import part_of_progress
from contactlab.studies.characterise.operation import UNKNOWN, Point, operate

FIRST: Final = (-0.25, 0.0, 0.25, 0.5, 0.75, 1.0, 1.25)
"""Velocities over that without load on which a curve begins."""

MOST: Final = 12
"""Prescribed speeds that show the shape of a curve."""

STRAIGHT: Final = 0.04
"""Distance of a point from the line between its neighbours, over the largest torque, below which the
curve is straight."""

CLOSEST: Final = 2e-3
"""Smallest distance of two prescribed speeds over the velocity without load."""

ZERO: Final = 1e-4
"""Torque over the largest that counts as zero."""

BEST: Final = ("output_power", "electrical_efficiency")
"""Quantities whose greatest value a curve contains."""


class Curve:
    """A speed-torque curve in the making.

    Args:
        setup: motor and law.
        velocity: of the rotor without load [rad/s]; its sign is the motor's sense.
    """

    def __init__(self, setup: Setup, velocity: float) -> None:
        self._setup, self._velocity = setup, velocity
        self._points: dict[float, Point] = {}
        for share in FIRST:
            self._add(share)
        while len(self._points) < MOST and self._add(self._bend()):
            pass
        for name in BEST:
            self._add(self._top(name))
        while self._add(self._crossing()):
            pass

    @property
    def points(self) -> list[Point]:
        """The points in the order of their velocities, which are in the motor's sense."""
        return [self._points[share] for share in sorted(self._points)]

    def _add(self, share: float | None) -> bool:
        """Add the point at a share of the velocity unless one is close; return whether it was added."""
        if share is None or any(abs(share - other) < CLOSEST for other in self._points):
            return False
        count = len(self._points)
        # How many there will be depends on the curve.
        begin, end = (min(each / MOST, 1.0) for each in (count, count + 1))
        with part_of_progress(begin, end, f"operating point {count + 1}: "):
            point = operate(self._setup, self._velocity * share)
        self._points[share] = point.turned(float(np.sign(self._velocity)))
        return True

    def _known(self, name: str) -> tuple[list[float], list[float]]:
        """Return shares and values of a quantity where it is known."""
        values = {share: self._points[share].value(name) for share in sorted(self._points)}
        known = [share for share, value in values.items() if np.isfinite(value)]
        return known, [values[share] for share in known]

    def _bend(self) -> float | None:
        """Return the middle of the longer interval at the sharpest bend; None where there is no sharp one."""
        known, torques = self._known("torque")
        rows = zip(known, known[1:], known[2:], torques, torques[1:], torques[2:], strict=False)
        worst, result = STRAIGHT * max(map(abs, torques), default=0.0), None
        for a, b, c, at_a, at_b, at_c in rows:
            distance = abs(at_b - at_a - (at_c - at_a) * (b - a) / (c - a))
            if distance > worst and max(b - a, c - b) > 0.05:
                worst, result = distance, 0.5 * (a + b if b - a > c - b else b + c)
        return result

    def _top(self, name: str) -> float | None:
        """Return where the parabola through a quantity's greatest value and its neighbours has its top."""
        known, values = self._known(name)
        place = int(np.argmax(values)) if values else 0
        if not 0 < place < len(known) - 1:
            return None
        near = slice(place - 1, place + 2)
        a, b, _ = np.polyfit(known[near], values[near], 2)
        return float(np.clip(-0.5 * b / a, known[near][0], known[near][2])) if a < 0.0 else None

    def _crossing(self) -> float | None:
        """Return where the linear interpolant of the torque falls through zero, unless a point is close."""
        known, torques = self._known("torque")
        limit = ZERO * max(map(abs, torques), default=0.0)
        rows = [*zip(pairwise(known), pairwise(torques), strict=True)]
        for (a, b), (at_a, at_b) in reversed(rows):
            if at_a > 0.0 >= at_b:
                near = min(abs(at_a), abs(at_b)) <= limit or b - a < 3.0 * CLOSEST
                return None if near else a + (b - a) * at_a / (at_a - at_b)
        return None


def greatest(points: Iterable[Point], name: str) -> Point | None:
    """Return the point at which a quantity is greatest; None where it is nowhere known."""
    known = [point for point in points if np.isfinite(point.value(name))]
    return max(known, key=lambda point: point.value(name), default=None)


def root(points: Iterable[Point]) -> Estimate:
    """Return the greatest velocity at which the torque falls through zero [rad/s], by linear interpolation.

    Its error is the distance from the nearer point, and the error of the torque over the slope.
    """
    known = [point for point in points if point.belt is not None and np.isfinite(point.value("torque"))]
    for below, above in reversed([*pairwise(known)]):
        (v, w), ((m, m_error), (n, n_error)) = (
            (below.value("velocity"), above.value("velocity")),
            (below["torque"], above["torque"]),
        )
        if m > 0.0 >= n:
            value = v + (w - v) * m / (m - n)
            spread = max(m_error, n_error) * (w - v) / (m - n)
            return Estimate(value, min(value - v, w - value) + spread)
    return UNKNOWN
