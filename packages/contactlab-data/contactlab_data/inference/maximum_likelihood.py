"""Least squares as a method: maximum likelihood, covariance, and intervals by the profile likelihood.

Residuals r(x) are standardised by the noise, so that about the optimum, in the unit cube,

    -ln L = r'r / 2 + what the noise alone sets,    covariance = s^2 (J'J)^-1,    J = dr/dx

with s = 1 where the noise is stated. Where its size is free, s^2 = r'r / (n - p) of n residuals and p
numbers, and quantiles are those of Student's t distribution with n - p degrees of freedom. The sizes of the
noise, at which the predictions are known, are found in turn with the numbers of law and motor. The profile of
a number x_k is

    zeta(x_k)^2 = (min r'r at x_k - min r'r) / s^2

and its interval is where |zeta| is below the quantile: exact where residuals are linear, and one-sided where
they do not determine the number towards one end of its range. Laplace's approximation of the evidence in the
cube, whose prior density is one, is ln L + ln det(2 pi covariance) / 2.

Sources: Venzon and Moolgavkar (1988), Appl. Stat. 37, 87; Bates and Watts (1988), Nonlinear Regression
Analysis, ch. 6; Tierney and Kadane (1986), J. Am. Stat. Assoc. 81, 82.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import inf, nan, pi, sqrt
from typing import Any, Final

import numpy as np
from scipy.linalg import block_diag
from scipy.optimize import minimize
from scipy.special import ndtri, stdtrit

from contactlab.arrays import Array
from contactlab.progress import part_of_progress, tell_progress, untold_progress
from contactlab_data.inference.free_parameters import from_cube, to_cube
from contactlab_data.inference.least_squares import FLAT, Optimum, best_fit, starting_points
from contactlab_data.inference.posterior import ENDS, NormalPosterior
from contactlab_data.inference.problem import IMPOSSIBLE, Problem

STARTS: Final = 16
"""Default number of starts."""

LOOKS: Final = 4
"""Candidate points for each start."""

AGREED: Final = 3
"""Starts that reach the lowest cost after which no other is tried."""

ROUNDS: Final = 8
MOVED: Final = 0.02
"""Fits with new sizes of the noise at most, and the change in standard deviations below which they end."""

WAYS: Final = 8
"""Points for each number of the noise from the best of which its likelihood is searched."""

CURVED: Final = 1e-3
"""Step of second differences of that likelihood in the unit cube."""

EXACT: Final = 0.01
"""Relative error of |zeta| at an end of an interval."""

REFITS: Final = 16
"""Fits at most for one end of an interval."""

ROUGH: Final = 1e-5
"""Accuracy of these fits, see `best_fit`."""

DRAWS: Final = 1000
"""Samples that are drawn of a normal distribution."""

WIDE: Final = sqrt(1.0 / 12.0)
"""Standard deviation of the prior in the unit cube."""

Residuals = Callable[[Array], Array]


def maximum_likelihood(problem: Problem, starts: int, seed: int, begin: Array | None = None) -> Optimum:
    """Return the likeliest numbers of law and motor, and those of the noise.

    Args:
        starts, seed, begin: of the first search, see `best_fit`.

    Raises:
        ValueError: the residuals are finite at no point.
    """
    search: dict[str, Any] = {"begin": begin, "step": problem.step, "agreed": AGREED, "looks": LOOKS}
    best = found = best_fit(problem.residuals, problem.parameters, starts, seed, **search)
    for _ in range(ROUNDS if problem.nuisances else 0):
        noise = likeliest_noise(problem, best.values)
        again = refit(standardised(problem, noise), problem, best.values)
        moved = best.residuals.size and np.linalg.norm(again.jacobian @ (again.point - best.point))
        best = replace(again, noise=noise)
        if moved < MOVED:
            break
    return replace(best, costs=found.costs, hits=found.hits)


def followed_search(problem: Problem, starts: int, seed: int) -> tuple[Problem, Optimum]:
    """Return the problem whose steady states follow each other, and its optimum.

    Where the optimum has other residuals from rest, the motor has come to another motion than the one that
    was followed: then it is the problem itself, searched from rest.

    Args:
        starts, seed: of the search, see `best_fit`.

    Raises:
        ValueError: the residuals are finite at no point.
    """
    followed = problem.following()
    best = maximum_likelihood(followed, starts, seed)
    off = problem.residuals(best.all_values) - best.residuals
    if np.linalg.norm(off) < MOVED:
        return followed, best
    return problem, maximum_likelihood(problem, starts, seed)


def standardised(problem: Problem, noise: Array) -> Residuals:
    """Return the residuals as a function of the numbers of law and motor, at fixed ones of the noise."""
    return lambda values: problem.residuals(np.append(values, noise))


def refit(residuals: Residuals, problem: Problem, begin: Array) -> Optimum:
    """Return the optimum of residuals of the numbers of law and motor, by one search."""
    with untold_progress():
        return best_fit(residuals, problem.parameters, 1, 0, begin=begin, step=problem.step)


def likeliest_noise(problem: Problem, values: Array) -> Array:
    """Return the likeliest numbers of the noise at the numbers of law and motor [SI]."""
    free, cost = problem.nuisances, _cost_of_noise(problem, values)
    begin = min(starting_points(len(free), WAYS * len(free), 0), key=cost)
    end = minimize(cost, begin, method="L-BFGS-B", bounds=[(0.0, 1.0)] * len(free))
    return from_cube(free, np.asarray(end.x))


def _cost_of_noise(problem: Problem, values: Array) -> Callable[[Array], float]:
    """Return -ln L as a function of the numbers of the noise in the unit cube."""
    predicted = problem.predict(values)
    # An optimum has a prediction.
    assert predicted is not None

    def cost(shares: Array) -> float:
        every = np.append(values, from_cube(problem.nuisances, shares))
        total = sum(float(x.sum()) for x in problem.log_densities(predicted, every).values())
        return -max(total, IMPOSSIBLE)

    return cost


def scale_of(problem: Problem, best: Optimum) -> tuple[float, float]:
    """Return s^2 of the residuals, and the quantile of |zeta| of a 90 % interval."""
    left = best.residuals.size - best.values.size
    if not problem.nuisances or left < 1:
        return 1.0, float(ndtri(ENDS[1]))
    # Noise at the lower end of its range may be larger than the residuals.
    return max(2.0 * best.cost / left, 1.0), float(stdtrit(left, ENDS[1]))


def normal_posterior(problem: Problem, best: Optimum, ends: Array, seed: int) -> NormalPosterior:
    """Return the normal distribution about an optimum.

    Args:
        ends: 90 % intervals of the numbers of law and motor in the unit cube, shape (parameter, 2).
        seed: of its draws.
    """
    scale, quantile = scale_of(problem, best)
    covariance = covariance_of(best.jacobian, scale)
    point, free = best.point, problem.free
    if problem.nuisances:
        shares = to_cube(problem.nuisances, best.noise)
        curvature = second_derivatives(_cost_of_noise(problem, best.values), shares)
        roots, directions = np.linalg.eigh(curvature)
        # A likelihood that does not bend leaves the prior.
        own = (directions / np.maximum(roots, WIDE**-2)) @ directions.T
        covariance, point = block_diag(covariance, own), np.append(point, shares)
        reach = quantile * np.sqrt(np.diag(own))
        ends = np.vstack([ends, np.column_stack([shares - reach, shares + reach])])
    ends = np.clip(ends, 0.0, 1.0)
    draws = np.random.default_rng([seed, 3])
    samples = draws.multivariate_normal(point, covariance, DRAWS)
    for _ in range(REFITS):
        # Those that lie outside are drawn again.
        out = (np.abs(samples - 0.5) > 0.5).any(axis=1)
        samples[out] = draws.multivariate_normal(point, covariance, int(out.sum()))
    samples = np.clip(samples, 0.0, 1.0)
    inverse = np.linalg.pinv(covariance, hermitian=True)
    likeliest = problem.log_likelihood(best.all_values)
    off = samples - point
    units = np.array([item.slope(float(x)) for item, x in zip(free, best.all_values, strict=True)])
    known = not (best.undetermined or best.at_end)
    volume = 0.5 * float(np.linalg.slogdet(2.0 * pi * covariance)[1]) if len(free) else 0.0
    return NormalPosterior(
        "least squares",
        free,
        np.array([from_cube(free, shares) for shares in samples]),
        likeliest - 0.5 * np.einsum("ni,ij,nj->n", off, inverse, off),
        np.full(DRAWS, -np.log(DRAWS)),
        likeliest + volume if known else nan,
        nan,
        nan,
        0,
        0,
        seed,
        best.all_values,
        covariance * np.outer(units, units),
        np.array([[from_cube([item], [x])[0] for x in row] for item, row in zip(free, ends, strict=True)]),
    )


def covariance_of(jacobian: Array, scale: float) -> Array:
    """Return s^2 (J'J)^-1 in the unit cube; directions without effect have the variance of the prior."""
    rows, columns = jacobian.shape
    filled = np.vstack([jacobian, np.zeros((max(columns - rows, 0), columns))])
    _, sizes, directions = np.linalg.svd(filled, full_matrices=False)
    flat = sizes <= max(FLAT * sizes.max(initial=0.0), sqrt(scale) / WIDE)
    variances = np.where(flat, WIDE**2, scale / np.where(flat, 1.0, sizes) ** 2)
    return np.asarray((directions.T * variances) @ directions)


def second_derivatives(cost: Callable[[Array], float], point: Array) -> Array:
    """Return the second derivatives of a function in the unit cube, by differences inside of it."""
    point = np.clip(point, 2.0 * CURVED, 1.0 - 2.0 * CURVED)
    steps = CURVED * np.eye(point.size)

    def corner(i: int, j: int) -> float:
        a, b = steps[i], steps[j]
        ahead = cost(point + a + b) + cost(point - a - b)
        return float(ahead - cost(point + a - b) - cost(point - a + b)) / (4.0 * CURVED**2)

    return np.array([[corner(i, j) for j in range(point.size)] for i in range(point.size)])


def profile_ends(
    residuals: Residuals,
    best: Optimum,
    scale: float,
    quantile: float,
    places: Sequence[int] | None = None,
    step: float | None = None,
) -> Array:
    """Return the 90 % intervals of numbers by the profile likelihood, in the unit cube, shape (place, 2).

    An end of the cube is one of the interval where the profile stays below the quantile up to it.

    Args:
        residuals: standardised, of the numbers of law and motor.
        best: their optimum; an interval of other residuals than its own begins there too.
        scale, quantile: of `scale_of`.
        places: indices of the numbers; None is all.
        step: of finite differences, see `best_fit`.
    """
    chosen = range(len(best.free)) if places is None else places
    covariance = covariance_of(best.jacobian, scale)
    result = np.empty((len(chosen), 2))
    for row, place in enumerate(chosen):
        others = [i for i in range(len(best.free)) if i != place]
        slopes = covariance[:, place] / covariance[place, place]

        def zeta(
            share: float, place: int = place, others: Sequence[int] = others, slopes: Array = slopes
        ) -> float:
            """Return |zeta| of a share of the range, the others fitted from where they are expected."""
            begin = np.clip(best.point + slopes * (share - best.point[place]), 0.0, 1.0)
            begin[place] = share
            free = [best.free[i] for i in others]

            def of_others(values: Array) -> Array:
                point = np.array(begin)
                point[others] = to_cube(free, values)
                return residuals(from_cube(best.free, point))

            try:
                start = from_cube(best.free, begin)[others]
                least = best_fit(of_others, free, 1, 0, begin=start, step=step, accuracy=ROUGH).cost
            except ValueError:
                return inf
            return sqrt(max(2.0 * (least - best.cost) / scale, 0.0))

        reach = quantile * sqrt(covariance[place, place])
        for column, (sign, end) in enumerate(((-1.0, 0.0), (1.0, 1.0))):
            number = 2 * row + column
            with part_of_progress(number / result.size, (number + 1) / result.size):
                tell_progress(f"interval of {best.free[place].name}", 0.0)
                with untold_progress():
                    result[row, column] = profile_end(
                        zeta, float(best.point[place]), sign * reach, end, quantile
                    )
    return result


def profile_end(
    zeta: Callable[[float], float], middle: float, reach: float, end: float, quantile: float
) -> float:
    """Return where |zeta| is the quantile on one side, or the end of the cube where it stays below.

    Args:
        reach: expected distance from the middle, with its sign.
    """
    near, below, far, above, crossed = middle, 0.0, end, inf, False
    share = middle + reach
    for _ in range(REFITS):
        share = max(share, end) if reach < 0.0 else min(share, end)
        value = zeta(share)
        if abs(value - quantile) <= EXACT * quantile or (value < quantile and share == end):
            return share
        if value < quantile:
            near, below = share, value
        else:
            far, above, crossed = share, value, True
        if crossed:
            # Halves where a straight line would not.
            weight = min(max((quantile - below) / (above - below), 0.1), 0.9) if above < inf else 0.5
            share = near + weight * (far - near)
        else:
            # In a profile that bends away the next is no further than four times as far.
            share = middle + (min(quantile / value, 4.0) if value > 0.0 else 4.0) * (share - middle)
    return 0.5 * (near + far)
