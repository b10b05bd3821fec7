"""Holm's procedure: its worked example, its bound on false rejections, and what it must leave alone."""

import numpy as np
import pytest

from contactlab.studies.compare.multiple import holm


def test_three_p_values_by_hand() -> None:
    # 3 x 0.01, then 2 x 0.03, then 0.04, which may not be below the one before it.
    assert holm([0.04, 0.01, 0.03]) == pytest.approx([0.06, 0.03, 0.06])


def test_the_closed_tests_of_bonferroni_agree() -> None:
    """Holm's p-value is the largest of Bonferroni's over all sets of hypotheses with it."""
    values = np.random.default_rng(1).uniform(size=6) ** 3
    sets = [np.array([bool(number >> k & 1) for k in range(6)]) for number in range(1, 64)]
    closed = [max(min(s.sum() * values[s].min(), 1.0) for s in sets if s[k]) for k in range(6)]
    assert holm(values) == pytest.approx(closed)


def test_true_hypotheses_are_rarely_rejected_however_they_depend() -> None:
    rng = np.random.default_rng(2)
    shared = rng.standard_normal((4000, 1)) + 0.5 * rng.standard_normal((4000, 20))
    from scipy.stats import norm

    p_values = norm.sf(shared / np.sqrt(1.25))
    rejected = np.mean([holm(row).min() <= 0.05 for row in p_values])
    assert rejected <= 0.05 + 3.0 * np.sqrt(0.05 * 0.95 / 4000)


def test_missing_tests_and_shapes_stay() -> None:
    square = np.array([[np.nan, 0.01], [0.02, np.nan]])
    assert holm(square) == pytest.approx(np.array([[np.nan, 0.02], [0.02, np.nan]]), nan_ok=True)
    assert holm([]).size == 0


@pytest.mark.parametrize("bad", [[-0.1, 0.5], [0.5, 1.1]])
def test_what_is_no_probability_is_refused(bad: list[float]) -> None:
    with pytest.raises(ValueError, match="p_values"):
        holm(bad)
