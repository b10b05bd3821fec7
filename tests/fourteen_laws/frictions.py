"""Frictions of the literature: a falling bound, bristles that yield, and a smooth cone."""

from dataclasses import dataclass
from math import exp, tanh
from types import MappingProxyType
from typing import Annotated

from contactlab.compiled import kernel
from contactlab.laws import Friction, InternalVariable, Parameter
from contactlab.laws.base import RATE_DEPENDENT
from contactlab.laws.memory import ODD
from contactlab.parameter import positive


@dataclass(frozen=True)
class Tustin(Friction):
    """Set-valued friction whose bound falls with the slip."""

    name = "tustin"
    equation = "|F| <= N (mu + (mu_s - mu) exp(-|v|/v_s))"
    source = "Tustin (1947), J. Inst. Electr. Eng. 94, 143"

    static_ratio: Annotated[float, Parameter("mu_s/mu", "1", "static over kinetic", at_least=1.0)] = 1.3
    stribeck_velocity: Annotated[float, positive("v_s", "m s-1", "Stribeck velocity")] = 0.05

    @staticmethod
    @kernel
    def bound(normal, slip, friction_coefficient, static_ratio, stribeck_velocity):
        more = (static_ratio - 1.0) * exp(-abs(slip) / stribeck_velocity)
        return friction_coefficient * (1.0 + more) * max(normal, 0.0)


@dataclass(frozen=True)
class SolidFriction(Friction):
    """Friction of the way alone, which grows the less the more it has grown: Dahl's with exponent 2."""

    name = "solid_friction"
    equation = "F = -N sigma z, dz/dt = v (1 - s)^2 sign(1 - s), s = sigma z sign(v)/mu"
    source = "Dahl (1968), Aerospace Corp. TOR-0158(3107-18)-1"
    friction_kind = RATE_DEPENDENT
    exact_stick = False
    convergence_order = 0.5
    internal_variables = (InternalVariable("bend", "z", "m", "bend of the bristles", parity=ODD),)
    violations = MappingProxyType(
        {"friction_opposes_slip": "what is bent grows stiffer with the normal force, and gains energy."}
    )

    stiffness_ratio: Annotated[float, positive("sigma", "m-1", "stiffness over N")] = 1e6

    @staticmethod
    @kernel
    def state(normal, slip, bend, friction_coefficient, stiffness_ratio):
        pressed, left = max(normal, 0.0), 0.0
        if friction_coefficient > 0.0:
            left = 1.0 - stiffness_ratio * bend * (1.0 if slip > 0.0 else -1.0) / friction_coefficient
        stored = 0.5 * pressed * stiffness_ratio * bend * bend
        return -pressed * stiffness_ratio * bend, slip * left * abs(left), stored, 0.0


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
