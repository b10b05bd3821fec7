"""Friction of bristles: the LuGre law."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import exp
from types import MappingProxyType
from typing import Annotated, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel
from contactlab.laws.base import RATE_DEPENDENT
from contactlab.laws.friction.coulomb import STATIC_RATIO
from contactlab.laws.parameter import FRICTION_COEFFICIENT
from contactlab.laws.part import Friction, StateKernel
from contactlab.parameter import Parameter

Array = NDArray[np.float64]

BRISTLE_STIFFNESS = Parameter("sigma_0", "m-1", "bristle stiffness over N", above=0.0)
BRISTLE_DAMPING = Parameter("sigma_1", "s m-1", "bristle damping over N", at_least=0.0)
STRIBECK_VELOCITY = Parameter("v_s", "m s-1", "Stribeck velocity", above=0.0)

BRISTLE_VIOLATIONS = MappingProxyType(
    {
        "friction_opposes_slip": "bent bristles grow stiffer with the normal force, which gives them energy "
        "that nothing brought."
    }
)


@final
@dataclass(frozen=True)
class LuGre(Friction):
    """Bristles of stiffness and damping in proportion to the normal force.

        F = -N (sigma_0 z + sigma_1 dz/dt),  dz/dt = v - sigma_0 |v| z / g(v),
        g(v) = mu + (mu_s - mu) exp(-(v/v_s)^2)

    Source: Canudas de Wit, Olsson, Astrom and Lischinsky (1995), IEEE Trans. Autom. Control 40, 419;
    in proportion to N as Canudas de Wit and Tsiotras (1999) have it.

    Args:
        friction_coefficient: mu of fast slip [1].
        static_ratio: mu_s / mu [1].
        bristle_stiffness: sigma_0 [1/m]; the bristles bend by mu/sigma_0.
        bristle_damping: sigma_1 [s/m].
        stribeck_velocity: v_s [m/s].
    """

    name: ClassVar[str] = "lugre"
    equation: ClassVar[str] = "F = -N (sigma_0 z + sigma_1 dz/dt), dz/dt = v - sigma_0 |v| z / g(v)"
    source: ClassVar[str] = "Canudas de Wit et al. (1995), IEEE Trans. Autom. Control 40, 419"
    friction_kind: ClassVar[int] = RATE_DEPENDENT
    exact_stick: ClassVar[bool] = False
    # The bristles have a kink where the slip reverses, and no step ends there.
    convergence_order: ClassVar[float] = 0.5
    internal_variables: ClassVar[tuple[str, ...]] = ("deflection of the bristles [m]",)
    violations: ClassVar[Mapping[str, str]] = BRISTLE_VIOLATIONS

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    static_ratio: Annotated[float, STATIC_RATIO] = 1.0
    bristle_stiffness: Annotated[float, BRISTLE_STIFFNESS] = 1e6
    bristle_damping: Annotated[float, BRISTLE_DAMPING] = 0.1
    stribeck_velocity: Annotated[float, STRIBECK_VELOCITY] = 1e-2

    @property
    def state(self) -> StateKernel:
        """The kernel; see `Friction.state`."""
        return lugre_state


@kernel
def lugre_state(
    normal: float,
    stiffness: float,
    stiffness_rate: float,
    slip: float,
    memory: float,
    parameters: Array,
    at: int,
) -> tuple[float, float, float, float]:
    """Friction [N], rate of the deflection [m/s], stored energy [J]."""
    pressed = max(normal, 0.0)
    sigma = parameters[at + 2]
    drag = stribeck(slip, parameters, at)
    rate = slip - sigma * abs(slip) * memory / drag if drag > 0.0 else 0.0
    force = -pressed * (sigma * memory + parameters[at + 3] * rate)
    return force, rate, 0.5 * pressed * sigma * memory * memory, 0.0


@kernel
def stribeck(slip: float, parameters: Array, at: int) -> float:
    """Coefficient of steady slip [1]."""
    mu = parameters[at]
    lifted = parameters[at + 1] - 1.0
    return float(mu * (1.0 + lifted * exp(-((slip / parameters[at + 4]) ** 2))))
