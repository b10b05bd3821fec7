"""What a run may depend on and what it may not, and motions whose course is known in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from support.flights import flight_of
from support.motors import case_a, default_motor, every_law, final, hertz, run

from contactlab.engine import simulate
from contactlab.engine.plant import MODES, TONES
from contactlab.engine.propagator import Workspace
from contactlab.laws import ContactLaw, HertzPenalty
from contactlab.motor import NormalModes
from contactlab.motor.drive import Drive
from contactlab.motor.motor import Motor
from contactlab.trajectory import Trajectory

STEPS_PER_CALL = "contactlab.engine.simulation.STEPS_PER_CALL"
WORKSPACE = "contactlab.engine.preparation._workspace"

laws = pytest.mark.parametrize("law", every_law(), ids=lambda law: law.name)


def assert_same_bits(first: Trajectory, second: Trajectory) -> None:
    for columns, others in ((first.contacts, second.contacts), (first.series, second.series)):
        for name, column in columns.items():
            np.testing.assert_array_equal(column, others[name], err_msg=name)
    assert np.array_equal(first.time, second.time)
    assert np.array_equal(first.contact_mode, second.contact_mode)
    assert first.statistics == second.statistics


@laws
def test_looking_at_progress_does_not_change_the_trajectory(
    law: ContactLaw, monkeypatch: pytest.MonkeyPatch
) -> None:
    undisturbed = run(case_a(), law, 1e-3)
    monkeypatch.setattr(STEPS_PER_CALL, 7)
    seen: list[float] = []
    watched = simulate(case_a(), law, duration=1e-3, record_interval=1e-5, progress=seen.append)
    assert len(seen) > 10
    assert seen == sorted(seen)
    assert seen[-1] == 1e-3
    assert_same_bits(undisturbed, watched)


@pytest.mark.parametrize(("duration", "interval"), [(1e-3, 3e-4), (1e-3, 1e-3), (7e-4, 1.1e-5)])
def test_the_last_record_lies_at_the_end_whatever_the_interval(duration: float, interval: float) -> None:
    trajectory = run(case_a(), hertz(), duration, interval)
    assert trajectory.time[-1] == duration
    inner = trajectory.time[:-1]
    assert inner == pytest.approx(interval * np.arange(inner.size), rel=1e-14)
    assert 0.0 < duration - inner[-1] <= interval * (1.0 + 1e-6)


@laws
@pytest.mark.parametrize("clearance", [0.0, 1e-6])
def test_without_drive_nothing_moves_and_nothing_touches(law: ContactLaw, clearance: float) -> None:
    motor = default_motor(voltage_1=0.0, voltage_2=0.0, clearance=clearance)
    trajectory = run(motor, law, 1e-3)
    assert trajectory.contacts["start_time"].size == 0
    assert np.all(trajectory.series["tip_slope"] == 0.0)
    assert np.all(trajectory.series["rotor_velocity"] == 0.0)
    assert np.all(trajectory.contact_mode == 0)


def test_free_vibration_is_the_closed_solution() -> None:
    # Exact flow: no step of the engine shows, with under- and overdamped modes alike.
    motor = default_motor(clearance=1e-4)
    trajectory = run(motor, hertz(), 5e-3)
    gap, _ = flight_of(motor).at(trajectory.time)
    travel = np.abs(gap - 1e-4).max()
    assert np.abs(trajectory.series["gap"] - gap).max() < 1e-12 * travel


@pytest.mark.parametrize("damping", [0.0, 1e-6, 1e-3, 5.0])
def test_load_and_damping_turn_the_free_rotor(damping: float) -> None:
    torque, start, inertia = 1e-3, -0.7, 4.8e-5
    motor = default_motor(clearance=1e-3, rotor_damping=damping, load_torque=torque, initial_velocity=start)
    trajectory = run(motor, hertz(), 5e-3)
    expected = start - torque / inertia * trajectory.time
    if damping > 0.0:
        decayed = np.expm1(-damping / inertia * trajectory.time)
        expected = start + (start + torque / damping) * decayed
    assert trajectory.series["rotor_velocity"] == pytest.approx(expected, rel=1e-12, abs=1e-13)


def test_a_rotor_too_heavy_to_move_is_a_wall_with_a_moving_surface() -> None:
    motor = default_motor(rotor_inertia=1e6, initial_velocity=5.0)
    trajectory = run(motor, hertz(), 2e-3)
    assert trajectory.series["rotor_velocity"] == pytest.approx(5.0, rel=1e-9)
    # The surface is faster than the tip ever is: it slips one way all along.
    friction = trajectory.contacts["friction_impulse"]
    assert friction == pytest.approx(0.3 * trajectory.contacts["normal_impulse"], rel=1e-9)
    assert np.all(trajectory.contacts["stick_duration"] == 0.0)


def crowded(clearance: float) -> Motor:
    """A motor of 70 coordinates and nine tones: 65 weak modes, none of them still, and the usual four."""
    motor = default_motor(clearance=clearance)
    few, rates = motor.modes, 2.0 * np.pi * np.linspace(2e3, 4e4, 65)
    weak = np.full(65, 0.1)
    modes = NormalModes(
        stiffness=np.append(few.stiffness, rates**2),
        damping=np.append(few.damping, 0.02 * rates),
        coupling=np.vstack([few.coupling, np.outer(weak, few.coupling[0])]),
        tip_displacement=np.append(few.tip_displacement, few.tip_displacement[0] * weak),
        tip_slope=np.append(few.tip_slope, few.tip_slope[1] * weak),
        shape_coupling=few.shape_coupling,
    )
    volts = np.array([60.0, 60.0, *[20.0] * 7, *[10.0] * 8])
    phasors = volts * np.exp(1j * np.add.outer([0.0, 6.0], np.arange(17.0)))
    others = [0.5, 1.5, 3.0, 2.5, 0.75, 1.25, 1.75, 2.25, 2.75, 3.25, 3.5, 3.75, 4.0, 4.25, 4.5]
    frequencies = 3210.0 * np.array([1.0, 2.0, *others])
    return replace(motor, modes=modes, drive=Drive(frequencies, phasors))


@pytest.mark.long
def test_a_motor_beyond_the_usual_room_for_modes_and_tones_runs() -> None:
    motor, law = crowded(1e-6), HertzPenalty()
    assert motor.modes.stiffness.size + 1 == 70 > MODES
    assert motor.drive.frequency.size == 17 > TONES
    trajectory = run(motor, law, 5e-4)
    assert trajectory.contacts["start_time"].size > 0
    residual = np.abs(trajectory.series["energy_residual"]).max()
    assert residual <= 1e-8 * abs(final(trajectory, "drive_work"))
    flight = crowded(1e-4)
    gap, _ = flight_of(flight).at((free := run(flight, law, 5e-4)).time)
    assert np.abs(free.series["gap"] - gap).max() < 1e-11 * np.abs(gap - 1e-4).max()


def test_what_ran_before_changes_no_bit(monkeypatch: pytest.MonkeyPatch) -> None:
    # Runs share the responses of the last motor: each of these differs in what those depend on.
    changes: list[dict[str, float]] = [
        {},
        {"rotor_inertia": 1e-5},
        {"frequency": 3000.0},
        {"shapes": 3},
        {"stiffness_damping": 1e-5},
        {"rotor_radius": 20e-3},
        {"rotor_damping": 1e-4},
        {},
    ]

    def angle(law: ContactLaw, step: float, change: dict[str, float]) -> float:
        values = {"duration": 1e-3, "record_interval": 1e-3, "contact_step": step}
        return final(simulate(default_motor(**change), law, **values), "rotor_angle")

    cases = [(law, step, change) for law in every_law() for step in (1e-7, 2e-7) for change in changes]
    shared = [angle(*case) for case in cases]
    for case, expected in zip(cases, shared, strict=True):
        monkeypatch.setattr(WORKSPACE, Workspace())
        assert angle(*case) == expected, case
