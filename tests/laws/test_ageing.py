"""Static friction that ages, in a compliant and in a rigid contact: on a belt, its bound, and one step."""

from math import atan, log, log1p, pi, sqrt
from typing import NamedTuple

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from support.closed_forms import SPRING, WEIGHT, resting
from support.kernels import stepped

from contactlab.laws import ContactLaw, LagrangeAgeing, LagrangeStick
from contactlab.laws.base import SLIP, STICK
from contactlab.laws.composed import Composed
from contactlab.laws.friction import AgeingStick
from contactlab.laws.memory import AT_RELEASE, AT_SLIP, AT_STICK, AT_TOUCH
from contactlab.laws.normal import Linear
from contactlab.testing.kernel_properties import drawn_impacts
from contactlab.testing.plants import first, run

MU, ONSET, STIFFNESS = 0.3, 1e-3, 100.0
LAW = Composed(Linear(SPRING), friction=AgeingStick(MU, 0.05, ONSET))


class Belt(NamedTuple):
    """A block of 1 kg, held by a spring of 100 N/m, on a belt of a speed [m/s], and the error of its stick.

    The static friction is `static` + `delta` ln(1 + t/t_0), the kinetic one MU.
    """

    law: ContactLaw
    static: float
    delta: float
    speed: float
    height: float  # of the block at rest [m]
    step: float  # of the contact [s]
    error: float  # of a time of stick [s]

    def breakaway(self, pulled: float = 0.0, before: float = 0.0) -> float:
        """Time t [s] at which pulled + k v t = mu_s(before + t) N."""
        pull = STIFFNESS * self.speed

        def excess(t: float) -> float:
            static = self.static + self.delta * log1p((before + t) / ONSET)
            return pulled + pull * t - WEIGHT * static

        # Until the rates meet, friction grows faster than the pull.
        least = max(self.delta * WEIGHT / pull - ONSET - before, 0.0)
        return float(brentq(excess, least, least + 1e3, xtol=1e-14))

    def stuck(self, until: float) -> float:
        """Time of stick [s] until a time, of a spring that begins unstretched."""
        motor = resting(
            height=self.height, stiffness=STIFFNESS, velocity=self.speed, belt_velocity=self.speed
        )
        return first(run(motor, self.law, until, self.step), "stick_duration")


RIGID = LagrangeAgeing(MU, 0.4 / MU, 0.02, ONSET)
BELTS = {
    "ageing_stick": Belt(LAW, MU, 0.05, 0.03, -WEIGHT / SPRING, 1e-3, 1e-8),
    **{
        f"lagrange_ageing, {step:g} s": Belt(RIGID, 0.4, 0.02, 0.1, 0.0, step, 2.0 * step)
        for step in (4e-4, 1e-4)
    },
}


@pytest.mark.parametrize("belt", BELTS.values(), ids=list(BELTS))
def test_every_slip_begins_the_age_anew(belt: Belt) -> None:
    """After the slip, which lasts (2/w)[pi - atan(dF w/(k v))], the spring holds mu N - dF."""
    pull, root, once = STIFFNESS * belt.speed, sqrt(STIFFNESS), belt.breakaway()
    drop = pull * once - MU * WEIGHT
    slip = 2.0 / root * (pi - atan(drop * root / pull))
    again = belt.breakaway(MU * WEIGHT - drop)
    sticks = belt.stuck(once + 0.5 * slip), belt.stuck(once + 1.5 * slip + again)
    assert sticks[0] == pytest.approx(once, rel=0.0, abs=belt.error)
    assert sticks[1] - sticks[0] == pytest.approx(again, rel=0.0, abs=belt.error)
    # Without ageing it would break away earlier, and with an age that went on later.
    assert once > WEIGHT * belt.static / pull + 10.0 * belt.error
    assert belt.breakaway(MU * WEIGHT - drop, once) > again + 10.0 * belt.error


@pytest.mark.parametrize("law", [AgeingStick(), LagrangeAgeing()], ids=lambda law: law.name)
def test_the_age_counts_stick_and_is_forgotten_by_slip_and_by_a_new_contact(
    law: AgeingStick | LagrangeAgeing,
) -> None:
    assert [law.rate(slip) for slip in (0.0, 1e-300, 1e-12, -1.0)] == [1, 0, 0, 0]
    after = [law.jump(event, 0.7) for event in (AT_TOUCH, AT_RELEASE, AT_SLIP, AT_STICK)]
    assert after == [0.0, 0.7, 0.0, 0.7]


def test_the_bound_grows_with_the_logarithm_of_the_age_up_to_its_longest_and_not_in_slip() -> None:
    """From one decade to the next it gains delta ln 10, with Dieterich's A = delta ln 10 and B = 1/t_0."""
    delta = 0.05
    friction = AgeingStick(MU, delta, ONSET, longest_age=100.0)
    ages = 10.0 ** np.arange(-6.0, 5.0)
    result = np.array([friction.evaluate("bound", normal=2.0, slip=0.0, age=age) for age in ages])
    expected = MU + delta * log(10.0) * np.log10(1.0 + np.minimum(ages, 100.0) / ONSET)
    assert_allclose(result, 2.0 * expected, rtol=1e-14)
    assert_allclose(result[7] - result[6], 2.0 * delta * log(10.0), rtol=1e-3)
    assert result[-1] == pytest.approx(2.0 * friction.friction_limit, rel=1e-15)
    for slip in (0.1, -0.1, 1e-300):
        assert friction.evaluate("bound", normal=2.0, slip=slip, age=1.0) == MU * 2.0
    assert friction.evaluate("bound", normal=-1.0, slip=0.0, age=1.0) == 0.0


def test_slip_forgets_the_age_where_it_begins_and_not_where_it_ends() -> None:
    motor = resting(stiffness=STIFFNESS, velocity=0.03, belt_velocity=0.03)
    made = run(motor, LAW, BELTS["ageing_stick"].breakaway() + 1.0, 1e-3, record_interval=1e-3)
    sticks, slips = (made.contact_mode == mode for mode in (STICK, SLIP))
    assert slips.any()
    assert sticks[-1]
    ages = made.series["internal_age"]
    assert ages[sticks].max() > 0.1
    assert np.all(ages[slips] == 0.0)


def step_of(law: LagrangeAgeing, age: float, *state: float) -> tuple[float, float, int]:
    """Impulses and mode of a step in contact; an age is that of a stick."""
    return stepped(law, *state, mode=STICK if age > 0.0 else SLIP, variables=(age,))  # type: ignore[no-any-return]


def test_without_ageing_and_with_one_coefficient_it_is_lagrange_stick() -> None:
    law, plain = LagrangeAgeing(MU, 1.0, 0.0), LagrangeStick(MU)
    for approach, slip, *d in drawn_impacts(MU):
        assert stepped(law, approach, slip, approach, slip, *d) == stepped(
            plain, approach, slip, approach, slip, *d
        )
        for start in (0.0, slip):
            lasting = approach, slip, 0.0, start, *d
            for age in (0.0, 1.0):
                assert step_of(law, age, *lasting) == stepped(plain, *lasting)


def test_static_friction_holds_what_rests_and_catches_what_would_turn_back_but_brakes_nothing() -> None:
    law, d = LagrangeAgeing(MU, 1.5, 0.0), (1000.0, 0.0, 1000.0)
    # In one step: an impulse of 1e-4 N s presses, and 0.4 of it would hold.
    rate, stored = -0.1, 0.04
    assert step_of(law, 1.0, rate, stored, 0.0, 0.0, *d)[2] == STICK
    assert step_of(law, 0.0, rate, stored, 0.0, 0.0, *d)[2] == STICK
    # It slid the other way, and has been stopped within the step.
    assert step_of(law, 0.0, rate, stored, 0.0, -0.001, *d)[2] == STICK
    assert step_of(law, 0.0, rate, stored, 0.0, 0.02, *d)[1:] == (pytest.approx(-MU * 1e-4), SLIP)
    # More than the static cone holds.
    assert step_of(law, 1.0, rate, 0.046, 0.0, 0.0, *d)[1:] == (pytest.approx(-MU * 1e-4), SLIP)


def test_growth_of_a_rigid_contact_ends_at_the_longest_age() -> None:
    law, d = LagrangeAgeing(MU, 1.0, 0.02, 1e-3, 0.5), (1000.0, 0.0, 1000.0)
    limit = MU + 0.02 * log1p(500.0)
    assert law.friction_limit == pytest.approx(limit, rel=1e-14)
    for share, mode in ((1.0 - 1e-9, STICK), (1.0 + 1e-9, SLIP)):
        assert step_of(law, 1e9, -0.1, 0.1 * limit * share, 0.0, 0.0, *d)[2] == mode
