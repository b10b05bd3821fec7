"""A simulator's runs are those of `simulate`, whatever ran before and whatever it shares with another."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from support.faulty_laws import NoNumber
from support.motors import case_a, default_motor, every_law

import contactlab as cl
from contactlab.engine import Simulator, simulate
from contactlab.laws import ContactLaw, HertzPenalty, Newton
from contactlab.laws.composed import Composed
from contactlab.laws.friction import LuGre, Mindlin
from contactlab.motor import ModalState, Motor, Rotor
from contactlab.trajectory import Trajectory

LAWS = [*every_law(), Newton(), *(Composed(friction=friction) for friction in (Mindlin(), LuGre()))]

DURATION = 8e-4


def content(run: Trajectory) -> dict[str, bytes | str]:
    """All that a run leaves, its state to go on from included."""
    parts = run.series | {f"contacts.{name}": values for name, values in run.contacts.items()}
    parts |= {f"state.{name}": np.asarray(value) for name, value in run.state.items()}
    return {name: values.tobytes() for name, values in parts.items()} | {"message": run.message}


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.title)
def test_every_run_of_a_simulator_is_that_of_simulate_to_the_bit(law: ContactLaw) -> None:
    motor = case_a()
    first = simulate(motor, law, duration=DURATION, record_interval=1e-5)
    later = simulate(motor, law, duration=DURATION, record_interval=1e-5, start=first.state)
    simulator = Simulator(motor, law, DURATION)
    for start, expected in ((None, first), (first.state, later), (None, first)):
        assert content(simulator.run(record_interval=1e-5, start=start)) == content(expected)


def test_a_run_that_fails_leaves_nothing_to_the_next() -> None:
    motor = default_motor(voltage_1=0.0, voltage_2=0.0)
    simulator = Simulator(motor, NoNumber(), DURATION)
    still = simulator.run(record_interval=DURATION)
    thrown = replace(motor, start=ModalState(np.zeros(4), -1e-2 * motor.modes.tip_displacement))
    moving = simulate(thrown, HertzPenalty(), duration=1e-7, record_interval=1e-7)
    failed = simulator.run(record_interval=DURATION, start=moving.state)
    assert not failed.ending.reached_end
    assert content(simulator.run(record_interval=DURATION)) == content(still)
    assert content(simulator.run(record_interval=DURATION, start=moving.state)) == content(failed)


CHANGES = {
    "nothing": lambda motor: motor,
    "phase": lambda motor: replace(motor, drive=cl.Drive.two_mode(100.0, 100.0, 3210.0, 2.0, 0.1)),
    "frequency": lambda motor: replace(motor, drive=cl.Drive.two_mode(100.0, 100.0, 3100.0)),
    "one tone": lambda motor: replace(motor, drive=cl.TwoPhase(frequency=3210.0).drive()),
    "no tone": lambda motor: replace(motor, drive=cl.Drive()),
    "chirp": lambda motor: replace(motor, drive=cl.Chirp(duration=DURATION).drive()),
    "clearance": lambda motor: replace(motor, geometry=replace(motor.geometry, clearance=3e-7)),
    "radius": lambda motor: replace(motor, geometry=replace(motor.geometry, rotor_radius=2e-2)),
    "rotor": lambda motor: replace(motor, rotor=Rotor(3e-5, 1e-6, 1e-3, -0.1)),
    "load": lambda motor: replace(motor, rotor=replace(motor.rotor, load_torque=2e-3)),
    "start": lambda motor: replace(
        motor,
        start=ModalState(np.full(motor.modes.stiffness.size, 1e-9), np.zeros(motor.modes.stiffness.size)),
        rotor=replace(motor.rotor, initial_velocity=0.3),
    ),
    "preload": lambda motor: replace(motor, preload=np.full(motor.modes.stiffness.size, 1e-3)),
    "modes": lambda motor: replace(motor, modes=cl.RitzResonator(shapes=3).modes, preload=None),
}


@pytest.mark.parametrize("law", [HertzPenalty(), Newton(), Composed(friction=LuGre())], ids=lambda x: x.title)
@pytest.mark.parametrize("before", ["nothing", "one tone", "chirp", "preload"])
@pytest.mark.parametrize("change", CHANGES)
def test_what_is_shared_with_another_simulator_changes_no_bit(
    change: str, before: str, law: ContactLaw
) -> None:
    other = CHANGES[before](default_motor())
    used = Simulator(other, law, DURATION)
    used.run(record_interval=DURATION)
    motor: Motor = CHANGES[change](other)
    shares, alone = Simulator(motor, law, 3e-4, like=used), Simulator(motor, law, 3e-4)
    assert shares.ready.plant.tobytes() == alone.ready.plant.tobytes()
    assert shares.ready.signature == alone.ready.signature
    assert content(shares.run(record_interval=1e-4)) == content(alone.run(record_interval=1e-4))


@pytest.mark.parametrize("law", [HertzPenalty(), Composed(friction=LuGre())], ids=lambda law: law.title)
@pytest.mark.parametrize("change", CHANGES)
def test_a_motor_is_made_ready_once_for_all_its_starts(change: str, law: ContactLaw) -> None:
    used = Simulator(default_motor(), law, DURATION)
    used.run(record_interval=DURATION)
    motor: Motor = CHANGES[change](used.motor)
    shares, alone = Simulator(motor, law, DURATION, like=used), Simulator(motor, law, DURATION)
    assert (shares.ready.plant is used.ready.plant) == (change in ("nothing", "start"))
    assert content(shares.run(record_interval=1e-4)) == content(alone.run(record_interval=1e-4))


def test_a_state_that_nobody_has_read_goes_through_pickle() -> None:
    run = simulate(case_a(), HertzPenalty(), duration=DURATION, record_interval=DURATION)
    copied = pickle.loads(pickle.dumps(run.state))
    assert {name: np.asarray(x).tobytes() for name, x in copied.items()} == {
        name: np.asarray(x).tobytes() for name, x in run.state.items()
    }


def test_another_law_than_that_of_the_simulator_shared_with_acts() -> None:
    motor, law, softer = case_a(), HertzPenalty(), HertzPenalty(stiffness=5e9)
    shares = Simulator(motor, softer, DURATION, like=Simulator(motor, law, DURATION))
    expected = simulate(motor, softer, duration=DURATION, record_interval=1e-5)
    assert content(shares.run(record_interval=1e-5)) == content(expected)
