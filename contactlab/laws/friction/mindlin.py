"""A tangential spring after Mindlin, ended by a slider."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel
from contactlab.laws.base import ELASTOPLASTIC
from contactlab.laws.parameter import FRICTION_COEFFICIENT
from contactlab.laws.part import Friction, StateKernel
from contactlab.parameter import Parameter

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Mindlin(Friction):
    """A spring of stiffness k_t = kappa dN/dd, stretched by the slip, that slides at mu N.

        F = -k_t z,  |F| <= mu N,  dz/dt = v - z max(dk_t/dt, 0) / k_t - (sliding)

    While the contact grows, what it gains in stiffness is new and carries nothing: the force stays,
    the stretch z shrinks. While it shrinks, what it loses takes its share of the force along. Either
    way 1/2 z^2 |dk_t/dt| is lost, and no cycle of load makes energy (Elata and Berryman 1996), as it
    would with a force that stays in unloading.

    Source: Mindlin (1949), J. Appl. Mech. 16, 259, for kappa = 2 (1 - nu)/(2 - nu) between equal
    bodies; Thornton and Randall (1988) and Elata and Berryman (1996), Mech. Mater. 24, 229, for the
    unloading. Microslip is left out: the contact slides as a whole.

    Args:
        friction_coefficient: mu [1].
        stiffness_ratio: kappa, tangential over normal stiffness [1]; 0.82 for steel.
    """

    name: ClassVar[str] = "mindlin"
    equation: ClassVar[str] = "F = -kappa (dN/dd) z, |F| <= mu N, dz/dt = v - sliding"
    source: ClassVar[str] = "Mindlin (1949), J. Appl. Mech. 16, 259; Elata and Berryman (1996)"
    friction_kind: ClassVar[int] = ELASTOPLASTIC
    exact_stick: ClassVar[bool] = False
    internal_variables: ClassVar[tuple[str, ...]] = ("stretch of the spring [m]",)

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    stiffness_ratio: Annotated[
        float, Parameter("kappa", "1", "tangential over normal stiffness", above=0.0)
    ] = 0.82

    @property
    def state(self) -> StateKernel:
        """The kernel; see `Friction.state`."""
        return mindlin_state


@kernel
def mindlin_state(
    normal: float,
    stiffness: float,
    stiffness_rate: float,
    slip: float,
    memory: float,
    parameters: Array,
    at: int,
) -> tuple[float, float, float, float]:
    """Friction [N], rate of the stretch [m/s], stored energy [J], tangential stiffness [N/m]."""
    tangential = parameters[at + 2] * stiffness
    growth = max(stiffness_rate, 0.0) / stiffness if stiffness > 0.0 else 0.0
    force = -tangential * memory
    return force, slip - growth * memory, -0.5 * force * memory, tangential
