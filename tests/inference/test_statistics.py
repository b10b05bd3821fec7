"""Claims on folds, bootstrap intervals and the order of laws."""

import numpy as np
import pytest
from scipy.stats import bootstrap

from contactlab.inference.bootstrap import resampled
from contactlab.inference.folds import folds_of
from contactlab.inference.ranking import Pair, groups_of, order_of, pair_of, sentences
from contactlab.inference.residuals import binned


def test_folds_are_a_partition_of_even_parts_that_a_seed_fixes():
    fold = folds_of(np.arange(103), 5, seed=4)

    assert sorted(np.bincount(fold)) == [20, 20, 21, 21, 21]
    assert (fold == folds_of(np.arange(103), 5, seed=4)).all()
    assert (fold != folds_of(np.arange(103), 5, seed=5)).any()


@pytest.mark.parametrize(("impacts", "folds", "seed"), [(103, 5, 4), (7, 3, 0), (1718, 5, 2)])
def test_impacts_without_repeats_are_dealt_out_one_by_one(impacts, folds, seed):
    dealt = np.empty(impacts, dtype=np.int64)
    dealt[np.random.default_rng([seed, folds]).permutation(impacts)] = np.arange(impacts) % folds

    assert (folds_of(np.arange(impacts), folds, seed) == dealt).all()


def test_repeats_of_one_measurement_stay_in_one_fold_of_even_parts():
    measurement = np.repeat(np.arange(30), np.arange(30) % 4 + 1)
    fold = folds_of(measurement, 5, seed=1)

    assert all(len(set(fold[measurement == each])) == 1 for each in range(30))
    assert np.ptp(np.bincount(fold, minlength=5)) <= 4


def test_an_interval_is_that_of_an_independent_bootstrap():
    skewed = np.random.default_rng(2).exponential(size=80)
    ours = resampled(skewed[:, None], seed=1, resamples=20000).interval(0, 0.9)
    theirs = bootstrap((skewed,), np.mean, confidence_level=0.9, n_resamples=20000, rng=3, method="BCa")

    width = ours[1] - ours[0]
    assert ours == pytest.approx(
        (theirs.confidence_interval.low, theirs.confidence_interval.high), abs=0.03 * width
    )


def test_the_interval_of_a_difference_is_that_of_pairs():
    rng = np.random.default_rng(0)
    shared, apart = rng.normal(size=400), rng.normal(0.02, 0.05, size=400)
    both = resampled(np.column_stack([shared, shared + apart]), seed=0)
    mean, low, high = both.difference(1, 0)
    spread = apart.std() / np.sqrt(400.0)

    assert mean == pytest.approx(apart.mean())
    # What both share has a spread of 1/sqrt(400), twenty times that.
    assert (low, high) == pytest.approx((mean - 1.96 * spread, mean + 1.96 * spread), abs=0.15 * spread)
    assert both.difference(0, 0) == (0.0, 0.0, 0.0)


def test_nine_of_ten_intervals_of_nine_tenths_cover_a_skewed_mean():
    rng, covered = np.random.default_rng(7), 0
    for seed in range(300):
        low, high = resampled(rng.exponential(size=(60, 1)), seed, 800).interval(0, 0.9)
        covered += low <= 1.0 <= high

    # Of 300 with a chance of 0.9 the deviation is 0.017.
    assert 0.85 <= covered / 300 <= 0.95


def test_the_same_seed_resamples_the_same_bits():
    values = np.random.default_rng(1).random((50, 2))

    assert resampled(values, 3, 300).means.tobytes() == resampled(values, 3, 300).means.tobytes()


def test_laws_are_ordered_by_their_means_and_parted_where_the_pairs_part_them():
    rng = np.random.default_rng(5)
    hard = rng.exponential(0.1, 500)
    table = np.column_stack(
        [hard + 0.01 + rng.normal(0.0, 0.02, 500), hard, hard + rng.normal(0.0, 0.02, 500)]
    )
    names, drawn = ("worst", "first", "like it"), resampled(table, seed=0)

    assert order_of(drawn)[-1] == 0
    assert [sorted(group) for group in groups_of(drawn, names)] == [[1, 2], [0]]
    assert sentences(drawn, names)[0].startswith("The data cannot tell ")
    pair = pair_of(drawn, names, 0, 1)
    assert (pair.better, pair.worse, pair.parted) == ("first", "worst", True)
    # The spread of the pairs over sqrt(500), though that of either law is five times as large.
    reach = 1.96 * (table[:, 0] - table[:, 1]).std() / np.sqrt(500.0)
    assert pair.sentence == f"first beats worst by {pair.apart:.4f} +- {0.5 * (pair.high - pair.low):.4f}"
    assert 0.5 * (pair.high - pair.low) == pytest.approx(reach, rel=0.1)


def test_two_laws_that_differ_by_round_off_predict_the_same():
    errors = np.random.default_rng(0).exponential(0.1, (100, 1))
    drawn = resampled(np.hstack([errors, errors + 1e-12]), seed=0)

    assert pair_of(drawn, ("one", "other"), 0, 1).sentence == "one and other predict the same"
    assert groups_of(drawn, ("one", "other")) == [[0, 1]]


@pytest.mark.parametrize(
    ("low", "said"),
    [
        (-2e-5, "the data cannot tell one from other: less than 0.0001 apart"),
        (2e-6, "one beats other by less than 0.0001"),
    ],
)
def test_a_difference_that_four_decimals_do_not_show_is_less(low: float, said: str) -> None:
    assert Pair("one", "other", apart=1e-5, low=low, high=4e-5).sentence == said


def test_bins_of_equal_numbers_have_the_quartiles_of_what_is_in_them():
    x = np.random.default_rng(0).permutation(80).astype(float)
    found = binned(x, 2.0 * x)

    assert found.at == pytest.approx(4.5 + 10.0 * np.arange(8))
    assert found.median == pytest.approx(2.0 * found.at)
    assert found.high - found.low == pytest.approx(9.0)
