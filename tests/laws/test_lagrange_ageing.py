"""Stick-slip with two coefficients and with ageing: in closed form on a belt, and the kernel alone."""

from functools import partial
from math import atan, log1p, pi, sqrt

import pytest
from scipy.optimize import brentq
from support.kernels import stepped

from contactlab.laws import LagrangeAgeing, LagrangeStick
from contactlab.laws.base import SLIP, STICK
from contactlab.laws.memory import AT_RELEASE, AT_SLIP, AT_STICK, AT_TOUCH
from contactlab.testing.kernel_properties import drawn_impacts
from contactlab.testing.plants import block, first, run

WEIGHT, STIFFNESS, BELT = 9.81, 100.0, 0.1
"""Of a block of 1 kg [N], its spring [N/m], the belt's velocity [m/s]."""
MU = 0.3

on_belt = partial(block, weight=WEIGHT, stiffness=STIFFNESS, velocity=BELT, belt_velocity=BELT)


def stuck(law: LagrangeAgeing, until: float, step: float) -> float:
    return first(run(on_belt(), law, until, step), "stick_duration")


def test_ageing_holds_the_first_stick_and_the_next_for_as_long_as_it_grows() -> None:
    """k v_b t = N mu_s(t) at first; behind a slip k v_b t = N (mu_s(t) - mu) + N (mu_s(first) - mu)."""
    delta, onset = 0.02, 1e-3
    law = LagrangeAgeing(MU, 0.4 / MU, delta, onset)
    pull, w = STIFFNESS * BELT, sqrt(STIFFNESS)

    def static(age: float) -> float:
        return 0.4 + delta * log1p(age / onset)

    away = brentq(lambda t: pull * t - WEIGHT * static(t), 0.1, 2.0, xtol=1e-14)
    drop = WEIGHT * (static(away) - MU)
    slip = 2.0 / w * (pi - atan(drop * w / pull))
    stick = brentq(lambda t: pull * t - drop - WEIGHT * (static(t) - MU), 0.1, 2.0, xtol=1e-14)
    # Without ageing at all it would break away by a fifth earlier.
    assert away > 1.2 * WEIGHT * 0.4 / pull
    for step in (4e-4, 1e-4):
        once, twice = (stuck(law, end, step) for end in (away + 0.5 * slip, away + 1.5 * slip + stick))
        print(f"step {step:g}: away {once - away:.2e} s off, stick {twice - once - stick:.2e} s off")
        assert once == pytest.approx(away, abs=2.0 * step)
        assert twice - once == pytest.approx(stick, abs=2.0 * step)


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


def test_age_runs_in_stick_and_ends_with_it() -> None:
    law = LagrangeAgeing()
    assert (law.rate(0.0), law.rate(1e-300)) == (1.0, 0.0)
    ages = [law.jump(event, 0.2) for event in (AT_TOUCH, AT_SLIP, AT_STICK, AT_RELEASE)]
    assert ages == [0.0, 0.0, 0.2, 0.2]


def test_growth_ends_at_the_longest_age() -> None:
    law, d = LagrangeAgeing(MU, 1.0, 0.02, 1e-3, 0.5), (1000.0, 0.0, 1000.0)
    limit = MU + 0.02 * log1p(500.0)
    assert law.friction_limit == pytest.approx(limit, rel=1e-14)
    for share, mode in ((1.0 - 1e-9, STICK), (1.0 + 1e-9, SLIP)):
        assert step_of(law, 1e9, -0.1, 0.1 * limit * share, 0.0, 0.0, *d)[2] == mode
