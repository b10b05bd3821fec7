"""A compliant contact after Hertz with set-valued Coulomb friction."""

from dataclasses import dataclass
from math import sqrt
from typing import Annotated, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel
from contactlab.laws.base import PenaltyKernel, PenaltyLaw
from contactlab.laws.composed import Composed
from contactlab.laws.damping import Undamped
from contactlab.laws.friction.coulomb import Coulomb
from contactlab.laws.normal.hertz_point import HertzPoint, hertz_elastic
from contactlab.laws.parameter import FRICTION_COEFFICIENT
from contactlab.parameter import Parameter

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class HertzPenalty(PenaltyLaw):
    """Hertz point contact with Coulomb friction and exact stick: a composition that has a name.

        N = K max(-g, 0)^(3/2),  V = 2/5 K max(-g, 0)^(5/2),  |F| <= mu N

    Elastic: the normal direction loses nothing. Not valid when the contact radius nears the tip's,
    nor above the yield limit.

    Source: Hertz (1881); K. L. Johnson, Contact Mechanics (1985), eq. 4.23.

    Args:
        stiffness: K [N m^-3/2]; `hertz_stiffness` gives it from radii and moduli.
        friction_coefficient: mu [1].
    """

    name: ClassVar[str] = "hertz_penalty"
    equation: ClassVar[str] = "N = K max(-g, 0)^1.5, |F| <= mu N, F = -mu N sign(v) where v != 0"
    source: ClassVar[str] = "Hertz (1881); Johnson, Contact Mechanics (1985), eq. 4.23"
    default_contact_step: ClassVar[float] = 4e-6

    stiffness: Annotated[float, Parameter("K", "N m-1.5", "contact stiffness", above=0.0)] = 1e10
    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    @property
    def composition(self) -> Composed:
        """The same law out of its parts."""
        return Composed(HertzPoint(self.stiffness), Undamped(), Coulomb(self.friction_coefficient))

    @property
    def force(self) -> PenaltyKernel:
        """The kernel; see `PenaltyLaw.force`."""
        return hertz_force


# What the composition's kernel does, under a name: its code is kept, so that the default law starts at once.
@kernel
def hertz_force(
    gap: float, gap_rate: float, slip: float, approach: float, parameters: Array
) -> tuple[float, float, float, float]:
    """Normal force [N], friction bound [N], stored energy [J], normal loss [W]."""
    normal, stored, _, _ = hertz_elastic(max(-gap, 0.0), parameters, 0)
    return normal, parameters[1] * normal, stored, 0.0


def hertz_stiffness(
    tip_radius: float,
    rotor_radius: float,
    youngs_modulus: float = 210e9,
    poisson_ratio: float = 0.3,
) -> float:
    """K = 4/3 E* sqrt(R_e) of a spherical tip on a cylindrical rotor of the same material [N m^-3/2].

        1/E* = 2 (1 - nu^2) / E,   R_e = [ (1/r) (1/r + 1/R) ]^(-1/2)

    R_e is the geometric mean of the two relative radii, exact for a circular contact and good to
    a fraction of a percent in K while r is well below R (Johnson 1985, sec. 4.2).

    Args:
        tip_radius: r [m].
        rotor_radius: R [m].
        youngs_modulus: E [Pa] of both bodies.
        poisson_ratio: nu [1] of both bodies.
    """
    effective_modulus = youngs_modulus / (2.0 * (1.0 - poisson_ratio**2))
    effective_radius = ((1.0 / tip_radius) * (1.0 / tip_radius + 1.0 / rotor_radius)) ** -0.5
    return 4.0 / 3.0 * effective_modulus * sqrt(effective_radius)
