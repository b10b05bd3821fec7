"""Claims on the paired comparison: closed forms of its intervals, error rates, power, shares of factors."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.typing import NDArray
from scipy.stats import binom

from contactlab.arrays import Array
from contactlab.studies.compare.factors import START, Factor
from contactlab.studies.compare.hypercube import drawn
from contactlab.studies.compare.paired import (
    AGREED,
    ALONE,
    BINS,
    EQUAL,
    GREATER,
    INCONCLUSIVE,
    LESS,
    NO_ROLE,
    NONE,
    OUTCOMES,
    TOGETHER,
    UNTESTED,
    VARIES,
    factor_shares,
    least_draws,
    looks_up_to,
    orders,
    power,
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
    shares = factor_shares(hits, draws)
    of_first = (1.0 - q) ** 2 / 4.0 / (p * (1.0 - p))
    assert shares.first[0] == pytest.approx(of_first, abs=0.04)
    assert abs(shares.first[2]) < shares.chance < 0.01
    # Of the interaction, q (1 - q) / 4 over the same, halves see the square of a correlation, q / (1 - q).
    seen = 0.25 * q * (1.0 - q) / (p * (1.0 - p)) * q / (1.0 - q)
    assert shares.joint[0, 1] == pytest.approx(seen, abs=0.03)
    # A third outcome in one half of the range has its own part: Var(P) over the sum of three variances.
    three = np.where(draws[:, 0] < 0.5, 2, draws[:, 1] < 0.5)
    assert factor_shares(three, draws).first[0] == pytest.approx(0.375 / 0.625, abs=0.03)


def test_the_total_share_is_the_total_order_index_of_a_product_of_halves() -> None:
    """A or B, each with a probability of 1/2: S_A = 1/3, S_AB = 1/3, and T_A = 2/3."""
    draws = np.random.default_rng(4).random((4096, 3))
    shares = factor_shares((draws[:, 0] < 0.5) | (draws[:, 1] < 0.5), draws)
    assert shares.first == pytest.approx([1 / 3, 1 / 3, 0.0], abs=0.03)
    assert shares.total == pytest.approx([2 / 3, 2 / 3, 0.0], abs=0.04)
    assert shares.joint[0, 1] == shares.joint[1, 0] == pytest.approx(1 / 3, abs=0.03)
    assert (np.diagonal(shares.joint) == 0.0).all()
    # Two that are equally large: neither is named alone.
    assert ALONE not in shares.role


def test_noise_has_a_share_beyond_chance_in_a_twentieth_of_all_comparisons() -> None:
    """Eight factors that decide nothing: the largest share is corrected for their number and for its bias."""
    rng = np.random.default_rng(3)
    draws = rng.random((64, 8))
    named = [(factor_shares(rng.random(64) < 0.7, draws).role != NO_ROLE).any() for _ in range(100)]
    assert sum(named) <= 5
    shares = factor_shares(rng.random((100, 64)) < 0.7, draws)
    assert abs(shares.first.mean()) < 0.015
    # All outcomes are one family.
    assert (shares.first > shares.chance).any(axis=-1).sum() <= 2
    # An event that a quarter of the range decides is seen in nearly all of them.
    hits = (draws[:, 0] > 0.25) | (rng.random((100, 64)) < 0.2)
    role = factor_shares(hits, draws).role
    assert (role[:, 1:] == NO_ROLE).mean() > 0.99
    assert (role[:, 0] == ALONE).mean() > 0.9
    for nothing in (np.ones((1, 64), bool), np.zeros((0, 64), bool)):
        assert np.isnan(factor_shares(nothing, draws).first).all()
    assert np.isnan(factor_shares(np.arange(2 * BINS - 1) > 2, draws[: 2 * BINS - 1]).chance)


FACTORS = (
    *(Factor(f"factor {n}", "uniform", 0.0, 1.0) for n in range(7)),
    Factor(START, "uniform", 0.0, 1.0),
)
"""Seven numbers and the start."""

Deciding = Callable[[Array], NDArray[np.bool_]]
DECIDED: dict[str, tuple[Deciding, set[int]]] = {
    "one by its median": (lambda u: u[:, 0] < 0.5, {0}),
    "one by its quarter": (lambda u: u[:, 0] < 0.25, {0}),
    "one by its tenth": (lambda u: u[:, 0] < 0.1, {0}),
    "the sense of the start": (lambda u: u[:, 7] < 0.5, {7}),
    "exclusive or of two": (lambda u: (u[:, 0] < 0.5) ^ (u[:, 1] < 0.5), {0, 1}),
    "exclusive or with the start": (lambda u: (u[:, 0] < 0.5) ^ (u[:, 7] < 0.5), {0, 7}),
    "a product": (lambda u: u[:, 0] * u[:, 1] < 0.25, {0, 1}),
    "a sum": (lambda u: u[:, 0] + u[:, 1] < 1.0, {0, 1}),
    "nothing drawn": (lambda u: np.random.default_rng(u[0].view(np.uint64)).random(len(u)) < 0.5, set()),
}
"""Worlds of known truth: what decides the outcome, and the factors that have a say in it."""

SEEN = {
    "one by its median": (0.3, 1.0, 1.0),
    "one by its quarter": (0.0, 0.9, 1.0),
    "the sense of the start": (1.0, 1.0, 1.0),
    "exclusive or of two": (0.9, 0.95, 0.95),
    "exclusive or with the start": (0.9, 0.95, 0.95),
}
"""Least share of the designs in which exactly what decides is named, after 16, 32 and 64 draws."""


@pytest.mark.parametrize("world", DECIDED)
@pytest.mark.parametrize("look", [0, pytest.param(1, marks=pytest.mark.long), 2])
def test_a_factor_without_a_say_is_named_in_at_most_a_twentieth_of_all_designs(world: str, look: int) -> None:
    """A hundred designs: neither alone nor with others, whatever decides the outcome."""
    decides, say = DECIDED[world]
    wrong = right = 0
    for seed in range(100):
        draws = drawn(FACTORS, looks_up_to(64)[look], seed)
        role = factor_shares(np.where(decides(draws), GREATER, LESS), draws).role
        named = {*np.flatnonzero(role != NO_ROLE).tolist()}
        wrong += not named <= say
        right += named == say and {*role[[*say]].tolist()} <= {ALONE, TOGETHER}
    assert wrong <= 5
    assert right >= 100.0 * SEEN.get(world, (0.0, 0.0, 0.0))[look]


@pytest.mark.parametrize("count", [16, 32, 64, 128])
def test_starts_of_either_sense_are_equal_in_every_part_of_every_other_factor(count: int) -> None:
    draws = drawn(FACTORS, count)
    assert np.array_equal(draws, drawn(FACTORS, 256)[:count])
    assert not np.array_equal(draws, drawn(FACTORS, count, seed=1))
    # A Latin hypercube up to each look: as many draws in each sixteenth of every factor.
    parts = (draws * 16).astype(int)
    assert all((np.bincount(column) == count // 16).all() for column in parts.T)
    backwards = parts[:, 7] < 8
    for column in parts[:, :7].T:
        assert (np.bincount(column[backwards] // 4) == count // 8).all()


def test_no_quarter_of_a_factor_is_half_of_another_in_more_designs_than_by_chance() -> None:
    """A Sobol' sequence has such pairs in each design: 11 of 56 after 16 draws, one after 64."""
    halves = []
    for seed in range(50):
        draws = drawn(FACTORS, 16, seed)
        lower = draws < 0.5
        quarters = [(draws >= n / 4) & (draws < (n + 1) / 4) for n in range(4)]
        inside = np.stack([quarter.T.astype(int) @ lower for quarter in quarters])
        halves.append(((inside == 0) | (inside == 4)).all(axis=0) & ~np.eye(8, dtype=bool))
    # Of 56 pairs; all four quarters of four draws are in one half or the other by chance in 6 of 12,870.
    assert np.mean(halves) < 0.005


def test_the_power_of_a_single_look_is_that_of_the_binomial() -> None:
    """Sixteen draws of one outcome are too few of ten claims; of 32, all 32, 31 or 30 show it."""
    assert power(16, 10, 0.95) == 0.0
    assert least_draws(2, 1) == 17
    assert 2.0 * AGREED ** least_draws(2, 3) <= 0.05 / 3.0 < 2.0 * AGREED ** (least_draws(2, 3) - 1)
    assert power(least_draws(2, 1) - 1, 2, 1.0) == 0.0


@pytest.mark.parametrize(("pairs", "share"), [(1, 0.95), (10, 0.95), (5, 1.0)])
def test_the_power_by_several_looks_is_that_of_draws(pairs: int, share: float) -> None:
    """The first pair has an order, the others have none that is stated or denied."""
    rng, looks, seen = np.random.default_rng(5), looks_up_to(64), 0
    others = np.where(np.arange(64) % 5 > 0, GREATER, LESS)
    for _ in range(REPETITIONS):
        first = np.where(rng.random(64) < share, GREATER, LESS)
        outcomes = np.stack([first, *[others] * (pairs - 1)])
        seen += any(orders(outcomes[:, :look], len(looks)).verdict[0] == GREATER for look in looks)
    chance = power(64, 2 * pairs, share)
    assert abs(seen - REPETITIONS * chance) <= 3.5 * np.sqrt(REPETITIONS * chance * (1.0 - chance)) + 1e-9
