"""Least squares with many starts, in the unit cube of the free parameters, and what it cannot tell."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, sqrt
from typing import Final, final

import numpy as np
from scipy.optimize import OptimizeResult, least_squares
from scipy.stats import qmc

from contactlab.arrays import Array
from contactlab.fitting.parameters import Free, from_cube

HIT: Final = 1e-4
"""Relative difference of two costs that are taken for one optimum."""

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
        costs: that of every start's end, shape (start,), infinite where the residuals are not finite at
            the start.
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
    step: float | None = None,
    accuracy: float = 1e-8,
    advance: Callable[[], object] = bool,
) -> Fit:
    """Find the values with the least sum of squared residuals, from the cube's middle and from drawn starts.

    The starts after the first are a Latin hypercube's. Each is followed by a trust region (Branch, Coleman
    and Li 1999, SIAM J. Sci. Comput. 21, 1) that stays in the ranges. A step to where a residual is not
    finite is shortened; a start there is given up.

    Args:
        residuals: gives from values [SI], shape (parameter,), the residuals, shape (residual,).
        free: what is free; without any the residuals are taken as they are.
        starts: how many, at least one.
        seed: of the starts; the same seed gives the same bits.
        step: of the differences in the unit cube that the derivatives are taken by; None is that of
            residuals without noise, 1.5e-8. A law that is integrated to a tolerance wants its square root.
        accuracy: relative change of cost, and of the point in the cube, at which a start has ended.
        advance: called as each start has ended.

    Raises:
        ValueError: there is no start, or the residuals are finite at none of them.
    """
    if starts < 1:
        raise ValueError(f"starts is {starts}; it must be at least 1.")
    free = tuple(free)
    if not free:
        return _of_nothing(residuals(np.empty(0)))

    def in_cube(shares: Array) -> Array:
        return np.asarray(residuals(from_cube(free, shares)), dtype=np.float64)

    ends: list[OptimizeResult | None] = []
    for start in starting_points(len(free), starts, seed):
        if np.isfinite(in_cube(start)).all():
            bounds = (0.0, 1.0)
            settings = {"ftol": accuracy, "xtol": accuracy, "gtol": None, "diff_step": step}
            ends.append(least_squares(in_cube, start, bounds=bounds, **settings))
        else:
            ends.append(None)
        advance()
    costs = np.array([inf if end is None else float(end.cost) for end in ends])
    best = ends[int(np.argmin(costs))]
    if best is None:
        names = ", ".join(map(str, free))
        raise ValueError(
            f"None of {starts} starts has residuals that are finite numbers, of {names}. Narrow the ranges."
        )
    spread = noise(best.fun, len(free))
    point = np.asarray(best.x)
    return Fit(
        free,
        from_cube(free, point),
        float(best.cost),
        costs,
        int(np.sum(costs <= best.cost * (1.0 + HIT) + np.finfo(float).tiny)),
        np.linalg.svd(best.jac, compute_uv=False),
        undetermined(free, best.jac, spread),
        tuple(one.name for one, x in zip(free, point, strict=True) if min(x, 1.0 - x) < AT_END),
    )


def starting_points(size: int, starts: int, seed: int) -> Array:
    """Give the points of the unit cube from which a search begins, shape (start, parameter).

    The first is the middle, the others are a Latin hypercube's.
    """
    drawn = qmc.LatinHypercube(size, seed=seed).random(starts - 1) if starts > 1 else np.empty((0, size))
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
