"""Claims on the paired comparison: closed forms of its intervals, error rates, and measurements."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.stats import binom

from contactlab.inference.paired import (
    AGREED,
    EQUAL,
    GREATER,
    INCONCLUSIVE,
    LESS,
    VARIES,
    classes,
    log_bayes_factors,
    looks_up_to,
    orders,
)


def test_draws_of_one_sign_have_the_exact_interval_and_the_test_of_the_binomial() -> None:
    """Clopper and Pearson: the lower end p of n of n solves p^n = 0.025."""
    outcome = orders(np.ones((1, 16)))
    assert outcome.share.tolist() == [[1.0, 0.0, 0.0]]
    assert outcome.low[0, 0] == pytest.approx(0.025 ** (1 / 16))
    assert outcome.high[0].tolist() == pytest.approx([1.0, *[1.0 - 0.025 ** (1 / 16)] * 2])
    assert outcome.p_value[0] == pytest.approx(AGREED**16)
    assert outcome.verdict[0] == GREATER
    assert orders(-np.ones((1, 16))).verdict[0] == LESS
    assert orders(np.zeros((1, 16))).verdict[0] == EQUAL
    # Of two looks each has half of the 5 %.
    assert orders(np.ones((1, 16)), looks=2).verdict[0] == INCONCLUSIVE


@given(st.integers(1, 64), st.integers(0, 64))
def test_the_verdict_is_that_of_the_counts_and_no_steady_state_is_no_draw(count: int, lost: int) -> None:
    signs = np.concatenate([np.ones(count), np.full(lost, np.nan)])[None]
    outcome = orders(signs)
    assert outcome.p_value[0] == pytest.approx(AGREED**count)
    assert (outcome.verdict[0] == GREATER) == (AGREED**count <= 0.05)


def test_nothing_is_claimed_of_a_pair_without_draws() -> None:
    outcome = orders(np.full((2, 1, 8), np.nan))
    assert (outcome.verdict == INCONCLUSIVE).all()
    assert np.isnan(outcome.share).all()


def test_a_pair_without_draws_is_no_test_among_the_others() -> None:
    signs = np.array([np.ones(16), np.full(16, np.nan)])[:, None]
    assert orders(signs).p_value[0] == orders(signs[:1]).p_value[0]


def test_an_order_that_half_of_the_motors_has_varies() -> None:
    signs = np.where(np.arange(64) % 2, 1.0, -1.0)[None]
    assert orders(signs).verdict[0] == VARIES
    assert orders(signs[:, :4]).verdict[0] == INCONCLUSIVE


@pytest.mark.parametrize("probability", [0.5, AGREED, 0.95, 1.0])
def test_claims_on_many_pairs_are_wrong_in_at_most_a_twentieth_of_all_comparisons(probability: float) -> None:
    """Twelve laws with independent pairs at the bound of the claim, three looks."""
    rng = np.random.default_rng(1)
    looks, wrong, decided = looks_up_to(64), 0, 0
    for _ in range(300):
        signs = np.where(rng.random((20, 1, 64)) < probability, 1.0, -1.0)
        claimed = np.full(20, INCONCLUSIVE)
        for look in looks:
            verdict = orders(signs[..., :look], len(looks)).verdict[:, 0]
            claimed = np.where(claimed == INCONCLUSIVE, verdict, claimed)
        false = claimed == VARIES if probability > AGREED else claimed < VARIES
        wrong += bool(false.any())
        decided += int((claimed != INCONCLUSIVE).sum())
    assert wrong <= binom.ppf(0.999, 300, 0.05)
    if probability == 1.0:
        assert decided == 300 * 20


def test_looks_double_up_to_the_budget() -> None:
    assert looks_up_to(64) == [16, 32, 64]
    assert looks_up_to(8) == [8]


def test_laws_of_a_class_are_all_equal_to_each_other() -> None:
    """a = b and b = c, but not a = c: equality of pairs is not transitive."""
    equal = np.eye(4, dtype=bool)
    equal[0, 1] = equal[1, 0] = equal[1, 2] = equal[2, 1] = True
    groups = classes(equal)
    assert groups[0] != groups[2]
    assert len(set(groups)) == 3
    assert classes(np.ones((3, 3), bool)).tolist() == [1, 1, 1]


@settings(max_examples=20)
@given(st.floats(0.5, 2.0), st.floats(0.3, 2.0))
def test_the_log_bayes_factor_of_two_normal_laws_is_that_of_the_closed_form(
    apart: float, error: float
) -> None:
    """d^2 / (2 s^2) of normal laws, s^2 = 1 + error^2 and the square of the kernel's width."""
    from scipy.stats import norm

    draws = norm.ppf((np.arange(400) + 0.5) / 400)
    (factors,) = log_bayes_factors(np.array([draws, draws + apart]), [error])
    width = 1.0 + error**2 + (400**-0.2) ** 2
    expected = 0.5 * apart**2 / width
    assert factors[0, 1] == pytest.approx(expected, rel=0.1, abs=0.02)
    assert np.isnan(factors[0, 0])


def test_equal_laws_are_told_apart_by_no_measurement() -> None:
    rng = np.random.default_rng(0)
    draws = rng.normal(size=200)
    (factors,) = log_bayes_factors(np.array([draws, draws]), [0.1])
    # The draw itself is left out of the density of its own law alone.
    assert factors[0, 1] < 0.0
