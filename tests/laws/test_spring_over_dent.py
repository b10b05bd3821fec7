"""Mindlin's spring over normal forces whose stiffness jumps where they begin or cease to yield."""

from math import sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose

import contactlab as cl


@pytest.mark.parametrize("share", [0.2, 0.9])
def test_a_spring_over_a_dent_comes_back_as_the_dent_does(share: float) -> None:
    """With D_tt kappa = D_nn spring and contact swing alike: both have the restitution sqrt(k_1/k_2).

    Loading leaves F/N = kappa v_0/u_0 everywhere. Where the stiffness grows from k_1 to k_2 the force stays,
    and the stretch shrinks to k_1/k_2 of it, as the elastic depth does: the same ratio holds until release.
    """
    kappa, mu, approach, mobility = 0.8, 0.5, 0.2, 800.0
    loading, unloading = 1e7, 1.5e7
    slip = share * mu * approach / kappa
    law = cl.Composed(cl.WaltonBraun(loading, unloading), friction=cl.Mindlin(mu, kappa))
    matrix = np.diag([mobility, mobility / kappa])
    made = cl.impact(law, matrix, [-approach, slip], tolerance=1e-11)
    e = sqrt(loading / unloading)
    assert_allclose(made.velocity_after.values[0], [e * approach, -e * slip], rtol=1e-9)


@pytest.mark.parametrize("slip", [0.01, 0.1, 0.3])
def test_no_jump_of_the_stiffness_gives_the_spring_energy(slip: float) -> None:
    matrix = np.array([[900.0, 200.0], [200.0, 1500.0]])
    before = np.array([-0.2, slip])
    for normal in (cl.WaltonBraun(1e7, 4e7), cl.Thornton(yield_pressure=3e8)):
        made = cl.impact(cl.Composed(normal, friction=cl.Mindlin(0.3)), matrix, before)
        after = made.velocity_after.values[0]
        lost = 0.5 * (before @ np.linalg.solve(matrix, before) - after @ np.linalg.solve(matrix, after))
        assert lost > 0.0
        assert_allclose(made.energy_loss, lost, rtol=1e-6)


def test_a_spring_that_slides_over_a_dent_does_not_chatter() -> None:
    """A contact of this motor yields, unloads and yields again a few times, no thousand times at once."""
    motor = ["law=composed", "law/normal=thornton", "law/friction=mindlin", "law.normal.yield_pressure=3e8"]
    made = cl.simulate(cl.build([*motor, "contact.clearance=0.3 um", "solver.duration=4e-3"]))
    assert made.complete, made.message
