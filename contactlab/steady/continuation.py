"""Branches of periodic orbits over a parameter, through folds, by pseudo-arclength continuation.

Source: Seydel, Practical Bifurcation and Stability Analysis (2010), ch. 4.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.steady.period_map import BrokenOffError, PeriodMap
from contactlab.steady.shooting import CLOSED, STEP, Orbit

MOST_CORRECTIONS: Final = 10

GROWTH: Final = 1.5


@final
@dataclass(frozen=True)
class Point:
    parameter: float
    orbit: Orbit


def continue_branch(
    map_at: Callable[[float], PeriodMap],
    first: Orbit,
    value: float,
    end: float,
    step: float,
    *,
    smallest: float | None = None,
    points: int = 400,
) -> list[Point]:
    """Follow a branch of orbits."""
    size = float(np.linalg.norm(first.state))
    scale = abs(end - value)
    smallest = smallest or step * 1e-4

    def residual(y: Array) -> Array:
        try:
            z = y[:-1] * size
            return (map_at(value + scale * y[-1])(z) - z) / size
        except (BrokenOffError, ValueError):
            return np.full(y.size - 1, np.inf)

    def along_parameter(y: Array) -> Array:
        h = np.zeros_like(y)
        h[-1] = STEP
        return (residual(y + h) - residual(y - h)) / (2.0 * STEP)

    y = np.append(first.state / size, 0.0)
    found = [Point(value, first)]
    jac = np.column_stack([first.jacobian - np.eye(y.size - 1), along_parameter(y)])
    tangent = _null(jac)
    tangent *= np.sign((end - value) * tangent[-1]) or 1.0
    ds = step
    while len(found) < points:
        guess = y + ds * tangent
        new, J = guess.copy(), jac.copy()
        r = np.append(residual(new), 0.0)
        for it in range(MOST_CORRECTIONS):
            if not np.all(np.isfinite(r)) or np.linalg.norm(r) > 1e3:
                break
            if np.linalg.norm(r[:-1]) <= CLOSED:
                break
            B = np.vstack([J, tangent])
            dy = -np.linalg.solve(B, r)
            if np.linalg.norm(new + dy - guess) > ds:
                r[0] = np.inf
                break
            after = np.append(residual(new + dy), tangent @ (new + dy - guess))
            J = J + np.outer(after[:-1] - r[:-1] - J @ dy, dy) / (dy @ dy)
            new, r = new + dy, after
        if not np.all(np.isfinite(r)) or np.linalg.norm(r[:-1]) > CLOSED:
            ds *= 0.5
            if ds < smallest:
                break
            continue
        y = new
        p = value + scale * y[-1]
        section = map_at(p)
        z = y[:-1] * size
        jz = section.jacobian(z, STEP)
        orbit = Orbit(section, z, float(np.linalg.norm(r[:-1])), jz, np.nan)
        found.append(Point(p, orbit))
        jac = np.column_stack([jz - np.eye(z.size), along_parameter(y)])
        t = _null(jac)
        tangent = t * (np.sign(t @ tangent) or 1.0)
        if it <= 3:
            ds = min(ds * GROWTH, 4 * step)
        if not (min(value, end) <= p <= max(value, end)):
            break
    return found


def _null(matrix: Array) -> Array:
    """Give the unit vector that a matrix with one row less than columns takes to nothing."""
    return np.linalg.svd(matrix)[2][-1]
