"""Adhesion after Johnson, Kendall and Roberts (1971); its cost after Thornton and Ning (1998)."""

from math import asin, pi, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from support.normal_balance import forces

from contactlab.laws import Composed, HertzPoint, Jkr
from contactlab.testing.closed_forms import restitution
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


def test_the_pulls_are_the_published_shares_of_three_halves_pi_w_r() -> None:
    largest = minimize_scalar(lambda x: forces(SPHERE, -x * BREAK)[0], (0.1, 0.5, 0.9))
    assert_allclose(-largest.fun, PULL_OFF, rtol=1e-9)
    assert_allclose(forces(SPHERE, 0.0)[0], -8.0 / 9.0 * PULL_OFF, rtol=1e-12)
    assert_allclose(forces(SPHERE, -BREAK)[0], -5.0 / 9.0 * PULL_OFF, rtol=1e-6)


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


def test_a_body_that_is_moved_away_is_held_to_the_gap_of_the_break() -> None:
    """So heavy that nothing disturbs it, it swings in and out: the contact is longer than half a swing."""
    mass, swing, rate = 1e6, 3.0 * BREAK, 2.0 * pi * 1e3
    heavy = block(mass, height=swing, normal_stiffness=mass * rate**2)
    contacts = run(heavy, Composed(SPHERE), 2e-3).contacts
    assert_allclose(contacts["duration"], (pi + asin(BREAK / swing)) / rate, rtol=1e-7)
    assert_allclose(contacts["energy_loss"], work_of_parting(), rtol=1e-6)


@pytest.mark.parametrize(("share", "holds"), [(0.85, True), (1.01, False)])
def test_a_constant_pull_parts_the_bodies_beyond_the_pull_off_force(share: float, holds: bool) -> None:
    x = 0.75 * (1.0 + sqrt(max(1.0 - share, 0.0)))
    unit = SPHERE.parameters()[1]
    depth = max(x ** (1.0 / 3.0) * (x - 1.0), 1e-3) * unit
    made = run(block(MASS, height=-depth, weight=-share * PULL_OFF), Composed(SPHERE), 2e-3)
    if holds:
        assert_allclose(last(made, "gap"), -depth, rtol=1e-6)
    else:
        assert last(made, "gap") > 10.0 * BREAK


def test_without_surface_energy_it_is_hertz() -> None:
    bare = Jkr(work_of_adhesion=1e-9)
    hertz = HertzPoint(4.0 / 3.0 * bare.effective_modulus * sqrt(bare.radius))
    assert_allclose(forces(bare, 1e-6)[:3], forces(hertz, 1e-6)[:3], rtol=1e-5)
