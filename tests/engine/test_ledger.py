"""The energy ledger closes, its losses are losses, and impulses are what momentum says."""

from functools import cache

import numpy as np
import pytest
from support.motors import PLACEMENT_1, default_motor, every_law, final, hertz, run, total

from contactlab.laws import ContactLaw, LagrangeSlip, LagrangeStick
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
def test_ledger_of_every_law_closes_to_a_thousandth_at_its_default_step(changes: dict[str, float]) -> None:
    for law in laws_of(changes):
        assert largest_residual(ran(changes, law)) <= 1e-3, law.name


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


@motors
def test_damping_always_takes(changes: dict[str, float]) -> None:
    for law in laws_of(changes):
        assert np.all(np.diff(ran(changes, law).series["damping_loss"]) > 0.0), law.name


@motors
def test_friction_of_the_set_valued_laws_never_gives(changes: dict[str, float]) -> None:
    compliant, stick, _ = (ran(changes, law) for law in laws_of(changes))
    loss = compliant.series["friction_loss"]
    # Stick holds the slip at zero only to round-off, far below 1e-13 m/s in the mean.
    assert np.diff(loss).min() >= -1e-13 * total(compliant, "normal_impulse")
    loss = stick.series["friction_loss"]
    # The force is held over the step in which the slip ends, so that the last of it rubs the
    # wrong way: an error of the step like any other.
    assert np.diff(loss).min() >= -1e-6 * abs(loss[-1])


@motors
def test_normal_direction_loses_nothing_in_hertz_and_takes_in_rigid_impacts(
    changes: dict[str, float],
) -> None:
    compliant, *rigid = (ran(changes, law) for law in laws_of(changes))
    assert np.all(compliant.series["contact_loss"] == 0.0)
    assert final(compliant, "contact_energy") >= 0.0
    for trajectory in rigid:
        loss = trajectory.series["contact_loss"]
        # While the contact lasts the gap rate is zero but for the step's error.
        assert np.diff(loss).min() >= -1e-6 * loss[-1]
        assert np.all(trajectory.series["contact_energy"] == 0.0)


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


@pytest.mark.parametrize("interval", [0.5e-6, 1e-6, 1e-5])
@pytest.mark.parametrize("changes", [{}, LOADED, STRONG], ids=["case A", "loaded", "strong"])
def test_recorded_mean_forces_carry_the_contacts_impulses(changes: dict[str, float], interval: float) -> None:
    for law in laws_of(changes):
        trajectory = run(default_motor(**changes), law, 5e-3, interval)
        lengths = np.diff(trajectory.time)
        for force, impulse in (("normal_force", "normal_impulse"), ("friction_force", "friction_impulse")):
            recorded = float((trajectory.series[force][1:] * lengths).sum())
            # A friction impulse is a difference of pushes to both sides.
            scale = np.abs(trajectory.contacts[impulse]).sum()
            assert recorded == pytest.approx(total(trajectory, impulse), abs=1e-12 * scale)


@pytest.mark.parametrize("law", every_law(), ids=lambda law: law.name)
def test_loaded_rotor_keeps_its_momentum_balance(law: ContactLaw) -> None:
    trajectory = ran(LOADED, law)
    gained = 4.8e-5 * (final(trajectory, "rotor_velocity") + 0.9)
    pushed = -25e-3 * total(trajectory, "friction_impulse") - 2e-3 * 5e-3
    pushed -= 1e-4 * final(trajectory, "rotor_angle")
    # Thirty thousand steps of a rigid law, a few bits of the momentum each.
    assert gained == pytest.approx(pushed, abs=5e-11 * 4.8e-5 * 0.9)


@motors
def test_every_contact_stays_inside_the_friction_cone(changes: dict[str, float]) -> None:
    mu = changes.get("friction_coefficient", 0.3)
    for law in laws_of(changes):
        contacts = ran(changes, law).contacts
        bound = mu * contacts["normal_impulse"]
        assert np.all(contacts["normal_impulse"] >= 0.0)
        assert np.all(np.abs(contacts["friction_impulse"]) <= bound * (1.0 + 1e-9))
        assert np.all(contacts["stick_duration"] <= contacts["duration"] * (1.0 + 1e-12))


@motors
def test_contacts_lose_what_friction_and_impacts_took(changes: dict[str, float]) -> None:
    for law in laws_of(changes):
        trajectory = ran(changes, law)
        lost = final(trajectory, "friction_loss") + final(trajectory, "contact_loss")
        scale = np.abs(trajectory.contacts["energy_loss"]).sum()
        assert total(trajectory, "energy_loss") == pytest.approx(lost, abs=1e-12 * scale)
