"""The energy ledger closes, its losses are losses, and impulses are what momentum says."""

from functools import cache

import numpy as np
import pytest
from support.motors import PLACEMENT_1, default_motor, every_law, final, hertz, run

from contactlab.engine import simulate
from contactlab.laws import (
    Composed,
    ContactLaw,
    Coulomb,
    HertzPoint,
    LagrangeSlip,
    LagrangeStick,
    LinearDamping,
    Prony,
)
from contactlab.motor import ball, oscillator
from contactlab.trajectory import Trajectory

LOADED = {"load_torque": 2e-3, "rotor_damping": 1e-4, "initial_velocity": -0.9, "clearance": 0.0}
STRONG = {"voltage_1": 400.0, "voltage_2": 300.0, "friction_coefficient": 0.8}
MOTORS = {
    "case A": {},
    "loaded": LOADED,
    "strong": STRONG,
    "placement 1": {**PLACEMENT_1, "frequency": 2019.9},
    "twelve shapes": {"shapes": 12},
}

motors = pytest.mark.parametrize("changes", MOTORS.values(), ids=MOTORS.keys())


@cache
def _run(items: tuple[tuple[str, float], ...], law: ContactLaw, duration: float) -> Trajectory:
    return run(default_motor(**dict(items)), law, duration)


def ran(changes: dict[str, float], law: ContactLaw, duration: float = 5e-3) -> Trajectory:
    return _run(tuple(changes.items()), law, duration)


def laws_of(changes: dict[str, float]) -> list[ContactLaw]:
    return every_law(changes.get("friction_coefficient", 0.3))


def largest_residual(trajectory: Trajectory) -> float:
    """Largest residual of a run as a share of the drive's work."""
    residual = np.abs(trajectory.series["energy_residual"]).max()
    return float(residual / abs(final(trajectory, "drive_work")))


@motors
def test_ledger_of_hertz_closes_to_a_billionth_of_the_drive_work_after_20_ms(
    changes: dict[str, float],
) -> None:
    law = laws_of(changes)[0]
    assert largest_residual(ran(changes, law, 20e-3)) <= 1e-9


@motors
@pytest.mark.parametrize("law", [LagrangeStick, LagrangeSlip], ids=lambda law: law.name)
def test_residual_of_a_rigid_law_falls_with_its_step(
    changes: dict[str, float], law: type[LagrangeStick] | type[LagrangeSlip]
) -> None:
    mu = changes.get("friction_coefficient", 0.3)
    motor = default_motor(**changes)
    steps = (4e-7, 1e-7, 2.5e-8)
    residuals = [largest_residual(run(motor, law(mu), contact_step=h)) for h in steps]
    # First order would be a factor of four a step; twice is what a falling one shows at least.
    assert residuals[1] < 0.5 * residuals[0]
    assert residuals[2] < 0.5 * residuals[1]


@motors
def test_energy_is_that_of_the_recorded_motion(changes: dict[str, float]) -> None:
    # The ledger's states must be the dataset's: rotor and contact energy from other columns.
    trajectory = ran(changes, laws_of(changes)[0])
    s = trajectory.series
    stored = 0.4 * 1e10 * np.maximum(-s["gap"], 0.0) ** 2.5
    assert s["contact_energy"] == pytest.approx(stored, rel=1e-12, abs=1e-30)
    rotor = 0.5 * 4.8e-5 * s["rotor_velocity"] ** 2
    assert np.all(s["kinetic_energy"] >= rotor * (1.0 - 1e-14))
    assert s["kinetic_energy"][0] == pytest.approx(rotor[0], rel=1e-14)


def test_slip_only_friction_creates_energy_where_friction_is_strong() -> None:
    # mu^2 D_tt > D_nn: the reversed slip carries away more than the old one brought.
    loss = final(ran(STRONG, LagrangeSlip(0.8)), "friction_loss")
    assert loss < -0.1 * final(ran(STRONG, LagrangeSlip(0.8)), "drive_work")
    assert final(ran(STRONG, LagrangeStick(0.8)), "friction_loss") > 0.0


@pytest.mark.parametrize("clearance", [1e-3, 1e-6])
def test_an_undamped_frictionless_motor_conserves_the_work_of_its_drive(clearance: float) -> None:
    # Off resonance, where the steady state does not dwarf what there is.
    motor = default_motor(mass_damping=0.0, stiffness_damping=0.0, clearance=clearance, frequency=2500.0)
    trajectory = run(motor, hertz(0.0), 5e-3)
    assert (trajectory.contacts["start_time"].size > 5) == (clearance < 1e-4)
    s = trajectory.series
    energy = s["kinetic_energy"] + s["strain_energy"] + s["contact_energy"]
    assert np.abs(energy - s["drive_work"]).max() <= 1e-9 * energy.max()


def test_what_a_lining_still_stores_in_flight_is_in_the_ledger() -> None:
    """The arms are stretched where the ball leaves, and relax while it flies."""
    lining = Composed(Prony(relaxed_stiffness=1e6, first_stiffness=4e6, first_time=2e-5))
    result = simulate(ball(1e-3, height=1e-6, gravity=9.81), lining, duration=2e-3, record_interval=1e-6)
    assert result.series["contact_energy"][result.contact_mode == 0].max() > 1e-2 * final(result, "load_work")
    assert result.complete, result.message


@pytest.mark.parametrize("restitution", [0.3, 0.09])
def test_elastic_energy_that_a_damping_outweighs_is_lost_as_exactly_as_the_tolerance_says(
    restitution: float,
) -> None:
    # The bodies part with a spring that is still compressed: no force is left that would shorten a step.
    damping = LinearDamping(restitution, effective_mass=1.0, impact_speed=0.5)
    law = Composed(HertzPoint(1e8), damping, Coulomb(0.0))
    motor = oscillator(1.0, 1e4, gap=1e-4, force=6.0, frequency=20.0, velocity=0.5)
    ran = simulate(motor, law, duration=0.06, record_interval=1e-5, contact_step=2e-3, tolerance=1e-7)
    force, depth = ran.series["normal_force"], -ran.series["gap"]
    assert np.count_nonzero((force == 0.0) & (depth > 1e-5)) > 10
    assert np.abs(ran.series["energy_residual"]).max() < 1e-7 * 0.125
