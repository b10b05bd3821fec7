"""Moreau-Jean time stepping: a rigid contact as a constraint on velocities."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, ClassVar, final

from contactlab.laws.base import MultiplierKernel, MultiplierLaw
from contactlab.laws.newton import newton_impulse
from contactlab.laws.parameter import FRICTION_COEFFICIENT, RESTITUTION


@final
@dataclass(frozen=True)
class MoreauJean(MultiplierLaw):
    """The constraint of a closed gap on velocities only, with Newton's restitution of every step.

        g <= 0:  0 <= p  _|_  gdot_end + e gdot_start >= 0
        |p_t| <= mu p,  v_end != 0 => p_t = -mu p sign(v_end)

    The impulses are those of `newton`. No displacement is put back onto the closed gap: the contact
    penetrates by O(step), at first by what the impact step travels, and lasts, in the end without
    impulse, until a step begins with an open gap. A gap that opens from rest as the cube of time has its
    contact longer by O(step^(1/3)) for that; state and impulses converge at order one.

    Source: Moreau (1988), Unilateral contact and dry friction in finite freedom dynamics; Jean (1999),
    Comput. Methods Appl. Mech. Eng. 177, 235.

    Args:
        friction_coefficient: mu [1].
        restitution: e, of the gap rate [1].
    """

    name: ClassVar[str] = "moreau_jean"
    equation: ClassVar[str] = (
        "0 <= p _|_ gdot_end + e gdot_start >= 0 where g <= 0, |p_t| <= mu p, p_t = -mu p sign(v_end)"
    )
    source: ClassVar[str] = "Moreau (1988); Jean (1999), Comput. Methods Appl. Mech. Eng. 177, 235"
    default_contact_step: ClassVar[float] = 5e-8
    projects: ClassVar[bool] = False
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
        """The kernel, that of `newton`; see `MultiplierLaw.solve`."""
        return newton_impulse
