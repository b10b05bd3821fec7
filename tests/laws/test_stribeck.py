"""The Stribeck curve in a set-valued cone: its bound, growth on a belt, stick-slip."""

from math import exp, pi, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support.closed_forms import SPRING, WEIGHT, resting
from support.stribeck_belt import Belt, Stribeck as BeltLaw

from contactlab.laws.composed import Composed
from contactlab.laws.friction import Stribeck
from contactlab.laws.normal import Linear
from contactlab.testing.plants import last, run, way_of

MU, RATIO = 0.3, 1.5
DROP = MU * (RATIO - 1.0)


def law_of(velocity: float, exponent: float = 1.0) -> Composed:
    return Composed(Linear(SPRING), friction=Stribeck(MU, RATIO, velocity, exponent))


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
def test_the_bound_is_the_published_curve_and_the_same_in_the_mirror(exponent: float) -> None:
    friction = Stribeck(MU, RATIO, 1e-2, exponent)
    assert friction.evaluate("bound", normal=2.0, slip=0.0) == MU * RATIO * 2.0
    assert friction.evaluate("bound", normal=-2.0, slip=0.0) == 0.0
    for slip in (1e-9, 3e-3, 1e-2, 0.2):
        result = friction.evaluate("bound", normal=2.0, slip=slip)
        expected = 2.0 * (MU + DROP * exp(-((slip / 1e-2) ** exponent)))
        assert_allclose(result, expected, rtol=1e-14)
        assert result == friction.evaluate("bound", normal=2.0, slip=-slip)


@pytest.mark.parametrize(("exponent", "slow"), [(1.0, 0.08), (2.0, 0.1)])
def test_steady_sliding_on_a_belt_grows_at_the_rate_of_the_falling_curve(
    exponent: float, slow: float
) -> None:
    """x'' + w^2 x = 2 lambda x' with lambda = -N mu'(v)/(2 m), about where the spring holds mu(v) N."""
    stiffness, belt, swing = 400.0, 0.1, 2e-7
    share = (belt / slow) ** exponent
    growth = 0.5 * WEIGHT * DROP * exponent * share * exp(-share) / belt
    place = WEIGHT * (MU + DROP * exp(-share)) / stiffness
    wave = sqrt(stiffness - growth**2)
    motor = resting(stiffness=stiffness, way=place + swing, velocity=growth * swing, belt_velocity=belt)
    end = 4.0 * pi / wave
    made = run(motor, law_of(slow, exponent), end, 1e-2, end / 8.0, tolerance=1e-12)
    time = made.time
    expected = swing * np.exp(growth * time) * np.cos(wave * time)
    assert growth * end > 0.2
    # What is left is the curvature of mu over the swing.
    assert_allclose(way_of(made.series["tip_slope"]) - place, expected, atol=1e-3 * abs(expected).max())


@pytest.mark.parametrize(("exponent", "slow"), [(1.0, 1e-2), (2.0, 3e-3)])
def test_stick_slip_on_a_belt_is_that_of_an_ordinary_differential_equation(
    exponent: float, slow: float
) -> None:
    belt = Belt(BeltLaw(1e7, 0.45, MU, slow, exponent), 1e-6, velocity=0.03)
    friction = Stribeck(MU, 0.45 / MU, slow, exponent)
    made = run(belt.motor, Composed(Linear(1e7), friction=friction), 4e-3, 2e-4, 1e-4, tolerance=1e-8)
    result = way_of(made.series["tip_slope"])[-1], last(made, "slip_velocity") + belt.belt_velocity
    assert_allclose(result, belt.end(4e-3), rtol=1e-6, atol=1e-9)
    assert set(made.contact_mode[1:].tolist()) == {1, 2}
