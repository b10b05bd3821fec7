"""A tangential spring that slides at Coulomb's cone."""

from dataclasses import dataclass
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import ELASTOPLASTIC, Friction
from contactlab.laws.memory import ODD, InternalVariable
from contactlab.parameter import positive


@final
@dataclass(frozen=True)
class Mindlin(Friction):
    """A Jenkins element: a spring of stiffness k_t = kappa dN/dd that slides at mu N.

        F = -k_t z,  |F| <= mu N,  dz/dt = v - z max(dk_t/dt, 0) / k_t - (sliding)

    While the contact grows, what it gains in stiffness is new and carries nothing: the force stays,
    the stretch z shrinks. While it shrinks, what it loses takes its share of the force along. Either
    way 1/2 z^2 |dk_t/dt| is lost, and no cycle of load makes energy (Elata and Berryman 1996), as it
    would with a force that stays in unloading. Microslip is left out, which `microslip` has.

    Source: Mindlin (1949) for kappa = 2 (1 - nu)/(2 - nu) between equal bodies, 0.82 for steel; Thornton
    and Randall (1988) and Elata and Berryman (1996), Mech. Mater. 24, 229, for the unloading.
    """

    name = "mindlin"
    equation = "F = -kappa (dN/dd) z, |F| <= mu N, dz/dt = v - sliding"
    source = "Mindlin (1949), J. Appl. Mech. 16, 259; Elata and Berryman (1996)"
    validity = "displacements from full slip on: without microslip"
    friction_kind = ELASTOPLASTIC
    exact_stick = False
    internal_variables = (InternalVariable("stretch", "z", "m", "stretch of the spring", parity=ODD),)

    stiffness_ratio: Annotated[float, positive("kappa", "1", "tangential over normal stiffness")] = 0.82

    @staticmethod
    @kernel
    def state(normal_stiffness, normal_stiffness_rate, slip, stretch, stiffness_ratio):
        tangential = stiffness_ratio * normal_stiffness
        growth = max(normal_stiffness_rate, 0.0) / normal_stiffness if normal_stiffness > 0.0 else 0.0
        force = -tangential * stretch
        return force, slip - growth * stretch, -0.5 * force * stretch, tangential
