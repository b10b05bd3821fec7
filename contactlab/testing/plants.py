"""Small plants whose motion is known in closed form, each a `Motor` like any other.

A block has two rigid-body modes, one normal and one along a belt. Springs turn them into oscillators, a
weight presses it on, a tone pushes it. Tip length and rotor radius are so large that the contact is flat,
and the rotor is a belt.
"""

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from contactlab.motor import NormalModes
from contactlab.motor.drive import Drive
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.motor import ModalState, Motor, Rotor

Array = NDArray[np.float64]

FLAT = 1e9
"""Tip length and rotor radius [m] of a flat contact: a way x along it changes the gap by x^2 / FLAT."""

HEAVY = 1e18
"""Mass of a belt that nothing brakes [kg]."""


def silent_drive() -> Drive:
    """A drive without a tone."""
    return Drive(np.empty(0), np.empty((2, 0), dtype=np.complex128))


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
    """A block over a belt.

    Args:
        mass: m [kg].
        height: gap at the start [m]; negative is pressed in.
        gap_rate: its rate at the start [m/s].
        way, velocity: along the belt at the start [m], [m/s].
        weight: constant force towards the belt [N].
        push: constant force along the belt [N].
        normal_stiffness: of a spring that pulls the block to a gap of zero [N/m].
        stiffness: of a spring that pulls the block to way zero [N/m].
        push_amplitude, push_frequency: force along the belt, P cos(2 pi f t) [N], [Hz].
        belt_mass: by default one that nothing brakes [kg].
        belt_velocity: along the way, at the start [m/s].
    """
    root = sqrt(mass)
    drive = silent_drive()
    if push_amplitude != 0.0:
        drive = Drive(
            np.array([push_frequency]), np.array([[push_amplitude], [0.0]], dtype=np.complex128)
        )
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
        drive=drive,
        geometry=ContactGeometry(FLAT, FLAT, 0.0),
        rotor=Rotor(inertia=belt_mass * FLAT**2, initial_velocity=belt_velocity / FLAT),
        preload=np.array([weight, push]) / root,
        start=ModalState(
            displacement=root * np.array([-height, way]),
            velocity=root * np.array([-gap_rate, velocity]),
        ),
    )


def way_of(theta: Array) -> Array:
    """Way along the belt [m] from the recorded tip slope."""
    return np.asarray(-FLAT * np.sin(theta))


def coupled_body(seed: int, modes: int = 5, *, approach: float = 0.3) -> Motor:
    """A body of several coupled modes and a rotor, about to touch; drawn from a seed.

    Args:
        seed: of the rows, stiffnesses, dampings and velocities.
        modes: how many.
        approach: gap rate at the touch-down [m/s].
    """
    rng = np.random.default_rng(seed)
    geometry = ContactGeometry(tip_length=19e-3, rotor_radius=25e-3, clearance=0.0)
    tip_displacement = rng.normal(size=modes) * 20.0
    tip_slope = rng.normal(size=modes) * 1e3
    velocity = rng.normal(size=modes) * 1e-3
    # Along u the tip approaches as wanted, and the modes keep the rest of what was drawn.
    velocity += (
        (approach - tip_displacement @ velocity)
        * tip_displacement
        / (tip_displacement @ tip_displacement)
    )
    rate = 2.0 * np.pi * np.sort(rng.uniform(1e3, 2e4, modes))
    height = 1e-12
    displacement = -height * tip_displacement / (tip_displacement @ tip_displacement)
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
        geometry=geometry,
        rotor=Rotor(inertia=float(rng.uniform(1e-6, 1e-4)), initial_velocity=2.0),
        start=ModalState(displacement, velocity),
    )
