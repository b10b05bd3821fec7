"""The contact step: that of a compliant law, none of a rigid one, and the shortest that close a contact."""

import numpy as np
import pytest
from support.configurations import composed
from support.motors import case_a, every_law, hertz, run

from contactlab.config import Setup, build
from contactlab.engine import simulate
from contactlab.engine.defaults import default_contact_step
from contactlab.laws import ContactLaw, LagrangeSlip, LagrangeStick, MultiplierLaw, Newton, Poisson, Stronge
from contactlab.motor.drive import Drive
from contactlab.motor.motor import Motor
from contactlab.testing.plants import block
from contactlab.trajectory import Trajectory

PROJECTING = (LagrangeStick(), LagrangeSlip(), Newton(), Poisson(), Stronge())

laws = pytest.mark.parametrize("law", PROJECTING, ids=lambda law: law.name)

RINGING = {
    "shapes": 35,
    "tip_mass": 4.7e-5,
    "tip_inertia": 7e-10,
    "stiffness_damping": 2.3e-11,
    "mass_damping": 0.41,
}
"""A resonator with a light tip and hardly any damping: all of its modes take part in an impact."""


def ringing_setup(law: str, step: float | None = None) -> Setup:
    """A small rotor before it, driven hard."""
    sections = composed(law=law)
    changes: dict[str, dict[str, float | None]] = {
        "resonator": {**RINGING},
        "drive": {"voltage_1": 470.0, "voltage_2": 160.0, "phase": 2.37, "frequency_ratio": 8.04},
        "contact": {"friction_coefficient": 0.287, "clearance": 1.41e-6, "tip_length": 5.08e-3},
        "rotor": {"radius": 3.07e-3, "inertia": 6.12e-8},
        "solver": {"duration": 2e-3, "contact_step": step},
    }
    for section, keys in changes.items():
        sections[section] |= keys
    return build(sections)


def run_of(setup: Setup) -> Trajectory:
    result = setup.run(record_interval=1e-5)
    assert result.ending.reached_end, result.message
    return result


def openness(trajectory: Trajectory) -> float:
    """Ledger residual over the work of the drive [1]."""
    series = trajectory.series
    return float(np.abs(series["energy_residual"]).max() / np.abs(series["drive_work"]).max())


@laws
def test_a_rigid_law_has_no_step_of_its_own(law: MultiplierLaw) -> None:
    assert default_contact_step(case_a(), law, 2e-4) is None
    assert run(case_a(), law, 2e-4).contact_step == 0.0


@pytest.mark.parametrize("step", [None, 5e-8])
def test_a_configuration_records_the_step_it_runs_with_which_is_its_own_where_it_has_one(
    step: float | None,
) -> None:
    setup = ringing_setup("poisson", step)
    assert setup.contact_step == setup.configuration["solver"]["contact_step"] == step
    # A setup has one control of its error.
    assert (setup.tolerance is None) == (step is not None)


@pytest.mark.parametrize("law", ["newton", "lagrange_stick", "poisson", "stronge"])
def test_the_ledger_of_a_ringing_motor_closes(law: str) -> None:
    result = openness(run_of(ringing_setup(law)))
    coarse = openness(run_of(ringing_setup(law, 5e-8)))
    assert coarse > 5e-3
    assert result < 1e-6


@pytest.mark.parametrize("step", [1e-13, 1e-17, 1e-20, 1e-22])
@pytest.mark.parametrize("law", every_law(), ids=lambda law: law.name)
def test_however_short_a_step_the_contact_closes_and_turns(law: ContactLaw, step: float) -> None:
    # Of a hundred steps; a belt without friction, and hardly a force yet where the law is compliant.
    duration = 100.0 * step
    result = simulate(
        block(1e-3, gap_rate=-0.1), law, duration=duration, record_interval=duration, contact_step=step
    )
    assert result.complete, result.message
    assert result.contacts["start_time"].tolist()[:1] == [0.0]
    if isinstance(law, MultiplierLaw):
        assert result.contacts["normal_impulse"][0] >= 1e-4 * (1.0 - 1e-9)
    else:
        assert result.contacts["max_penetration"][0] == pytest.approx(0.1 * duration, rel=1e-6)


def test_a_motor_too_fast_for_the_clock_is_refused_and_does_not_hang() -> None:
    # Steps of its flight would be shorter than the clock resolves, and the run would stand still.
    slow = block(1e-3, gap_rate=-0.1)
    drive = Drive(np.array([1e18]), np.ones((2, 1), dtype=np.complex128))
    fast = Motor(slow.modes, drive, slow.geometry, slow.rotor, slow.preload, slow.start)
    with pytest.raises(ValueError, match="rad/s"):
        simulate(fast, hertz(), duration=1e-3, record_interval=1e-3)
