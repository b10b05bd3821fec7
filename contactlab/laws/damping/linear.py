"""A dashpot beside the contact."""

from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, ClassVar, final

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from contactlab.compiled import kernel
from contactlab.laws.damping.hysteresis import ACHIEVED_RESTITUTION
from contactlab.laws.part import DampedKernel, Damping, NormalForce
from contactlab.parameter import Parameter

Array = NDArray[np.float64]

INTEGRATION = 1e-12
"""Tolerance of the impact that is solved for the coefficient."""


@final
@dataclass(frozen=True)
class LinearDamping(Damping):
    """N = max(f(d) + c dd/dt, 0): a jump of the force at touch-down, and none that pulls at the end.

    c is solved so that a free impact of the given mass at the given speed has the given restitution; it
    has another one at another mass, and with an f that is not linear at another speed.

    Source: K. L. Johnson, Contact Mechanics (1985), sec. 11.5; Kelvin and Voigt.

    Args:
        restitution: e [1].
        effective_mass: m of the impact [kg].
        impact_speed: v [m/s].
    """

    name: ClassVar[str] = "linear"
    equation: ClassVar[str] = "N = max(f(d) + c dd/dt, 0), c solved for e of (m, v)"
    source: ClassVar[str] = "Johnson, Contact Mechanics (1985), sec. 11.5"

    restitution: Annotated[float, ACHIEVED_RESTITUTION] = 0.8
    effective_mass: Annotated[float, Parameter("m", "kg", "mass of the impact", above=0.0)] = 2e-3
    impact_speed: Annotated[float, Parameter("v", "m s-1", "speed of the impact", above=0.0)] = 0.1

    def coefficients(self, normal: NormalForce) -> tuple[float, ...]:
        """The coefficient c [N s/m]."""
        return (
            damping_coefficient(normal, self.restitution, self.effective_mass, self.impact_speed),
        )

    @property
    def damped(self) -> DampedKernel:
        """The kernel; see `Damping.damped`."""
        return linear_damped


@kernel
def linear_damped(
    elastic: float, closing_rate: float, approach: float, parameters: Array, at: int
) -> float:
    """Normal force [N]."""
    return float(max(elastic + parameters[at] * closing_rate, 0.0))


@cache
def damping_coefficient(
    normal: NormalForce, restitution: float, mass: float, speed: float
) -> float:
    """The c [N s/m] at which a free impact has a restitution."""
    if restitution == 1.0:
        return 0.0
    parameters = np.array(normal.coefficients())
    depth = _deepest(normal, parameters, 0.5 * mass * speed**2)
    scale = mass * speed / depth
    right = 1.0
    while _rebound(normal, parameters, mass, speed, right * scale, depth) > restitution:
        right *= 2.0
    ratio = brentq(
        lambda r: _rebound(normal, parameters, mass, speed, r * scale, depth) - restitution,
        0.0,
        right,
        xtol=1e-13,
    )
    return float(ratio * scale)


def _deepest(normal: NormalForce, parameters: Array, energy: float) -> float:
    """Penetration that stores an energy [m]."""
    kernel_of: Any = normal.elastic

    def missing(exponent: float) -> float:
        return float(np.log(kernel_of(10.0**exponent, parameters, 0)[1] / energy))

    exponent: float = brentq(missing, -20.0, 2.0, xtol=1e-12)
    return float(10.0**exponent)


def _rebound(
    normal: NormalForce, parameters: Array, mass: float, speed: float, c: float, depth: float
) -> float:
    """Restitution of a free impact, in units of the elastic depth and the speed."""
    kernel_of: Any = normal.elastic
    unit = depth / (mass * speed**2)

    def force(y: Array) -> float:
        elastic = kernel_of(max(y[0], 0.0) * depth, parameters, 0)[0]
        return float(unit * (elastic + c * speed * y[1]))

    def rates(_: float, y: Array) -> list[float]:
        return [y[1], -force(y)]

    def ends(_: float, y: Array) -> float:
        return force(y)

    ends.terminal = True  # type: ignore[attr-defined]
    ends.direction = -1.0  # type: ignore[attr-defined]
    done = solve_ivp(
        rates,
        (0.0, 1e9),
        [0.0, 1.0],
        method="DOP853",
        rtol=INTEGRATION,
        atol=INTEGRATION,
        events=ends,
    )
    return -float(done.y[1, -1])
