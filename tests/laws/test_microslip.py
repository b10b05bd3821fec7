"""Microslip: Mindlin's curves at constant force, his oblique compression, and a patch solved otherwise."""

from itertools import pairwise

import numpy as np
import pytest
import sphere_rebounds as spheres
from numpy.testing import assert_allclose
from sphere_laws import ALUMINA_ON_GLASS
from support.closed_forms import SPRING, WEIGHT, resting
from support.published import loss_of_cycle, spheres_friction, spheres_loss

import contactlab as cl
from contactlab.testing.plants import HEAVY, run

MU, KAPPA = 0.3, 0.8
LIMIT = MU * WEIGHT
WHOLE = 1.5 * LIMIT / (KAPPA * SPRING)
"""Friction of sliding [N], and the slip at which all slides [m]."""


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_first_loading_is_mindlins(way: float) -> None:
    """F = mu N [1 - (1 - x/x_s)^(3/2)], recorded as means over records."""
    shares = np.linspace(0.0, 1.2, 61)
    work = shares - (1.0 - np.maximum(1.0 - shares, 0.0) ** 2.5) / 2.5
    errors = []
    for rings in (8, 16, 32):
        law = cl.Composed(cl.Linear(SPRING), friction=cl.Microslip(MU, KAPPA, rings))
        slipping = resting(HEAVY, velocity=way * 1.2 * WHOLE / 0.06)
        made = -way * run(slipping, law, 0.06, 1e-4, 1e-3).series["friction_force"][1:] / LIMIT
        errors.append(np.abs(made - np.diff(work) / np.diff(shares)))
        # All slides from x_s on, up to the knee.
        assert_allclose(made[-5:], 1.0, rtol=1e-6)
    assert [error.max() for error in errors] == sorted([error.max() for error in errors], reverse=True)
    assert errors[1].max() < 0.02
    assert errors[2].max() < 0.01


def test_the_loop_is_mindlins_and_goes_with_the_cube_of_a_small_amplitude() -> None:
    shares = (0.15, 0.3, 0.6, 1.0)
    closed, friction = [spheres_loss(share) for share in shares], cl.Microslip(MU, KAPPA, 32)
    made = [loss_of_cycle(friction, share * WHOLE, 2) / (LIMIT * WHOLE) for share in shares]
    assert_allclose(made[1:], closed[1:], rtol=0.02)
    order = [np.log(b / a) / np.log(2.0) for a, b in pairwise(made[:3])]
    assert order == pytest.approx([np.log(b / a) / np.log(2.0) for a, b in pairwise(closed[:3])], abs=0.2)
    assert closed[0] == pytest.approx(spheres_friction(shares[0]) ** 3 * 4.8 * 5.0 / 162.0, rel=0.2)


@pytest.mark.parametrize("obliquity", [0.5, 0.9])
def test_a_patch_that_grows_under_an_oblique_force_sticks_everywhere(obliquity: float) -> None:
    """At dx = c dd, c < mu/kappa, every spring has the stretch c (d - p) and F = kappa c N: no loss.

    With D_tt = D_nn/kappa the motion of an impact keeps that ratio, and is reversed.
    """
    mass, mu = 2e-3, 0.4
    slip = 0.1 * obliquity * mu / KAPPA
    before = np.array([-0.1, slip])
    errors = []
    for rings in (8, 16, 32):
        law = cl.Composed(friction=cl.Microslip(mu, KAPPA, rings))
        after = cl.impact(law, np.diag([1.0, 1.0 / KAPPA]) / mass, before).velocity_after.values[0]
        assert after[0] == pytest.approx(0.1, rel=1e-6)
        errors.append(abs(after[1] / slip + 1.0))
    assert errors[1] < 0.01
    assert errors[2] < 0.6 * errors[1] < 0.36 * errors[0]


def test_beyond_that_it_slides_as_a_whole() -> None:
    mass, mu = 2e-3, 0.1
    law = cl.Composed(friction=cl.Microslip(mu, KAPPA))
    after = cl.impact(law, np.diag([1.0, 1.0 / KAPPA]) / mass, [-0.1, 0.1]).velocity_after.values[0]
    assert after[1] == pytest.approx(0.1 - 2.0 * mu / KAPPA * 0.1, rel=1e-5)


def test_an_oblique_impact_is_that_of_a_foundation_of_two_hundred_springs() -> None:
    """Stick, microslip and sliding, also where a damped force is not Hertz's: Popov and Hess (2015)."""
    pair, incidence = ALUMINA_ON_GLASS, np.array([5.0, 12.0, 18.0, 24.0, 40.0])
    friction = cl.Microslip(spheres.FRICTION, pair.stiffness_ratio)
    law = cl.Composed(cl.HertzPoint(pair.hertz), cl.Flores(spheres.RESTITUTION), friction)
    result = spheres.law_predictions(lambda _: law)(incidence)["tangential_restitution"]
    other = spheres.microslip(pair.effective, pair.stiffness_ratio)(incidence)["tangential_restitution"]
    assert_allclose(result, other, atol=1e-3)
