"""A law that a user writes outside the package runs like one of its own."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, final

import numpy as np
import pytest

from contactlab.compiled import kernel
from contactlab.engine import simulate
from contactlab.laws import ContactLaw, MultiplierLaw, PenaltyLaw
from contactlab.laws.base import SLIP
from contactlab.motor import RitzResonator
from contactlab.motor.drive import Drive
from contactlab.motor.motor import Motor
from contactlab.parameter import Parameter

DAMPING = 5.0


@kernel
def spring_and_dashpot(gap, gap_rate, slip, impact_speed, parameters):
    stiffness, damping = parameters[0], parameters[1]
    normal = max(-stiffness * gap - damping * gap_rate, 0.0)
    elastic = -stiffness * gap
    return normal, 0.0, 0.5 * stiffness * gap * gap, -(normal - elastic) * gap_rate


@final
@dataclass(frozen=True)
class SpringAndDashpot(PenaltyLaw):
    """N = max(k d + c ddot, 0), without friction."""

    name = "spring_and_dashpot"
    equation = "N = max(k d + c ddot, 0)"
    source = "this test"
    default_contact_step = 4e-6

    stiffness: Annotated[float, Parameter("k", "N m-1", "contact stiffness", above=0.0)]
    damping: Annotated[float, Parameter("c", "N s m-1", "contact damping", at_least=0.0)]

    force = staticmethod(spring_and_dashpot)


@kernel
def frictionless(normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, parameters):
    return -normal_rate / d_nn, 0.0, SLIP


@final
@dataclass(frozen=True)
class Frictionless(MultiplierLaw):
    """g = 0, no friction."""

    name = "frictionless"
    equation = "g = 0, N >= 0, F = 0"
    source = "this test"
    default_contact_step = 1e-7

    solve = staticmethod(frictionless)


@dataclass(frozen=True)
class OfNoFamily(ContactLaw):
    """Neither compliant nor rigid."""

    name = "of_no_family"
    equation = "none"
    source = "this test"
    default_contact_step = 1e-7


@pytest.fixture(scope="module")
def motor() -> Motor:
    drive = Drive.two_mode(100.0, 100.0, 3210.0, 2.0, -np.pi / 5.0)
    return Motor(RitzResonator().modes, drive)


def test_a_dashpot_of_ones_own_closes_the_ledger_and_loses_energy(motor: Motor) -> None:
    law = SpringAndDashpot(stiffness=1e7, damping=DAMPING)
    run = simulate(motor, law, duration=2e-3, record_interval=1e-6)
    loss = run.series["contact_loss"]
    assert run.complete
    assert len(run.contacts["start_time"]) > 3
    assert np.all(np.diff(loss) >= -1e-18)
    # The dashpot's force jumps at touch-down, where a smooth law's starts from zero.
    assert abs(run.series["energy_residual"][-1]) < 1e-6 * run.series["drive_work"][-1]
    assert np.isclose(run.contacts["energy_loss"].sum(), loss[-1], rtol=1e-12)


def test_a_dashpot_of_ones_own_separates_slower_than_it_approached(motor: Motor) -> None:
    def rebound(damping: float) -> float:
        law = SpringAndDashpot(stiffness=1e7, damping=damping)
        contacts = simulate(motor, law, duration=3e-4, record_interval=1e-5).contacts
        return float(-contacts["separation_velocity"][0] / contacts["approach_velocity"][0])

    assert rebound(40.0) < rebound(20.0) < rebound(0.0)


def test_a_rigid_law_of_ones_own_leaves_the_rotor_alone(motor: Motor) -> None:
    run = simulate(motor, Frictionless(), duration=2e-3, record_interval=1e-6)
    assert run.complete
    assert run.contacts["normal_impulse"].sum() > 0.0
    assert np.all(run.series["rotor_velocity"] == 0.0)


def test_a_law_of_neither_family_is_refused(motor: Motor) -> None:
    with pytest.raises(TypeError, match="neither a PenaltyLaw nor a MultiplierLaw"):
        simulate(motor, OfNoFamily(), duration=1e-4, record_interval=1e-5)


def test_the_law_that_the_tutorial_writes_in_a_script_runs(motor: Motor) -> None:
    tutorial = Path(__file__).resolve().parents[2] / "docs" / "tutorial.md"
    (code,) = [
        block.partition("\n\n\nsetup")[0]
        for block in tutorial.read_text(encoding="utf-8").split("```python\n")
        if "class Spring(PenaltyLaw)" in block.partition("```")[0]
    ]
    names: dict[str, Any] = {"__name__": "script"}
    exec(code, names)
    found = simulate(motor, names["Spring"](2e7), duration=1e-3, record_interval=1e-6)
    assert found.complete
    assert len(found.contacts["start_time"]) > 1
