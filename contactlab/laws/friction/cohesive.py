"""Coulomb's cone with its apex at a pull: friction that cohesion adds to."""

from dataclasses import dataclass
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import Friction
from contactlab.laws.friction.coulomb import STATIC_RATIO
from contactlab.parameter import not_negative


@final
@dataclass(frozen=True)
class Cohesive(Friction):
    """Two-term friction with tangentially rigid stick, as if the force C pressed the bodies together too.

    There is friction at N = 0, from the touch-down on, and under a pull down to -C. Over a normal force
    of Johnson, Kendall and Roberts with the pull-off force F_c, Thornton (1991) has C = 2 F_c, so that
    mu F_c is left at the pull-off; Derjaguin has C = A p_0 of the molecular attraction p_0 over the area
    A. The normal force is the other part's: C itself does not pull. C = 0 is `coulomb`.

    Source: Derjaguin (1934), Z. Phys. 88, 661; Thornton (1991), J. Phys. D 24, 1942.
    """

    name = "cohesive"
    equation = "|F| <= mu_s (N + C), F = -mu (N + C) sign(v) where v != 0"
    source = "Derjaguin (1934), Z. Phys. 88, 661; Thornton (1991), J. Phys. D 24, 1942"
    validity = "normal forces above -C"

    static_ratio: Annotated[float, STATIC_RATIO] = 1.0
    cohesion: Annotated[float, not_negative("C", "N", "force of cohesion in the cone")] = 0.1

    @property
    def friction_offset(self) -> float:
        """C [N]."""
        return self.cohesion

    @staticmethod
    @kernel
    def bound(normal, slip, friction_coefficient, static_ratio, cohesion):
        ratio = static_ratio if slip == 0.0 else 1.0
        return friction_coefficient * ratio * max(normal + cohesion, 0.0)
