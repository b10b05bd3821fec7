"""Wear after Archard: the volume worn is (k/H) times the integral of N |v|."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from contactlab.engine import simulate
from contactlab.laws.archard import Archard
from contactlab.testing.plants import block, paper_motor, run

MU, STIFFNESS, WEIGHT, MASS = 0.3, 1e10, 5.0, 2e-3


def softness(law: Archard) -> float:
    """Depth worn by a work of N over a way [m/J]."""
    return law.wear_coefficient / (law.hardness * law.apparent_area)


def test_a_block_with_a_constant_weight_wears_linearly_in_the_way() -> None:
    """W = k N s / H: N is the weight, s the way of a belt under a block that a spring holds."""
    law, speed, spring = Archard(friction_coefficient=MU, wear_coefficient=1e-3), 0.5, 1e6
    depth = (WEIGHT / STIFFNESS) ** (2 / 3)
    motor = block(
        MASS,
        height=-depth,
        gap_rate=-softness(law) * WEIGHT * speed,
        weight=WEIGHT,
        way=MU * WEIGHT / spring,
        stiffness=spring,
        belt_velocity=speed,
    )
    series = run(motor, law, 2e-3, record_interval=1e-4).series
    ways = speed * 1e-4 * np.arange(21)
    assert_allclose(series["internal_wear"], softness(law) * WEIGHT * ways, rtol=1e-7)
    # The gap follows the surface that recedes.
    assert_allclose(series["gap"], -depth - series["internal_wear"], atol=1e-7 * depth)
    assert series["internal_wear"][-1] > 0.3 * depth


@pytest.mark.parametrize(("tolerance", "close"), [(None, 1e-4), (1e-11, 5e-6)])
def test_a_motor_wears_by_the_work_of_its_friction(tolerance: float | None, close: float) -> None:
    """A w = (k/H) int N |v| dt, by what friction loses and by the recorded series.

    Both would agree to round-off but for steps in which the slip reverses: |v| has its kink there, and the
    nodes behind it are not taken but have their say.
    """
    law = Archard(wear_coefficient=1e-2)
    simulated = simulate(paper_motor(), law, duration=3e-3, record_interval=1e-7, tolerance=tolerance)
    series = simulated.series
    wear = series["internal_wear"]
    assert_allclose(wear[-1], softness(law) / MU * series["friction_loss"][-1], rtol=close)
    slips = np.abs(series["slip_velocity"])
    recorded = np.sum(series["normal_force"][1:] * 0.5 * (slips[1:] + slips[:-1])) * 1e-7
    assert_allclose(wear[-1], softness(law) * recorded, rtol=1e-4)
    # What was pressed and has worn off.
    worn_off = np.sum(series["normal_force"][1:] * np.diff(wear))
    assert_allclose(series["contact_loss"][-1], worn_off, rtol=1e-3)
    residual = np.abs(series["energy_residual"]).max()
    assert residual < 1e-6 * series["drive_work"].max()
