"""Coulomb's cone smeared out over small slips."""

from dataclasses import dataclass
from math import sqrt
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import RATE_DEPENDENT, Friction
from contactlab.parameter import positive


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
    validity = "sliding: no load is held, it creeps"
    friction_kind = RATE_DEPENDENT
    exact_stick = False

    creep_velocity: Annotated[float, positive("v_0", "m s-1", "creep velocity")] = 1e-3

    @staticmethod
    @kernel
    def state(normal, slip, friction_coefficient, creep_velocity):
        bound = friction_coefficient * max(normal, 0.0)
        return -bound * slip / sqrt(slip * slip + creep_velocity**2), 0.0, 0.0, 0.0
