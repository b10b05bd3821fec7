"""What no force depends on is no part of the state: free coordinates, and the velocity of a belt."""

import numpy as np

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
