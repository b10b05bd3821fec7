"""The kernels of the three laws alone: cone, no tension, impacts in closed form, energy."""

from math import inf, nan, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st
from support.impacts import Delassus, Solution, after, impact_of, loss, round_off
from support.kernels import stepped

from contactlab.engine import simulate
from contactlab.laws import HertzElliptic, HertzPenalty, LagrangeSlip, LagrangeStick, hertz_stiffness
from contactlab.laws.base import SLIP, STICK
from contactlab.laws.friction import Coulomb
from contactlab.testing.plants import paper_motor

STIFFNESS = 1e10

# Whole micrometres a second: zero and everything else, but no numbers near the end of the range.
rate = st.integers(-2_000_000, 2_000_000).map(lambda x: 1e-6 * x)
approach = st.integers(-2_000_000, -1).map(lambda x: 1e-6 * x)
friction = st.integers(0, 2_000_000).map(lambda x: 1e-6 * x)


@st.composite
def delassus(draw: st.DrawFn) -> Delassus:
    """Symmetric positive definite 2x2 matrices, up to strong coupling of the two directions."""
    d_nn, d_tt = (10.0 ** draw(st.floats(1.0, 4.0)) for _ in range(2))
    return d_nn, draw(st.floats(-0.99, 0.99)) * sqrt(d_nn * d_tt), d_tt


def slip_law(mu: float, normal: float, tangential: float, slip: float, d: Delassus) -> Solution:
    law = LagrangeSlip(mu)
    return stepped(law, normal, tangential, 0.0, slip, *d)


@settings(deadline=None)
@given(st.floats(1e-12, 1e-4), rate, rate, friction)
def test_hertz_presses_with_the_power_three_halves_and_bounds_friction_by_the_cone(
    depth: float, gap_rate: float, slip: float, mu: float
) -> None:
    law = HertzPenalty(STIFFNESS, mu)
    normal, bound, stored, loss = law.evaluate("force", depth=depth, slip=slip)
    assert normal == pytest.approx(STIFFNESS * depth**1.5, rel=1e-14)
    assert bound == pytest.approx(mu * normal, rel=1e-15)
    assert stored == pytest.approx(0.4 * STIFFNESS * depth**2.5, rel=1e-14)
    # Elastic: neither the gap rate nor the slip enters, and nothing is lost.
    assert loss == 0.0
    assert law.evaluate("force", depth=depth, slip=0.0)[0] == normal


def test_hertz_stiffness_of_a_ball_on_a_plane_is_four_thirds_of_modulus_and_root_of_radius() -> None:
    modulus = 210e9 / (2.0 * (1.0 - 0.3**2))
    expected = 4.0 / 3.0 * modulus * sqrt(5e-3)
    assert hertz_stiffness(5e-3, inf) == pytest.approx(expected, rel=1e-14)


def test_hertz_stiffness_on_the_rotor_is_the_elliptical_one_within_half_a_percent() -> None:
    # Relative radii: 5 mm along the rotor's axis, 1/(1/5 + 1/25) mm around it.
    exact = HertzElliptic(5e-3, 1.0 / (200.0 + 40.0)).parameters()[0]
    assert hertz_stiffness(5e-3, 25e-3) == pytest.approx(exact, rel=5e-3)
    # The default tip has about 1e10.
    assert hertz_stiffness(5e-3, 25e-3) == pytest.approx(1e10, rel=0.05)


@settings(deadline=None)
@given(approach, rate, friction, delassus())
def test_stick_law_ends_the_approach_inside_the_cone(
    normal: float, tangential: float, mu: float, d: Delassus
) -> None:
    result = impact_of(LagrangeStick(mu), normal, tangential, d)
    p_n, p_t, mode = result
    gap_rate, slip = after(normal, tangential, d, result)
    error = round_off(normal, tangential, d, result)
    assert p_n > 0.0
    assert abs(gap_rate) <= error
    assert abs(p_t) <= mu * p_n * (1.0 + 1e-15)
    if mode == STICK:
        assert abs(slip) <= error
    else:
        assert mode == SLIP
        assert abs(p_t) == mu * p_n
        assert p_t * slip <= abs(p_t) * error


def test_contact_on_the_surface_of_the_cone_still_sticks() -> None:
    # |p_t| = mu p_n exactly, in numbers without round-off.
    d = (2.0, 0.0, 4.0)
    assert impact_of(LagrangeStick(0.25), -1.0, 0.5, d) == (0.5, -0.125, STICK)
    p_n, p_t, mode = impact_of(LagrangeStick(0.25), -1.0, 0.5 * (1.0 + 1e-9), d)
    assert (p_n, p_t, mode) == (0.5, -0.125, SLIP)


@pytest.mark.parametrize("mu", [0.0, 0.3, 2.0])
def test_the_cone_is_mu_n_in_slip_and_its_static_ratio_wider_in_stick(mu: float) -> None:
    law = Coulomb(mu, static_ratio=1.5)
    for normal in (2.0, 0.5, 0.0, -1.0):
        bounds = [law.evaluate("bound", normal=normal, slip=slip) for slip in (0.0, 1e-300, -0.1)]
        assert bounds == pytest.approx(np.array([1.5, 1.0, 1.0]) * mu * max(normal, 0.0), rel=1e-15)


@pytest.mark.parametrize("mu", [0.0, 0.3, 2.0])
def test_parting_bodies_are_released_not_pulled(mu: float) -> None:
    d = (900.0, 20.0, 2000.0)
    assert stepped(LagrangeStick(mu), 0.1, 0.4, 0.0, 0.4, *d)[0] <= 0.0
    assert slip_law(mu, 0.1, 0.4, 0.4, d)[0] <= 0.0


@settings(deadline=None)
@given(approach, rate, rate, friction, delassus())
def test_slip_law_rubs_against_the_slip_it_began_with(
    normal: float, tangential: float, slip: float, mu: float, d: Delassus
) -> None:
    # Without mu |D_nt| < D_nn slip has no solution of its own (Painleve), in this law or any.
    assume(mu * abs(d[1]) < 0.9 * d[0])
    result = slip_law(mu, normal, tangential, slip, d)
    p_n, p_t, mode = result
    assert mode == SLIP
    assert p_n > 0.0
    assert p_t == pytest.approx(-np.sign(slip) * mu * p_n, rel=1e-15)
    error = round_off(normal, tangential, d, result)
    assert abs(after(normal, tangential, d, result)[0]) <= error
    p_n, p_t, _ = impact_of(LagrangeSlip(mu), normal, slip, d)
    assert p_n > 0.0
    assert p_t == pytest.approx(-np.sign(slip) * mu * p_n, rel=1e-15)


def test_slip_law_creates_energy_when_it_reverses_a_slip_with_strong_friction() -> None:
    # From almost no slip: -v_n^2/(2 d_nn) + (mu v_n)^2 d_tt/(2 d_nn^2), a gain for mu^2 d_tt > d_nn.
    d, mu, normal, slip = (1000.0, 0.0, 4000.0), 0.8, -0.05, 1e-12
    gain = -loss(normal, slip, d, slip_law(mu, normal, slip, slip, d))
    expected = 0.5 * normal**2 / d[0] * (mu**2 * d[2] / d[0] - 1.0)
    assert gain == pytest.approx(expected, rel=1e-9)
    assert gain > 0.0
    assert -loss(normal, slip, d, impact_of(LagrangeStick(mu), normal, slip, d)) < 0.0


def test_the_stiffness_of_a_hertz_law_follows_from_its_tip_and_the_rotor() -> None:
    law = HertzPenalty(stiffness=None, tip_radius=5e-3)
    assert law.describe() == {"friction_coefficient": 0.3, "tip_radius": 5e-3}
    assert law.on_rotor(25e-3) == HertzPenalty(hertz_stiffness(5e-3, 25e-3))
    assert HertzPenalty(2e9).on_rotor(25e-3) == HertzPenalty(2e9)
    motor = paper_motor()
    result = simulate(motor, law, duration=1e-4, record_interval=1e-6)
    known = law.on_rotor(motor.geometry.rotor_radius)
    assert result.law == known
    expected = simulate(motor, known, duration=1e-4, record_interval=1e-6)
    np.testing.assert_array_equal(result.series["gap"], expected.series["gap"])


@pytest.mark.parametrize("arguments", [{"stiffness": None}, {"tip_radius": 5e-3}])
def test_stiffness_and_tip_radius_are_not_given_both_nor_neither(arguments: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="tip_radius"):
        HertzPenalty(**arguments)


def test_a_law_describes_every_parameter_by_name() -> None:
    law = HertzPenalty(stiffness=2e9, friction_coefficient=0.1)
    assert law.describe() == {"stiffness": 2e9, "friction_coefficient": 0.1}
    np.testing.assert_array_equal(law.parameters(), [2e9, 0.1, nan])
    assert LagrangeStick(0.4).describe() == {"friction_coefficient": 0.4}
