"""Least squares with many starts, in the unit cube of the free parameters, and what it cannot tell."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, sqrt
from typing import Final, final

import numpy as np
from scipy.optimize import OptimizeResult, least_squares
from scipy.stats import qmc

from contactlab.arrays import Array
from contactlab.inference.free_parameters import Free, from_cube, to_cube

HIT: Final = 1e-4
"""Relative difference of two costs that are taken for one optimum."""

LOOKS: Final = 8
"""Points that are looked at for each start: a plateau, such as that on which every contact sticks, holds
whatever starts there."""

NO_SLOPE: Final = 1e-15
"""Slope of a cost of one at which a start has ended; a plateau has none."""

FLAT: Final = 1e-6
"""Singular value over the largest below which a direction changes nothing that is predicted."""

SHARE: Final = 0.3
"""Part that a parameter has in a flat direction of length one from which it is named."""

AT_END: Final = 1e-6
"""Distance from an end of the unit interval at which a parameter is taken to lie on it."""


@final
@dataclass(frozen=True, eq=False)
class Fit:
    """What a fit found: the best of its starts, and how far it is to be believed.

    Args:
        free: what was free.
        values: the optimum [SI], shape (parameter,).
        cost: half the sum of the squared residuals there.
        costs: that of every start's end, shape (start,), infinite where there were fewer points at which the
            residuals are finite.
        hits: how many starts ended at the best cost.
        singular_values: of the Jacobian of the residuals in the unit cube at the optimum, falling.
        cannot_tell: names of the parameters that the residuals do not determine; see `undetermined`.
        at_end: names of those that lie on an end of their range, where the best may lie beyond.
    """

    free: tuple[Free, ...]
    values: Array
    cost: float
    costs: Array
    hits: int
    singular_values: Array
    cannot_tell: tuple[str, ...]
    at_end: tuple[str, ...]

    def warnings(self) -> list[str]:
        """Say, a sentence each, which of the values are none that the data determine."""
        said = [f"cannot tell: {', '.join(self.cannot_tell)}"] if self.cannot_tell else []
        ends = {one.name: value for one, value in zip(self.free, self.values, strict=True)}
        return said + [f"{name} lies on an end of its range, {ends[name]:.4g}" for name in self.at_end]


def best_fit(
    residuals: Callable[[Array], Array],
    free: Sequence[Free],
    starts: int,
    seed: int,
    *,
    looks: int = LOOKS,
    begin: Array | None = None,
    step: float | None = None,
    accuracy: float = 1e-8,
    advance: Callable[[], object] = bool,
) -> Fit:
    """Find the values with the least sum of squared residuals, from the best of many points of the cube.

    The points are its middle and a Latin hypercube's, so many for each start; the residuals are looked at
    there, and the best points are started from. Each start is followed by a trust region (Branch, Coleman
    and Li 1999, SIAM J. Sci. Comput. 21, 1) that stays in the ranges. A step to where a residual is not
    finite is shortened; a point there is not started from.

    Args:
        residuals: gives from values [SI], shape (parameter,), the residuals, shape (residual,).
        free: what is free; without any the residuals are taken as they are.
        starts: how many, at least one.
        seed: of the points; the same seed gives the same bits.
        looks: points that are looked at for each start.
        begin: values [SI], shape (parameter,), of the one start that there is then; nothing is drawn.
        step: of the differences in the unit cube that the derivatives are taken by; None is that of
            residuals without noise, 1.5e-8. A law that is integrated to a tolerance wants its square root.
        accuracy: relative change of cost, and of the point in the cube, at which a start has ended.
        advance: called as each start has ended.

    Raises:
        ValueError: there is no start, or the residuals are finite at no point.
    """
    if starts < 1 or looks < 1:
        raise ValueError(f"starts is {starts} and looks is {looks}; both must be at least 1.")
    free = tuple(free)
    if not free:
        return _of_nothing(residuals(np.empty(0)))

    def in_cube(shares: Array) -> Array:
        return np.asarray(residuals(from_cube(free, shares)), dtype=np.float64)

    if begin is None:
        points = starting_points(len(free), starts * looks, seed)
    else:
        points = np.clip(to_cube(free, begin), 0.0, 1.0)[None]
    seen = np.array([_cost(in_cube(point)) for point in points])
    if not np.isfinite(seen).any():
        names = ", ".join(map(str, free))
        raise ValueError(
            f"None of {len(points)} points has residuals that are finite numbers, of {names}. Narrow the "
            "ranges."
        )
    # In units of the best that was seen, so that no tolerance depends on the unit of the residuals.
    unit = sqrt(2.0 * seen.min()) or 1.0
    best, ends = None, []
    for place in np.argsort(seen, kind="stable")[:starts]:
        end = None
        if np.isfinite(seen[place]):
            end = _descend(lambda shares: in_cube(shares) / unit, points[place], step, accuracy)
            best = end if best is None or end.cost < best.cost else best
        ends.append(inf if end is None else float(end.cost))
        advance()
    assert best is not None
    return _fit(free, best, np.array(ends, dtype=np.float64), unit)


def _descend(
    residuals: Callable[[Array], Array], start: Array, step: float | None, accuracy: float
) -> OptimizeResult:
    """Follow one start to its end."""
    settings = {"ftol": accuracy, "xtol": accuracy, "gtol": NO_SLOPE, "diff_step": step}
    return least_squares(residuals, start, bounds=(0.0, 1.0), **settings)


def _fit(free: tuple[Free, ...], best: OptimizeResult, ends: Array, unit: float) -> Fit:
    """Say what was found, in the unit of the residuals."""
    point, jacobian = np.asarray(best.x), np.asarray(best.jac) * unit
    spread = noise(np.asarray(best.fun) * unit, len(free))
    return Fit(
        free,
        from_cube(free, point),
        float(best.cost) * unit**2,
        ends * unit**2,
        int(np.sum(ends <= best.cost * (1.0 + HIT) + np.finfo(float).tiny)),
        np.asarray(np.linalg.svd(jacobian, compute_uv=False), dtype=np.float64),
        undetermined(free, jacobian, spread),
        tuple(one.name for one, x in zip(free, point, strict=True) if min(x, 1.0 - x) < AT_END),
    )


def _cost(residuals: Array) -> float:
    """Give half the sum of the squares, infinite where a residual is no number."""
    return 0.5 * float(np.sum(residuals**2)) if np.isfinite(residuals).all() else inf


def starting_points(size: int, points: int, seed: int) -> Array:
    """Give the points of the unit cube from which a search begins, shape (point, parameter).

    The first is the middle, the others are a Latin hypercube's.
    """
    drawn = qmc.LatinHypercube(size, seed=seed).random(points - 1) if points > 1 else np.empty((0, size))
    return np.vstack([np.full((1, size), 0.5), drawn])


def noise(residuals: Array, parameters: int) -> float:
    """Estimate the standard deviation of one residual from those of a fit with so many parameters."""
    return sqrt(float(np.sum(residuals**2)) / max(residuals.size - parameters, 1))


def undetermined(free: Sequence[Free], jacobian: Array, spread: float) -> tuple[str, ...]:
    """Name the parameters that no residual determines.

    A direction of the unit cube with the singular value s of the Jacobian is known to spread/s. It is flat
    where that is more than 1/sqrt(12), the deviation of the range itself, so that the data say nothing, or
    where s is below `FLAT` of the largest. The parameters with a part of `SHARE` and more in it are named.

    Args:
        free: the parameters.
        jacobian: of the residuals over the shares of the ranges, shape (residual, parameter).
        spread: standard deviation of one residual.
    """
    rows, columns = jacobian.shape
    # A row short of a square has directions that no singular value stands for.
    filled = np.vstack([jacobian, np.zeros((max(columns - rows, 0), columns))])
    _, sizes, directions = np.linalg.svd(filled, full_matrices=False)
    flat = (sizes <= FLAT * sizes[0]) | (sizes < sqrt(12.0) * spread)
    named = (np.abs(directions[flat]) >= SHARE).any(axis=0)
    return tuple(one.name for one, is_flat in zip(free, named, strict=True) if is_flat)


def _of_nothing(residuals: Array) -> Fit:
    """Give the fit of no parameter."""
    if not np.isfinite(residuals).all():
        raise ValueError("The residuals are not finite numbers, and nothing is free to change that.")
    cost = 0.5 * float(np.sum(np.asarray(residuals) ** 2))
    return Fit((), np.empty(0), cost, np.array([cost]), 1, np.empty(0), (), ())
