"""Claims on free parameters and on least squares with many starts."""

from math import exp, pi

import numpy as np
import pytest

import contactlab as cl
from contactlab.parameter import Parameter
from contactlab_data.inference.free_parameters import FreeParameter, free_parameters, with_values
from contactlab_data.inference.least_squares import best_fit, starting_points

ANY = Parameter("x", "1", "any number")


def free(name, low, high, logarithmic=False):
    return FreeParameter(name, low, high, logarithmic, ANY)


def test_ranges_follow_from_the_declarations_of_a_law_and_its_parts():
    law = cl.law("composed", normal="hertz_point", damping="flores", friction="mindlin")
    result = {item.name: item for item in free_parameters(law)}

    assert list(result) == [
        "normal.stiffness",
        "damping.restitution",
        "damping.least_speed",
        "friction.friction_coefficient",
        "friction.stiffness_ratio",
    ]
    stiffness, ratio = result["normal.stiffness"], result["friction.stiffness_ratio"]
    assert (stiffness.low, stiffness.high, stiffness.logarithmic) == (1e7, 1e13, True)
    assert (ratio.low, ratio.high, ratio.logarithmic) == pytest.approx((0.082, 8.2, True))
    restitution, friction = result["damping.restitution"], result["friction.friction_coefficient"]
    assert (restitution.low, restitution.high) == (1e-3, 1.0)
    assert (friction.low, friction.high, friction.logarithmic) == (0.0, 1.2, False)


def test_chosen_names_alone_are_free_each_in_its_own_range_or_a_given_one():
    options = {"restitution": None, "friction_coefficient": (0.05, 0.5)}
    friction, restitution = free_parameters(cl.Newton(), options)

    assert (friction.name, friction.low, friction.high, friction.logarithmic) == (
        "friction_coefficient",
        0.05,
        0.5,
        False,
    )
    assert (restitution.low, restitution.high) == (0.0, 1.0)
    assert free_parameters(cl.HertzPenalty(), {"stiffness": (1e8, 1e11)})[0].logarithmic


@pytest.mark.parametrize(
    "chosen", [{"frictio": None}, {"restitution": (0.5, 1.5)}, {"restitution": (0.5, 0.2)}]
)
def test_a_range_that_a_law_does_not_admit_is_refused(chosen):
    with pytest.raises(ValueError, match="".join(chosen)):
        free_parameters(cl.Newton(), chosen)


def test_values_that_bind_each_other_are_set_together():
    # Its unloading must be stiffer than its loading, before and after.
    law = cl.law("composed", normal="walton_braun")
    chosen = free_parameters(law, {"normal.loading_stiffness": None, "normal.unloading_stiffness": None})

    assert with_values(law, chosen, (1e9, 2e9)).normal == cl.WaltonBraun(1e9, 2e9)


def test_the_best_of_many_starts_is_the_least_of_many_valleys():
    # One valley in 2 pi, the least at x = 12.
    def residuals(values):
        x, y = values
        return np.array([2.0 * np.sin(0.5 * (x - 12.0)), 0.05 * (x - 12.0), y - 3.0])

    ranges = free("x", -40.0, 40.0), free("y", 0.0, 10.0)
    result = best_fit(residuals, ranges, 24, seed=1, looks=1)

    assert result.values == pytest.approx([12.0, 3.0], abs=1e-6)
    assert result.costs.max() > 0.25 * (0.05 * 2.0 * pi) ** 2
    assert 1 <= result.hits < 24
    assert result.undetermined == ()


def test_the_optimum_of_an_exponential_decay_is_that_of_the_normal_equations():
    # Linear in the logarithm of its parameter: log y = log a, whose least squares are the mean.
    seen = np.array([0.9, 1.3, 1.1, 0.7])
    ranges = (free("a", 1e-3, 1e3, logarithmic=True),)
    result = best_fit(lambda values: np.log(values[0] / seen), ranges, 3, seed=0)

    assert result.values[0] == pytest.approx(exp(np.log(seen).mean()), rel=1e-7)
    assert result.cost == pytest.approx(0.5 * seen.size * np.var(np.log(seen)), rel=1e-10)
    assert result.hits == 3


def test_a_parameter_that_changes_nothing_and_two_that_only_act_together_cannot_be_told():
    ranges = tuple(free(name, 0.0, 1.0) for name in ("sum_1", "sum_2", "known", "idle"))
    noise = np.random.default_rng(3).normal(0.0, 0.01, 50)
    along = np.linspace(-1.0, 1.0, 50)

    def residuals(values):
        return values[0] + values[1] - 0.8 + (values[2] - 0.5) * along + noise

    result = best_fit(residuals, ranges, 2, seed=0)

    assert result.undetermined == ("sum_1", "sum_2", "idle")
    assert result.values[2] == pytest.approx(0.5, abs=0.01)


def test_an_optimum_beyond_a_range_is_said_to_lie_on_its_end():
    result = best_fit(lambda values: values - 2.0, (free("x", 0.0, 1.0),), 2, seed=0)

    assert result.values[0] == pytest.approx(1.0, abs=1e-5)
    assert result.at_end == ("x",)


def test_starts_without_numbers_are_given_up_and_none_at_all_is_a_sentence():
    def half(values):
        return values - 0.75 if values[0] > 0.6 else np.array([np.nan])

    ranges = (free("x", 0.0, 1.0),)
    result = best_fit(half, ranges, 8, seed=0, looks=1)
    assert result.values[0] == pytest.approx(0.75)
    # The middle and five of seven slices of the rest lie below 0.6.
    assert np.isfinite(result.costs).sum() in (2, 3)
    with pytest.raises(ValueError, match="finite"):
        best_fit(lambda _: np.array([np.nan]), ranges, 2, seed=0)


def test_the_same_seed_gives_the_same_bits_and_starts_are_spread():
    item, same, other = (starting_points(2, 9, seed) for seed in (5, 5, 6))

    assert item.tobytes() == same.tobytes() != other.tobytes()
    # A Latin hypercube has one start in each slice of each axis.
    assert (np.sort(np.floor(item[1:] * 8), axis=0) == np.arange(8.0)[:, None]).all()
