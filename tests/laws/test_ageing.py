"""Static friction that ages: its bound, and how slip ends the age."""

from math import atan, log, log1p, pi, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from support.closed_forms import SPRING, WEIGHT, resting

from contactlab.laws.base import SLIP, STICK
from contactlab.laws.composed import Composed
from contactlab.laws.friction import AgeingStick
from contactlab.laws.memory import AT_RELEASE, AT_SLIP, AT_STICK, AT_TOUCH
from contactlab.laws.normal import Linear
from contactlab.testing.plants import first, run

MU, DELTA, BEGINS = 0.3, 0.05, 1e-3
STIFFNESS = 100.0
LAW = Composed(Linear(SPRING), friction=AgeingStick(MU, DELTA, BEGINS))


def breakaway(speed: float, duration: float = 0.0, before: float = 0.0) -> float:
    """Time t at which held + k v t = mu_s(before + t) N [s]."""

    def excess(t: float) -> float:
        return duration + STIFFNESS * speed * t - WEIGHT * (MU + DELTA * log1p((before + t) / BEGINS))

    # Until the rates meet, friction grows faster than the pull.
    least = max(DELTA * WEIGHT / (STIFFNESS * speed) - BEGINS - before, 0.0)
    return float(brentq(excess, least, least + 1e3, xtol=1e-14))


def stick_of(speed: float, until: float, law: Composed = LAW) -> float:
    """Time of stick of a block on a belt whose spring begins unstretched [s]."""
    motor = resting(stiffness=STIFFNESS, velocity=speed, belt_velocity=speed)
    return first(run(motor, law, until, 1e-3), "stick_duration")


def test_the_bound_grows_with_the_logarithm_of_the_age_up_to_its_longest_and_not_in_slip() -> None:
    """From one decade to the next it gains delta ln 10, with Dieterich's A = delta ln 10 and B = 1/t_0."""
    friction = AgeingStick(MU, DELTA, BEGINS, longest_age=100.0)
    ages = 10.0 ** np.arange(-6.0, 5.0)
    result = np.array([friction.evaluate("bound", normal=2.0, slip=0.0, age=age) for age in ages])
    expected = MU + DELTA * log(10.0) * np.log10(1.0 + np.minimum(ages, 100.0) / BEGINS)
    assert_allclose(result, 2.0 * expected, rtol=1e-14)
    assert_allclose(result[7] - result[6], 2.0 * DELTA * log(10.0), rtol=1e-3)
    assert result[-1] == pytest.approx(2.0 * friction.friction_limit, rel=1e-15)
    for slip in (0.1, -0.1, 1e-300):
        assert friction.evaluate("bound", normal=2.0, slip=slip, age=1.0) == MU * 2.0
    assert friction.evaluate("bound", normal=-1.0, slip=0.0, age=1.0) == 0.0


def test_the_age_counts_stick_and_is_forgotten_by_slip_and_by_a_new_contact() -> None:
    friction = AgeingStick()
    assert [friction.rate(slip) for slip in (0.0, 1e-12, -1.0)] == [1, 0, 0]
    after = [friction.jump(event, 0.7) for event in (AT_TOUCH, AT_RELEASE, AT_SLIP, AT_STICK)]
    assert after == [0.0, 0.7, 0.0, 0.7]


def test_every_slip_begins_the_age_anew() -> None:
    """After the slip, which lasts (2/w)[pi - atan(dF w/(k v))], the spring holds mu N - dF."""
    speed, root = 0.03, sqrt(STIFFNESS)
    once = breakaway(speed)
    drop = STIFFNESS * speed * once - MU * WEIGHT
    slip = 2.0 / root * (pi - atan(drop * root / (STIFFNESS * speed)))
    again = breakaway(speed, MU * WEIGHT - drop)
    result = stick_of(speed, once + slip + again + 1e-3)
    assert_allclose(result, once + again, rtol=1e-8)
    # With an age that went on it would have held for some hundredths longer.
    assert breakaway(speed, MU * WEIGHT - drop, once) > 1.03 * again


def test_slip_forgets_the_age_where_it_begins_and_not_where_it_ends() -> None:
    motor = resting(stiffness=STIFFNESS, velocity=0.03, belt_velocity=0.03)
    made = run(motor, LAW, breakaway(0.03) + 1.0, 1e-3, record_interval=1e-3)
    sticks, slips = (made.contact_mode == mode for mode in (STICK, SLIP))
    assert slips.any()
    assert sticks[-1]
    ages = made.series["internal_age"]
    assert ages[sticks].max() > 0.1
    assert np.all(ages[slips] == 0.0)
