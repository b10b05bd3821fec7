"""Adhesion after Derjaguin, Muller and Toporov (1975): pull-off, and an impact that costs nothing."""

from math import pi, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from support.normal_balance import forces

from contactlab.laws import Composed, Dmt, HertzPoint, Jkr
from contactlab.testing.closed_forms import restitution
from contactlab.testing.plants import block, first, run

MASS = 2e-3
SPHERE = Dmt(work_of_adhesion=1.0)
PULL_OFF = 2.0 * pi * SPHERE.work_of_adhesion * SPHERE.radius


def test_force_is_hertz_less_a_constant_pull() -> None:
    hertz = HertzPoint(4.0 / 3.0 * SPHERE.effective_modulus * sqrt(SPHERE.radius))
    for depth in (1e-9, 1e-7, 1e-5):
        ours, plain = forces(SPHERE, depth), forces(hertz, depth)
        assert_allclose(ours[0], plain[0] - PULL_OFF, rtol=1e-14)
        assert ours[2:] == plain[2:]
    assert forces(SPHERE, 0.0)[:2] == (-PULL_OFF, 0.0)


def test_it_holds_a_third_more_than_jkr() -> None:
    pull = min(forces(Jkr(work_of_adhesion=1.0), d)[0] for d in np.linspace(-2e-8, 0.0, 2001).tolist())
    assert_allclose(PULL_OFF / -pull, 4.0 / 3.0, rtol=1e-5)


@pytest.mark.parametrize("speed", [1e-3, 1e-2, 1.0])
def test_an_impact_is_elastic_at_every_speed(speed: float) -> None:
    made = run(block(MASS, height=1e-7, gap_rate=-speed), Composed(SPHERE), 1e-7 / speed + 3e-3)
    assert_allclose(restitution(made), 1.0, rtol=1e-6)
    assert first(made, "energy_loss") == pytest.approx(0.0, abs=1e-12 * MASS * speed**2)
    energy = 0.5 * MASS * speed**2

    def left(depth: float) -> float:
        return forces(SPHERE, depth)[1] - energy

    deepest = brentq(left, 1e-8, 1e-4, xtol=1e-18)
    assert_allclose(first(made, "max_penetration"), deepest, rtol=1e-6)
