"""Friction that remembers: what is kept within a contact, what ends with it, and where its energy is."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import pytest
from numpy.testing import assert_allclose

from contactlab.compiled import kernel
from contactlab.engine import simulate
from contactlab.laws.base import ELASTOPLASTIC, Friction
from contactlab.laws.composed import Composed
from contactlab.laws.declaration import FRICTION_COEFFICIENT
from contactlab.laws.friction import ElastoPlastic, LuGre, Mindlin
from contactlab.laws.memory import ODD, InternalVariable
from contactlab.laws.normal import Linear
from contactlab.testing.contract import PROPERTIES, check
from contactlab.testing.plants import Bench, block, paper_motor, run

WEIGHT, STIFFNESS, MU = 10.0, 1e7, 0.3

REMEMBERING = pytest.mark.parametrize(
    "friction", [Mindlin(), LuGre(), ElastoPlastic()], ids=lambda friction: friction.name
)

mindlin_state = Mindlin().state


def test_the_energy_of_a_stretched_spring_is_stored_and_not_lost() -> None:
    """A block swings on Mindlin's spring without sliding: contact energy 1/2 k_t z^2, no friction loss."""
    ratio = 0.5
    law = Composed(Linear(STIFFNESS), friction=Mindlin(MU, ratio))
    period = 2.0 * np.pi / np.sqrt(ratio * STIFFNESS)
    push = 0.4 * MU * WEIGHT
    motor = block(1.0, height=-WEIGHT / STIFFNESS, weight=WEIGHT, push=push)
    series = run(motor, law, 2.0 * period, 1e-5, period / 64.0).series
    rate = np.sqrt(ratio * STIFFNESS)
    time = np.arange(series["gap"].size) * period / 64.0
    way = push / (ratio * STIFFNESS) * (1.0 - np.cos(rate * time))
    held = 0.5 * ratio * STIFFNESS * way**2
    pressed = 0.5 * WEIGHT**2 / STIFFNESS
    assert_allclose(series["contact_energy"] - pressed, held, atol=1e-6 * held.max())
    assert np.abs(series["friction_loss"]).max() < 1e-6 * held.max()


@REMEMBERING
def test_every_touch_down_begins_without_memory(friction: Friction) -> None:
    """Two equal throws: the second contact is the first, though the first has stretched its spring."""
    law = Composed(Linear(STIFFNESS), friction=friction)
    mass, speed = 2e-3, 0.1
    rate = 2.0 * np.pi * 40.0

    def thrown(velocity: float) -> dict[str, np.ndarray]:
        motor = block(mass, gap_rate=-speed, velocity=velocity, normal_stiffness=mass * rate**2)
        return run(motor, law, 0.03, 1e-6).contacts

    contacts = thrown(0.02)
    assert contacts["start_time"].size > 1
    # What comes down the second time has the slip that the first contact left.
    again = thrown(0.02 + contacts["friction_impulse"][0] / mass)
    assert_allclose(contacts["friction_impulse"][1], again["friction_impulse"][0], rtol=1e-6)


@REMEMBERING
def test_ledger_of_friction_that_remembers_closes(friction: Friction) -> None:
    law = Composed(friction=friction)
    series = simulate(paper_motor(), law, duration=5e-3, record_interval=1e-6).series
    assert np.abs(series["energy_residual"]).max() < 1e-8 * series["drive_work"].max()
    assert series["friction_loss"][-1] > 0.0


@REMEMBERING
def test_records_do_not_change_the_motion(friction: Friction) -> None:
    law = Composed(friction=friction)
    coarse = simulate(paper_motor(), law, duration=2e-3, record_interval=1e-3)
    fine = simulate(paper_motor(), law, duration=2e-3, record_interval=1e-7)
    for name, values in coarse.contacts.items():
        np.testing.assert_array_equal(values, fine.contacts[name])


@kernel
def hiding_state(normal, stiffness, stiffness_rate, slip, memory, parameters, at):
    """Mindlin's spring without its energy."""
    force, rate, _, tangential = mindlin_state(
        normal, stiffness, stiffness_rate, slip, memory, parameters, at
    )
    return force, rate, 0.0, tangential


@dataclass(frozen=True)
class Hiding(Friction):
    """A spring that holds energy and does not say so: what it gives back looks like a gain."""

    name = "hiding"
    equation = "Mindlin's"
    source = "this test"
    friction_kind = ELASTOPLASTIC
    exact_stick = False
    internal_variables = (InternalVariable("stretch", "z", "m", "stretch of the spring", parity=ODD),)

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = MU

    def coefficients(self) -> tuple[float, ...]:
        return self.friction_coefficient, 1.0, 0.82

    state = staticmethod(hiding_state)


def test_a_spring_that_hides_its_energy_fails_where_it_cheats() -> None:
    bench = Bench(Composed(friction=Hiding()))
    failed = {name for name in PROPERTIES if not all(c.holds for c in check(bench, name))}
    assert failed == {"kernel_is_consistent", "friction_opposes_slip"}
