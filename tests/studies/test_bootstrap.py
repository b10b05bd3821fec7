"""Claims on bootstrap intervals of means and of paired differences."""

import numpy as np
import pytest

from contactlab.studies.compare.bootstrap import mean_intervals, paired_differences


def test_the_interval_of_a_difference_is_that_of_pairs():
    rng = np.random.default_rng(0)
    shared, apart = rng.normal(size=400), rng.normal(0.02, 0.05, size=400)
    differences, intervals = paired_differences(np.column_stack([shared, shared + apart]), seed=0)
    mean, (low, high) = differences[1, 0], intervals[1, 0]
    spread = apart.std() / np.sqrt(400.0)

    assert mean == pytest.approx(apart.mean())
    # What both share has a spread of 1/sqrt(400), twenty times that.
    assert (low, high) == pytest.approx((mean - 1.96 * spread, mean + 1.96 * spread), abs=0.15 * spread)
    assert (-intervals[0, 1, ::-1]).tolist() == intervals[1, 0].tolist()
    assert intervals[0, 0].tolist() == [0.0, 0.0]


def test_the_same_seed_resamples_the_same_bits_and_equal_rows_have_no_interval():
    values = np.random.default_rng(1).random((50, 2))
    values[:, 1] = 0.3
    first, second = (mean_intervals(values, 3, resamples=300) for _ in range(2))

    assert first.resampled.tobytes() == second.resampled.tobytes()
    assert first.interval[1] == pytest.approx([0.3, 0.3], rel=1e-14)


def test_rows_that_depend_on_each_other_are_resampled_together():
    """Copies of a row carry no more than the row: its interval is that of the rows without copies."""
    rows = np.random.default_rng(2).normal(size=(200, 1))
    alone = mean_intervals(rows, seed=0)
    copied = mean_intervals(np.repeat(rows, 4, axis=0), seed=0, blocks=np.repeat(np.arange(200), 4))
    without = mean_intervals(np.repeat(rows, 4, axis=0), seed=0)

    assert copied.interval == pytest.approx(alone.interval)
    assert without.half == pytest.approx(0.5 * alone.half, rel=0.1)
