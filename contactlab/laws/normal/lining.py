"""A soft lining that is pressed through to what lies behind it."""

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
class Lining(NormalForce):
    """Two stages: dN/dd = k_1 up to the depth d_1, k_2 beyond d_1 + w, and linear in between.

    The passage has a width because a stiffness that jumps is no material's and takes the order of any
    integration.

    Source: the two-stage spring of piecewise linear oscillators, Shaw and Holmes (1983), J. Sound Vib.
    90, 129, with a passage of finite width.

    Args:
        soft_stiffness: k_1 of the lining [N/m].
        hard_stiffness: k_2 of what lies behind [N/m].
        lining_depth: d_1 [m].
        passage: w [m].
    """

    name: ClassVar[str] = "lining"
    equation: ClassVar[str] = "dN/dd = k_1 for d < d_1, k_2 for d > d_1 + w, linear in between"
    source: ClassVar[str] = "after Shaw and Holmes (1983), J. Sound Vib. 90, 129"

    soft_stiffness: Annotated[float, Parameter("k_1", "N m-1", "of the lining", above=0.0)] = 5e6
    hard_stiffness: Annotated[float, Parameter("k_2", "N m-1", "of what is behind", above=0.0)] = (
        5e7
    )
    lining_depth: Annotated[float, Parameter("d_1", "m", "depth of the lining", above=0.0)] = 5e-7
    passage: Annotated[float, Parameter("w", "m", "width of the passage", above=0.0)] = 1e-7

    @property
    def elastic(self) -> ElasticKernel:
        """The kernel; see `NormalForce.elastic`."""
        return lining_elastic


@kernel
def lining_elastic(depth: float, parameters: Array, at: int) -> tuple[float, float, float, float]:
    """Force [N], energy [J], stiffness [N/m], its slope [N/m^2]."""
    soft, width = parameters[at], parameters[at + 3]
    more = parameters[at + 1] - soft
    force, energy = soft * depth, 0.5 * soft * depth * depth
    beyond = depth - parameters[at + 2]
    if beyond <= 0.0:
        return force, energy, soft, 0.0
    inside = min(beyond, width)
    slope = more / width
    through = beyond - inside
    force += 0.5 * slope * inside * inside + more * through
    energy += slope * inside**3 / 6.0 + 0.5 * more * through * (width + through)
    if through > 0.0:
        return force, energy, soft + more, 0.0
    return force, energy, soft + slope * inside, slope
