"""Poisson's restitution of impulses in a rigid impact."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel
from contactlab.laws.base import MultiplierKernel, MultiplierLaw
from contactlab.laws.impact_process import complete, compression, impact_approach, stages_of
from contactlab.laws.lagrange_stick import stick_or_slip_impulse
from contactlab.laws.parameter import FRICTION_COEFFICIENT, RESTITUTION

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Poisson(MultiplierLaw):
    """A rigid impact that gives back a share of the impulse of compression, with Coulomb friction.

        p = (1 + e) p_c,  gdot(p_c) = 0;  |dp_t| <= mu dp, slip != 0 => dp_t = -mu dp sign(slip)

    The friction impulse follows the slip through the impact (`contactlab.laws.impact_process`). Contact
    that lasts has no restitution and is that of `lagrange_stick`.

    Source: Routh (1891), Dynamics of a System of Rigid Bodies, elementary part; Wang and Mason (1992),
    J. Appl. Mech. 59, 635.

    Args:
        friction_coefficient: mu [1].
        restitution: e, of the normal impulse [1].
    """

    name: ClassVar[str] = "poisson"
    equation: ClassVar[str] = "p = (1 + e) p_c, gdot(p_c) = 0, dp_t = -mu dp sign(v) or v = 0"
    source: ClassVar[str] = "Routh (1891); Wang and Mason (1992), J. Appl. Mech. 59, 635"
    default_contact_step: ClassVar[float] = 5e-8
    violations: ClassVar[Mapping[str, str]] = MappingProxyType(
        {
            "friction_opposes_slip": "friction opposes the slip at every instant of an impact, but where "
            "the slip reverses in it the sum of friction may have the direction of the slip that is left."
        }
    )

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    restitution: Annotated[float, RESTITUTION] = 0.5

    @property
    def solve(self) -> MultiplierKernel:
        """The kernel; see `MultiplierLaw.solve`."""
        return poisson_impulse


@kernel
def poisson_impulse(
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
    approach = impact_approach(normal_rate, gap_rate)
    if approach == 0.0:
        return stick_or_slip_impulse(
            normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, parameters
        )
    stages = stages_of(tangential_rate, d_nt, d_tt, parameters[0])
    p_n = (1.0 + parameters[1]) * compression(approach, d_nn, d_nt, stages)
    remainder = normal_rate - approach
    return complete(
        p_n, stages, remainder, normal_rate, tangential_rate, d_nn, d_nt, d_tt, parameters
    )
