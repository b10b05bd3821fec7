"""The line contact of a roller of finite length."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel
from contactlab.laws.normal.hertz_elliptic import EFFECTIVE_MODULUS, STEEL
from contactlab.laws.part import ElasticKernel, NormalForce
from contactlab.parameter import Parameter

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Line(NormalForce):
    """d = 1.36 (N/E*)^0.9 / L^0.8, that is N = E* (d L^0.8 / 1.36)^(10/9).

    The approach of a line contact depends on what lies behind it, by a logarithm; this power law stands
    for rollers in raceways. With steel it is Palmgren's rule within 2 %.

    Source: Lundberg and Sjovall (1958); Palmgren (1959); Harris, Rolling Bearing Analysis.

    Args:
        length: L of the line [m].
        effective_modulus: E* [Pa].
    """

    name: ClassVar[str] = "line"
    equation: ClassVar[str] = "N = E* (d L^0.8 / 1.36)^(10/9)"
    source: ClassVar[str] = "Lundberg and Sjovall (1958); Palmgren (1959)"

    length: Annotated[float, Parameter("L", "m", "length of the line", above=0.0)] = 16e-3
    effective_modulus: Annotated[float, EFFECTIVE_MODULUS] = STEEL

    def coefficients(self) -> tuple[float, ...]:
        """The stiffness K of N = K d^(10/9)."""
        return (self.effective_modulus * (self.length**0.8 / 1.36) ** (10.0 / 9.0),)

    @property
    def elastic(self) -> ElasticKernel:
        """The kernel; see `NormalForce.elastic`."""
        return line_elastic


@kernel
def line_elastic(depth: float, parameters: Array, at: int) -> tuple[float, float, float, float]:
    """Force [N], energy [J], stiffness [N/m], its slope [N/m^2]."""
    force = parameters[at] * depth ** (10.0 / 9.0)
    stiffness = 10.0 / 9.0 * force / depth if depth > 0.0 else 0.0
    slope = stiffness / (9.0 * depth) if depth > 0.0 else 0.0
    return force, 9.0 / 19.0 * force * depth, stiffness, slope
