"""Bootstrap intervals of means over rows, for example of the errors of many laws over impacts.

Rows, or blocks of rows that depend on each other, are resampled with replacement. One draw serves all
columns, so that the interval of the difference of two columns is that of paired rows. Intervals are
bias-corrected and accelerated (Efron 1987, J. Am. Stat. Assoc. 82, 171), by `scipy.stats.bootstrap`.
"""

from typing import Final, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array

RESAMPLES: Final = 4000
LEVEL: Final = 0.95
"""Confidence level."""

_BATCH: Final = 200
"""Resamples that are drawn at once."""


@final
class MeanIntervals(NamedTuple):
    """Means of columns, shape (column,), intervals, shape (column, 2), and means of the resamples."""

    mean: Array
    interval: Array
    resampled: Array

    @property
    def half(self) -> Array:
        """Half-widths of the intervals, shape (column,)."""
        return np.asarray(0.5 * (self.interval[:, 1] - self.interval[:, 0]))


def mean_intervals(
    values: Array, seed: int, resamples: int = RESAMPLES, blocks: NDArray[np.int64] | None = None
) -> MeanIntervals:
    """Return the means of columns with their intervals; the same seed gives the same bits.

    Args:
        values: shape (row, column).
        seed: of the resamples, which are the same for every table with as many rows.
        resamples: how many.
        blocks: number from 0 of the block that each row belongs to, shape (row,); None has a block for each.
    """
    # Imported here: a run needs no scipy.stats.
    from scipy.stats import bootstrap

    rows = len(values)
    mean = np.asarray(values.mean(axis=0))
    # Equal rows have no spread, and round-off is none.
    size = 1e-14 * np.abs(values).max(axis=0, initial=0.0)
    varying = np.sum((values - mean) ** 2, axis=0) > size**2 * rows
    interval, resampled = np.column_stack([mean, mean]), np.tile(mean[:, None], resamples)
    if varying.any():
        labels = np.arange(rows) if blocks is None else blocks
        sizes = np.bincount(labels).astype(np.float64)
        columns = np.zeros((sizes.size, int(varying.sum())))
        np.add.at(columns, labels, values[:, varying])

        def means(drawn: Array, axis: int = -1) -> Array:
            del axis
            each = drawn.reshape(-1, drawn.shape[-1])
            counts = np.array([np.bincount(row, minlength=sizes.size) for row in each], dtype=np.float64)
            result = counts @ columns / (counts @ sizes)[:, None]
            return np.moveaxis(result.reshape(*drawn.shape[:-1], columns.shape[1]), -1, 0)

        result = bootstrap(
            (np.arange(sizes.size),),
            means,
            n_resamples=resamples,
            batch=_BATCH,
            vectorized=True,
            confidence_level=LEVEL,
            rng=np.random.default_rng(seed),
        )
        interval[varying] = np.column_stack([result.confidence_interval.low, result.confidence_interval.high])
        resampled[varying] = result.bootstrap_distribution
    return MeanIntervals(mean, interval, resampled)


def paired_differences(
    values: Array, seed: int, blocks: NDArray[np.int64] | None = None
) -> tuple[Array, Array]:
    """Return mean differences of columns, row less column, and their intervals by pairs of rows.

    Returns:
        Differences, shape (column, column), and intervals, shape (column, column, 2).
    """
    count = values.shape[1]
    first, second = np.triu_indices(count, 1)
    apart, interval = np.zeros((count, count)), np.zeros((count, count, 2))
    if first.size:
        result = mean_intervals(values[:, first] - values[:, second], seed, blocks=blocks)
        apart[first, second], apart[second, first] = result.mean, -result.mean
        interval[first, second], interval[second, first] = result.interval, -result.interval[:, ::-1]
    return apart, interval
