"""A friction of the literature: a smooth cone."""

from dataclasses import dataclass
from math import tanh
from typing import Annotated

from contactlab.compiler.kernels import kernel
from contactlab.laws import Friction
from contactlab.laws.base import RATE_DEPENDENT
from contactlab.parameter import positive


@dataclass(frozen=True)
class SmoothCone(Friction):
    """Coulomb's cone smeared out by a hyperbolic tangent; it creeps under any load."""

    name = "smooth_cone"
    equation = "F = -mu N tanh(v/v_0)"
    source = "Andersson, Soderberg and Bjorklund (2007), Tribol. Int. 40, 580"
    friction_kind = RATE_DEPENDENT
    exact_stick = False

    creep_velocity: Annotated[float, positive("v_0", "m s-1", "creep velocity")] = 1e-2

    @staticmethod
    @kernel
    def state(normal, slip, friction_coefficient, creep_velocity):
        return -friction_coefficient * max(normal, 0.0) * tanh(slip / creep_velocity), 0.0, 0.0, 0.0
