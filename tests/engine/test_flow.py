"""A flow takes many starts to the bit where runs take them, and says which broke off and why."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from support.faulty_laws import NoNumber
from support.motors import case_a, default_motor, every_law, hertz

from contactlab.arrays import Array
from contactlab.engine import Flow, Simulator, simulate
from contactlab.laws import ContactLaw, LagrangeStick, MoreauJean, Newton, Poisson, Stronge
from contactlab.laws.composed import Composed
from contactlab.laws.friction import LuGre, Mindlin, Regularised
from contactlab.motor import ModalState, Motor
from contactlab.trajectory import Trajectory

PERIOD = 1.0 / 3210.0

LAWS = [
    *every_law(),
    MoreauJean(),
    Newton(),
    Poisson(),
    Stronge(),
    *(Composed(friction=friction) for friction in (Mindlin(), LuGre(), Regularised())),
]

laws = pytest.mark.parametrize("law", LAWS, ids=lambda law: law.title)


def started(motor: Motor, q: Array, v: Array, rotor_velocity: float) -> Motor:
    rotor = replace(motor.rotor, initial_velocity=rotor_velocity)
    return replace(motor, start=ModalState(q, v), rotor=rotor)


def ended(motor: Motor, law: ContactLaw, duration: float) -> Trajectory:
    return simulate(motor, law, duration=duration, record_interval=duration)


def some_starts(seed: int, count: int) -> tuple[Array, Array, Array]:
    """Motions whose tip moves by 0.5 um and 2 cm/s, about as in the motor's steady state."""
    rng, modes = np.random.default_rng(seed), case_a().modes
    row = modes.tip_displacement / (modes.tip_displacement @ modes.tip_displacement)
    q = 0.5e-6 * row * rng.uniform(-1.0, 1.0, (count, row.size))
    return q, 2e-2 * row * rng.uniform(-1.0, 1.0, (count, row.size)), rng.uniform(-5.0, 5.0, count)


@laws
@settings(max_examples=3)
@given(seed=st.integers(0, 2**32), periods=st.sampled_from([0.3, 1.0, 2.0]))
def test_every_start_ends_where_a_run_from_it_does_to_the_bit(
    law: ContactLaw, seed: int, periods: float
) -> None:
    q, v, rotor = some_starts(seed, 3)
    ends = Flow(Simulator(case_a(), law, periods * PERIOD))(q, v, rotor)
    assert ends.messages == ("", "", "")
    for i in range(3):
        run = ended(started(case_a(), q[i], v[i], rotor[i]), law, periods * PERIOD)
        assert np.array_equal(ends.displacement[i], run.final.displacement)
        assert np.array_equal(ends.velocity[i], run.final.velocity)
        assert ends.rotor_velocity[i] == run.series["rotor_velocity"][-1]


def test_a_start_inside_the_rotor_is_refused_by_a_rigid_law_alone_and_the_others_run() -> None:
    motor = default_motor(clearance=0.0)
    q, v, rotor = some_starts(5, 3)
    # The second tip is pressed in, and lies behind the first and the last.
    inwards = np.sign(motor.modes.tip_displacement)
    q = np.abs(q) * inwards * np.array([[-1.0], [1.0], [-1.0]])
    v = -np.abs(v) * inwards
    for law in (hertz(), LagrangeStick()):
        ends = Flow(Simulator(motor, law, PERIOD))(q, v, rotor)
        rigid = law.name == "lagrange_stick"
        assert [bool(message) for message in ends.messages] == [False, rigid, False]
        assert np.isnan(ends.velocity).any(axis=1).tolist() == [False, rigid, False]
        assert np.isnan(ends.rotor_velocity).tolist() == [False, rigid, False]


def test_a_run_that_breaks_off_says_what_its_own_run_says_and_the_others_reach_their_end() -> None:
    motor, law = default_motor(voltage_1=0.0, voltage_2=0.0), NoNumber()
    q, v, rotor = np.zeros((2, 4)), np.zeros((2, 4)), np.zeros(2)
    v[1] = -1e-2 * motor.modes.tip_displacement
    ends = Flow(Simulator(motor, law, PERIOD))(q, v, rotor)
    assert ends.messages == ("", ended(started(motor, q[1], v[1], 0.0), law, PERIOD).message)
    assert np.array_equal(ends.velocity[0], np.zeros(4))
    assert np.isnan(ends.velocity[1]).all()


@pytest.mark.parametrize("law", [hertz(), Newton(), Composed(friction=LuGre())], ids=lambda law: law.title)
def test_a_flow_forgets_the_starts_of_the_call_before(law: ContactLaw) -> None:
    motor, count = case_a(), 40
    flow = Flow(Simulator(motor, law, PERIOD))
    rest = np.zeros((1, motor.modes.stiffness.size))
    other = np.full((count, rest.size), 1e-8)
    first = flow(rest, rest, np.zeros(1), times=3)
    flow(other, -other, np.full(count, -0.5))
    again = flow(rest, rest, np.zeros(1), times=3)
    assert first.displacement.tobytes() == again.displacement.tobytes()
    assert first.velocity.tobytes() == again.velocity.tobytes()
