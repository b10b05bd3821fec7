"""Adhesion after Johnson, Kendall and Roberts (1971), and after Derjaguin, Muller and Toporov (1975)."""

from math import pi, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import brentq
from support.closed_forms import restitution
from support.normal_balance import forces

import contactlab as cl
from contactlab.driving import drive
from contactlab.laws import Composed, Dmt, HertzPoint, Jkr, tabor_number
from contactlab.testing.plants import attempt, block, first, last, run

MASS = 2e-3
SPHERE = Jkr(work_of_adhesion=1.0)
PULL_OFF = 1.5 * pi * SPHERE.work_of_adhesion * SPHERE.radius
BREAK = SPHERE.evaluate("limits")[1]

SCALE = (SPHERE.work_of_adhesion**5 * SPHERE.radius**4 / SPHERE.effective_modulus**2) ** (1.0 / 3.0)
"""(w^5 R^4 / E*^2)^(1/3) [J]."""


def approach(radius: float) -> float:
    """The published depth at a contact radius."""
    s = SPHERE
    return radius**2 / s.radius - sqrt(2.0 * pi * s.work_of_adhesion * radius / s.effective_modulus)


def force(radius: float) -> float:
    """The published force at a contact radius."""
    s = SPHERE
    adhesive = sqrt(8.0 * pi * s.work_of_adhesion * s.effective_modulus * radius**3)
    return 4.0 / 3.0 * s.effective_modulus * radius**3 / s.radius - adhesive


def work_of_parting() -> float:
    """From a gap of zero to the break, by quadrature of the published force over the contact radius."""
    s = SPHERE
    zero = (2.0 * pi * s.work_of_adhesion * s.radius**2 / s.effective_modulus) ** (1.0 / 3.0)
    least = zero * 4.0 ** (-2.0 / 3.0)

    def way(a: float) -> float:
        return 2.0 * a / s.radius - sqrt(pi * s.work_of_adhesion / (2.0 * s.effective_modulus * a))

    assert way(least) == pytest.approx(0.0, abs=1e-12 * way(zero))
    return float(quad(lambda a: -force(a) * way(a), least, zero, epsrel=1e-12)[0])


def sticking_speed() -> float:
    return sqrt(2.0 * work_of_parting() / MASS)


def test_force_over_depth_is_the_published_one_over_the_contact_radius() -> None:
    least = (pi * SPHERE.work_of_adhesion * SPHERE.radius**2 / (8.0 * SPHERE.effective_modulus)) ** (
        1.0 / 3.0
    )
    for radius in least * np.geomspace(1.01, 1e3, 40):
        result = forces(SPHERE, approach(float(radius)))[0]
        assert_allclose(result, force(float(radius)), rtol=1e-9, atol=1e-11 * PULL_OFF)


def test_the_work_of_parting_has_the_published_number() -> None:
    """7.09 (w^5 R^4 / E*^2)^(1/3): what is still stored where the contact breaks."""
    assert work_of_parting() / SCALE == pytest.approx(7.09, abs=5e-3)
    assert forces(SPHERE, 0.0)[1] == pytest.approx(0.0, abs=1e-14 * SCALE)
    assert_allclose(forces(SPHERE, -BREAK)[1], work_of_parting(), rtol=1e-10)


@pytest.mark.parametrize("ratio", [1.01, 1.5, 10.0, 100.0])
def test_restitution_falls_short_by_the_work_of_parting(ratio: float) -> None:
    """e = sqrt(1 - (v_s/v)^2), v_s = (14.18/m)^(1/2) (w^5 R^4 / E*^2)^(1/6)."""
    speed = ratio * sticking_speed()
    made = run(block(MASS, height=1e-7, gap_rate=-speed), Composed(SPHERE), 1e-7 / speed + 2e-3)
    assert_allclose(restitution(made), sqrt(1.0 - 1.0 / ratio**2), rtol=1e-5)
    assert_allclose(first(made, "energy_loss"), work_of_parting(), rtol=1e-6)
    assert abs(last(made, "energy_residual")) < 1e-8 * 0.5 * MASS * speed**2


@pytest.mark.parametrize(("ratio", "count"), [(0.99, 1), (1.01, 2)])
def test_a_bead_slower_than_the_sticking_speed_never_leaves(ratio: float, count: int) -> None:
    speed = ratio * sticking_speed()
    made = attempt(block(MASS, height=1e-7, gap_rate=-speed, weight=1e-9), Composed(SPHERE), 5e-3)
    left = np.isfinite(made.contacts["separation_velocity"][0])
    assert left == (count > 1)


ATTRACTED = Dmt(work_of_adhesion=1.0)
ATTRACTION = 2.0 * pi * ATTRACTED.work_of_adhesion * ATTRACTED.radius


def test_dmt_force_is_hertz_less_a_constant_pull() -> None:
    hertz = HertzPoint(4.0 / 3.0 * ATTRACTED.effective_modulus * sqrt(ATTRACTED.radius))
    for depth in (1e-9, 1e-7, 1e-5):
        ours, plain = forces(ATTRACTED, depth), forces(hertz, depth)
        assert_allclose(ours[0], plain[0] - ATTRACTION, rtol=1e-14)
        assert ours[2:] == plain[2:]
    assert forces(ATTRACTED, 0.0)[:2] == (-ATTRACTION, 0.0)


@pytest.mark.parametrize("speed", [1e-3, 1e-2, 1.0])
def test_a_dmt_impact_is_elastic_at_every_speed(speed: float) -> None:
    made = run(block(MASS, height=1e-7, gap_rate=-speed), Composed(ATTRACTED), 1e-7 / speed + 3e-3)
    assert_allclose(restitution(made), 1.0, rtol=1e-6)
    assert first(made, "energy_loss") == pytest.approx(0.0, abs=1e-12 * MASS * speed**2)
    energy = 0.5 * MASS * speed**2

    def left(depth: float) -> float:
        return forces(ATTRACTED, depth)[1] - energy

    deepest = brentq(left, 1e-8, 1e-4, xtol=1e-18)
    assert_allclose(first(made, "max_penetration"), deepest, rtol=1e-6)


def test_tabors_number_is_the_gap_at_which_the_neck_breaks_over_the_equilibrium_distance() -> None:
    """g = 3/4^(4/3) a_0^2/R, a_0 = (2 pi w R^2/E*)^(1/3), is 3 (pi/8)^(2/3) z_0 mu_T."""
    distance = 3e-10
    number = tabor_number(SPHERE.radius, SPHERE.effective_modulus, SPHERE.work_of_adhesion, distance)
    assert 3.0 * (pi / 8.0) ** (2.0 / 3.0) * number * distance == pytest.approx(BREAK, rel=1e-12)


def test_a_contact_that_begins_in_its_neck_goes_on_as_one_that_was_pulled_there() -> None:
    law = Composed(SPHERE)
    time = np.linspace(0.0, 1.0, 201)
    whole, rest = (
        drive(law, of, gap=2.0 * BREAK * of, touching=True, record_interval=0.005) for of in (time, time[50:])
    )
    assert_allclose(rest.contacts.duration, whole.contacts.duration - 0.25, rtol=1e-9)
    assert_allclose(rest["normal_force"][1:], whole["normal_force"][51:], atol=1e-9 * PULL_OFF)
    # What is lost at the break is the same; what the neck has at the start the path has not done.
    assert_allclose(rest["contact_loss"][-1], whole["contact_loss"][-1], rtol=1e-9)
    brought = quad(lambda gap: -forces(SPHERE, -gap)[0], 0.0, 0.5 * BREAK, epsrel=1e-12)[0]
    assert_allclose(whole["drive_work"][-1] - rest["drive_work"][-1], brought, rtol=1e-9)
    assert abs(rest["energy_residual"]).max() < 1e-12 * brought


@pytest.mark.parametrize("height", [0.0, 0.999 * BREAK, 1.001 * BREAK])
def test_a_body_that_starts_touching_is_in_its_neck_unless_that_is_broken(height: float) -> None:
    start = block(1.0, height=height, touching=True)
    touches = cl.simulate(start, Composed(SPHERE), duration=1e-6, record_interval=1e-7)["contact_mode"][1:]
    assert bool((touches != 0).all()) == (height < BREAK)
    assert not touches.any() or height < BREAK


def test_a_steady_state_has_no_start_in_a_neck() -> None:
    setup = cl.Setup.of(block(1.0, height=0.5 * BREAK, touching=True), Composed(SPHERE), 1e-3)
    with pytest.raises(ValueError, match="touching"):
        cl.steady(setup)
