"""What a run may depend on and what it may not, and how it ends when it cannot go on."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from flights import flight_of
from motors import case_a, default_motor, every_law, final, hertz, run

from contactlab.drive import Drive
from contactlab.engine import simulate
from contactlab.laws import ContactLaw, LagrangeStick
from contactlab.trajectory import Ending, Trajectory
from contactlab.variables import CONTACTS, SERIES

STEPS_PER_CALL = "contactlab.engine.simulation.STEPS_PER_CALL"

laws = pytest.mark.parametrize("law", every_law(), ids=lambda law: law.name)


def assert_same_contacts(first: Trajectory, second: Trajectory) -> None:
    """Bit for bit; an equal NaN is equal."""
    for name, column in first.contacts.items():
        np.testing.assert_array_equal(column, second.contacts[name], err_msg=name)


def assert_same_bits(first: Trajectory, second: Trajectory) -> None:
    assert_same_contacts(first, second)
    for name, column in first.series.items():
        np.testing.assert_array_equal(column, second.series[name], err_msg=name)
    assert np.array_equal(first.time, second.time)
    assert np.array_equal(first.contact_mode, second.contact_mode)
    assert first.statistics == second.statistics


@laws
def test_a_run_fills_every_variable_at_every_record(law: ContactLaw) -> None:
    trajectory = run(case_a(), law, 1e-3)
    assert list(trajectory.series) == [v.name for v in SERIES]
    assert list(trajectory.contacts) == [v.name for v in CONTACTS]
    assert {column.shape for column in trajectory.series.values()} == {(101,)}
    assert trajectory.contact_mode.shape == trajectory.time.shape == (101,)
    assert all(np.all(np.isfinite(column)) for column in trajectory.series.values())


@laws
def test_the_same_run_twice_is_the_same_bits(law: ContactLaw) -> None:
    assert_same_bits(run(case_a(), law, 2e-3), run(case_a(), law, 2e-3))


@laws
def test_recording_does_not_change_the_trajectory(law: ContactLaw) -> None:
    runs = [run(case_a(), law, 2e-3, interval) for interval in (1e-5, 0.7e-6, 2e-3)]
    for other in runs[1:]:
        assert_same_contacts(runs[0], other)
        assert other.statistics == runs[0].statistics
        for name in ("rotor_velocity", "tip_slope", "gap", "drive_work", "friction_loss"):
            assert final(other, name) == final(runs[0], name), name


@laws
def test_records_at_the_same_time_are_the_same(law: ContactLaw) -> None:
    coarse, fine = (run(case_a(), law, 1e-3, interval) for interval in (1e-5, 1e-6))
    for name in ("tip_normal_displacement", "tip_slope", "rotor_velocity", "drive_work"):
        both = coarse.series[name], fine.series[name][::10]
        # 10 k fine intervals and k coarse ones may differ in the last bit of time.
        assert both[0] == pytest.approx(both[1], abs=1e-12 * np.abs(both[0]).max()), name
    assert np.array_equal(coarse.contact_mode, fine.contact_mode[::10])


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


@laws
def test_a_shorter_run_is_the_beginning_of_a_longer_one(law: ContactLaw) -> None:
    short, long = (run(case_a(), law, duration) for duration in (1e-3, 2e-3))
    # The last record of the short one may end a step early, no other.
    for name in ("tip_slope", "rotor_velocity", "damping_loss"):
        assert np.array_equal(short.series[name][:-1], long.series[name][:100]), name
    count = len(short.contacts["start_time"]) - 1
    assert count > 0
    assert np.array_equal(
        short.contacts["normal_impulse"][:count], long.contacts["normal_impulse"][:count]
    )


@laws
def test_interrupting_keeps_what_the_run_had(
    law: ContactLaw, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(STEPS_PER_CALL, 50)

    def interrupt(time: float) -> None:
        if time > 0.4e-3:
            raise KeyboardInterrupt

    cut = simulate(case_a(), law, duration=1e-3, record_interval=1e-5, progress=interrupt)
    assert cut.ending is Ending.INTERRUPTED
    assert not cut.complete
    assert "nterrupted" in cut.message
    whole = run(case_a(), law, 1e-3)
    records = cut.time.size
    assert 30 < records < 101
    assert np.array_equal(cut.time, whole.time[:records])
    assert np.array_equal(cut.series["tip_slope"], whole.series["tip_slope"][:records])


def test_a_contact_that_the_end_cuts_is_listed_without_a_separation() -> None:
    cut = run(case_a(), hertz(), 140e-6, 1e-6)
    assert len(cut.contacts["start_time"]) == 1
    assert np.isnan(cut.contacts["separation_velocity"][0])
    reached = cut.contacts["start_time"][0] + cut.contacts["duration"][0]
    assert reached == pytest.approx(140e-6, rel=1e-12)
    assert cut.contact_mode[-1] != 0
    whole = run(case_a(), hertz(), 300e-6, 1e-6)
    assert whole.contacts["separation_velocity"][0] > 0.0
    assert whole.contacts["duration"][0] > cut.contacts["duration"][0]


@laws
@pytest.mark.parametrize(("duration", "interval"), [(1e-3, 3e-4), (1e-3, 1e-3), (7e-4, 1.1e-5)])
def test_the_last_record_lies_at_the_end_whatever_the_interval(
    law: ContactLaw, duration: float, interval: float
) -> None:
    trajectory = run(case_a(), law, duration, interval)
    assert trajectory.time[-1] == duration
    inner = trajectory.time[:-1]
    assert inner == pytest.approx(interval * np.arange(inner.size), rel=1e-14)
    assert 0.0 < duration - inner[-1] <= interval * (1.0 + 1e-6)
    reference = run(case_a(), law, duration, duration)
    assert final(trajectory, "tip_slope") == final(reference, "tip_slope")


@laws
def test_the_mirrored_motor_turns_the_other_way(law: ContactLaw) -> None:
    # Electrodes exchanged: patches, slope, slip and rotor are mirrored, height and gap are not.
    motor = default_motor(initial_velocity=0.2, load_torque=1e-3)
    drive = Drive(motor.drive.frequency, motor.drive.phasors[::-1].copy())
    rotor = replace(motor.rotor, initial_velocity=-0.2, load_torque=-1e-3)
    mirrored = run(replace(motor, drive=drive, rotor=rotor), law, 3e-3)
    original = run(motor, law, 3e-3)
    # Gamma is symmetric to round-off only, which contacts amplify.
    for name, sign in (
        ("tip_normal_displacement", 1.0),
        ("gap", 1.0),
        ("tip_slope", -1.0),
        ("tip_tangential_displacement", -1.0),
        ("slip_velocity", -1.0),
        ("rotor_velocity", -1.0),
        ("normal_force", 1.0),
        ("friction_force", -1.0),
        ("drive_work", 1.0),
    ):
        expected = original.series[name]
        scale = np.abs(expected).max()
        assert sign * mirrored.series[name] == pytest.approx(expected, abs=1e-7 * scale), name


@laws
def test_without_clearance_the_motor_runs(law: ContactLaw) -> None:
    trajectory = run(default_motor(clearance=0.0), law, 2e-3)
    assert len(trajectory.contacts["start_time"]) > 3
    assert abs(final(trajectory, "rotor_velocity")) > 0.01


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


def test_load_torque_turns_the_free_rotor_with_constant_acceleration() -> None:
    motor = default_motor(clearance=1e-3, load_torque=2e-3, initial_velocity=0.3)
    trajectory = run(motor, hertz(), 5e-3)
    time, rate = trajectory.time, 2e-3 / 4.8e-5
    velocity, angle = 0.3 - rate * time, 0.3 * time - 0.5 * rate * time**2
    assert trajectory.series["rotor_velocity"] == pytest.approx(velocity, rel=1e-12, abs=1e-13)
    assert trajectory.series["rotor_angle"] == pytest.approx(angle, rel=1e-11, abs=1e-15)


@pytest.mark.parametrize("damping", [1e-6, 1e-3, 5.0])
def test_damping_slows_the_free_rotor_exponentially(damping: float) -> None:
    torque, start, inertia = 1e-3, -0.7, 4.8e-5
    motor = default_motor(
        clearance=1e-3, rotor_damping=damping, load_torque=torque, initial_velocity=start
    )
    trajectory = run(motor, hertz(), 5e-3)
    settled = -torque / damping
    decayed = np.expm1(-damping / inertia * trajectory.time)
    expected = start + (start - settled) * decayed
    assert trajectory.series["rotor_velocity"] == pytest.approx(expected, rel=1e-12, abs=1e-13)


def test_a_rotor_too_heavy_to_move_is_a_wall_with_a_moving_surface() -> None:
    motor = default_motor(rotor_inertia=1e6, initial_velocity=5.0)
    trajectory = run(motor, hertz(), 2e-3)
    assert trajectory.series["rotor_velocity"] == pytest.approx(5.0, rel=1e-9)
    # The surface is faster than the tip ever is: it slips one way all along.
    friction = trajectory.contacts["friction_impulse"]
    assert friction == pytest.approx(0.3 * trajectory.contacts["normal_impulse"], rel=1e-9)
    assert np.all(trajectory.contacts["stick_duration"] == 0.0)


@laws
@pytest.mark.parametrize(("shapes", "duration"), [(1, 2e-3), (12, 2e-3), (40, 5e-4)])
def test_any_number_of_shapes_runs_and_keeps_its_ledger(
    law: ContactLaw, shapes: int, duration: float
) -> None:
    frequency = 1000.0 if shapes == 1 else 3210.0
    trajectory = run(default_motor(shapes=shapes, frequency=frequency), law, duration)
    assert trajectory.contacts["start_time"].size > 0
    residual = np.abs(trajectory.series["energy_residual"]).max()
    allowed = 1e-8 if law.name == "hertz_penalty" else 1e-3
    assert residual <= allowed * abs(final(trajectory, "drive_work"))


ABSURD = """
import sys
sys.path.insert(0, {tests!r})
import numpy as np
from contactlab.engine import simulate
from contactlab.trajectory import Ending
from motors import default_motor, every_law, hertz

# What overflows on the way is what the ending is about.
np.seterr(all="ignore")
for law in every_law():
    for volts in (1e6, 1e9, 1e15, 1e30, 1e150):
        motor = default_motor(voltage_1=volts, voltage_2=volts)
        result = simulate(motor, law, duration=1e-3, record_interval=1e-5)
        print(law.name, volts, result.ending is Ending.DIVERGED, result.message)
for stiffness in (1e20, 1e100, 1e300):
    motor, law = default_motor(), hertz(stiffness=stiffness)
    result = simulate(motor, law, duration=1e-3, record_interval=1e-5)
    print(law.name, stiffness, result.complete or result.ending is Ending.DIVERGED, "diverges")
"""


def test_absurd_voltages_and_stiffnesses_end_with_a_sentence_and_never_hang() -> None:
    # In a process of its own, so that a hang is a failure and not the end of all tests.
    script = ABSURD.format(tests=str(Path(__file__).parent))
    result = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=120, check=False
    )
    assert result.returncode == 0, result.stderr
    lines = result.stdout.splitlines()
    assert len(lines) == 18
    for line in lines:
        _, _, as_stated, message = line.split(maxsplit=3)
        assert as_stated == "True", line
        assert "diverges" in message


def test_a_diverged_run_holds_what_it_had() -> None:
    with np.errstate(all="ignore"):
        result = simulate(
            default_motor(voltage_1=1e6, voltage_2=1e6),
            hertz(),
            duration=1e-3,
            record_interval=1e-6,
        )
    assert result.ending is Ending.DIVERGED
    assert not result.complete
    assert 0.0 < result.time[-1] < 1e-3
    assert result.series["gap"].shape == result.time.shape


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"duration": 0.0}, "duration is 0.0 s; it must be positive"),
        ({"duration": -1.0}, "duration is -1.0 s"),
        ({"duration": float("nan")}, "duration is nan s"),
        ({"duration": float("inf")}, "duration is inf s; it must be positive and finite"),
        ({"record_interval": 0.0}, "record interval is 0.0 s; it must be positive"),
        ({"record_interval": 2e-3}, "at most the duration, 0.001 s"),
        ({"record_interval": float("nan")}, "record interval is nan s"),
        ({"contact_step": 0.0}, "contact step is 0.0 s"),
        ({"contact_step": float("nan")}, "contact step is nan s"),
        ({"tolerance": 0.0}, "tolerance is 0.0; it must lie between 0 and 1"),
        ({"tolerance": 1.0}, "tolerance is 1.0"),
    ],
)
def test_an_argument_out_of_range_is_refused_with_value_and_bound(
    arguments: dict[str, float], sentence: str
) -> None:
    given = {"duration": 1e-3, "record_interval": 1e-5} | arguments
    with pytest.raises(ValueError, match=sentence):
        simulate(case_a(), hertz(), **given)  # type: ignore[arg-type]


def test_a_rigid_law_refuses_a_tolerance_it_would_ignore() -> None:
    with pytest.raises(ValueError, match="lagrange_stick has no error control"):
        simulate(case_a(), LagrangeStick(0.3), duration=1e-3, record_interval=1e-5, tolerance=1e-6)


def test_a_negative_clearance_is_refused() -> None:
    with pytest.raises(ValueError, match=r"clearance is -1e-06 m; it must not be negative"):
        run(default_motor(clearance=-1e-6), hertz())


def test_an_undamped_mode_that_a_tone_meets_is_refused() -> None:
    frequency = float(default_motor(shapes=4).modes.natural_frequency[0])
    motor = default_motor(mass_damping=0.0, stiffness_damping=0.0, frequency=frequency)
    with pytest.raises(ValueError, match=r"meets mode 1 at .* Hz, which has no damping"):
        run(motor, hertz())
