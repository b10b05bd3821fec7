"""Wear after Archard: the volume worn is (k/H) times the integral of N |v|, and the surface recedes by it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from contactlab.engine import simulate
from contactlab.laws import HertzPenalty
from contactlab.laws.archard import Archard
from contactlab.testing.plants import block, paper_motor, run

MU, STIFFNESS, WEIGHT, MASS = 0.3, 1e10, 5.0, 2e-3


def softness(law: Archard) -> float:
    """Depth worn by a work of N over a way [m/J]."""
    return law.wear_coefficient / (law.hardness * law.apparent_area)


def test_kernels_say_one_thing_of_force_energy_and_wear() -> None:
    """dV/dt = -N gdot - loss along a flow of gap and wear, and where the wear is the contact ends."""
    law = Archard(wear_coefficient=0.5)
    wear, gap, gap_rate, slip, step = 3e-7, -1.2e-6, 0.07, -0.4, 1e-11
    normal, bound, _, loss = law.evaluate("force", depth=-gap, slip=slip, wear=wear)
    assert normal == pytest.approx(STIFFNESS * 0.9e-6**1.5)
    assert bound == pytest.approx(MU * normal)
    worn = law.evaluate("rate", normal=normal, slip=slip)
    assert worn == pytest.approx(softness(law) * normal * abs(slip))
    ahead, behind = (
        law.evaluate("force", depth=-gap - t * gap_rate, slip=slip, wear=wear + t * worn)[2]
        for t in (step, -step)
    )
    assert (ahead - behind) / (2.0 * step) == pytest.approx(-normal * gap_rate - loss, rel=1e-6)
    assert loss == pytest.approx(normal * worn)
    assert law.limits(wear) == (-wear, -wear)


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


def test_contact_of_a_worn_surface_begins_where_the_surface_is() -> None:
    """A block comes down again and again, sliding, and each time later by what it has worn."""
    law = Archard(wear_coefficient=0.1)
    rate = 2.0 * np.pi * 100.0
    motor = block(MASS, gap_rate=-0.05, velocity=0.5, normal_stiffness=MASS * rate**2)
    made = run(motor, law, 1.2e-2, record_interval=1e-6)
    starts = made.contacts["start_time"]
    assert starts.size >= 2
    for start, wear in zip(
        starts[1:], (np.interp(starts[1:], made.time, made.series["internal_wear"])), strict=True
    ):
        gap = np.interp(start, made.time, made.series["gap"])
        assert gap == pytest.approx(-wear, rel=0.05)
        assert wear > 1e-8


def test_without_wear_it_is_hertz_with_coulombs_friction() -> None:
    worn, plain = (
        simulate(paper_motor(), law, duration=1e-3, record_interval=1e-5).series
        for law in (Archard(wear_coefficient=0.0), HertzPenalty())
    )
    scale = np.abs(plain["rotor_velocity"]).max()
    assert_allclose(worn["rotor_velocity"], plain["rotor_velocity"], atol=1e-9 * scale)
    assert np.all(worn["internal_wear"] == 0.0)
