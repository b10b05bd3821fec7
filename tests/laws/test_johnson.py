"""Johnson's restitution of a ball that yields: from its dent, and by its power of the speed."""

from math import pi, sqrt

import numpy as np
import pytest
from scipy.integrate import quad
from support.impacts import drawn_impacts, impact_of

from contactlab.laws import Johnson, Newton

MODULUS, STRENGTH, RADIUS = 115e9, 3e8, 4.5e-3
"""E* [Pa], Y [Pa], R [m]."""


def restitution(law: Johnson, speed: float, mass: float) -> float:
    """Rebound over approach of a mass that hits without friction."""
    p_n, _, _ = impact_of(law, -speed, 0.0, (1.0 / mass, 0.0, 1.0 / mass))
    return p_n / (mass * speed) - 1.0


def test_restitution_is_what_a_dent_of_one_pressure_gives_back_as_of_hertz() -> None:
    """Loading at p_d = 3 Y on the area pi a^2 = 2 pi R d, unloading from there elastically.

    The dent has the curvature that lets a sphere of modulus E* touch it over a at the load P:
    a^2 = R' d, P = 4/3 E* sqrt(R') d^(3/2).
    """
    law, mass, pressure = Johnson(0.3, MODULUS, STRENGTH, RADIUS), 2e-3, 3.0 * STRENGTH
    for speed in (0.5, 2.0, 10.0):
        depth = sqrt(0.5 * mass * speed**2 / (pi * RADIUS * pressure))
        work, _ = quad(lambda d: 2.0 * pi * RADIUS * d * pressure, 0.0, depth)
        assert work == pytest.approx(0.5 * mass * speed**2, rel=1e-12)
        load, a = 2.0 * pi * RADIUS * depth * pressure, sqrt(2.0 * RADIUS * depth)
        back = 0.75 * load / (MODULUS * a)
        stiffness = 4.0 / 3.0 * MODULUS * sqrt(a**2 / back)
        assert stiffness * back**1.5 == pytest.approx(load, rel=1e-12)
        values = stiffness * quad(lambda d: d**1.5, 0.0, back, epsabs=0.0)[0]
        assert restitution(law, speed, mass) == pytest.approx(sqrt(values / work), rel=1e-9)


def test_restitution_falls_with_the_fourth_root_of_the_speed_from_the_one_that_it_begins_at() -> None:
    law, mass = Johnson(0.3, MODULUS, STRENGTH, RADIUS), 2e-3
    speeds = np.array([0.5, 1.0, 4.0, 20.0])
    result = np.log([restitution(law, speed, mass) for speed in speeds])
    assert np.polyfit(np.log(speeds), result, 1)[0] == pytest.approx(-0.25, abs=1e-9)
    # Continuous where it leaves one, at 27 times the speed of first yield.
    leaves = sqrt(law.parameters()[1] / mass)
    assert leaves / law.first_yield(mass) == pytest.approx(26.9, abs=0.1)
    assert restitution(law, leaves * (1.0 - 1e-9), mass) == pytest.approx(1.0, abs=1e-12)
    assert restitution(law, leaves * (1.0 + 1e-9), mass) == pytest.approx(1.0, abs=1e-9)
    assert restitution(law, leaves * 16.0, mass) == pytest.approx(0.5, rel=1e-12)


def test_first_yield_is_where_the_peak_pressure_of_hertz_is_so_large() -> None:
    """W = 2/5 K d^(5/2) and p_0 = 3 P/(2 pi a^2) of Hertz; with p_0 = 1.6 Y about 53 Y^5 R^3/E*^4."""
    mass, law = 2e-3, Johnson(0.3, MODULUS, STRENGTH, RADIUS)
    energy = 0.5 * mass * law.first_yield(mass) ** 2
    stiffness = 4.0 / 3.0 * MODULUS * sqrt(RADIUS)
    depth = (2.5 * energy / stiffness) ** 0.4
    assert 1.5 * stiffness * depth**1.5 / (pi * RADIUS * depth) == pytest.approx(1.6 * STRENGTH, rel=1e-12)
    assert energy * MODULUS**4 / (STRENGTH**5 * RADIUS**3) == pytest.approx(53.0, rel=0.01)


def test_with_friction_it_is_newtons_impact_of_that_restitution() -> None:
    for normal, slip, d, mu in drawn_impacts(200, 0.5):
        law = Johnson(mu, MODULUS, 5e7, RADIUS)
        e = restitution(law, -normal, 1.0 / d[0])
        result, expected = (
            impact_of(law, normal, slip, d),
            impact_of(Newton(mu, min(e, 1.0)), normal, slip, d),
        )
        assert result == pytest.approx(expected, rel=1e-9)
        turned = impact_of(law, normal, -slip, (d[0], -d[1], d[2]))
        assert turned == (result[0], -result[1], result[2])
