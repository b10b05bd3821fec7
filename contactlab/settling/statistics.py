"""Statistics of sequences: their mean, trend, limit, and the kind of motion that they show."""

from dataclasses import dataclass
from math import hypot, inf
from typing import Final, final

import numpy as np
import scipy

from contactlab.arrays import Array
from contactlab.estimate import Estimate

WINDOW: Final = 2.5
"""Window of the sum of correlations, in units of that sum: five correlation times."""

MOST_ALIKE: Final = 0.9
"""Largest correlated share of a sequence of which a variance is computed."""

CONFIDENCE: Final = 0.95

MOST_PERIODS: Final = 16
"""Longest period of a periodic motion [periods of the drive]."""

ANGLES: Final = 100
"""Number of frequencies of the 0-1 test, which takes their median."""

REPEATS: Final = 1e-3
"""Relative difference of states at which a motion is periodic."""

ALIKE: Final = 0.2
"""Ratio of the change of states over a cycle to that over one of its periods, at most."""

PERIODIC, QUASI_PERIODIC, CHAOTIC = "periodic", "quasi-periodic", "chaotic"
APERIODIC, WITHOUT_CONTACT, STANDING = "aperiodic", "without contact", "standing"
"""Kinds of motion; aperiodic is one of which quasi-periodic and chaotic are not told apart."""

MOST_REGULAR, LEAST_CHAOTIC = 0.2, 0.8
"""Values of the 0-1 test; between them it does not tell the kind."""

LEAST_TESTED: Final = 1000
"""Least length of a sequence for the 0-1 test: a tenth of it are the lags of a random walk, and a slow
beat is one while it lasts."""

LEAST_VALUES: Final = 40
"""Length of a sequence below which half of it cannot be distinguished from a straight line with scatter."""

SIGNIFICANT: Final = 2.0
"""Distance from the limit over its error, above which the sequence moves."""

SLOWEST, FASTEST, RATES = 0.1, 60.0, 80
"""Rates that are tried, over a window of half the sequence: in equal ratios, from an approach as slow as the
whole sequence to one of which double precision retains nothing at the end."""

STILL: Final = 1.0
"""Lowest rate of a sequence without trend: a slower approach would have shown since the start."""

BLOCKS: Final = 64
"""Largest number of block means in a window: they keep its form and are less scattered and correlated."""

MOST_CORRELATED, FEWEST_INDEPENDENT = 0.95, 5.0
"""Largest autocorrelation of residuals, and least number of independent values for three unknowns."""

ROUND_OFF: Final = 1e-9
"""Relative error of the values themselves."""


def mean_with_error(values: Array) -> Estimate:
    """Return the mean of a stationary sequence and half the width of its 95 % interval.

    The number of independent values is that of the values over 1 + 2 sum rho_k, summed over a window that
    follows from the sum. Variance and sum are corrected for the estimated mean; the window sets the degrees
    of freedom.

    Source: Sokal, in Functional Integration (1997) 131, sec. 3; Wolff, Comput. Phys. Commun. 156 (2004)
    143, eqs. 41 to 49.
    """
    mean, count = float(values.mean()), values.size
    rest = values - mean
    variance = float(rest @ rest) / count
    if variance <= (np.finfo(float).eps * mean) ** 2:
        return Estimate(mean, 0.0)
    # Padded, so that the end does not meet the start.
    power = np.abs(np.fft.rfft(rest, 2 * count)) ** 2
    correlation = np.fft.irfft(power)[:count] / (count * variance)
    sums = 2.0 * np.cumsum(correlation) - 1.0
    outside = np.arange(count) >= WINDOW * sums
    last = int(outside.argmax()) if outside.any() else count // 2
    extent = (2.0 * last + 1.0) / count
    # Anticorrelated values count as independent, on the safe side.
    alike = max(float(sums[last]), 1.0) * (1.0 + extent) / count
    spread = np.sqrt(variance * alike / (1.0 - min(alike, MOST_ALIKE)))
    return Estimate(
        mean, float(scipy.special.stdtrit(max(1.0 / extent, 1.0), 0.5 + 0.5 * CONFIDENCE) * spread)
    )


def trend(values: Array) -> tuple[float, float]:
    """Return the change of a sequence along its line of regression, and the error of that change.

    A mean over n values that spreads by s makes a slope that spreads by sqrt(12) s over the sequence.
    """
    place = np.linspace(-0.5, 0.5, values.size)
    change = float(place @ values / (place @ place))
    return change, float(np.sqrt(12.0) * mean_with_error(values - change * place)[1])


def repeats_after(states: Array, tolerance: float) -> int:
    """Return the number of periods after which a motion repeats itself, 0 if it does not.

    Args:
        states: one a period, shape (period, quantity); the second half is compared.
        tolerance: of the largest difference, in the unit of the states.
    """
    late = states[len(states) // 2 :]
    for count in range(1, min(MOST_PERIODS, len(late) - 1) + 1):
        if np.all(np.abs(late[count:] - late[:-count]) <= tolerance):
            return count
    return 0


def cycle_of(states: Array, tolerance: float) -> int:
    """Return the number of periods in a cycle of a motion, which may drift; 1 where none is seen.

    What drifts is the farther from itself the more periods lie between, so that a cycle is seen where the
    states are much more alike after several periods than after one. Arguments as of `repeats_after`.
    """
    if count := repeats_after(states, tolerance):
        return count
    late = states[len(states) // 2 :]
    most = min(MOST_PERIODS, len(late) - 1)
    moved = [float(np.abs(late[count:] - late[:-count]).max()) for count in range(1, most + 1)]
    return next((count for count, each in enumerate(moved, 1) if each <= ALIKE * moved[0]), 1)


def chaos_indicator(values: Array) -> float:
    """Return the 0-1 test for chaos: near 0 for regular, near 1 for chaotic motion.

    The sum of values times cos(c n) and sin(c n) walks at random where the motion is chaotic, and stays
    bounded where it is regular; K is the correlation of its mean square displacement with time.

    Args:
        values: one a period of a motion that has settled, shape (period,), some hundred or more.

    Source: Gottwald and Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129, with the damping of sec. 3.
    """
    # What stands still walks nowhere.
    if np.ptp(values) == 0.0:
        return 0.0
    steps = np.arange(1, values.size + 1)
    lags = np.arange(1, values.size // 10 + 1)
    mean_square = values.mean() ** 2
    result = []
    for c in np.random.default_rng(0).uniform(np.pi / 5.0, 4.0 * np.pi / 5.0, ANGLES):
        p, q = np.cumsum(values * np.cos(c * steps)), np.cumsum(values * np.sin(c * steps))
        count = values.size - lags[-1]
        moved = np.array(
            [np.mean((p[n : n + count] - p[:count]) ** 2 + (q[n : n + count] - q[:count]) ** 2) for n in lags]
        )
        # Remove the term that oscillates in any motion.
        moved -= mean_square * (1.0 - np.cos(c * lags)) / (1.0 - np.cos(c))
        result.append(np.corrcoef(lags, moved)[0, 1])
    return float(np.median(result))


def kind_without_period(states: Array) -> str:
    """Return the kind of a motion without a period: QUASI_PERIODIC, CHAOTIC, or APERIODIC if unknown.

    Args:
        states: one a period, of comparable quantities, shape (period, quantity); that which moves most is
            tested, as a motor may hold any of the others.
    """
    if len(states) < LEAST_TESTED:
        return APERIODIC
    indicator = chaos_indicator(states[:, states.std(axis=0).argmax()])
    if indicator < MOST_REGULAR:
        return QUASI_PERIODIC
    return CHAOTIC if indicator > LEAST_CHAOTIC else APERIODIC


@final
@dataclass(frozen=True)
class Approach:
    """Exponential approach to a limit.

    Args:
        limit, error: of the sequence, to 95 %; the error is infinite where the limit is not determined.
        distance: of the curve at the end from the limit.
        drift: change of the curve from one value to the next at the end.
    """

    limit: float
    error: float
    distance: float
    drift: float

    @property
    def now(self) -> float:
        """Value of the curve at the end."""
        return self.limit + self.distance


def approach(values: Array) -> Approach:
    """Extrapolate a sequence of at least `LEAST_VALUES` values to its limit.

    Near a steady state everything approaches it exponentially, by the slowest multiplier:

        x_k = limit + distance exp(-rate (k - n) / m),    k = n - m ... n

    with m values in the window that ends at the last, n. The error is the root of the sum of three squares:

    scatter     range of the limits of all rates that fit as well at 95 %, with the number of independent
                values from the autocorrelation of the residuals;
    window      limit of the last half less that of the last quarter, as the rate may still change;
    curvature   distance^2 / (2 swing), the error of Newton's step on f(x) = dx/dk, f''/(2 f') distance^2,
                if f' changes by its own size over the swing, the change of x since the start.

    For 178 motors with drawn laws, drives, clearances, frictions, inertias and loads, cut after 32 to 512
    periods, the error covered the mean of the long run in 96 % of the 1683 cases in which it was at most
    half of the velocity, and in 99.5 % of the 661 that are called settled.

    Source: Seber and Wild, Nonlinear Regression (2003), sec. 5.3 (limits of the profile), 6.2 (correlation).
    """
    count = values.size
    half, quarter = _fit(values[count // 2 :]), _fit(values[count - count // 4 :])
    swing = float(np.abs(values - half.now).max())
    curvature = 0.5 * half.distance**2 / swing if swing > 0.0 else 0.0
    round_off = ROUND_OFF * float(np.abs(values).max())
    error = hypot(half.error, half.limit - quarter.limit, curvature) + round_off
    return Approach(half.limit, error, half.distance, half.drift)


def _fit(window: Array) -> Approach:
    """Fit one exponential by least squares; its error is that of the scatter alone."""
    length = -(-window.size // BLOCKS)
    count = window.size // length
    y = window[window.size - count * length :].reshape(count, length).mean(axis=1)
    x = np.arange(1 - count, 1) / count
    rates = np.geomspace(SLOWEST, min(FASTEST, 0.5 * count), RATES)
    curves = np.exp(-np.outer(rates, x))
    middle = curves.mean(axis=1)
    curves -= middle[:, np.newaxis]
    spread = (curves**2).sum(axis=1)
    distance = curves @ (y - y.mean()) / spread
    limit = y.mean() - distance * middle
    residuals = y - y.mean() - distance[:, np.newaxis] * curves
    squares = (residuals**2).sum(axis=1)
    best = int(squares.argmin())
    left = residuals[best]
    correlation = float(left[1:] @ left[:-1] / squares[best]) if squares[best] > 0.0 else 0.0
    correlation = min(max(correlation, 0.0), MOST_CORRELATED)
    independent = max(count * (1.0 - correlation) / (1.0 + correlation), FEWEST_INDEPENDENT)
    freedom = max(independent - 3.0, 1.0)
    quantile = float(scipy.special.stdtrit(freedom, 0.975))
    variance = squares / freedom
    of_limit = quantile * np.sqrt(variance / count * (1.0 + count * middle**2 / spread))
    of_distance = quantile * float(np.sqrt(variance[best] / spread[best]))
    fits = squares <= squares[best] * (1.0 + quantile**2 / freedom)
    moves = abs(distance[best]) > SIGNIFICANT * of_distance
    if not moves:
        fits &= rates >= min(STILL, rates[best])
    error = float(np.abs(limit - limit[best] + np.array([[-1.0], [1.0]]) * of_limit)[:, fits].max())
    if fits[0] and moves:
        # Slower rates than any that was tried would fit as well.
        error = inf
    slope = -float(distance[best] * rates[best]) / (count * length)
    return Approach(float(limit[best]), error, float(distance[best]), slope)
