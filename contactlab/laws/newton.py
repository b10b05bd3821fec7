"""Newton's restitution of velocities in a rigid impact."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel
from contactlab.laws.base import MultiplierKernel, MultiplierLaw
from contactlab.laws.lagrange_stick import stick_or_slip_impulse
from contactlab.laws.parameter import FRICTION_COEFFICIENT, RESTITUTION

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Newton(MultiplierLaw):
    """A rigid impact that gives back a share of the approach, with set-valued friction.

        gdot+ = -e gdot- in an impact, g = 0 after it;  |F| <= mu N, slip != 0 => F = -mu N sign(slip)

    The slip of the friction law is that after the impact. A rebound that ends within the step is
    none. Where slip ends or reverses in the impact the restitution can create energy.

    Source: Newton (1687), Principia, scholium to the laws of motion; its energy: Kane and Levinson
    (1985), Dynamics: Theory and Applications.

    Args:
        friction_coefficient: mu [1].
        restitution: e, of the gap rate [1].
    """

    name: ClassVar[str] = "newton"
    equation: ClassVar[str] = (
        "gdot+ = -e gdot-, N >= 0, |F| <= mu N, F = -mu N sign(v+) where v+ != 0"
    )
    source: ClassVar[str] = "Newton (1687), Principia, scholium to the laws of motion"
    default_contact_step: ClassVar[float] = 5e-8
    violations: ClassVar[Mapping[str, str]] = MappingProxyType(
        {
            "dissipates": "the rebound is that of the whole approach, also where friction has ended the slip "
            "and taken its share of the approach with it (Kane and Levinson 1985)."
        }
    )

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    restitution: Annotated[float, RESTITUTION] = 0.5

    @property
    def solve(self) -> MultiplierKernel:
        """The kernel; see `MultiplierLaw.solve`."""
        return newton_impulse


@kernel
def newton_impulse(
    normal_rate: float,
    tangential_rate: float,
    gap_rate: float,
    slip: float,
    d_nn: float,
    d_nt: float,
    d_tt: float,
    parameters: Array,
) -> tuple[float, float, int]:
    """Impulses [N s] and mode; arguments as in `MultiplierLaw.solve`."""
    # The plastic law to the rate that is asked for in place of zero.
    missing = normal_rate + parameters[1] * min(gap_rate, 0.0)
    return stick_or_slip_impulse(
        missing, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, parameters
    )
