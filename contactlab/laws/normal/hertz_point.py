"""Hertz's circular point contact."""

from dataclasses import dataclass
from math import sqrt
from typing import Annotated, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel
from contactlab.laws.part import ElasticKernel, NormalForce
from contactlab.parameter import Parameter

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class HertzPoint(NormalForce):
    """N = K d^(3/2).

    Source: Hertz (1881); K. L. Johnson, Contact Mechanics (1985), eq. 4.23.

    Args:
        stiffness: K [N m^-3/2]; `contactlab.laws.hertz_stiffness` gives it from radii and moduli.
    """

    name: ClassVar[str] = "hertz_point"
    equation: ClassVar[str] = "N = K d^1.5"
    source: ClassVar[str] = "Hertz (1881); Johnson, Contact Mechanics (1985), eq. 4.23"

    stiffness: Annotated[float, Parameter("K", "N m-1.5", "contact stiffness", above=0.0)] = 1e10

    @property
    def elastic(self) -> ElasticKernel:
        """The kernel; see `NormalForce.elastic`."""
        return hertz_elastic


@kernel
def hertz_elastic(depth: float, parameters: Array, at: int) -> tuple[float, float, float, float]:
    """Force [N], energy [J], stiffness [N/m], its slope [N/m^2]."""
    root = sqrt(depth)
    force = parameters[at] * depth * root
    stiffness = 1.5 * parameters[at] * root
    slope = 0.5 * stiffness / depth if depth > 0.0 else 0.0
    return force, 0.4 * force * depth, stiffness, slope
