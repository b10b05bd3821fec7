"""Set-valued Coulomb friction."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, final

from contactlab.laws.parameter import FRICTION_COEFFICIENT
from contactlab.laws.part import Friction
from contactlab.parameter import Parameter

STATIC_RATIO = Parameter("mu_s/mu", "1", "static over kinetic coefficient", at_least=1.0)
"""Shared by the friction laws that hold more than they drag."""


@final
@dataclass(frozen=True)
class Coulomb(Friction):
    """|F| <= mu_s N in stick, F = -mu N sign(v) in slip; exact stick.

    Source: Coulomb (1785); Moreau (1988) in the set-valued form.

    Args:
        friction_coefficient: mu of slip [1].
        static_ratio: mu_s / mu [1].
    """

    name: ClassVar[str] = "coulomb"
    equation: ClassVar[str] = "|F| <= mu_s N, F = -mu N sign(v) where v != 0"
    source: ClassVar[str] = "Coulomb (1785); Moreau (1988)"

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    static_ratio: Annotated[float, STATIC_RATIO] = 1.0
