"""Claims on the paired comparison: closed forms of its intervals, error rates, power, shares of factors."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.stats import binom

from contactlab.inference.paired import (
    AGREED,
    BINS,
    EQUAL,
    GREATER,
    INCONCLUSIVE,
    LESS,
    NONE,
    OUTCOMES,
    UNTESTED,
    VARIES,
    factor_shares,
    looks_up_to,
    orders,
)


def verdict_of_equal_draws(outcome: int, count: int = 32) -> int:
    return int(orders(np.full((1, count), outcome)).verdict[0])


def test_draws_verdict_of_equal_draws_have_the_exact_interval_and_the_test_of_the_binomial() -> None:
    """Clopper and Pearson: the lower end p of n of n solves p^n = 0.025. Two claims: an order, and none."""
    result = orders(np.full((1, 32), GREATER))
    assert result.share.tolist() == [[1.0, 0.0, 0.0, 0.0]]
    assert result.low[0, 0] == pytest.approx(0.025 ** (1 / 32))
    assert result.high[0].tolist() == pytest.approx([1.0, *[1.0 - 0.025 ** (1 / 32)] * 3])
    assert result.p_value[0] == pytest.approx(2.0 * AGREED**32)
    for outcome in (GREATER, LESS, EQUAL, NONE):
        assert verdict_of_equal_draws(outcome) == outcome
    # 2 x 0.8^18 = 0.036 is below 5 %, and above its half.
    assert verdict_of_equal_draws(GREATER, 18) == GREATER
    assert orders(np.full((1, 18), GREATER), looks=2).verdict[0] == INCONCLUSIVE


@given(st.integers(20, 64), st.integers(0, 64))
def test_a_motor_without_a_steady_state_counts_against_an_order(count: int, without: int) -> None:
    result = orders(np.repeat([GREATER, NONE], [count, without])[None])
    few_enough = 2.0 * binom.sf(count - 1, count + without, AGREED) <= 0.05
    assert (result.verdict[0] == GREATER) == few_enough
    assert result.share[0, GREATER] == pytest.approx(count / (count + without))


def test_a_quantity_that_is_none_is_no_test_among_the_others() -> None:
    outcomes = np.array([np.full(32, GREATER), np.full(32, UNTESTED)])
    result = orders(outcomes)
    assert result.p_value[0] == orders(outcomes[:1]).p_value[0]
    assert result.verdict[1] == INCONCLUSIVE


def test_an_order_that_half_of_the_motors_has_varies() -> None:
    outcomes = np.where(np.arange(64) % 2, GREATER, LESS)[None]
    assert orders(outcomes).verdict[0] == VARIES
    assert orders(outcomes[:, :4]).verdict[0] == INCONCLUSIVE


WORLDS = {
    "at the bound of an order": (AGREED, 1.0 - AGREED, 0.0, 0.0),
    # Nine tenths of the motors in which the first law is not greater have no steady state.
    "gaps that hide the other sign": (0.6, 0.04, 0.0, 0.36),
    "most motors without a steady state": (0.25, 0.0, 0.0, 0.75),
    "no order": (0.4, 0.3, 0.2, 0.1),
    "one order": (0.95, 0.05, 0.0, 0.0),
    "always": (1.0, 0.0, 0.0, 0.0),
}
"""Probabilities of the outcomes in worlds of known truth."""

REPETITIONS, PAIRS = 200, 10


@pytest.mark.parametrize("world", WORLDS)
def test_claims_are_wrong_in_at_most_a_twentieth_of_all_comparisons(world: str) -> None:
    """Five laws, independent pairs, one kind of world, looks after 16, 32 and 64 draws."""
    rng, truth = np.random.default_rng(1), np.array(WORLDS[world])
    looks, wrong, decided = looks_up_to(64), 0, 0
    for _ in range(REPETITIONS):
        outcomes = rng.choice(len(OUTCOMES), (PAIRS, 64), p=truth)
        claimed = np.full(PAIRS, INCONCLUSIVE)
        for look in looks:
            verdict = orders(outcomes[:, :look], len(looks)).verdict
            claimed = np.where(claimed == INCONCLUSIVE, verdict, claimed)
        has_order = np.append(truth > AGREED, [True, True])
        false = claimed == VARIES if truth.max() > AGREED else ~has_order[claimed]
        wrong += bool(false.any())
        decided += int((claimed != INCONCLUSIVE).sum())
    assert wrong <= binom.ppf(0.999, REPETITIONS, 0.05)
    # Power: how many of the pairs get the verdict that is right.
    least = {"always": 1.0, "one order": 0.5, "no order": 0.99, "gaps that hide the other sign": 0.5}
    assert decided >= least.get(world, 0.0) * REPETITIONS * PAIRS


def test_looks_double_up_to_the_budget() -> None:
    assert looks_up_to(64) == [16, 32, 64]
    assert looks_up_to(8) == [8]


def test_the_share_of_a_step_is_that_of_the_closed_form() -> None:
    """The event is A < 1/2, or B < q: p = (1 + q) / 2 and S_A = (1 - q)^2 / 4 / (p (1 - p))."""
    rng = np.random.default_rng(2)
    draws, q = rng.random((4096, 3)), 0.3
    hits = (draws[:, 0] < 0.5) | (draws[:, 1] < q)
    p = 0.5 * (1.0 + q)
    shares, chance = factor_shares(hits, draws)
    assert shares[0] == pytest.approx((1.0 - q) ** 2 / 4.0 / (p * (1.0 - p)), abs=0.04)
    assert abs(shares[2]) < chance < 0.01
    # A third outcome in one half of the range has its own part: Var(P) over the sum of three variances.
    three = np.where(draws[:, 0] < 0.5, 2, draws[:, 1] < 0.5)
    assert factor_shares(three, draws)[0][0] == pytest.approx(0.375 / 0.625, abs=0.03)


def test_noise_has_a_share_beyond_chance_in_a_twentieth_of_all_comparisons() -> None:
    """Eight factors that decide nothing: the largest share is corrected for their number and for its bias."""
    rng = np.random.default_rng(3)
    draws = rng.random((64, 8))
    shares, chance = factor_shares(rng.random((400, 64)) < 0.7, draws)
    assert (shares.max(axis=-1) > chance).sum() <= binom.ppf(0.999, 400, 0.05)
    assert abs(shares.mean()) < 0.01
    # An event that a quarter of the range decides is seen in nearly all of them.
    hits = (draws[:, 0] > 0.25) | (rng.random((400, 64)) < 0.2)
    shares, chance = factor_shares(hits, draws)
    assert (shares.argmax(axis=-1)[shares.max(axis=-1) > chance] == 0).mean() > 0.99
    assert (shares[:, 0] > chance).mean() > 0.99
    assert np.isnan(factor_shares(np.ones((1, 64), bool), draws)[0]).all()
    assert np.isnan(factor_shares(np.ones((1, 2 * BINS - 1), bool), draws[: 2 * BINS - 1])[1]).all()
