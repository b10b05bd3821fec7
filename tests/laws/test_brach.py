"""Brach's impact: Newton's where that dissipates, else without loss."""

import numpy as np
import pytest
from support.impacts import after, contact_energy, double_pendulum, drawn_impacts, impact_of, loss

from contactlab.laws import Brach, Newton


def test_it_is_newtons_impact_where_that_makes_no_energy_and_else_one_without_loss() -> None:
    cases = {"alike": 0, "bounded": 0}
    for normal, slip, d, mu in drawn_impacts(3000):
        # Beyond the critical friction Newton's law may have no answer.
        if mu * abs(d[1]) >= 0.99 * d[0]:
            continue
        result, newton = (impact_of(law(mu, 0.8), normal, slip, d) for law in (Brach, Newton))
        kept = contact_energy(normal, slip, d)
        if loss(normal, slip, d, newton) > 1e-9 * kept:
            cases["alike"] += 1
            assert result[:2] == pytest.approx(newton[:2], rel=1e-6, abs=1e-9 * newton[0])
        elif loss(normal, slip, d, newton) < -1e-9 * kept:
            cases["bounded"] += 1
            assert loss(normal, slip, d, result) == pytest.approx(0.0, abs=1e-9 * kept)
            # Less friction of the same direction, and the same rebound.
            assert 0.0 <= result[1] / newton[1] < 1.0
            assert after(normal, slip, d, result)[0] == pytest.approx(-0.8 * normal, rel=1e-9)
    assert cases["alike"] > 1000
    assert cases["bounded"] > 20


def test_the_double_pendulum_that_gains_energy_from_newtons_law_gains_none() -> None:
    normal, slip, d = double_pendulum()
    kept = contact_energy(normal, slip, d)
    gains = {
        law: -loss(normal, slip, d, impact_of(law(0.5, 0.7), normal, slip, d)) / kept
        for law in (Newton, Brach)
    }
    print("energy made, over that of the pendulum:", {law.name: gain for law, gain in gains.items()})
    # Two rods: the velocity of the free end is all the motion there is.
    assert kept == pytest.approx(0.5 * (4 / 3 * 0.01 + np.cos(np.radians(10)) * 0.02 + 0.04 / 3), rel=1e-12)
    assert gains[Newton] > 0.1
    assert gains[Brach] == pytest.approx(0.0, abs=1e-12)
