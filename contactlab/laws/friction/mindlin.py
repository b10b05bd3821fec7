"""A tangential spring that slides at Coulomb's cone."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import copysign
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import ELASTOPLASTIC, RATE_DEPENDENT, Friction
from contactlab.laws.declaration import Coefficient
from contactlab.laws.memory import ODD, InternalVariable, dependent
from contactlab.parameter import positive

VISCOUS_TIME = positive("tau", "s", "dashpot over the spring")


@final
@dataclass(frozen=True)
class Mindlin(Friction):
    """A Jenkins element: a spring of stiffness k_t = kappa dN/dd that slides at mu N.

        F = -k_t z,  |F| <= mu N,  dz/dt = v - z max(dk_t/dt, 0) / k_t - (sliding)

    While the contact grows, what it gains in stiffness is new and carries nothing: the force stays,
    the stretch z shrinks. While it shrinks, what it loses takes its share of the force along. Either
    way 1/2 z^2 |dk_t/dt| is lost, and no cycle of load makes energy (Elata and Berryman 1996), as it
    would with a force that stays in unloading. Microslip is left out, which `microslip` has.

    A viscous time tau puts a dashpot tau k_t along the spring, inside of the cone, as Cundall and Strack
    (1979), Geotechnique 29, 47, have it: F = -k_t (z + tau w) with w = v - (sliding). A swing of what the
    contact holds has the damping ratio tau omega/2, omega = sqrt(k_t D_tt). In sliding the element relaxes
    to mu N within tau, where they leave the dashpot out. tau k_t w^2 is lost. Friction is then
    rate-dependent: it has no modes, and the edge of the cone lies within a step.

    Source: Mindlin (1949) for kappa = 2 (1 - nu)/(2 - nu) between equal bodies, 0.82 for steel; Thornton
    and Randall (1988) and Elata and Berryman (1996), Mech. Mater. 24, 229, for the unloading.
    """

    name = "mindlin"
    equation = "F = -kappa (dN/dd) z, |F| <= mu N, dz/dt = v - sliding"
    source = "Mindlin (1949), J. Appl. Mech. 16, 259; Elata and Berryman (1996)"
    validity = "displacements from full slip on: without microslip"
    exact_stick = False
    internal_variables = (InternalVariable("stretch", "z", "m", "stretch of the spring", parity=ODD),)

    stiffness_ratio: Annotated[float, positive("kappa", "1", "tangential over normal stiffness")] = 0.82
    viscous_time: Annotated[float | None, VISCOUS_TIME] = None

    @dependent
    def friction_kind(self) -> int:
        """A slider that ends a spring, or with a dashpot a function of slip and stretch."""
        return ELASTOPLASTIC if self.viscous_time is None else RATE_DEPENDENT

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return the fields by name; the viscous time of a spring alone is zero."""
        return {**super().coefficients(), "viscous_time": self.viscous_time or 0.0}

    @staticmethod
    @kernel
    def state(
        normal,
        normal_stiffness,
        normal_stiffness_rate,
        slip,
        stretch,
        friction_coefficient,
        stiffness_ratio,
        viscous_time,
    ):
        tangential = stiffness_ratio * normal_stiffness
        growth = max(normal_stiffness_rate, 0.0) / normal_stiffness if normal_stiffness > 0.0 else 0.0
        force, rate = -tangential * (stretch + viscous_time * slip), slip
        bound = friction_coefficient * max(normal, 0.0)
        if viscous_time > 0.0 and abs(force) > bound:
            force = copysign(bound, force)
            rate = -(force / tangential + stretch) / viscous_time
        return force, rate - growth * stretch, 0.5 * tangential * stretch * stretch, tangential
