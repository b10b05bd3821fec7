"""Motors whose tip is led along a path: what its modes would weigh has no say, friction follows the slip.

A tip on an ellipse, B sin wt along a plate and A cos wt - c into it, whose contact is a spring k with Coulomb
friction mu: on a plate of velocity V the mean friction is mu k/pi [2 (A sin p - c p) - (A sin t - c t)], with
cos p = V/(B w) and cos t = c/A.
"""

from dataclasses import replace
from math import acos, cos, pi, sin

import numpy as np
import pytest
from scipy.optimize import brentq

import contactlab as cl
from contactlab.testing.plants import FLAT

FREQUENCY, A, B, CLEARANCE, STIFFNESS, FRICTION = 40e3, 1e-6, 2e-6, 0.3e-6, 5e6, 0.2
TURN = 2.0 * pi * FREQUENCY
RIM = 0.025
LAW = cl.Composed(cl.Linear(STIFFNESS), cl.Undamped(), cl.Coulomb(FRICTION))


def pressed(phase: float) -> float:
    return A * sin(phase) - CLEARANCE * phase


EDGE = acos(CLEARANCE / A)
FASTEST = B * TURN * cos(brentq(lambda phase: pressed(phase) - 0.5 * pressed(EDGE), 0.0, EDGE))
"""Velocity of a plate that the tip does not push on the whole [m/s]."""


def friction_on(velocity: float) -> float:
    phase = min(acos(min(velocity / (B * TURN), 1.0)), EDGE)
    return FRICTION * STIFFNESS / pi * (2.0 * pressed(phase) - pressed(EDGE))


def led(root: float, rim: float, mass: float, velocity: float = 0.0) -> cl.Motor:
    """Return the motor with a plate of a mass on its rim, the led modes' masses being root^2."""
    turns = 2.0 * pi * np.arange(64) / 64
    path = np.stack([-A * np.cos(turns), B * np.sin(turns)])
    modes = cl.NormalModes(
        stiffness=np.zeros(2),
        damping=np.zeros(2),
        coupling=np.diag([-root, root]),
        tip_displacement=np.array([1.0 / root, 0.0]),
        tip_slope=np.array([0.0, -1.0 / (rim * root)]),
        prescribed=np.array([True, True]),
    )
    drive = cl.Drive(waveform=cl.Waveform.sampled(turns / TURN, path, 7, 1.0 / FREQUENCY))
    rotor = cl.Rotor(inertia=mass * rim**2, initial_velocity=velocity / rim)
    return cl.Motor(modes, drive, cl.ContactGeometry(rim, rim, CLEARANCE), rotor)


def test_a_run_does_not_hang_on_the_mass_of_what_is_led() -> None:
    runs = [
        cl.simulate(led(root, RIM, 1e-3), LAW, duration=1e-3, record_interval=1e-4) for root in (1e5, 1e-3)
    ]
    velocities = [run["rotor_velocity"].values[-1] for run in runs]
    assert velocities[0] > 0.0
    assert velocities[1] == pytest.approx(velocities[0], rel=1e-10)


@pytest.mark.parametrize("root", [1e10, 1e-3])
def test_a_slider_on_a_led_tip_settles_at_the_velocity_at_which_it_is_not_pushed(root: float) -> None:
    result = cl.steady(led(root, FLAT, 1e-3), LAW)
    assert result.kind == "periodic"
    velocity, error = (FLAT * number for number in result.velocity)
    assert error < 1e-6
    # It swings a little in a period.
    ripple = FLAT * float(np.ptp(result["rotor_velocity"].values))
    assert abs(velocity - FASTEST) <= error + ripple


@pytest.mark.parametrize("velocity", [0.2, 0.45])
def test_the_friction_on_a_plate_that_moves_is_that_of_each_sense_of_the_slip(velocity: float) -> None:
    right = friction_on(velocity)
    plate = led(1e10, FLAT, 1e12, velocity)
    period = 1.0 / FREQUENCY
    run = cl.simulate(plate, LAW, duration=2.0 * period, record_interval=period / 50)
    assert -run["friction_force"].values[51:].mean() == pytest.approx(right, abs=1e-8)
    on_belt = cl.steady(plate, LAW, belt=velocity / FLAT)
    force, error = on_belt.average("friction_force")
    assert abs(-force - right) <= error < 1e-7


def test_a_rigid_contact_whose_gap_is_led_is_refused() -> None:
    with pytest.raises(ValueError, match="prescribed"):
        cl.simulate(led(1e10, RIM, 1e-3), cl.Newton(), duration=1e-4, record_interval=1e-5)
    lighter = replace(led(1.0, RIM, 1e-3), rotor=cl.Rotor())
    with pytest.raises(ValueError, match="prescribed"):
        cl.steady(lighter, cl.LagrangeStick(0.3))
