"""Claims on the map of contrasts over groups, in worlds whose truth is known."""

from math import inf, nan

import numpy as np
import pytest
from contrast_map import BAR, LARGEST, SMALLEST, mapped

from contactlab.arrays import Array


def world(signal: float, noise: float, seed: int, motors: int = 256) -> tuple[Array, Array]:
    """Return 13 groups, and sizes that two of them decide, one of them over decades."""
    rng = np.random.default_rng(seed)
    groups = rng.random((motors, 13))
    groups[:, 0] = 10.0 ** (4.0 * groups[:, 0] - 2.0)
    shape = np.tanh(np.log10(groups[:, 0])) + np.sin(3.0 * groups[:, 1])
    shape /= shape.std()
    return groups, np.exp(-3.0 + signal * shape + noise * rng.standard_normal(motors))


@pytest.mark.parametrize("seed", range(4))
def test_the_share_that_the_groups_decide_is_found(seed: int) -> None:
    """R^2 at most 0.8, as a fifth of the variance is no group's."""
    judged = mapped(*world(0.8, 0.4, seed), fitted=192)
    assert judged.motors == 64
    assert BAR < judged.low < judged.r2 < judged.high < 1.0
    assert 0.6 < judged.r2 < 0.9
    assert 0.8 < judged.coverage <= 1.0


def test_where_no_group_decides_none_is_found() -> None:
    """At most one of 40 worlds of noise has a lower end above the bar, and predictions keep their width."""
    judged = [mapped(*world(0.0, 0.8, seed), fitted=192) for seed in range(40)]
    assert sum(each.low > BAR for each in judged) <= 1
    assert np.mean([each.coverage for each in judged]) == pytest.approx(0.9, abs=0.03)


def test_motors_that_turn_count_as_the_largest_and_those_without_a_contrast_do_not() -> None:
    groups, size = world(0.8, 0.2, 0)
    bounds, turned, missing = size.copy(), size.copy(), size.copy()
    bounds[[3, 5, 200]] = LARGEST, SMALLEST, LARGEST
    turned[[3, 5, 200]] = inf, 0.0, inf
    missing[[3, 200]] = nan
    assert mapped(groups, turned, 192) == mapped(groups, bounds, 192)
    assert mapped(groups, missing, 192).motors == 63
