"""Adhesion after Maugis (1992): a Dugdale zone around the contact, between JKR and DMT."""

from itertools import pairwise
from math import pi, sqrt, tan

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar
from support.closed_forms import restitution
from support.normal_balance import forces

import contactlab as cl
from contactlab.laws import Composed, Coulomb, Dmt, Jkr, Maugis, tabor_number
from contactlab.testing.plants import block, first, last, run

MASS = 2e-3
NUMBERS = (1e-2, 0.1, 0.5, 0.8, 0.82, 1.0, 5.0, 1e2)
"""Tabor's numbers on both sides of that, 0.811, at which the bodies part as they cease to touch."""

JKR, DMT = Jkr(work_of_adhesion=1.0), Dmt(work_of_adhesion=1.0)
R, W, K = JKR.radius, JKR.work_of_adhesion, 4.0 / 3.0 * JKR.effective_modulus
FORCE, DEPTH = pi * W * R, (pi**2 * W**2 * R / K**2) ** (1.0 / 3.0)
"""Units of force [N] and depth [m]."""


def sphere(number: float) -> Maugis:
    return Maugis(work_of_adhesion=W, tabor_number=number)


def parameter_of(number: float) -> float:
    """Lambda, by its definition, of an equilibrium distance z_0 [m] and sigma_0 = 16 w/(9 sqrt(3) z_0)."""
    distance = brentq(
        lambda z: tabor_number(R, JKR.effective_modulus, W, z) - number, 1e-14, 1e-4, xtol=1e-30
    )
    stress = 16.0 * W / (9.0 * sqrt(3.0) * distance)
    return 2.0 * stress * (R / (pi * W * K**2)) ** (1.0 / 3.0)


def published(parameter: float, angle: float) -> tuple[float, float]:
    """Depth and force in their units at arcsec c/a: the condition of the opening is quadratic in a."""
    root, less = tan(angle), tan(angle) * tan(0.5 * angle)
    squared = 1.0 + root**2
    first = 0.5 * parameter * (root + (squared - 2.0) * angle)
    second = 4.0 / 3.0 * parameter**2 * (root * angle - less)
    a = 2.0 / (second + sqrt(second**2 + 4.0 * first))
    force = a**3 - parameter * a**2 * (root + squared * angle)
    return a**2 - 4.0 / 3.0 * parameter * a * root, force


def last_angle(parameter: float) -> float:
    """The angle up to which a contact is stable under a given depth, that of the least depth."""
    least_of = minimize_scalar(
        lambda angle: published(parameter, angle)[0],
        bounds=(0.5 / parameter if parameter > 0.5 else 0.5, 0.5 * pi - 1e-6),
        method="bounded",
        options={"xatol": 1e-10},
    )
    return float(least_of.x)


def reach_of(law: Maugis) -> tuple[float, float]:
    """Depths at which a contact begins and ends, in their unit."""
    begins, ends = law.evaluate("limits")
    return -begins / DEPTH, -ends / DEPTH


def at(law: Maugis, depth: float) -> tuple[float, ...]:
    """Force, stored energy, stiffness and its slope in their units at a depth in its unit."""
    force, energy, stiffness, slope, _ = forces(law, depth * DEPTH)
    return force / FORCE, energy / (FORCE * DEPTH), stiffness / FORCE * DEPTH, slope / FORCE * DEPTH**2


def meeting(parameter: float) -> float:
    """Depth at which the middles meet, a = 0: the condition of the opening is quadratic in c."""
    linear = 4.0 / 3.0 * parameter**2 * (0.5 * pi - 1.0)
    return -8.0 / 3.0 * parameter / (linear + sqrt(linear**2 + pi * parameter))


def pull_off(law: Maugis) -> float:
    """The largest pull in its unit."""
    _, least = reach_of(law)
    lowest = minimize_scalar(lambda depth: at(law, depth)[0], bounds=(least, 0.5), method="bounded")
    return -float(lowest.fun)


def lost(law: Maugis) -> float:
    """What is stored where the contact ends [J]."""
    return forces(law, -law.evaluate("limits")[1])[1]


@settings(max_examples=200, deadline=None)
@given(st.floats(-2.0, 2.0), st.floats(-1.3, -0.004))
def test_force_over_depth_is_the_published_one_over_the_ratio_of_the_radii(
    digits: float, share: float
) -> None:
    parameter = parameter_of(10.0**digits)
    law, angle = sphere(10.0**digits), 10.0**share * last_angle(parameter)
    depth, expected = published(parameter, angle)
    force, _, stiffness, _ = at(law, depth)
    # The depth has round-off, too.
    assert abs(force - expected) < 1e-12 * (1.0 + abs(expected)) + 1e-14 * abs(stiffness) * (1.0 + abs(depth))


@pytest.mark.parametrize("number", [1e-2, 0.1, 0.5, 0.8])
def test_surfaces_that_do_not_touch_pull_with_the_stress_over_their_ring(number: float) -> None:
    """N = -pi sigma_0 c^2, with the gap h_0 at the radius c: c^2/(2 R) - d - 4 sigma_0 c/(pi E*)."""
    law = sphere(number)
    begins, ends = law.evaluate("limits")
    stress = 0.5 * parameter_of(number) * (pi * W * K**2 / R) ** (1.0 / 3.0)
    assert begins == pytest.approx(W / stress, rel=1e-12)
    soft = 4.0 * stress / (pi * JKR.effective_modulus)
    touching = -meeting(parameter_of(number)) * DEPTH
    for gap in touching + (ends - touching) * np.array([0.01, 0.5, 0.99]):
        c = R * soft + sqrt((R * soft) ** 2 + 2.0 * R * (begins - gap))
        assert_allclose(forces(law, -gap)[0], -pi * stress * c**2, rtol=1e-9)


def test_a_contact_begins_where_the_surfaces_pull_0974_equilibrium_distances_apart() -> None:
    for distance in (2e-10, 3e-10):
        number = tabor_number(R, JKR.effective_modulus, W, distance)
        begins, _ = sphere(number).evaluate("limits")
        assert begins == pytest.approx(9.0 * sqrt(3.0) / 16.0 * distance, rel=1e-12)


@pytest.mark.parametrize("number", NUMBERS)
def test_force_stiffness_and_slope_are_the_derivatives_of_the_energy(number: float) -> None:
    law = sphere(number)
    begins, least = reach_of(law)
    assert at(law, begins)[1] == pytest.approx(0.0, abs=1e-13)
    # The stiffness is continuous and its slope is not where the touching area vanishes.
    kink = meeting(parameter_of(number))
    depths = np.array([least + 1e-3, *(least + np.geomspace(0.03, 40.0, 12))])
    for low, high in pairwise(depths):
        inner = [kink] if low < kink < high else None
        work = quad(lambda d: at(law, d)[0], low, high, epsabs=1e-14, epsrel=1e-13, points=inner, limit=200)[
            0
        ]
        assert work == pytest.approx(at(law, high)[1] - at(law, low)[1], rel=1e-12, abs=2e-12)
        step = 1e-4 * min(low - least, 1.0)
        if abs(low - kink) > 10.0 * step:
            below, here, above = (at(law, low + way) for way in (-step, 0.0, step))
            assert (above[0] - below[0]) / (2.0 * step) == pytest.approx(here[2], rel=1e-5, abs=1e-8)
            assert (above[2] - below[2]) / (2.0 * step) == pytest.approx(here[3], rel=1e-5, abs=1e-8)


@pytest.mark.parametrize("number", NUMBERS)
def test_pull_off_is_that_of_the_published_fit_between_both_limits(number: float) -> None:
    """7/4 - 1/4 (4.04 lambda^1.4 - 1)/(4.04 lambda^1.4 + 1), within 1.2 % (Carpick et al. 1999)."""
    x = 4.04 * parameter_of(number) ** 1.4
    assert pull_off(sphere(number)) == pytest.approx(1.75 - 0.25 * (x - 1.0) / (x + 1.0), rel=0.012)


def test_the_largest_pulls_are_those_of_both_limits() -> None:
    assert pull_off(sphere(1e2)) == pytest.approx(1.5, rel=1e-4)
    assert pull_off(sphere(1e-2)) == pytest.approx(2.0, rel=2e-3)


def test_force_and_energy_tend_to_jkr_with_the_square_of_tabors_number() -> None:
    def apart(number: float, depth: float) -> tuple[float, float]:
        law = sphere(number)
        other = forces(JKR, depth * DEPTH)
        force, energy, *_ = at(law, depth)
        return force - other[0] / FORCE, energy - at(law, 0.0)[1] - other[1] / (FORCE * DEPTH)

    for depth in (-0.5, 0.5, 5.0):
        coarse, fine = np.array(apart(10.0, depth)), np.array(apart(1e2, depth))
        assert np.all(np.abs(fine) < 3e-5)
        assert_allclose(coarse / fine, 100.0, rtol=0.02)


def test_what_is_lost_tends_to_that_of_jkr_with_tabors_number_and_to_none_with_its_fifth_power() -> None:
    whole = forces(JKR, -JKR.evaluate("limits")[1])[1]
    coarse, fine = (lost(sphere(number)) / whole - 1.0 for number in (10.0, 1e2))
    assert coarse / fine == pytest.approx(10.0, rel=0.03)
    # From c = 2 r to the break at c = r = 8 lambda/(3 pi), pi lambda/2 c^2 over the way (c - r) dc.
    for number in (0.1, 0.3, 0.5):
        parameter = parameter_of(number)
        expected = 17.0 / 24.0 * pi * parameter * (8.0 * parameter / (3.0 * pi)) ** 4
        assert lost(sphere(number)) / (FORCE * DEPTH) == pytest.approx(expected, rel=1e-9)


def test_force_tends_to_dmt_with_the_root_of_lambda() -> None:
    """The wide ring draws the bodies together by e = 8/3 (lambda/pi)^(1/2), and pulls less by pi lambda d.

    What is left falls with the next power, 3/2.
    """
    for depth in (0.5, 2.0):
        rest = []
        for number in (0.04, 0.01):
            parameter = parameter_of(number)
            drawn = 8.0 / 3.0 * sqrt(parameter / pi)
            terms = 1.5 * sqrt(depth) * drawn + 0.375 * drawn**2 / sqrt(depth) - pi * parameter * depth
            rest.append(at(sphere(number), depth)[0] - forces(DMT, depth * DEPTH)[0] / FORCE - terms)
        assert abs(rest[1]) < 0.02
        assert rest[0] / rest[1] == pytest.approx(8.0, rel=0.2)


@pytest.mark.parametrize("number", [0.3, 0.82, 1.0, 5.0])
def test_a_drive_to_and_fro_loses_what_is_stored_at_the_break(number: float) -> None:
    law = sphere(number)
    _, ends = law.evaluate("limits")
    time = np.linspace(0.0, 1.0, 2001)
    gap = 1.5 * ends - 3.0 * ends * np.sin(pi * time) ** 2
    made = cl.drive(Composed(law, friction=Coulomb(0.0)), time, gap=gap, degree=7)
    assert made.complete
    loss = float(made["contact_loss"][-1])
    assert loss == pytest.approx(lost(law), rel=1e-9)
    assert float(made["drive_work"][-1]) == pytest.approx(loss, rel=1e-9)


@pytest.mark.parametrize("number", [0.1, 0.6, 1.0, 5.0])
@pytest.mark.parametrize("energy", [0.1, 5.0])
def test_restitution_falls_short_by_the_energy_left_at_the_break(number: float, energy: float) -> None:
    """To nearly none for a small number: what the surfaces do on the way in they take on the way out."""
    law = sphere(number)
    brought = lost(law) + energy * FORCE * DEPTH
    speed, height = sqrt(2.0 * brought / MASS), 2.0 * law.evaluate("limits")[1]
    motor = block(MASS, height=height, gap_rate=-speed)
    made = run(motor, Composed(law), 2.0 * height / speed + 5e-3, tolerance=1e-8)
    assert_allclose(restitution(made), sqrt(1.0 - lost(law) / brought), rtol=1e-6)
    assert_allclose(first(made, "energy_loss"), lost(law), rtol=1e-9)
    assert abs(last(made, "energy_residual")) < 1e-8 * (brought + FORCE * DEPTH)
