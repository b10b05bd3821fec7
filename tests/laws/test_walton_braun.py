"""The two stiffnesses of Walton and Braun (1986): restitution, loops and dents."""

from math import pi, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose

from contactlab.laws import Composed, WaltonBraun
from contactlab.testing.plants import block, run

MASS, SOFT, STIFF = 2e-3, 1e7, 1.25e7


def test_a_swing_within_the_largest_force_has_one_loop_and_then_none() -> None:
    """From W/2 at rest a weight W swings to 3/2 W, and back and forth along k_2 from there on."""
    weight = 10.0
    start = 0.5 * weight / SOFT
    made = run(
        block(1.0, height=-start, weight=weight), Composed(WaltonBraun(SOFT, STIFF)), 1.5e-2, None, 5e-4
    )
    dent = 0.5 * (1.0 / SOFT - 1.0 / STIFF)
    loss = dent * weight**2 * (1.5**2 - 0.5**2)
    assert made.contacts["start_time"].size == 1
    assert_allclose(made.series["contact_loss"][[5, -1]], loss, rtol=1e-7)
    rate, turn = sqrt(STIFF), pi / sqrt(SOFT)
    # Turned at 3/2 W after half a swing on k_1.
    low = 1.5 * weight / SOFT - 0.5 * weight / STIFF
    assert_allclose(
        made.series["gap"][-1], -low - 0.5 * weight / STIFF * np.cos(rate * (1.5e-2 - turn)), rtol=1e-6
    )


def test_a_dent_is_met_again_where_it_is_and_a_clear_gap_forgets_it() -> None:
    deep, shallow = 4e-6, 1e-6
    law, mass, rate = Composed(WaltonBraun(SOFT, STIFF)), 1e6, 2.0 * pi * 1e3
    stiffness = mass * rate**2
    # In and out by `deep` about a gap of zero: every way in is on fresh material.
    clear = run(block(mass, height=deep, normal_stiffness=stiffness), law, 2e-3)
    loss = 0.5 * (SOFT * deep) ** 2 * (1.0 / SOFT - 1.0 / STIFF)
    assert_allclose(clear.contacts["energy_loss"], loss, rtol=1e-6)
    dent = deep * (1.0 - SOFT / STIFF)
    # Acos(-dent/deep) is where it leaves.
    assert_allclose(clear.contacts["duration"], (pi - np.arcsin(dent / deep)) / rate, rtol=1e-6)
    # Between a touch and `deep`: it leaves the dent, does not clear it, and meets it again.
    made = run(
        block(mass, height=-0.1 * shallow, weight=stiffness * 0.5 * deep, normal_stiffness=stiffness),
        law,
        2.7e-3,
    )
    top = deep - 0.1 * shallow
    assert made.contacts["start_time"].size == 3
    assert_allclose(made.contacts["energy_loss"][1:], 0.0, atol=1e-9 * loss)
    assert_allclose(made.contacts["internal_largest_depth"], top, rtol=1e-6)


def test_an_unloading_that_would_give_energy_is_refused() -> None:
    with pytest.raises(ValueError, match="must be at least loading_stiffness"):
        WaltonBraun(2e7, 1e7)
