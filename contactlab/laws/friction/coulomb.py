"""Coulomb's cone: set-valued friction with tangentially rigid stick."""

from dataclasses import dataclass
from typing import Annotated, final

from contactlab.laws.base import Friction
from contactlab.parameter import Parameter

STATIC_RATIO = Parameter("mu_s/mu", "1", "static over kinetic coefficient", at_least=1.0)


@final
@dataclass(frozen=True)
class Coulomb(Friction):
    """Set-valued friction: tangentially rigid stick."""

    name = "coulomb"
    equation = "|F| <= mu_s N, F = -mu N sign(v) where v != 0"
    source = "Coulomb (1785); Moreau (1988)"
    validity = "displacements far beyond the elastic one of the contact"

    static_ratio: Annotated[float, STATIC_RATIO] = 1.0
