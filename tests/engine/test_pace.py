"""A run that makes no progress ends, by chatter or by a crawl, and one that makes some does not."""

import numpy as np
import pytest
from support.faulty_laws import RateAndState, Rebound, SignOfSlip, Sound
from support.motors import case_a, default_motor, hertz

from contactlab.engine import simulate
from contactlab.engine.plant import motion_rate, plant_of
from contactlab.laws import ContactLaw
from contactlab.motor import NormalModes
from contactlab.motor.drive import Drive
from contactlab.motor.motor import Motor
from contactlab.testing.plants import block
from contactlab.trajectory import Ending, Trajectory

STEPS_PER_CALL = "contactlab.engine.simulation.STEPS_PER_CALL"
STEP_LIMIT = "contactlab.engine.plant.STEP_LIMIT"
EVENT_LIMIT = 1000


def ran(motor: Motor, law: ContactLaw, duration: float) -> Trajectory:
    return simulate(motor, law, duration=duration, record_interval=duration)


@pytest.mark.parametrize("voltage", [0.0, 20.0])
def test_a_slow_tone_is_no_chatter_whether_it_moves_anything_or_not(voltage: float) -> None:
    # A second tone of 3 Hz: in one of its periods the first one makes a thousand contacts.
    motor = default_motor(frequency_ratio=1e-3, voltage_2=voltage)
    trajectory = ran(motor, hertz(), 0.3)
    assert trajectory.complete, trajectory.message
    assert trajectory.statistics["touchdowns"] > 0.4 * EVENT_LIMIT
    assert trajectory.statistics["friction_switches"] > 0.4 * EVENT_LIMIT


def test_the_window_is_that_of_what_drives() -> None:
    fastest = 2.0 * np.pi * 6420.0
    assert motion_rate(plant_of(case_a())) == pytest.approx(fastest)
    for changes in ({"frequency_ratio": 1e-3}, {"frequency_ratio": 1e3, "voltage_2": 0.0}):
        rate = motion_rate(plant_of(default_motor(**changes)))
        assert rate == pytest.approx(2.0 * np.pi * 3210.1, rel=1e-3)
    # Without a drive a motor's slowest mode, and a body without springs nothing.
    slowest = float(np.sqrt(case_a().modes.stiffness[0]))
    silent = default_motor(voltage_1=0.0, voltage_2=0.0)
    assert motion_rate(plant_of(silent)) == pytest.approx(slowest)
    assert motion_rate(plant_of(block())) == 0.0


@pytest.mark.parametrize("frequency", [1e3, 2e4])
@pytest.mark.parametrize("steps", [50_000, 97])
def test_a_contact_that_never_comes_to_rest_chatters(
    frequency: float, steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(STEPS_PER_CALL, steps)
    # Pressed on by a weight, it is back within 120 ns, however slow or fast the drive.
    motor = block(2e-3, gap_rate=-0.1, weight=2.0, push_amplitude=1e-3, push_frequency=frequency)
    trajectory = ran(motor, Rebound(), 5e-3)
    assert trajectory.ending is Ending.CHATTERED
    assert "chatters" in trajectory.message
    assert trajectory.time[-1] < 1e-3
    assert trajectory.statistics["touchdowns"] < 20 * EVENT_LIMIT


def test_friction_that_jumps_with_the_slip_stalls() -> None:
    trajectory = ran(case_a(), SignOfSlip(), 1e-3)
    assert trajectory.ending is Ending.STALLED
    assert not trajectory.complete
    assert "stalls" in trajectory.message


def test_a_stall_where_a_slow_tone_takes_the_gaps_digits_is_not_blamed_on_the_law() -> None:
    # A hundredth of a hertz on a mode without stiffness: hardly a motion, and a steady state of metres.
    still = case_a()
    modes = NormalModes(
        stiffness=np.append(still.modes.stiffness, 0.0),
        damping=np.append(still.modes.damping, 0.0),
        coupling=np.vstack([still.modes.coupling, [[1e-2, 0.0]]]),
        tip_displacement=np.append(still.modes.tip_displacement, 1.0),
        tip_slope=np.append(still.modes.tip_slope, 0.0),
        shape_coupling=still.modes.shape_coupling,
    )
    tones = np.append(still.drive.frequency, 1e-2)
    drive = Drive(tones, np.hstack([still.drive.phasors, [[1.0], [0.0]]]))
    trajectory = ran(Motor(modes, drive, still.geometry, still.rotor), SignOfSlip(), 1e-3)
    assert trajectory.ending is Ending.STALLED
    assert "moves the tip by 2.53 m" in trajectory.message


@pytest.mark.parametrize("steps", [50_000, 1_009])
def test_a_law_that_crawls_stalls_after_as_many_steps_however_they_are_cut(
    steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(STEPS_PER_CALL, steps)
    monkeypatch.setattr(STEP_LIMIT, 5_000)
    trajectory = ran(case_a(), RateAndState(), 1e-3)
    assert trajectory.ending is Ending.STALLED
    limit = 5_000 + 2 * int(np.ceil(1.0 / 6420.0 / 4e-6))
    assert f"more than {limit} steps in contact" in trajectory.message
    taken = sum(trajectory.statistics[name] for name in ("contact_steps", "rejected_steps"))
    # Those of the last step are many, as it is tried shorter and shorter.
    assert limit < taken < 1.2 * limit


def test_a_sound_law_is_far_from_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = ran(case_a(), Sound(), 5e-3)
    monkeypatch.setattr(STEP_LIMIT, 500)
    watched = ran(case_a(), Sound(), 5e-3)
    assert watched.complete
    assert np.array_equal(watched.contacts["normal_impulse"], whole.contacts["normal_impulse"])


def test_a_silent_drive_and_none_are_the_same_to_the_pace() -> None:
    none = Drive(np.empty(0), np.empty((2, 0), dtype=np.complex128))
    motor = case_a()
    rate = motion_rate(plant_of(Motor(motor.modes, none)))
    assert rate == motion_rate(plant_of(default_motor(voltage_1=0.0, voltage_2=0.0)))
