"""Coulomb friction: set-valued, and with its step smeared out."""

from dataclasses import dataclass
from math import sqrt
from typing import Annotated, final

from contactlab.arrays import Array
from contactlab.compiled import kernel
from contactlab.laws.base import RATE_DEPENDENT
from contactlab.laws.declaration import FRICTION_COEFFICIENT
from contactlab.laws.part import Friction
from contactlab.parameter import Parameter

STATIC_RATIO = Parameter("mu_s/mu", "1", "static over kinetic coefficient", at_least=1.0)
"""Shared by the frictions that hold more than they drag."""


@kernel
def cone_bound(normal: float, slip: float, parameters: Array, at: int) -> float:
    """Give the largest friction [N]: mu_s N in stick, where the slip [m/s] is exactly zero, else mu N.

    A pull N < 0 gives no friction. From the place `at` on stand mu and mu_s / mu.
    """
    ratio = parameters[at + 1] if slip == 0.0 else 1.0
    return float(parameters[at] * ratio * max(normal, 0.0))


@final
@dataclass(frozen=True)
class Coulomb(Friction):
    """Set-valued friction: exact stick."""

    name = "coulomb"
    equation = "|F| <= mu_s N, F = -mu N sign(v) where v != 0"
    source = "Coulomb (1785); Moreau (1988)"

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    static_ratio: Annotated[float, STATIC_RATIO] = 1.0


@final
@dataclass(frozen=True)
class Regularised(Friction):
    """A contact that creeps under any tangential load, and never sticks.

    At v_0 friction has reached 0.71 of mu N. A run costs more steps the smaller v_0 is, in proportion to
    its logarithm, as long as it is above the slip's round-off. The source compares such functions.
    """

    name = "regularised"
    equation = "F = -mu N v / sqrt(v^2 + v_0^2)"
    source = "Mostaghel and Davis (1997), Earthquake Eng. Struct. Dyn. 26, 593"
    friction_kind = RATE_DEPENDENT
    exact_stick = False

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    creep_velocity: Annotated[float, Parameter("v_0", "m s-1", "creep velocity", above=0.0)] = 1e-3

    @staticmethod
    @kernel
    def state(normal, stiffness, stiffness_rate, slip, z, parameters, at):
        """See `Friction.state`; there is no internal variable, and nothing is stored."""
        bound = parameters[at] * max(normal, 0.0)
        return -bound * slip / sqrt(slip * slip + parameters[at + 2] ** 2), 0.0, 0.0, 0.0
