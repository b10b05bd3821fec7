"""No loss."""

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel
from contactlab.laws.part import DampedKernel, Damping, NormalForce

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Undamped(Damping):
    """The elastic force alone: restitution 1."""

    name: ClassVar[str] = "none"
    equation: ClassVar[str] = "no loss"
    source: ClassVar[str] = "Hertz (1881)"

    def coefficients(self, normal: NormalForce) -> tuple[float, ...]:
        """None."""
        return ()

    @property
    def damped(self) -> DampedKernel:
        """The kernel; see `Damping.damped`."""
        return undamped


@kernel
def undamped(
    elastic: float, closing_rate: float, approach: float, parameters: Array, at: int
) -> float:
    """Normal force [N]."""
    return elastic
