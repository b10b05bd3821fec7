"""Adhesion of hard, small spheres: Hertz, and a pull of the surfaces around the contact."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi, sqrt
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import NormalForce
from contactlab.laws.declaration import Coefficient
from contactlab.laws.normal.elastic import EFFECTIVE_MODULUS, STEEL, hertz_elastic
from contactlab.laws.normal.jkr import ADHESION, RADIUS


@final
@dataclass(frozen=True)
class Dmt(NormalForce):
    """Hertz less the constant force 2 pi w R with which the surfaces pull while they touch.

    The force jumps by it at the touch and at the release, both at a gap of zero: what it does on the way in
    it takes on the way out, and the impact is elastic. Its reach outside of the contact is left out.
    """

    name = "dmt"
    equation = "N = 4/3 E* sqrt(R) d^1.5 - 2 pi w R"
    source = "Derjaguin, Muller and Toporov (1975), J. Colloid Interface Sci. 53, 314"
    validity = "Tabor number below 0.1"
    allows_tension = True
    convergence_order = 0.9

    radius: Annotated[float, RADIUS] = 4.2e-3
    effective_modulus: Annotated[float, EFFECTIVE_MODULUS] = STEEL
    work_of_adhesion: Annotated[float, ADHESION] = 0.1

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return the stiffness K of N = K d^1.5 [N m^-1.5] and the pull [N]."""
        return {
            "stiffness": 4.0 / 3.0 * self.effective_modulus * sqrt(self.radius),
            "pull": 2.0 * pi * self.work_of_adhesion * self.radius,
        }

    @staticmethod
    @kernel
    def elastic(depth, stiffness, pull):
        force, energy, tangent, slope = hertz_elastic(depth, stiffness)
        return force - pull, energy - pull * depth, tangent, slope
