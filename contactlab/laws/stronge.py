"""Stronge's restitution of energy in a rigid impact."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt
from types import MappingProxyType
from typing import Annotated, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import inner_kernel, kernel
from contactlab.laws.base import MultiplierKernel, MultiplierLaw
from contactlab.laws.impact_process import (
    Stages,
    complete,
    compression,
    impact_approach,
    stages_of,
)
from contactlab.laws.lagrange_stick import stick_or_slip_impulse
from contactlab.laws.parameter import FRICTION_COEFFICIENT, RESTITUTION

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class Stronge(MultiplierLaw):
    """A rigid impact that gives back a share of the work of compression, with Coulomb friction.

        int_pc^p gdot dp = -e^2 int_0^pc gdot dp,  gdot(p_c) = 0;
        |dp_t| <= mu dp, slip != 0 => dp_t = -mu dp sign(slip)

    The friction impulse follows the slip through the impact (`contactlab.laws.impact_process`), and can
    only take energy; the normal impulse gives back no more than it took. So no impact creates energy.
    Contact that lasts has no restitution and is that of `lagrange_stick`.

    Source: Stronge (1990), Rigid body collisions with friction, Proc. R. Soc. A 431, 169.

    Args:
        friction_coefficient: mu [1].
        restitution: e, whose square is that of the work [1].
    """

    name: ClassVar[str] = "stronge"
    equation: ClassVar[str] = (
        "int_pc^p gdot dp = -e^2 int_0^pc gdot dp, dp_t = -mu dp sign(v) or v = 0"
    )
    source: ClassVar[str] = "Stronge (1990), Proc. R. Soc. A 431, 169"
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
        return stronge_impulse


@kernel
def stronge_impulse(
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
    p_n = _restituted(approach, d_nn, d_nt, stages, parameters[1])
    remainder = normal_rate - approach
    return complete(
        p_n, stages, remainder, normal_rate, tangential_rate, d_nn, d_nt, d_tt, parameters
    )


@inner_kernel
def _restituted(approach: float, d_nn: float, d_nt: float, stages: Stages, e: float) -> float:
    """Normal impulse at which the share e^2 of the work of compression has been given back [N s].

    Args:
        approach, d_nn, d_nt, stages: as in `compression`.
        e: restitution [1].
    """
    end, before, after, _ = stages
    p_c = compression(approach, d_nn, d_nt, stages)
    first, second = d_nn + d_nt * before, d_nn + d_nt * after
    if p_c > end:
        # Compression outlasts the slip: triangles of work up to there and from there.
        rate = approach + first * end
        work = -0.5 * (approach + rate) * end + 0.5 * rate * rate / second
        return p_c + e * sqrt(2.0 * work / second)
    if (1.0 + e) * p_c <= end:
        return (1.0 + e) * p_c
    # The slip ends in restitution, at a rate that has given back a part; the rest is quadratic.
    rate = first * (end - p_c)
    rest = 0.5 * (e * approach * e * approach - rate * rate) / first
    return end + 2.0 * rest / (rate + sqrt(rate * rate + 2.0 * second * rest))
