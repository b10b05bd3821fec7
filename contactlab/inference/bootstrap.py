"""Bootstrap intervals of means over impacts, of many laws by the same resamples.

The impacts are drawn anew with replacement, B times. One draw serves all laws, so that the interval of a
difference between two of them is that of pairs: what an impact does to both alike is not in it.

Source: Efron (1987), J. Am. Stat. Assoc. 82, 171, for the bias-corrected and accelerated percentiles; the
jackknife of a mean, from which the acceleration follows, is in closed form.
"""

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from scipy.special import ndtr, ndtri

from contactlab.arrays import Array

RESAMPLES: Final = 4000
LEVEL: Final = 0.95
"""Of the intervals."""

_BATCH: Final = 200
"""Resamples that are drawn at a time."""


@final
@dataclass(frozen=True, eq=False)
class Resampled:
    """Means of columns over rows, and over resampled rows.

    Args:
        values: shape (row, column).
        means: of the resamples, shape (resample, column).
    """

    values: Array
    means: Array

    def mean(self) -> Array:
        """Give the means, shape (column,)."""
        return np.asarray(self.values.mean(axis=0))

    def interval(self, column: int, level: float = LEVEL) -> tuple[float, float]:
        """Give the interval of the mean of one column."""
        return interval(self.values[:, column], self.means[:, column], level)

    def difference(self, one: int, other: int, level: float = LEVEL) -> tuple[float, float, float]:
        """Give the mean of one column less that of another, and its interval by pairs of rows."""
        apart = self.values[:, one] - self.values[:, other]
        ends = interval(apart, self.means[:, one] - self.means[:, other], level)
        return float(apart.mean()), *ends


def resampled(values: Array, seed: int, resamples: int = RESAMPLES) -> Resampled:
    """Draw the rows of a table anew, so many times; the same seed gives the same bits.

    Args:
        values: a column for each law, shape (row, column).
        seed: of the draw.
        resamples: how often.
    """
    rng, rows = np.random.default_rng(seed), len(values)
    means = np.empty((resamples, values.shape[1]))
    for first in range(0, resamples, _BATCH):
        last = min(first + _BATCH, resamples)
        drawn = rng.integers(rows, size=(last - first, rows))
        counts = np.array([np.bincount(one, minlength=rows) for one in drawn], dtype=np.float64)
        means[first:last] = counts @ values / rows
    return Resampled(values, means)


def interval(values: Array, means: Array, level: float = LEVEL) -> tuple[float, float]:
    """Give the bias-corrected and accelerated interval of a mean.

    Args:
        values: of the rows, shape (row,).
        means: of resamples of them, shape (resample,).
        level: of the interval.
    """
    off = values - values.mean()
    square = float(np.sum(off**2))
    # Rows that are all alike have no interval but their mean, and round-off is no spread.
    if square <= (1e-14 * float(np.abs(values).max(initial=0.0))) ** 2 * len(values):
        return float(values.mean()), float(values.mean())
    # Half of the ties lie below.
    below = float(np.mean(means < values.mean()) + 0.5 * np.mean(means == values.mean()))
    bias = float(ndtri(np.clip(below, 1.0 / len(means), 1.0 - 1.0 / len(means))))
    # The mean without row i is (n m - x_i)/(n - 1): its deviations are those of the rows turned round.
    acceleration = float(np.sum(off**3)) / (6.0 * square**1.5)
    shifted = bias + ndtri([0.5 * (1.0 - level), 0.5 * (1.0 + level)])
    low, high = np.quantile(means, ndtr(bias + shifted / (1.0 - acceleration * shifted)))
    return float(low), float(high)
