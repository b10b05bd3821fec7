"""Errors that the finest contact step or tolerance leaves, held to series whose limit is known."""

from math import inf, isnan, nan

import numpy as np
import pytest

import contactlab as cl
from contactlab.refinement import Refinement, richardson

STEPS = np.array([4.0, 2.0, 1.0])


@pytest.mark.parametrize("order", [1.0, 2.0])
def test_the_error_of_a_power_of_the_step_is_the_distance_from_its_limit(order: float) -> None:
    numbers = 5.0 + STEPS**order
    refinement = Refinement(2.0, order)
    assert refinement.error(numbers) == pytest.approx(1.0)
    # What converges more slowly than declared does not have the declared error.
    assert Refinement(2.0, order + 1.0).error(numbers) == pytest.approx(1.0)
    # Of two numbers the declared order must do.
    assert refinement.error(numbers[1:]) == pytest.approx(1.0)
    assert refinement.observed_order(numbers.tolist()) == pytest.approx(order)
    np.testing.assert_allclose(refinement.errors(numbers), STEPS**order - 1.0 + 1.0)
    assert refinement.error(numbers[:1]) == 0.0


def test_a_sequence_that_grows_has_nine_times_its_last_change_and_no_order() -> None:
    assert richardson([1.0, 2.0, 4.0], 2.0, 1.0) == pytest.approx(18.0)
    assert isnan(Refinement(2.0, 1.0).observed_order([1.0, 2.0, 4.0]))


def test_what_statistics_blur_has_its_range_and_an_infinite_number_no_error_of_the_step() -> None:
    refinement, numbers = Refinement(2.0, 1.0), [1.4, 1.2, 1.1]
    assert refinement.estimate(numbers, [0.01, 0.01, 0.01]) == pytest.approx((1.1, 0.1 + 0.01))
    assert refinement.estimate(numbers, [0.5, nan, 0.02]) == pytest.approx((1.1, 0.3 + 0.02))
    assert refinement.estimate([inf, inf, inf], [0.0, 0.0, 0.0]) == (inf, 0.0)


@pytest.mark.parametrize(
    ("keys", "control", "factor"),
    [
        (["law=lagrange_stick", "solver.contact_step=1 us"], "contact_step", 2.0),
        (["law=lagrange_stick"], "tolerance", 10.0),
        (["law=hertz_penalty", "solver.contact_step=1 us"], "tolerance", 10.0),
    ],
)
def test_only_time_stepping_is_refined_by_its_step(keys: list[str], control: str, factor: float) -> None:
    setup = cl.build(keys)
    refinement = Refinement.of(setup)
    assert (refinement.control, refinement.order) == (control, setup.law.convergence_order)
    coarsest, *finer = (getattr(each, control) for each in refinement.setups(setup))
    assert coarsest == getattr(setup, control)
    assert finer == pytest.approx([coarsest / factor, coarsest / factor**2])
    # The difference of two laws converges like the slower of them.
    assert Refinement.of_difference([2.0, 1.0]).error(5.0 + STEPS) == pytest.approx(1.0)
