"""A loss factor of the approach after Lankarani and Nikravesh."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel
from contactlab.laws.damping.hysteresis import (
    ACHIEVED_RESTITUTION,
    LEAST_SPEED,
    closing_number,
    refuse_beyond,
)
from contactlab.laws.part import DampedKernel, Damping, NormalForce

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class LankaraniNikravesh(Damping):
    """N = f(d) max(1 + D (dd/dt)/v, 0), v the speed of each approach: one restitution at all speeds.

    D is solved for the restitution of a free impact. The published D = 3/4 (1 - e_n^2) reaches 3/4 at
    most and leaves at least e = 0.663. Above that the model, so solved, is `flores`.

    Source: Lankarani and Nikravesh (1990), J. Mech. Des. 112, 369.

    Args:
        restitution: e of a free impact [1].
        least_speed: v_min, taken for v below it [m/s].
    """

    name: ClassVar[str] = "lankarani_nikravesh"
    equation: ClassVar[str] = "N = f(d) max(1 + D(e) (dd/dt)/v, 0), D <= 3/4"
    source: ClassVar[str] = "Lankarani and Nikravesh (1990), J. Mech. Des. 112, 369"

    restitution: Annotated[float, ACHIEVED_RESTITUTION] = 0.8
    least_speed: Annotated[float, LEAST_SPEED] = 1e-3

    def __post_init__(self) -> None:
        super().__post_init__()
        refuse_beyond(self.name, self.restitution, 0.75)

    def coefficients(self, normal: NormalForce) -> tuple[float, ...]:
        """D [1] and the least speed."""
        return closing_number(self.restitution), self.least_speed

    @property
    def damped(self) -> DampedKernel:
        """The kernel; see `Damping.damped`."""
        return approach_damped


@kernel
def approach_damped(
    elastic: float, closing_rate: float, approach: float, parameters: Array, at: int
) -> float:
    """Normal force [N]."""
    factor = parameters[at] / max(approach, parameters[at + 1])
    return float(elastic * max(1.0 + factor * closing_rate, 0.0))
