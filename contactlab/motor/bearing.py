"""The bearing that presses a rotor on the tip: the rotor's mass on a spring along the normal direction."""

from dataclasses import dataclass, replace
from math import inf, sqrt
from typing import Annotated, final

import numpy as np

from contactlab.checks import Checked, checked_arguments
from contactlab.motor.motor import ModalState, Motor
from contactlab.parameter import not_negative, positive

TOUCHING = 1e-9
"""Share of the clearance that is open where a pressed motor begins: round-off must not close it."""

PRELOAD = not_negative(
    "P", "N", "force that presses the rotor towards the tip at the clearance", usual=(0.0, 20.0)
)


@final
@dataclass(frozen=True)
class Bearing(Checked):
    """A bearing that lets the rotor move towards the tip, m wdd + c wd + k w = N_u - P.

    w is the displacement of the rotor's centre away from the tip, zero at the clearance; N_u is the component
    of the contact force along it. An infinitely stiff bearing is the fixed axle at the clearance, one without
    stiffness presses with P wherever the rotor is.

        >>> import contactlab as cl
        >>> motor = cl.on_bearing(cl.build().motor, cl.Bearing(mass=0.15, preload=5.0))
        >>> f"{1e6 * motor.start.displacement[-1] / 0.15**0.5:.3f} um"  # the rotor begins on the tip
        '-1.000 um'
    """

    mass: Annotated[float, positive("m", "kg", "mass of the rotor and of what the bearing moves with it")]
    preload: Annotated[float, PRELOAD] = 0.0
    stiffness: Annotated[float, not_negative("k", "N m-1", "stiffness of the bearing")] = 0.0
    damping: Annotated[float, not_negative("c", "N s m-1", "viscous damping of the bearing")] = 0.0


@checked_arguments()
def on_bearing(motor: Motor, bearing: Bearing) -> Motor:
    """Return a motor whose rotor can move along u, one more coordinate after its modes.

    It begins at rest: where the bearing's spring leaves the rotor, or on the tip, which it touches without
    force yet; what follows is part of the run. The drive and a start of the modes are kept.

    Raises:
        ValueError: the preload presses a rotor that the tip passes by.
    """
    modes, root, geometry = motor.modes, sqrt(bearing.mass), motor.geometry
    count = modes.stiffness.size
    none = np.zeros(count)
    carried = none if modes.rotor_displacement is None else modes.rotor_displacement
    pressed = replace(
        modes,
        stiffness=np.append(modes.stiffness, bearing.stiffness / bearing.mass),
        damping=np.append(modes.damping, bearing.damping / bearing.mass),
        coupling=np.vstack([modes.coupling, np.zeros_like(modes.coupling[:1])]),
        tip_displacement=np.append(modes.tip_displacement, 0.0),
        tip_slope=np.append(modes.tip_slope, 0.0),
        rotor_displacement=np.append(carried, 1.0 / root),
        points={name: np.append(row, 0.0) for name, row in modes.points.items()},
    )
    way = 0.0
    if bearing.preload > 0.0:
        if geometry.way_to_touch == inf:
            raise ValueError(
                f"contact.angle is {geometry.angle:g} rad, where the tip passes by the rotor; with a "
                "contact.preload one must press on the other."
            )
        free = bearing.preload / bearing.stiffness if bearing.stiffness > 0.0 else inf
        way = min(free, max(geometry.way_to_touch, 0.0) * (1.0 - TOUCHING))
    start = motor.start or ModalState(none, none)
    return replace(
        motor,
        modes=pressed,
        preload=np.append(none if motor.preload is None else motor.preload, -bearing.preload / root),
        start=replace(
            start,
            displacement=np.append(start.displacement, -root * way),
            velocity=np.append(start.velocity, 0.0),
        ),
    )
