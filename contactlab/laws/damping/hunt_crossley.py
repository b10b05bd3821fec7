"""A constant loss factor after Hunt and Crossley."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel
from contactlab.laws.damping.hysteresis import ACHIEVED_RESTITUTION, closing_number, refuse_beyond
from contactlab.laws.part import DampedKernel, Damping, NormalForce
from contactlab.parameter import Parameter

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class HuntCrossley(Damping):
    """N = f(d) max(1 + a dd/dt, 0) with a constant a: restitution falls with the speed of impact.

    a is solved so that a free impact at the given speed has the given restitution.

    Source: Hunt and Crossley (1975), J. Appl. Mech. 42, 440.

    Args:
        restitution: e at the impact speed [1].
        impact_speed: v [m/s].
    """

    name: ClassVar[str] = "hunt_crossley"
    equation: ClassVar[str] = "N = f(d) max(1 + a dd/dt, 0), a v = D(e)"
    source: ClassVar[str] = "Hunt and Crossley (1975), J. Appl. Mech. 42, 440"

    restitution: Annotated[float, ACHIEVED_RESTITUTION] = 0.8
    impact_speed: Annotated[
        float, Parameter("v", "m s-1", "speed at which e is achieved", above=0.0)
    ] = 0.1

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_beyond(self.name, self.restitution, 1.5)

    def coefficients(self, normal: NormalForce) -> tuple[float, ...]:
        """The loss factor a [s/m]."""
        return (closing_number(self.restitution) / self.impact_speed,)

    @property
    def damped(self) -> DampedKernel:
        """The kernel; see `Damping.damped`."""
        return hunt_crossley_damped


@kernel
def hunt_crossley_damped(
    elastic: float, closing_rate: float, approach: float, parameters: Array, at: int
) -> float:
    """Normal force [N]."""
    return float(elastic * max(1.0 + parameters[at] * closing_rate, 0.0))
