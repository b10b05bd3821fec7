"""Multi-start least squares in the unit cube of the free parameters."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite, sqrt
from typing import Final, final

import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from contactlab.arrays import Array
from contactlab.progress import tell_progress, untold_progress
from contactlab_data.inference.free_parameters import FreeParameter, from_cube, to_cube

HIT: Final = 1e-4
"""Relative difference below which two costs are one optimum."""

NEAR: Final = 0.02
"""Distance in the unit cube below which two optima of one cost are one place."""

LOOKS: Final = 8
"""Candidate points for each start: on a plateau, as where every contact sticks, a search cannot start."""

LOOKED: Final = 0.3
"""Share of the evaluations that candidate points take, roughly."""

NO_SLOPE: Final = 1e-15
"""Gradient, relative to the cost, at which a search ends; a plateau has none."""

FLAT: Final = 1e-6
"""Singular value over the largest below which a direction changes no prediction."""

SHARE: Final = 0.3
"""Component of a parameter in a flat direction of unit length from which on it is undetermined."""

AT_END: Final = 1e-6
"""Distance from an end of the unit interval below which a parameter lies on it."""


@final
@dataclass(frozen=True, eq=False)
class Optimum:
    """Result of a multi-start search.

    Args:
        free: the free parameters.
        values: the optimum [SI], shape (parameter,).
        cost: half the sum of the squared residuals there.
        costs: of all starts, shape (start,), infinite where fewer points had finite residuals.
        hits: number of starts that reached the lowest cost.
        undetermined: names of the parameters that the residuals do not determine; see `undetermined`.
        at_end: names of those that lie on an end of their range, where the optimum may lie beyond.
        point: the optimum in the unit cube, shape (parameter,).
        residuals: there, shape (residual,).
        jacobian: of the residuals in the unit cube, shape (residual, parameter).
        noise: likeliest values of the free numbers of the noise [SI], see `maximum_likelihood`.
    """

    free: tuple[FreeParameter, ...]
    values: Array
    cost: float
    costs: Array
    hits: int
    undetermined: tuple[str, ...]
    at_end: tuple[str, ...]
    point: Array
    residuals: Array
    jacobian: Array
    noise: Array = field(default_factory=lambda: np.empty(0))

    @property
    def all_values(self) -> Array:
        """The optimum, and the numbers of the noise behind it [SI]."""
        return np.append(self.values, self.noise)

    @property
    def by_name(self) -> dict[str, float]:
        """The optimum by the names of the parameters [SI]."""
        return {item.name: float(x) for item, x in zip(self.free, self.values, strict=True)}

    def warnings(self) -> list[str]:
        """Return a phrase for each kind of value that the data do not determine."""
        return [*(f"{name} lies on an end of its range, {self.by_name[name]:.4g}" for name in self.at_end)]


def best_fit(
    residuals: Callable[[Array], Array],
    free: Sequence[FreeParameter],
    starts: int,
    seed: int,
    *,
    looks: int = LOOKS,
    begin: Array | None = None,
    step: float | None = None,
    accuracy: float = 1e-8,
    agreed: int | None = None,
) -> Optimum:
    """Minimise the sum of squared residuals, starting from the best of many points of the unit cube.

    Candidate points are the middle of the cube and a Latin hypercube. Each start is followed by a trust
    region (Branch, Coleman and Li 1999, SIAM J. Sci. Comput. 21, 1) within the ranges. A step to where a
    residual is not finite is shortened.

    Args:
        residuals: function from values [SI], shape (parameter,), to residuals, shape (residual,).
        free: free parameters; without any the residuals are evaluated once.
        starts: how many, at least one.
        seed: of the points; the same seed gives the same bits.
        looks: candidate points for each start.
        begin: values [SI], shape (parameter,), of a single start instead.
        step: of finite differences in the unit cube; None is that of residuals exact to round-off, 1.5e-8.
            For a law integrated to a tolerance it should be the square root of that.
        accuracy: relative change of cost, and of the point in the cube, at which a search ends.
        agreed: number of starts that reach the lowest cost so far, in one place, after which no other is
            tried; None tries all.

    Raises:
        ValueError: there is no start, or the residuals are finite at no point.
    """
    if starts < 1 or looks < 1:
        raise ValueError(f"starts is {starts} and looks is {looks}; both must be at least 1.")
    free = tuple(free)
    if not free:
        least = np.asarray(residuals(np.empty(0)))
        if not isfinite(cost := _cost(least)):
            raise ValueError("The residuals are not finite numbers, and nothing is free to change that.")
        nothing = np.empty(0)
        jacobian = np.empty((least.size, 0))
        return Optimum((), nothing, cost, np.array([cost]), 1, (), (), nothing, least, jacobian)

    if begin is None:
        points = starting_points(len(free), starts * looks, seed)
    else:
        points = np.clip(to_cube(free, begin), 0.0, 1.0)[None]
    evaluations = 0
    looked = LOOKED if begin is None else 0.0

    def counted(shares: Array, share: float) -> Array:
        """Return the residuals at a point of the unit cube, and tell of it."""
        nonlocal evaluations
        evaluations += 1
        tell_progress(f"least squares: {evaluations} evaluations", share)
        with untold_progress():
            return np.asarray(residuals(from_cube(free, shares)), dtype=np.float64)

    seen = np.array(
        [_cost(counted(point, looked * number / len(points))) for number, point in enumerate(points)]
    )
    if not np.isfinite(seen).any():
        names = ", ".join(map(str, free))
        raise ValueError(
            f"None of {len(points)} points has residuals that are finite numbers, of {names}. Narrow the "
            "ranges."
        )
    # In units of the lowest cost, so that no tolerance depends on the unit of the residuals.
    unit = sqrt(2.0 * seen.min()) or 1.0
    ends, costs = list[OptimizeResult](), np.full(starts, inf)
    for number, place in enumerate(np.argsort(seen, kind="stable")[:starts]):
        if np.isfinite(seen[place]):
            end = least_squares(
                lambda shares, share=looked + (1.0 - looked) * number / starts: counted(shares, share) / unit,
                points[place],
                bounds=(0.0, 1.0),
                ftol=accuracy,
                xtol=accuracy,
                gtol=NO_SLOPE,
                diff_step=step,
            )
            ends.append(end)
            costs[number] = end.cost
            lowest = min(ends, key=lambda end: end.cost)
            # On a plateau starts end at one cost and in many places.
            as_low = [x for x in ends if x.cost <= lowest.cost * (1.0 + HIT)]
            if agreed and sum(np.abs(x.x - lowest.x).max() < NEAR for x in as_low) >= agreed:
                costs = costs[: number + 1]
                break
    best = min(ends, key=lambda end: end.cost)
    point, jacobian = np.asarray(best.x), np.asarray(best.jac) * unit
    squares = float(np.sum((np.asarray(best.fun) * unit) ** 2))
    spread = sqrt(squares / max(best.fun.size - len(free), 1))
    return Optimum(
        free,
        from_cube(free, point),
        float(best.cost) * unit**2,
        costs * unit**2,
        int(np.sum(costs <= best.cost * (1.0 + HIT) + np.finfo(float).tiny)),
        undetermined(free, jacobian, spread),
        tuple(item.name for item, x in zip(free, point, strict=True) if min(x, 1.0 - x) < AT_END),
        point,
        np.asarray(best.fun) * unit,
        jacobian,
    )


def _cost(residuals: Array) -> float:
    """Return half the sum of the squares, infinite if a residual is not finite."""
    return 0.5 * float(np.sum(residuals**2)) if np.isfinite(residuals).all() else inf


def starting_points(size: int, points: int, seed: int) -> Array:
    """Return the middle of the unit cube and a Latin hypercube, shape (point, parameter)."""
    # Imported here: a run needs no scipy.stats.
    from scipy.stats import qmc

    drawn = qmc.LatinHypercube(size, seed=seed).random(points - 1) if points > 1 else np.empty((0, size))
    return np.vstack([np.full((1, size), 0.5), drawn])


def undetermined(free: Sequence[FreeParameter], jacobian: Array, spread: float) -> tuple[str, ...]:
    """Return the names of the parameters that no residual determines.

    A direction of the unit cube with the singular value s of the Jacobian is known to spread/s. It is flat
    where that exceeds 1/sqrt(12), the deviation of the prior, or where s is below `FLAT` of the largest. The
    parameters with a component of `SHARE` and more in a flat direction are undetermined.

    Args:
        jacobian: of the residuals in the unit cube, shape (residual, parameter).
        spread: standard deviation of one residual.
    """
    rows, columns = jacobian.shape
    # With fewer rows than columns some directions have no singular value.
    filled = np.vstack([jacobian, np.zeros((max(columns - rows, 0), columns))])
    _, sizes, directions = np.linalg.svd(filled, full_matrices=False)
    flat = (sizes <= FLAT * sizes[0]) | (sizes < sqrt(12.0) * spread)
    named = (np.abs(directions[flat]) >= SHARE).any(axis=0)
    return tuple(item.name for item, is_flat in zip(free, named, strict=True) if is_flat)
