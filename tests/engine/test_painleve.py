"""Rigid contacts beyond the critical friction, where a step has several answers or, for slip alone, none."""

import numpy as np
import pytest

from contactlab.engine import simulate
from contactlab.laws import LagrangeSlip, LagrangeStick, MultiplierLaw, Newton, Poisson, Stronge
from contactlab.motor import NormalModes
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.motor import ModalState, Motor, Rotor
from contactlab.trajectory import Ending, Trajectory

NORMAL, TANGENTIAL = 10.0, 30.0
"""Ways of the leaning strut's tip per way of the strut [kg^-1/2]; the critical friction is their ratio."""

RADIUS, TIP_LENGTH, INERTIA = 25e-3, 19e-3, 1e-6
STEP = 1e-6


def leaning_strut(
    approach: float, rotor_velocity: float, parting: float = 0.0, load_torque: float = 0.0
) -> Motor:
    """A strut that can only move along itself, aslant onto a rotor.

    Args:
        approach: speed at which the gap closes [m/s].
        rotor_velocity: at the start [rad/s].
        parting: acceleration along the strut that opens the gap [m/s^2 kg^1/2].
        load_torque: on the rotor [N m].
    """
    return Motor(
        modes=NormalModes(
            stiffness=np.zeros(1),
            damping=np.zeros(1),
            coupling=np.zeros((1, 2)),
            tip_displacement=np.array([NORMAL]),
            tip_slope=np.array([TANGENTIAL / TIP_LENGTH]),
            shape_coupling=np.zeros((1, 2)),
        ),
        geometry=ContactGeometry(TIP_LENGTH, RADIUS, clearance=1e-10),
        rotor=Rotor(INERTIA, load_torque=load_torque, initial_velocity=rotor_velocity),
        preload=np.array([-parting]),
        start=ModalState(np.zeros(1), np.array([approach / NORMAL])),
    )


def run(motor: Motor, law: MultiplierLaw, duration: float = 1e-4) -> Trajectory:
    return simulate(motor, law, duration=duration, record_interval=1e-6, contact_step=STEP)


def test_slip_alone_has_no_answer_to_an_approach_and_the_run_says_so() -> None:
    result = run(leaning_strut(0.1, -40.0), LagrangeSlip(1.0))
    assert result.ending is Ending.INCONSISTENT
    assert not result.complete
    # It stops at the touch-down: nothing has gone into the rotor.
    assert result.contacts["start_time"].size == 1
    assert result.time[-1] <= result.contacts["start_time"][0]


@pytest.mark.parametrize(("spin", "mu"), [(40.0, 1.0), (-40.0, 0.3)])
def test_the_other_direction_and_less_friction_are_answered_by_slip_alone(spin: float, mu: float) -> None:
    result = run(leaning_strut(0.1, spin), LagrangeSlip(mu))
    assert result.complete, result.message
    assert result.series["gap"].min() > -0.1 * STEP


@pytest.mark.parametrize(
    "law", [LagrangeStick(1.0), Newton(1.0, 0.5), Poisson(1.0, 0.5), Stronge(1.0, 0.5)], ids=repr
)
@pytest.mark.parametrize("spin", [40.0, -40.0])
def test_laws_with_stick_answer_every_approach(law: MultiplierLaw, spin: float) -> None:
    result = run(leaning_strut(0.1, spin), law)
    assert result.complete, result.message
    assert result.contacts["normal_impulse"][0] > 0.0
    assert result.series["gap"].min() > -0.1 * STEP


def test_a_strut_that_jams_holds_a_rotor_and_the_run_counts_its_steps() -> None:
    # The load alone holds it: friction presses more than what parts the bodies, inside the cone.
    wedged = leaning_strut(1e-3, 0.0, parting=1.0, load_torque=50.0 * INERTIA / RADIUS)
    stored = run(wedged, LagrangeStick(1.0))
    assert stored.complete, stored.message
    assert stored.contacts["duration"].size == 1
    assert stored.contact_mode[-1] == 2
    assert abs(stored.series["rotor_velocity"][-1]) < 1e-12
    assert stored.statistics["wedged_steps"] > 90
    # With too little friction it opens.
    released = run(wedged, LagrangeStick(0.3))
    assert released.contact_mode[-1] == 0
    assert released.statistics["wedged_steps"] == 0
