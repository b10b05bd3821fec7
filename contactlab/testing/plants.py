"""Small plants whose motion is known in closed form, each a `Motor` like any other, and runs of them.

A block has two rigid-body modes, one normal and one along a belt. Springs turn them into oscillators, a
weight presses it on, a tone pushes it. Tip length and rotor radius are so large that the contact is flat,
and the rotor is a belt.
"""

from dataclasses import replace
from math import pi, sqrt
from typing import Any

import numpy as np

from contactlab.arrays import Array
from contactlab.engine import simulate
from contactlab.laws import ContactLaw
from contactlab.motor import NormalModes, RitzResonator
from contactlab.motor.drive import Drive
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.motor import ModalState, Motor, Rotor
from contactlab.trajectory import Trajectory

FLAT = 1e9
"""Tip length and rotor radius [m] of a flat contact: a way x along it changes the gap by x^2 / FLAT."""

HEAVY = 1e18
"""Mass of a belt that nothing brakes [kg]."""


def silent_drive() -> Drive:
    """Give a drive without a tone."""
    return Drive(np.empty(0), np.empty((2, 0), dtype=np.complex128))


def paper_motor() -> Motor:
    """Give the paper's motor: placement 2, 1 um clearance, 100 V at 3210 and 6420 Hz, phase -pi/5."""
    return Motor(RitzResonator().modes, Drive.two_mode(100.0, 100.0, 3210.0, 2.0, -pi / 5.0))


def mirrored(motor: Motor) -> Motor:
    """Give the same motor seen in a mirror that exchanges left and right."""
    velocity, torque = -motor.rotor.initial_velocity, -motor.rotor.load_torque
    rotor = replace(motor.rotor, initial_velocity=velocity, load_torque=torque)
    return replace(motor, modes=replace(motor.modes, tip_slope=-motor.modes.tip_slope), rotor=rotor)


def block(
    mass: float = 1.0,
    *,
    height: float = 0.0,
    gap_rate: float = 0.0,
    way: float = 0.0,
    velocity: float = 0.0,
    weight: float = 0.0,
    push: float = 0.0,
    normal_stiffness: float = 0.0,
    stiffness: float = 0.0,
    push_amplitude: float = 0.0,
    push_frequency: float = 1.0,
    belt_mass: float = HEAVY,
    belt_velocity: float = 0.0,
) -> Motor:
    """Give a block over a belt.

    Args:
        mass: m [kg].
        height, gap_rate: gap [m] and its rate [m/s] at the start; a negative height is pressed in.
        way, velocity: along the belt at the start [m], [m/s].
        weight, push: constant forces towards the belt and along it [N].
        normal_stiffness, stiffness: of springs that pull the block to a gap and a way of zero [N/m].
        push_amplitude, push_frequency: force along the belt, P cos(2 pi f t) [N], [Hz].
        belt_mass, belt_velocity: by default one that nothing brakes [kg]; along the way [m/s].
    """
    root = sqrt(mass)
    tone = Drive(np.array([push_frequency]), np.array([[push_amplitude], [0.0]], dtype=complex))
    modes = NormalModes(
        stiffness=np.array([normal_stiffness, stiffness]) / mass,
        damping=np.zeros(2),
        coupling=np.array([[0.0, 0.0], [1.0 / root, 0.0]]),
        # u falls with the gap, and the way is -FLAT sin(theta).
        tip_displacement=np.array([1.0 / root, 0.0]),
        tip_slope=np.array([0.0, -1.0 / (FLAT * root)]),
        shape_coupling=np.zeros((2, 2)),
    )
    return Motor(
        modes=modes,
        drive=tone if push_amplitude != 0.0 else silent_drive(),
        geometry=ContactGeometry(FLAT, FLAT, 0.0),
        rotor=Rotor(inertia=belt_mass * FLAT**2, initial_velocity=belt_velocity / FLAT),
        preload=np.array([weight, push]) / root,
        start=ModalState(
            displacement=root * np.array([-height, way]),
            velocity=root * np.array([-gap_rate, velocity]),
        ),
    )


def way_of(theta: Array) -> Array:
    """Give the way along the belt [m] of a recorded tip slope."""
    return np.asarray(-FLAT * np.sin(theta))


def coupled_body(seed: int, modes: int = 5, *, approach: float = 0.3) -> Motor:
    """Draw a body of several coupled modes and a rotor, about to touch at a gap rate of `approach` [m/s]."""
    rng = np.random.default_rng(seed)
    tip_displacement = rng.normal(size=modes) * 20.0
    tip_slope = rng.normal(size=modes) * 1e3
    velocity = rng.normal(size=modes) * 1e-3
    # Along u the tip approaches as wanted, and the modes keep the rest of what was drawn.
    squared = tip_displacement @ tip_displacement
    velocity += (approach - tip_displacement @ velocity) * tip_displacement / squared
    rate = 2.0 * np.pi * np.sort(rng.uniform(1e3, 2e4, modes))
    return Motor(
        modes=NormalModes(
            stiffness=rate**2,
            damping=2.0 * rng.uniform(0.0, 1.5, modes) * rate,
            coupling=np.zeros((modes, 2)),
            tip_displacement=tip_displacement,
            tip_slope=tip_slope,
            shape_coupling=np.zeros((modes, 2)),
        ),
        drive=silent_drive(),
        geometry=ContactGeometry(tip_length=19e-3, rotor_radius=25e-3, clearance=0.0),
        rotor=Rotor(inertia=float(rng.uniform(1e-6, 1e-4)), initial_velocity=2.0),
        start=ModalState(-1e-12 * tip_displacement / squared, velocity),
    )


def attempt(
    motor: Motor,
    law: ContactLaw,
    duration: float,
    contact_step: float | None = None,
    record_interval: float | None = None,
    tolerance: float | None = None,
) -> Trajectory:
    """Make a run, whatever becomes of it; without a record interval it is recorded at its ends only."""
    return simulate(
        motor,
        law,
        duration=duration,
        record_interval=record_interval or duration,
        contact_step=contact_step,
        tolerance=tolerance,
    )


def completed(trajectory: Trajectory) -> Trajectory:
    """Give a run back that has reached its end, or raise a RuntimeError with the reason why it has not."""
    if not trajectory.ending.reached_end:
        raise RuntimeError(f"{trajectory.law.name}: {trajectory.message}")
    return trajectory


def run(*of_attempt: Any, **named: Any) -> Trajectory:
    """Make a run as `attempt` does that must reach its end, or raise a RuntimeError."""
    return completed(attempt(*of_attempt, **named))


def first(trajectory: Trajectory, name: str) -> float:
    """Give a column of the first contact."""
    return float(trajectory.contacts[name][0])


def last(trajectory: Trajectory, name: str) -> float:
    """Give the last record of a series."""
    return float(trajectory.series[name][-1])
