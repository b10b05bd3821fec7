"""Coulomb's cone: set-valued friction with exact stick."""

from dataclasses import dataclass
from typing import Annotated, final

from contactlab.arrays import Array
from contactlab.compiled import kernel
from contactlab.laws.base import Friction
from contactlab.parameter import Parameter

STATIC_RATIO = Parameter("mu_s/mu", "1", "static over kinetic coefficient", at_least=1.0)


@kernel
def cone_bound(normal: float, slip: float, parameters: Array, at: int) -> float:
    """Give the largest friction [N]: mu_s N in stick, where the slip [m/s] is exactly zero, else mu N.

    A pull N < 0 gives no friction. From the place `at` on stand mu and mu_s / mu.
    """
    ratio = parameters[at + 1] if slip == 0.0 else 1.0
    return float(parameters[at] * ratio * max(normal, 0.0))


@final
@dataclass(frozen=True)
class Coulomb(Friction):
    """Set-valued friction: exact stick."""

    name = "coulomb"
    equation = "|F| <= mu_s N, F = -mu N sign(v) where v != 0"
    source = "Coulomb (1785); Moreau (1988)"

    static_ratio: Annotated[float, STATIC_RATIO] = 1.0
