"""Likelihood of residuals, compiled; exact at a cost proportional to the number of data.

Of a series: white noise and a discrepancy of the model, an Ornstein-Uhlenbeck process of the standard
deviation delta and the correlation time tau, so that residuals at t_i and t_j have the covariance

    sigma_i^2 (i = j) + delta^2 exp(-|t_i - t_j| / tau)

The process is Markov, so that a Kalman filter of one state gives the density of every residual given those
before it, and their product is that of the multivariate normal, in n steps in place of n^3.

Of impacts: the residual of the velocity after each has the covariance

    C_i + s^2 (u' D^-1 u) D

of the stated error C and an isotropic term in the norm of the kinetic energy, relative to the approach u: the
error of the law as `contactlab.measured` defines errors, s being its size.

With outliers either residual may have a Student-t distribution of that scale in place of a normal one (Lange,
Little and Taylor 1989, J. Am. Stat. Assoc. 84, 881); infinite degrees of freedom are the normal distribution.

Sources: Uhlenbeck and Ornstein (1930), Phys. Rev. 36, 823; Kalman (1960), J. Basic Eng. 82, 35; of the
discrepancy Kennedy and O'Hagan (2001), J. R. Stat. Soc. B 63, 425.
"""

from math import exp, inf, lgamma, log, log1p, pi, sqrt
from typing import Any, Final

import numpy as np

from contactlab.arrays import Array
from contactlab.compiled import kernel

LOG_TWO_PI: Final = log(2.0 * pi)


@kernel
def _filtered(
    residuals: Array, time: Array, white: Array, amplitude: float, correlation: float, terms: Array
) -> None:
    """Write the logarithm of the density of each residual given those before it into `terms`."""
    mean, variance, stationary = 0.0, amplitude * amplitude, amplitude * amplitude
    for i in range(residuals.size):
        if i > 0:
            kept = exp(-(time[i] - time[i - 1]) / correlation)
            mean *= kept
            variance = kept * kept * variance + (1.0 - kept * kept) * stationary
        total = variance + white[i] * white[i]
        missed = residuals[i] - mean
        terms[i] = -0.5 * (LOG_TWO_PI + log(total) + missed * missed / total)
        gain = variance / total
        mean += gain * missed
        variance *= 1.0 - gain


@kernel
def _ornstein_uhlenbeck(normals: Array, time: Array, amplitude: float, correlation: float) -> None:
    """Turn standard normal numbers into an Ornstein-Uhlenbeck process, in place."""
    for i in range(normals.size):
        if i == 0:
            normals[i] *= amplitude
        else:
            kept = exp(-(time[i] - time[i - 1]) / correlation)
            normals[i] = kept * normals[i - 1] + amplitude * sqrt(1.0 - kept * kept) * normals[i]


@kernel
def _of_impacts(
    residuals: Array,
    covariance: Array,
    delassus: Array,
    scale: Array,
    spread: float,
    degrees_of_freedom: float,
    terms: Array,
) -> None:
    """Write the logarithm of the density of each impact's residual into `terms`."""
    for i in range(residuals.shape[0]):
        size = spread * spread * scale[i]
        a = covariance[i, 0, 0] + size * delassus[i, 0, 0]
        b = covariance[i, 0, 1] + size * delassus[i, 0, 1]
        c = covariance[i, 1, 1] + size * delassus[i, 1, 1]
        determinant = a * c - b * b
        if not (a > 0.0 and determinant > 0.0):
            terms[i] = -inf
            continue
        x, y = residuals[i, 0], residuals[i, 1]
        distance = (c * x * x - 2.0 * b * x * y + a * y * y) / determinant
        if degrees_of_freedom < inf:
            # The gamma functions of the density in two dimensions leave 1/(2 pi).
            power = 0.5 * degrees_of_freedom + 1.0
            distance = 2.0 * power * log1p(distance / degrees_of_freedom)
        terms[i] = -LOG_TWO_PI - 0.5 * (log(determinant) + distance)


def series_log_densities(
    residuals: Array, time: Array, white: Array, amplitude: float = 0.0, correlation: float = 1.0
) -> Array:
    """Return log p(residual | those before it) of a series, whose sum is the log likelihood.

    Args:
        residuals: measured minus predicted, shape (time,), in any unit.
        time: increasing [s].
        white: standard deviation of each one's noise, shape (time,), positive, in the unit of the residuals.
        amplitude: standard deviation of the discrepancy in that unit; 0 is none.
        correlation: its correlation time [s].
    """
    terms = np.empty(residuals.size)
    _filtered(residuals, time, white, float(amplitude), float(correlation), terms)
    return terms


def ornstein_uhlenbeck(
    draws: np.random.Generator, time: Array, amplitude: float, correlation: float
) -> Array:
    """Draw an Ornstein-Uhlenbeck process at times [s], shape (time,), see `series_log_densities`."""
    path = draws.standard_normal(time.size)
    _ornstein_uhlenbeck(path, time, float(amplitude), float(correlation))
    return path


def student_log_densities(residuals: Array, scale: Array, degrees_of_freedom: float) -> Array:
    """Return the log density of independent residuals with Student-t distributions, shape as the residuals.

    Args:
        residuals: measured minus predicted, in any unit.
        scale: of each one's distribution, positive, in that unit.
        degrees_of_freedom: positive, finite.
    """
    half = 0.5 * degrees_of_freedom
    constant = lgamma(half + 0.5) - lgamma(half) - 0.5 * log(degrees_of_freedom * pi)
    square = (residuals / scale) ** 2
    return np.asarray(constant - np.log(scale) - (half + 0.5) * np.log1p(square / degrees_of_freedom))


def student_factor(draws: np.random.Generator, degrees_of_freedom: float, count: int) -> Array:
    """Draw the factors that turn normal numbers into Student-t ones, shape (count,)."""
    if degrees_of_freedom == inf:
        return np.ones(count)
    return np.asarray(np.sqrt(degrees_of_freedom / draws.chisquare(degrees_of_freedom, count)))


def impact_log_densities(
    residuals: Array,
    covariance: Array,
    delassus: Array,
    scale: Array,
    spread: float,
    degrees_of_freedom: float = inf,
) -> Array:
    """Return the log density of each impact's residual, shape (impact,); -inf where it has no variance.

    Args:
        residuals: measured minus predicted velocity after the impact [m/s], shape (impact, 2).
        covariance: of the stated error [m^2/s^2], shape (impact, 2, 2), zero where none is stated.
        delassus: [1/kg], shape (impact, 2, 2).
        scale: u' D^-1 u of the approach [J], shape (impact,).
        spread: s [1].
        degrees_of_freedom: of a bivariate Student-t distribution; infinite is the normal one.
    """
    terms = np.empty(len(residuals))
    _of_impacts(residuals, covariance, delassus, scale, float(spread), float(degrees_of_freedom), terms)
    return terms


def approach_scale(delassus: Array, velocity: Array) -> Array:
    """Return u' D^-1 u of approaches [J], shape (impact,)."""
    solved: Any = np.linalg.solve(delassus, velocity[..., None])[..., 0]
    return np.asarray(np.einsum("ni,ni->n", velocity, solved))
