"""The rigid reference solver finds a release that begins and ends within one of its steps."""

import pytest
from oracle import solve_rigid_stick
from support.motors import oracle_motor, random_motor


def test_a_release_shorter_than_a_step_is_a_release() -> None:
    # In its fourth contact this motor's normal force falls below zero for less than 1 us.
    motor = oracle_motor(**random_motor(148))
    coarse = solve_rigid_stick(motor, 1.7e-3, contact_step=1e-6)
    fine = solve_rigid_stick(motor, 1.7e-3, contact_step=5e-8)
    assert len(coarse.start_time) == 5
    assert coarse.start_time == pytest.approx(fine.start_time, abs=1e-12)
    assert coarse.normal_impulse == pytest.approx(fine.normal_impulse, rel=1e-8)
    assert coarse.duration[3] + coarse.start_time[3] < coarse.start_time[4]
