"""What no force depends on is no part of the state: free coordinates, and the velocity of a belt."""

import numpy as np
import pytest

import contactlab as cl
from contactlab.steady_state.period_map import PeriodMap
from contactlab.steady_state.search import steady_setup


def test_a_free_coordinate_and_a_belt_are_no_part_of_the_state() -> None:
    motor = cl.oscillator(1.0, 1.0, gap=0.1, force=1.0, frequency=2.8 / (2.0 * np.pi))
    assert motor.slides_freely.tolist() == [False, True]
    section = PeriodMap(steady_setup(motor, cl.Newton(restitution=0.8)))
    assert section.belt == motor.belt_velocity == 0.0
    state = section.state_of(cl.ModalState(np.array([1.0, 2.0]), np.array([3.0, 4.0])), 0.0)
    assert state[1:].tolist() == [3.0, 4.0]
    assert state.size == 3


def test_the_rotor_of_a_motor_is_no_belt() -> None:
    motor = cl.build().motor
    assert motor.belt_velocity is None
    assert not motor.slides_freely.any()


def test_an_oscillator_with_a_stop_has_the_multipliers_and_the_branch_of_one_impact_a_period() -> None:
    """An undamped motion of one impact has det J = e^2; off resonance both multipliers have the modulus e."""
    restitution, stiffness, force, omega = 0.8, 1e4, 20.0, 2.0 * np.pi * 18.0
    gap = 0.3 * force / abs(stiffness - omega**2)
    motor = cl.oscillator(1.0, stiffness, gap=gap, force=force, frequency=omega / (2.0 * np.pi))
    law = cl.Newton(restitution=restitution)
    branch = cl.branch(motor, "contact.clearance", gap, 3.0 * gap, law=law)
    assert not any(point.mark for point in branch.points)
    for point in branch.points:
        assert point.orbit.stable
        # Friction stops the slip in every impact.
        assert np.abs(point.orbit.multipliers) == pytest.approx([restitution, restitution, 0.0], abs=1e-6)
