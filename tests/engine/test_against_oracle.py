"""Other motors than the reference case end where the independent event-driven solver ends."""

from functools import cache

import numpy as np
import pytest
from oracle import OracleRun, solve_hertz, solve_rigid_stick
from support.command_line import cases
from support.motors import PLACEMENT_1, default_motor, final, hertz, oracle_motor, run, total

from contactlab.laws import LagrangeStick
from contactlab.trajectory import Trajectory

DURATION = 3e-3

MOTORS: dict[str, dict[str, float]] = {
    "placement 1 at its first frequency": {
        **PLACEMENT_1,
        "frequency": 2019.9,
        "clearance": 0.5e-6,
        "phase": 0.4,
    },
    "no clearance, loaded and damped, turning backwards": {
        "clearance": 0.0,
        "load_torque": 2e-3,
        "rotor_damping": 1e-4,
        "initial_velocity": -0.9,
    },
    "high voltages and friction": {"voltage_1": 400.0, "voltage_2": 300.0, "friction_coefficient": 0.8},
    "ratio three to two, six shapes, slippery": {
        "frequency": 3000.0,
        "frequency_ratio": 1.5,
        "phase": 1.0,
        "friction_coefficient": 0.1,
        "shapes": 6,
    },
    "five shapes, far away, at their first frequency": {
        "shapes": 5,
        "frequency": 2900.0,
        "clearance": 2e-6,
        "voltage_1": 180.0,
        "phase": 0.7,
        "friction_coefficient": 0.5,
    },
    "three shapes, second tone at the second frequency": {
        "shapes": 3,
        "frequency": 2750.0,
        "voltage_1": 150.0,
        "voltage_2": 60.0,
        "load_torque": -1e-3,
        "clearance": 0.3e-6,
    },
    "one tone for both, patches in between, fast rotor": {
        "patch_start": 5e-3,
        "patch_end": 14e-3,
        "frequency": 2600.0,
        "frequency_ratio": 1.0,
        "initial_velocity": 3.0,
        "rotor_damping": 5e-4,
    },
    "pressed together at rest, soft contact": {"clearance": -0.3e-6, "load_torque": 1e-3},
    "small light rotor, short tip, light damping": {
        "rotor_radius": 10e-3,
        "tip_length": 12e-3,
        "rotor_inertia": 4e-6,
        "mass_damping": 60.0,
        "stiffness_damping": 4e-6,
        "phase": -2.0,
    },
}

STIFFNESSES = (1e10, 1e10, 3e9, 1e9, 5e10, 2e10, 1e10, 1e9, 1e11)

SHORT = (
    "no clearance, loaded and damped, turning backwards",
    "high voltages and friction",
    "one tone for both, patches in between, fast rotor",
    "pressed together at rest, soft contact",
    "small light rotor, short tip, light damping",
)

motors = pytest.mark.parametrize("name", cases(MOTORS, SHORT))
rigid_motors = pytest.mark.parametrize(
    "name", cases([name for name, changes in MOTORS.items() if changes.get("clearance", 0.0) >= 0.0], SHORT)
)


def friction_of(changes: dict[str, float]) -> float:
    return changes.get("friction_coefficient", 0.3)


@cache
def rigid_reference(name: str) -> OracleRun:
    return solve_rigid_stick(oracle_motor(**MOTORS[name]), DURATION)


@cache
def rigid_run(name: str, contact_step: float) -> Trajectory:
    law = LagrangeStick(friction_of(MOTORS[name]))
    return run(default_motor(**MOTORS[name]), law, DURATION, contact_step=contact_step)


def assert_ends_agree(trajectory: Trajectory, reference: OracleRun, tolerance: float) -> None:
    """Same end, as a share of how far each quantity went."""
    for name, expected in (
        ("rotor_velocity", reference.rotor_velocity),
        ("rotor_angle", reference.rotor_angle),
        ("tip_normal_displacement", reference.u),
        ("tip_slope", reference.theta),
        ("drive_work", reference.drive_work),
        ("damping_loss", reference.damping_loss),
        ("load_work", reference.load_work),
        ("friction_loss", reference.friction_loss),
        ("kinetic_energy", reference.kinetic_energy),
        ("strain_energy", reference.strain_energy),
    ):
        travel = np.abs(trajectory.series[name]).max()
        assert final(trajectory, name) == pytest.approx(expected, abs=tolerance * travel), name


def assert_contacts_agree(trajectory: Trajectory, reference: OracleRun, tolerance: float) -> None:
    """Same contacts one by one, as a share of the largest."""
    contacts = trajectory.contacts
    assert len(contacts["start_time"]) == len(reference.start_time)
    if not len(reference.start_time):
        return
    for name in ("normal_impulse", "friction_impulse", "peak_normal_force"):
        expected = getattr(reference, name)
        largest = np.abs(expected).max()
        assert contacts[name] == pytest.approx(expected, abs=tolerance * largest), name
    for name in ("start_time", "duration", "stick_duration"):
        assert contacts[name] == pytest.approx(getattr(reference, name), abs=1e-9), name


@motors
def test_hertz_ends_where_the_oracle_ends(name: str) -> None:
    changes, stiffness = MOTORS[name], STIFFNESSES[list(MOTORS).index(name)]
    law = hertz(friction_of(changes), stiffness)
    trajectory = run(default_motor(**changes), law, DURATION, 1e-6)
    reference = solve_hertz(oracle_motor(**changes), stiffness, DURATION)
    assert len(reference.start_time) >= 4
    # Both are good to about 1e-9; contacts amplify it.
    assert_ends_agree(trajectory, reference, 1e-7)
    assert_contacts_agree(trajectory, reference, 1e-6)
    peaks = stiffness * trajectory.contacts["max_penetration"] ** 1.5
    largest = reference.peak_normal_force.max()
    assert peaks == pytest.approx(reference.peak_normal_force, abs=1e-5 * largest)


@rigid_motors
def test_rigid_stick_makes_the_contacts_of_the_oracle(name: str) -> None:
    fine, reference = rigid_run(name, 2.5e-8), rigid_reference(name)
    assert len(fine.contacts["start_time"]) == len(reference.start_time)
    assert total(fine, "normal_impulse") == pytest.approx(reference.normal_impulse.sum(), rel=1e-3)


@rigid_motors
def test_rigid_stick_tends_to_the_oracle_with_first_order(name: str) -> None:
    reference, steps = rigid_reference(name), (2e-7, 1e-7, 5e-8, 2.5e-8)
    for quantity, exact in (
        ("rotor_velocity", reference.rotor_velocity),
        ("normal_impulse", float(reference.normal_impulse.sum())),
    ):
        runs = [rigid_run(name, h) for h in steps]
        measure = final if quantity == "rotor_velocity" else total
        errors = np.array([measure(r, quantity) - exact for r in runs])
        order = np.polyfit(np.log(steps), np.log(np.abs(errors)), 1)[0]
        assert order > 0.8, (quantity, errors)
        # Extrapolated, the first-order part is gone.
        assert abs(2.0 * errors[-1] - errors[-2]) < 0.3 * abs(errors[-1]), (quantity, errors)
