"""Runs of the laws with restitution, and what the time stepping of Moreau and Jean converges to."""

import numpy as np
import pytest

from contactlab.laws import LagrangeStick, MoreauJean, Newton, Poisson, Stronge
from contactlab.testing.plants import MOTOR_DURATION, block, first, paper_motor, run
from contactlab.trajectory import Trajectory

Law = type[Newton] | type[Poisson] | type[Stronge] | type[MoreauJean]


@pytest.mark.parametrize("law", [Newton, Poisson, Stronge], ids=lambda law: law.name)
def test_without_restitution_the_motor_runs_as_with_lagrange_stick(law: Law) -> None:
    motor = paper_motor()
    result, expected = (run(motor, x, MOTOR_DURATION) for x in (law(0.3, 0.0), LagrangeStick(0.3)))
    for name in ("start_time", "normal_impulse", "friction_impulse", "energy_loss"):
        column = expected.contacts[name]
        assert result.contacts[name] == pytest.approx(column, rel=1e-9), name
    assert column.size >= 5


def distance(result: Trajectory, expected: Trajectory) -> float:
    """Root mean square of the relative differences of final velocity, final slope and all impulses."""
    parts = []
    for name in ("rotor_velocity", "tip_slope"):
        parts.append(result.series[name][-1] / expected.series[name][-1] - 1.0)
    for name in ("normal_impulse", "friction_impulse"):
        parts.append(result.contacts[name].sum() / expected.contacts[name].sum() - 1.0)
    return float(np.sqrt(np.mean(np.square(parts))))


def test_moreau_jean_without_restitution_converges_to_lagrange_stick_at_order_one() -> None:
    motor = paper_motor()
    steps = [5e-8 * 2.0**k for k in range(5, -1, -1)]
    reference = run(motor, LagrangeStick(0.3), MOTOR_DURATION, steps[-1] / 64.0)
    runs = [run(motor, MoreauJean(0.3, 0.0), MOTOR_DURATION, h) for h in steps]
    errors = [distance(trajectory, reference) for trajectory in runs]
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    depths = [trajectory.contacts["max_penetration"].max() for trajectory in runs]
    deepening = np.polyfit(np.log(steps), np.log(depths), 1)[0]
    assert 0.7 <= order <= 1.3
    assert 0.7 <= deepening <= 1.3
    assert all(x.contacts["start_time"].size == 5 for x in (reference, *runs))


@pytest.mark.parametrize("e", [0.0, 0.3, 0.5, 0.9])
def test_moreau_jean_penetrates_by_what_the_impact_step_travels(e: float) -> None:
    # The force is held over the step, so the gap rate goes from -v to e v linearly.
    speed, step = 0.2, 1e-7
    ball = block(0.1, height=1e-6, gap_rate=-speed)
    trajectory = run(ball, MoreauJean(0.0, e), 1e-6 / speed + 50.0 * step, step)
    depth = 0.5 * (1.0 - e) * speed * step
    assert first(trajectory, "max_penetration") == pytest.approx(depth, rel=1e-9)
    if e == 0.0:
        # Nothing opens it.
        assert trajectory.series["gap"][-1] == pytest.approx(-depth, rel=1e-9)
        return
    # It lasts whole steps until it is open: (1 - e)/2 v h is covered with e v.
    steps = 1.0 + np.ceil((1.0 - e) / (2.0 * e))
    assert first(trajectory, "duration") == pytest.approx(steps * step, rel=1e-9)
    assert first(trajectory, "separation_velocity") == pytest.approx(e * speed, rel=1e-12)
    assert first(trajectory, "normal_impulse") == pytest.approx(0.1 * (1.0 + e) * speed, rel=1e-9)
    assert trajectory.contacts["start_time"].size == 1
