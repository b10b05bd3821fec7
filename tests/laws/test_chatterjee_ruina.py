"""The impact of Chatterjee and Ruina: the sum of two plastic impacts, which never gains energy."""

import numpy as np
import pytest
from support.impacts import after, contact_energy, drawn_impacts, impact_of, loss
from support.published import two_plastic_impacts

from contactlab.laws import ChatterjeeRuina
from contactlab.laws.base import SLIP, STICK


def test_it_is_the_published_impulse_and_creates_no_energy_at_any_restitution() -> None:
    """Kane's cases are among those drawn: of slip that reverses, in bodies that couple both directions."""
    rng, on_cone = np.random.default_rng(2), 0
    for normal, slip, d, mu in drawn_impacts(2000):
        e, e_t = rng.uniform(0.0, 1.0), rng.uniform(-1.0, 1.0)
        result = impact_of(ChatterjeeRuina(mu, e, e_t), normal, slip, d)
        matrix = np.array([[d[0], d[1]], [d[1], d[2]]])
        expected = two_plastic_impacts(np.array([normal, slip]), matrix, mu, e, e_t)
        assert result[:2] == pytest.approx(expected, rel=1e-9, abs=1e-11 * result[0])
        kept = contact_energy(normal, slip, d)
        assert loss(normal, slip, d, result) >= -1e-12 * kept
        assert after(normal, slip, d, result)[0] == pytest.approx(-e * normal, rel=1e-9, abs=1e-12)
        on_cone += abs(result[1]) > mu * result[0] * (1.0 - 1e-12)
    assert 300 < on_cone < 1700


def test_it_sticks_only_where_no_slip_is_left() -> None:
    alone, coupled = (1000.0, 0.0, 2000.0), (1000.0, 300.0, 2000.0)
    assert impact_of(ChatterjeeRuina(0.9, 0.5, 0.0), -0.1, 0.05, alone)[2] == STICK
    assert impact_of(ChatterjeeRuina(0.9, 0.0, 0.0), -0.1, 0.05, coupled)[2] == STICK
    assert impact_of(ChatterjeeRuina(0.9, 0.5, 0.0), -0.1, 0.05, coupled)[2] == SLIP
    assert impact_of(ChatterjeeRuina(0.9, 0.5, 0.2), -0.1, 0.05, alone)[2] == SLIP


def test_a_perfectly_rough_ball_turns_as_garwin_found() -> None:
    """A solid ball that gives all back, e = e_t = 1 (Garwin 1969, Am. J. Phys. 37, 88).

    Energy, and angular momentum about the contact, of speed v along the floor and spin R w = s:
    v' = (3 v + 4 s)/7, s' = (10 v - 3 s)/7, where s counts as positive if it rolls along v.
    """
    mass, inertia = 0.1, 0.4
    for speed, spin in ((0.3, 0.0), (0.3, 0.2), (-0.1, 0.4), (0.2, 0.2)):
        d = (1.0 / mass, 0.0, (1.0 + 1.0 / inertia) / mass)
        result = impact_of(ChatterjeeRuina(1e3, 1.0, 1.0), -0.5, speed - spin, d)
        moved, spun = speed + result[1] / mass, spin - result[1] / (inertia * mass)
        assert moved == pytest.approx((3.0 * speed + 4.0 * spin) / 7.0, abs=1e-15)
        assert spun == pytest.approx((10.0 * speed - 3.0 * spin) / 7.0, abs=1e-15)
        assert moved**2 + inertia * spun**2 == pytest.approx(speed**2 + inertia * spin**2, rel=1e-13)
