"""Moreau-Jean time stepping: a rigid contact as a constraint on velocities."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, final

from contactlab.laws.impact_process import ImpactLaw
from contactlab.laws.newton import VIOLATIONS, newton_impulse


@final
@dataclass(frozen=True)
class MoreauJean(ImpactLaw):
    """The constraint of a closed gap on velocities only, with Newton's restitution of every step.

    The impulses are those of `newton`. No displacement is put back onto the closed gap: the contact
    penetrates by O(step), at first by what the impact step travels, and lasts, in the end without
    impulse, until a step begins with an open gap. A gap that opens from rest as the cube of time has its
    contact longer by O(step^(1/3)) for that; state and impulses converge at order one.

    Source: Moreau (1988), Unilateral contact and dry friction in finite freedom dynamics; Jean (1999).
    """

    name: ClassVar[str] = "moreau_jean"
    equation: ClassVar[str] = (
        "0 <= p _|_ gdot_end + e gdot_start >= 0 where g <= 0, |p_t| <= mu p, p_t = -mu p sign(v_end)"
    )
    source: ClassVar[str] = "Moreau (1988); Jean (1999), Comput. Methods Appl. Mech. Eng. 177, 235"
    projects: ClassVar[bool] = False
    violations: ClassVar[Mapping[str, str]] = VIOLATIONS

    solve = staticmethod(newton_impulse)
