"""Coulomb friction with its step smeared out."""

from dataclasses import dataclass
from math import sqrt
from typing import Annotated, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel
from contactlab.laws.base import RATE_DEPENDENT
from contactlab.laws.parameter import FRICTION_COEFFICIENT
from contactlab.laws.part import Friction, StateKernel
from contactlab.parameter import Parameter

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Regularised(Friction):
    """F = -mu N v / sqrt(v^2 + v_0^2): a contact under any tangential load creeps, and never sticks.

    Source: Mostaghel and Davis (1997), Earthquake Eng. Struct. Dyn. 26, 593, who compare such functions.

    Args:
        friction_coefficient: mu [1].
        creep_velocity: v_0 [m/s], at which friction has reached 0.71 of mu N. A run costs more steps the
            smaller it is, in proportion to its logarithm, as long as it is above the slip's round-off.
    """

    name: ClassVar[str] = "regularised"
    equation: ClassVar[str] = "F = -mu N v / sqrt(v^2 + v_0^2)"
    source: ClassVar[str] = "Mostaghel and Davis (1997), Earthquake Eng. Struct. Dyn. 26, 593"
    friction_kind: ClassVar[int] = RATE_DEPENDENT
    exact_stick: ClassVar[bool] = False

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    creep_velocity: Annotated[float, Parameter("v_0", "m s-1", "creep velocity", above=0.0)] = 1e-3

    @property
    def state(self) -> StateKernel:
        """The kernel; see `Friction.state`."""
        return regularised_state


@kernel
def regularised_state(
    normal: float,
    stiffness: float,
    stiffness_rate: float,
    slip: float,
    memory: float,
    parameters: Array,
    at: int,
) -> tuple[float, float, float, float]:
    """Friction [N]; nothing is remembered or stored."""
    bound = parameters[at] * max(normal, 0.0)
    return -bound * slip / sqrt(slip * slip + parameters[at + 2] ** 2), 0.0, 0.0, 0.0
