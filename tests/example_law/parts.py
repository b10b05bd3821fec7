"""Parts of a composed law in a package of their own."""

from dataclasses import dataclass
from math import sqrt
from typing import Annotated, ClassVar

from contactlab.compiler.kernels import kernel
from contactlab.laws import Friction, InternalVariable, NormalForce
from contactlab.laws.base import RATE_DEPENDENT
from contactlab.parameter import Parameter


@dataclass(frozen=True)
class Stiffening(NormalForce):
    """A spring that is four times as stiff at the depth d_0."""

    name: ClassVar[str] = "stiffening"
    equation: ClassVar[str] = "N = k d (1 + (d/d_0)^2)"
    source: ClassVar[str] = "Duffing (1918)"

    stiffness: Annotated[float, Parameter("k", "N m-1", "stiffness at first touch", above=0.0)] = 5e6
    unit_depth: Annotated[float, Parameter("d_0", "m", "depth of four times the stiffness", above=0.0)] = 1e-6

    @staticmethod
    @kernel
    def elastic(depth, stiffness, unit_depth):
        square = (depth / unit_depth) ** 2
        force, energy = stiffness * depth * (1.0 + square), 0.5 * stiffness * depth**2 * (1.0 + 0.5 * square)
        return force, energy, stiffness * (1.0 + 3.0 * square), 6.0 * stiffness * depth / unit_depth**2


@dataclass(frozen=True)
class Ageing(Friction):
    """Friction that is the stronger the older a contact is; slip over the distance D makes it young."""

    name: ClassVar[str] = "ageing"
    equation: ClassVar[str] = "F = -mu N (1 + b z/(z + t_0)) v/sqrt(v^2 + v_0^2), dz/dt = 1 - |v| z/D"
    source: ClassVar[str] = "Dieterich (1979), J. Geophys. Res. 84, 2161"
    friction_kind: ClassVar[int] = RATE_DEPENDENT
    exact_stick: ClassVar[bool] = False
    internal_variables = (InternalVariable("age", "z", "s", "age of the contact"),)

    strengthening: Annotated[float, Parameter("b", "1", "what age adds to the coefficient", at_least=0.0)] = (
        0.2
    )
    half_age: Annotated[float, Parameter("t_0", "s", "age of half the strengthening", above=0.0)] = 1e-5
    distance: Annotated[float, Parameter("D", "m", "slip that renews the contact", above=0.0)] = 1e-7
    velocity: Annotated[float, Parameter("v_0", "m s-1", "slip of creep", above=0.0)] = 1e-3

    @property
    def friction_limit(self):
        return self.friction_coefficient * (1.0 + self.strengthening)

    @staticmethod
    @kernel
    def state(normal, slip, age, friction_coefficient, strengthening, half_age, distance, velocity):
        older = 1.0 + strengthening * age / (age + half_age)
        share = slip / sqrt(slip**2 + velocity**2)
        return -friction_coefficient * normal * older * share, 1.0 - abs(slip) * age / distance, 0.0, 0.0
