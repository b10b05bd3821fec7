"""The rotor's angular momentum is judged by what the laws do, however strongly the rotor is damped."""

import dataclasses

import numpy as np
import pytest

from contactlab.engine import simulate
from contactlab.laws import HertzPenalty, LagrangeStick
from contactlab.laws.base import ContactLaw
from contactlab.metrics import METRICS, Run, assess
from contactlab.testing.plants import paper_motor


def momentum(law: ContactLaw, damping: float, torque: float, passed_on: float = 1.0) -> float:
    """The metric of a run, of which a share of the friction impulses is recorded."""
    motor = paper_motor()
    rotor = dataclasses.replace(motor.rotor, damping=damping, load_torque=torque)
    motor = dataclasses.replace(motor, rotor=rotor)
    run = simulate(motor, law, duration=3e-3, record_interval=1e-5)
    reported = run.contacts["friction_impulse"] * passed_on
    run = dataclasses.replace(run, contacts={**run.contacts, "friction_impulse": reported})
    radius = motor.geometry.rotor_radius
    facts = {"rotor": {"radius": radius, **dataclasses.asdict(rotor)}}
    return assess(Run.of_trajectory(run, facts), ["rotor_momentum"])["rotor_momentum"]


@pytest.mark.parametrize("law", [HertzPenalty(), LagrangeStick()], ids=lambda law: law.name)
@pytest.mark.parametrize("torque", [0.0, 1e-3])
@pytest.mark.parametrize("damping", [0.0, 1.0, 20.0, 200.0, 1e4])
def test_a_damped_rotor_fails_no_sound_law(law: ContactLaw, damping: float, torque: float) -> None:
    result = momentum(law, damping, torque)
    assert np.isnan(result) or result <= METRICS["rotor_momentum"].bound
    assert np.isfinite(result) or damping > 200.0


@pytest.mark.parametrize("damping", [0.0, 1.0, 20.0])
def test_impulses_that_do_not_reach_the_rotor_fail_at_any_damping_that_is_judged(damping: float) -> None:
    assert momentum(LagrangeStick(), damping, 0.0, passed_on=0.5) > 1e-6
