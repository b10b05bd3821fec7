"""Brach's impact: Newton's where that dissipates, else without loss."""

import numpy as np
import pytest
from support.impacts import after, contact_energy, double_pendulum, drawn_impacts, impact_of, loss

import contactlab as cl
from contactlab.laws import Brach, Newton
from contactlab.laws.base import STICK


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


@pytest.mark.parametrize("approach", [1e-6, 1e-12, 1e-17, 1e-25])
@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
def test_friction_that_jams_ends_the_slip_of_an_impact_however_slow(approach: float, e: float) -> None:
    # mu d_nt > d_nn: without an approach the impulse is that of the slip alone, D p = (0, -slip).
    slip, d = 0.3, (40.0, 90.0, 700.0)
    jammed = np.linalg.solve([[d[0], d[1]], [d[1], d[2]]], [0.0, -slip])
    result = impact_of(Brach(1.5, e), -approach, slip, d)
    assert result[:2] == pytest.approx(tuple(jammed), rel=100.0 * approach + 1e-12)
    assert result[2] == STICK


def test_no_impact_under_it_makes_energy_or_has_no_number_whatever_its_speeds() -> None:
    rng, count = np.random.default_rng(3), 5000
    turn, thin, scale = rng.uniform(0.0, np.pi, count), *(10.0 ** rng.uniform((-5, 0), (0, 4), (count, 2)).T)
    axes = np.stack([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]).transpose(2, 0, 1)
    d = np.einsum("iab,ib,icb->iac", axes, np.stack([scale, scale * thin], 1), axes)
    before = np.array([-1.0, 1.0]) * 10.0 ** rng.uniform(-22.0, 1.0, (count, 2))
    for mu, e in ((0.2, 0.5), (1.5, 0.0), (5.0, 0.3), (5.0, 1.0)):
        impulse = cl.impact(Brach(mu, e), d, before)["impulse"].values
        change = np.einsum("iab,ib->ia", d, impulse)
        assert np.all(impulse[:, 0] > 0.0)
        assert np.all(np.abs(impulse[:, 1]) <= mu * impulse[:, 0] * (1.0 + 1e-9))
        # Work of the impulses over the sizes that it is the difference of.
        work = np.einsum("ia,ia->i", impulse, before + 0.5 * change)
        size = np.einsum("ia,ia->i", np.abs(impulse), np.abs(before) + np.abs(change))
        assert np.max(work / size) < 1e-9
