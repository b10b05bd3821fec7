"""A run that makes no progress ends, by chatter or by a crawl, and one that makes some does not."""

import numpy as np
import pytest
from support.faulty_laws import RateAndState, Rebound, SignOfSlip
from support.motors import case_a, default_motor, final, hertz

from contactlab.config import build
from contactlab.config.setup import Setup
from contactlab.engine import simulate
from contactlab.laws import Composed, ContactLaw, HertzPenalty, Microslip, Newton
from contactlab.motor import ball
from contactlab.motor.motor import Motor
from contactlab.testing.plants import block
from contactlab.trajectory import Ending, Trajectory

STEPS_PER_CALL = "contactlab.engine.simulation.STEPS_PER_CALL"
STEP_LIMIT = "contactlab.engine.plant.STEP_LIMIT"
EVENT_LIMIT = 1000


def ran(motor: Motor, law: ContactLaw, duration: float, **others: float) -> Trajectory:
    return simulate(motor, law, duration=duration, record_interval=duration, **others)


@pytest.mark.parametrize("voltage", [0.0, 20.0])
def test_a_slow_tone_is_no_chatter_whether_it_moves_anything_or_not(voltage: float) -> None:
    # A second tone of 3 Hz: in one of its periods the first one makes a thousand contacts.
    motor = default_motor(frequency_ratio=1e-3, voltage_2=voltage)
    trajectory = ran(motor, hertz(), 0.3)
    assert trajectory.complete, trajectory.message
    assert trajectory.statistics["touchdowns"] > 0.4 * EVENT_LIMIT


@pytest.mark.parametrize("frequency", [1e3, 2e4])
@pytest.mark.parametrize("steps", [50_000, 97])
def test_a_contact_that_never_comes_to_rest_chatters(
    frequency: float, steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(STEPS_PER_CALL, steps)
    # Pressed on by a weight, it is back within 120 ns, however slow or fast the drive.
    motor = block(2e-3, gap_rate=-0.1, weight=2.0, push_amplitude=1e-3, push_frequency=frequency)
    trajectory = ran(motor, Rebound(), 5e-3, contact_step=5e-8)
    assert trajectory.ending is Ending.CHATTERED
    assert trajectory.time[-1] < 1e-3
    assert trajectory.statistics["touchdowns"] < 20 * EVENT_LIMIT


def test_every_ring_of_a_patch_has_kinks_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(STEP_LIMIT, 400)
    law = Composed(friction=Microslip(rings=24))
    made = ran(default_motor(), law, 5e-4, tolerance=1e-9)
    assert made.complete, made.message
    # In all the contacts of one period of the drive, far more than a force without kinks takes.
    assert made.statistics["contact_steps"] + made.statistics["rejected_steps"] > 800


def bounces(restitution: float, height: float, count: float, law: ContactLaw | None = None) -> Trajectory:
    """A ball that is dropped, until it has fallen so often."""
    duration = np.sqrt(2.0 * height / 9.81) * 2.0 * count
    return ran(ball(0.1, height=height), law or Newton(restitution=restitution), duration)


@pytest.mark.parametrize(("height", "count"), [(0.01, 1_100), (3.0, 1_100), (1e-9, 1_100), (0.01, 20_000)])
def test_an_elastic_ball_bounces_for_ever(height: float, count: int) -> None:
    trajectory = bounces(1.0, height, count)
    assert trajectory.complete, trajectory.message
    speeds = trajectory.contacts["separation_velocity"]
    assert speeds.size == count
    assert speeds == pytest.approx(np.sqrt(2.0 * 9.81 * height), rel=1e-12)


def test_a_ball_on_a_spring_bounces_for_ever() -> None:
    """Neither a weak spring nor a slow, weak push makes its bounces few for their period."""
    hertzian = HertzPenalty(friction_coefficient=0.0)
    for law in (Newton(restitution=1.0), hertzian):
        weak = {"normal_stiffness": 1e-9, "push_amplitude": 1e-9, "push_frequency": 1e-3}
        motor = block(0.1, height=1e-4, weight=0.981, **weak)
        trajectory = ran(motor, law, 1_300.5 * np.sqrt(8.0 * 1e-4 / 9.81))
        assert trajectory.complete, trajectory.message
        assert trajectory.contacts["start_time"].size > 1_200
        assert trajectory.contacts["separation_velocity"][-2] == pytest.approx(np.sqrt(2e-4 * 9.81), rel=1e-6)


@pytest.mark.parametrize("restitution", [0.3, 0.9, 0.99, 0.999])
def test_a_ball_comes_to_rest_after_infinitely_many_bounces(restitution: float) -> None:
    """At sqrt(2 h / g) (1 + e)/(1 - e), but for the last ones."""
    whole = (1.0 + restitution) / (1.0 - restitution)
    trajectory = bounces(restitution, 1.0, 0.55 * whole)
    assert trajectory.complete, trajectory.message
    rests = trajectory.contacts["start_time"][-1]
    assert rests == pytest.approx(whole * np.sqrt(2.0 / 9.81), rel=1e-3 / whole + 2e-4 * (restitution < 0.5))
    assert trajectory.contact_mode[-1] != 0
    assert final(trajectory, "gap") == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("least_speed", [1e-3, 1e-5])
def test_a_contact_that_its_damping_holds_takes_no_more_steps_than_another(least_speed: float) -> None:
    """It relaxes in far less time than the motor moves, and is at rest where force and preload agree."""
    setup = pressed("law/friction=coulomb", "law/damping=flores", "law.damping.restitution=0.2")
    trajectory = setup.with_(f"law.damping.least_speed={least_speed}").run()
    assert trajectory.complete, trajectory.message
    assert steps_of(trajectory) < 400
    assert final(trajectory, "normal_force") == pytest.approx(20.0, rel=0.1)


def test_a_contact_that_creeps_takes_no_more_steps_than_one_that_sticks() -> None:
    """The friction that holds it is found first, and from there that of its creep."""
    creeps, sticks = (pressed(f"law/friction={each}").run() for each in ("rate_and_state", "coulomb"))
    assert creeps.complete, creeps.message
    assert steps_of(creeps) < 2 * steps_of(sticks)
    assert np.abs(creeps.series["slip_velocity"]).max() < 1e-8


def pressed(*choices: str) -> Setup:
    """A motor that is always in contact."""
    parts = "law=composed", "law/normal=linear", "contact.preload=20 N", "rotor.bearing_damping=300"
    return build([*parts, "solver.duration=0.5 ms", *choices])


def steps_of(trajectory: Trajectory) -> int:
    return sum(trajectory.statistics[name] for name in ("contact_steps", "rejected_steps"))


def test_a_contact_on_a_fast_mode_may_take_the_steps_that_the_mode_wants(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(STEP_LIMIT, 5_000)
    mass, fast, slow = 1e-3, 1.6e7, 1e3
    springs = {"normal_stiffness": mass * fast**2, "stiffness": mass * slow**2}
    motor = block(mass, height=-1e-6, weight=10.0, **springs)
    trajectory = ran(motor, HertzPenalty(friction_coefficient=0.0), 2e-4)
    assert trajectory.complete, trajectory.message
    assert steps_of(trajectory) > 5_000 + 2 * int(np.ceil(2.0 * np.pi / slow / 4e-6))


def test_friction_that_jumps_with_the_slip_stalls() -> None:
    trajectory = ran(case_a(), SignOfSlip(), 1e-3)
    assert trajectory.ending is Ending.STALLED
    assert not trajectory.complete


@pytest.mark.parametrize("steps", [50_000, 1_009])
def test_a_law_that_crawls_stalls_after_as_many_steps_however_they_are_cut(
    steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(STEPS_PER_CALL, steps)
    monkeypatch.setattr(STEP_LIMIT, 5_000)
    # Its creep is below the round-off of a slip.
    trajectory = ran(case_a(), RateAndState(), 1e-3, tolerance=1e-11)
    assert trajectory.ending is Ending.STALLED
    limit = 5_000 + 2 * int(np.ceil(1.0 / 6420.0 / 4e-6))
    taken = steps_of(trajectory)
    # Those of the last step are many, as it is tried shorter and shorter.
    assert limit < taken < 2 * limit
