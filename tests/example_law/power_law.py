"""A contact law in a package of its own."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from contactlab.compiler.kernels import kernel
from contactlab.laws import PenaltyLaw
from contactlab.laws.declaration import FRICTION_COEFFICIENT
from contactlab.parameter import Parameter


@dataclass(frozen=True)
class PowerLaw(PenaltyLaw):
    """A force that grows with a power of the penetration, with Coulomb friction."""

    name: ClassVar[str] = "power_law"
    equation: ClassVar[str] = "N = P (d/d_0)^p, |F| <= mu N"
    source: ClassVar[str] = "Greenwood and Tripp (1970)"
    default_contact_step: ClassVar[float] = 4e-6

    load: Annotated[float, Parameter("P", "N", "load at d_0", above=0.0)] = 10.0
    unit_depth: Annotated[float, Parameter("d_0", "m", "penetration at P", above=0.0)] = 1e-6
    exponent: Annotated[float, Parameter("p", "1", "exponent", at_least=1.0, at_most=4.0)] = 1.5
    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    @staticmethod
    @kernel
    def force(depth, load, unit_depth, exponent, friction_coefficient):
        normal = load * (depth / unit_depth) ** exponent
        return normal, friction_coefficient * normal, normal * depth / (exponent + 1.0), 0.0
