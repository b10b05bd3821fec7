"""A linear spring."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel
from contactlab.laws.part import ElasticKernel, NormalForce
from contactlab.parameter import Parameter

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Linear(NormalForce):
    """N = k d: a flat punch, or a linearised contact.

    Source: K. L. Johnson, Contact Mechanics (1985), sec. 11.5.

    Args:
        stiffness: k [N/m].
    """

    name: ClassVar[str] = "linear"
    equation: ClassVar[str] = "N = k d"
    source: ClassVar[str] = "Johnson, Contact Mechanics (1985), sec. 11.5"

    stiffness: Annotated[float, Parameter("k", "N m-1", "contact stiffness", above=0.0)] = 1e7

    @property
    def elastic(self) -> ElasticKernel:
        """The kernel; see `NormalForce.elastic`."""
        return linear_elastic


@kernel
def linear_elastic(depth: float, parameters: Array, at: int) -> tuple[float, float, float, float]:
    """Force [N], energy [J], stiffness [N/m], its slope [N/m^2]."""
    force = parameters[at] * depth
    return force, 0.5 * force * depth, parameters[at], 0.0
