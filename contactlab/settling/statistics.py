"""Means over long runs with their statistical error, and what kind of motion a sequence shows."""

from typing import Final

import numpy as np
from scipy.special import stdtrit

from contactlab.arrays import Array
from contactlab.estimate import Estimate

WINDOW: Final = 2.5
"""Times the sum of the correlations over which they are summed, five times their memory."""

MOST_ALIKE: Final = 0.9
"""Share of a sequence that is alike, beyond which its variance is not told any more."""

CONFIDENCE: Final = 0.95

MOST_PERIODS: Final = 16
"""Periods of the drive after which a motion is asked whether it repeats itself."""

ANGLES: Final = 100
"""Frequencies of the 0-1 test, whose median decides."""


REPEATS: Final = 1e-3
"""Relative difference of states at which a motion is taken for one that repeats itself."""

REGULAR: Final = 0.2
CHAOTIC: Final = 0.8
"""Values of the 0-1 test that tell them apart; between them is no telling."""

LEAST_TESTED: Final = 200
"""Values of the 0-1 test: a tenth of them are the lags of a random walk, and fewer than twenty show none."""


def mean_with_error(values: Array) -> Estimate:
    """Return the mean of a stationary sequence and half the width of its 95 % interval.

    Values that follow each other are alike for some time; as many count as one as their correlations sum
    up to, 1 + 2 sum rho_k, over a window that follows from that sum. The mean that is taken off lowers
    variance and sum, which is put right; the window says how well the sum is known.

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
    looked = (2.0 * last + 1.0) / count
    # What swings about its mean is taken for independent, which is to the safe side.
    alike = max(float(sums[last]), 1.0) * (1.0 + looked) / count
    spread = np.sqrt(variance * alike / (1.0 - min(alike, MOST_ALIKE)))
    return Estimate(mean, float(stdtrit(max(1.0 / looked, 1.0), 0.5 + 0.5 * CONFIDENCE) * spread))


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
        states: one a period, shape (period, quantity); the second half is looked at.
        tolerance: of the largest difference, in the unit of the states.
    """
    late = states[len(states) // 2 :]
    for count in range(1, min(MOST_PERIODS, len(late) - 1) + 1):
        if np.all(np.abs(late[count:] - late[:-count]) <= tolerance):
            return count
    return 0


def chaos_indicator(values: Array, seed: int = 0) -> float:
    """Tell regular motion (near 0) from chaotic motion (near 1) by the 0-1 test.

    The sum of values times cos(c n) and sin(c n) walks at random where the motion is chaotic, and stays
    bounded where it is regular; K is the correlation of its mean square displacement with time.

    Args:
        values: one a period of a motion that has settled, shape (period,), some hundred or more.
        seed: of the frequencies c.

    Source: Gottwald and Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129, with the damping of sec. 3.
    """
    steps = np.arange(1, values.size + 1)
    lags = np.arange(1, values.size // 10 + 1)
    mean_square = values.mean() ** 2
    result = []
    for c in np.random.default_rng(seed).uniform(np.pi / 5.0, 4.0 * np.pi / 5.0, ANGLES):
        p, q = np.cumsum(values * np.cos(c * steps)), np.cumsum(values * np.sin(c * steps))
        count = values.size - lags[-1]
        moved = np.array(
            [np.mean((p[n : n + count] - p[:count]) ** 2 + (q[n : n + count] - q[:count]) ** 2) for n in lags]
        )
        # Without what oscillates in any motion.
        moved -= mean_square * (1.0 - np.cos(c * lags)) / (1.0 - np.cos(c))
        result.append(np.corrcoef(lags, moved)[0, 1])
    return float(np.median(result))


def kind_without_period(values: Array) -> str:
    """Return the kind of a settled motion without a period; 'irregular' where it is not known."""
    if values.size < LEAST_TESTED:
        return "irregular"
    indicator = chaos_indicator(values)
    return "quasi-periodic" if indicator < REGULAR else "chaotic" if indicator > CHAOTIC else "irregular"
