"""A dashpot beside the contact, and none."""

from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, final

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from contactlab.arrays import Array
from contactlab.compiled import kernel
from contactlab.laws.damping.hysteresis import ACHIEVED_RESTITUTION
from contactlab.laws.part import Damping, NormalForce
from contactlab.parameter import Parameter

INTEGRATION = 1e-12
"""Tolerance of the impact that is solved for the coefficient."""


@final
@dataclass(frozen=True)
class Undamped(Damping):
    """The elastic force alone: restitution 1."""

    name = "none"
    equation = "no loss"
    source = "Hertz (1881)"

    def coefficients(self, normal: NormalForce) -> tuple[float, ...]:
        """Give none."""
        return ()

    @staticmethod
    @kernel
    def damped(elastic, depth_rate, impact_speed, parameters, at):
        """See `Damping.damped`."""
        return elastic


@final
@dataclass(frozen=True)
class LinearDamping(Damping):
    """A dashpot: a jump of the force at touch-down, and none that pulls at the end. After Kelvin and Voigt.

    c is solved so that a free impact of the given mass at the given speed has the given restitution; it
    has another one at another mass, and with an f that is not linear at another speed.
    """

    name = "linear"
    equation = "N = max(f(d) + c dd/dt, 0), c solved for e of (m, v)"
    source = "Johnson, Contact Mechanics (1985), sec. 11.5"

    restitution: Annotated[float, ACHIEVED_RESTITUTION] = 0.8
    effective_mass: Annotated[float, Parameter("m", "kg", "mass of the impact", above=0.0)] = 2e-3
    impact_speed: Annotated[float, Parameter("v", "m s-1", "speed of the impact", above=0.0)] = 0.1

    def coefficients(self, normal: NormalForce) -> tuple[float, ...]:
        """Give the coefficient c [N s/m]."""
        e, mass, speed = self.restitution, self.effective_mass, self.impact_speed
        return (damping_coefficient(normal, e, mass, speed),)

    @staticmethod
    @kernel
    def damped(elastic, depth_rate, impact_speed, parameters, at):
        """See `Damping.damped`."""
        return float(max(elastic + parameters[at] * depth_rate, 0.0))


@cache
def damping_coefficient(
    normal: NormalForce, restitution: float, mass: float, speed: float
) -> float:
    """Give the c [N s/m] at which a free impact has a restitution."""
    if restitution == 1.0:
        return 0.0
    parameters = np.array(normal.coefficients())
    elastic: Any = normal.elastic
    energy = 0.5 * mass * speed**2

    def beyond(exponent: float) -> float:
        """Logarithm of the energy that a depth stores, over that of the impact."""
        return float(np.log(elastic(10.0**exponent, parameters, 0)[1] / energy))

    depth = float(10.0 ** brentq(beyond, -20.0, 2.0, xtol=1e-12))
    unit = depth / (mass * speed**2)

    def excess(ratio: float) -> float:
        """Restitution of the impact, less what is asked; in units of the elastic depth and the speed."""
        c = ratio * (mass * speed / depth)

        def force(_: float, y: Array) -> float:
            spring = elastic(max(y[0], 0.0) * depth, parameters, 0)[0]
            return float(unit * (spring + c * speed * y[1]))

        # The impact ends where the force does.
        force.terminal = True  # type: ignore[attr-defined]
        force.direction = -1.0  # type: ignore[attr-defined]
        done = solve_ivp(
            lambda t, y: [y[1], -force(t, y)],
            (0.0, 1e9),
            [0.0, 1.0],
            method="DOP853",
            rtol=INTEGRATION,
            atol=INTEGRATION,
            events=force,
        )
        return -float(done.y[1, -1]) - restitution

    right = 1.0
    while excess(right) > 0.0:
        right *= 2.0
    return float(brentq(excess, 0.0, right, xtol=1e-13) * (mass * speed / depth))
