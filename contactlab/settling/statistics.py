"""Means over long runs with their statistical error, and what kind of motion a sequence shows."""

from typing import Final

import numpy as np
from scipy.special import stdtrit

from contactlab.arrays import Array

BATCHES: Final = 16
"""Of consecutive values; their means are all but independent where each outlasts the memory of the motion."""

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


def mean_with_error(values: Array) -> tuple[float, float]:
    """Give the mean of a stationary sequence and half the width of its 95 % interval, by batch means.

    Source: Law, Simulation Modeling and Analysis (2015), sec. 9.5.3.
    """
    batches = values[values.size % BATCHES :].reshape(BATCHES, -1).mean(axis=1)
    width = stdtrit(BATCHES - 1, 0.5 + 0.5 * CONFIDENCE) * batches.std(ddof=1) / np.sqrt(BATCHES)
    return float(batches.mean()), float(width)


def repeats_after(states: Array, tolerance: float) -> int:
    """Give the number of periods after which a motion repeats itself, 0 if it does not.

    Args:
        states: one a period, scaled alike, shape (period, quantity); the second half is looked at.
        tolerance: of the largest difference, in parts of the largest value.
    """
    late = states[len(states) // 2 :]
    scale = np.abs(late).max(axis=0)
    scale[scale == 0.0] = 1.0
    for count in range(1, min(MOST_PERIODS, len(late) - 1) + 1):
        if np.all(np.abs(late[count:] - late[:-count]) <= tolerance * scale):
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
    found = []
    for c in np.random.default_rng(seed).uniform(np.pi / 5.0, 4.0 * np.pi / 5.0, ANGLES):
        p, q = np.cumsum(values * np.cos(c * steps)), np.cumsum(values * np.sin(c * steps))
        count = values.size - lags[-1]
        moved = np.array(
            [np.mean((p[n : n + count] - p[:count]) ** 2 + (q[n : n + count] - q[:count]) ** 2) for n in lags]
        )
        # Without what oscillates in any motion.
        moved -= mean_square * (1.0 - np.cos(c * lags)) / (1.0 - np.cos(c))
        found.append(np.corrcoef(lags, moved)[0, 1])
    return float(np.median(found))


def kind_without_period(values: Array) -> str:
    """Tell what a settled motion that does not repeat itself is; 'irregular' where that cannot be told."""
    if values.size < LEAST_TESTED:
        return "irregular"
    indicator = chaos_indicator(values)
    return "quasi-periodic" if indicator < REGULAR else "chaotic" if indicator > CHAOTIC else "irregular"
