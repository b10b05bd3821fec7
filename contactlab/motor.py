"""A motor: normal modes of a resonator, a drive, a contact geometry and a rotor."""

from dataclasses import dataclass, field
from typing import final

from contactlab.drive import Drive
from contactlab.geometry import ContactGeometry
from contactlab.resonator import NormalModes


@final
@dataclass(frozen=True)
class Rotor:
    """A rigid rotor, J Omegadot = -R F - C_r Omega - tau.

    Args:
        inertia: J [kg m^2].
        damping: viscous damping C_r [N m s/rad].
        load_torque: tau [N m], positive against positive rotation.
        initial_velocity: Omega(0) [rad/s].
    """

    inertia: float = 4.8e-5
    damping: float = 0.0
    load_torque: float = 0.0
    initial_velocity: float = 0.0


@final
@dataclass(frozen=True)
class Motor:
    """Everything that moves; which contact law acts between tip and rotor is not part of it.

    Args:
        modes: normal modes of the resonator, from any basis.
        drive: electrode voltages.
        geometry: tip, rotor radius and clearance.
        rotor: rotor inertia and load.
    """

    modes: NormalModes
    drive: Drive
    geometry: ContactGeometry = field(default_factory=ContactGeometry)
    rotor: Rotor = field(default_factory=Rotor)
