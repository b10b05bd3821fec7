"""A Hertz contact with Coulomb friction whose surfaces wear."""

from dataclasses import dataclass
from typing import Annotated, final

from contactlab.compiler.kernels import inner_kernel, kernel
from contactlab.laws.base import PenaltyLaw
from contactlab.laws.declaration import FRICTION_COEFFICIENT
from contactlab.laws.memory import InternalVariable
from contactlab.laws.normal import hertz_elastic
from contactlab.parameter import not_negative, positive


@inner_kernel
def wear_rate(normal, slip, wear_coefficient, hardness, apparent_area):
    """Return the rate of the depth worn off [m/s]."""
    return wear_coefficient * max(normal, 0.0) * abs(slip) / (hardness * apparent_area)


@final
@dataclass(frozen=True)
class Archard(PenaltyLaw):
    """A Hertz point contact whose surface recedes by w, in proportion to load and way (Archard's law).

    Stored is V = 2/5 K max(-g - w, 0)^2.5. The volume worn off, A w = (k/H) int N |v| dt, stays for the whole
    run, and what comes down later has the more clearance. The apparent area A over which it is spread is a
    constant, of the order of the contact's radius squared or that of a patch already run in, and the
    curvature keeps its value too. What was pressed and wears off takes its elastic energy along, N dw/dt, a
    loss of the contact.
    """

    name = "archard"
    equation = (
        "dw/dt = k N |v| / (H A), N = K max(-g - w, 0)^1.5, |F| <= mu N, F = -mu N sign(v) where v != 0"
    )
    source = "Archard (1953), J. Appl. Phys. 24, 981; Hertz (1881)"
    validity = "a patch that is run in, of constant area and curvature"
    default_contact_step = 4e-6
    internal_variables = (InternalVariable("wear", "w", "m", "depth worn off", life="run"),)

    stiffness: Annotated[float, positive("K", "N m-1.5", "contact stiffness")] = 1e10
    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    wear_coefficient: Annotated[float, not_negative("k", "1", "wear coefficient")] = 1e-4
    hardness: Annotated[float, positive("H", "Pa", "hardness of the softer body")] = 2e9
    apparent_area: Annotated[float, positive("A", "m2", "apparent area of contact")] = 1e-8

    @staticmethod
    @kernel
    def force(depth, slip, wear, stiffness, friction_coefficient, wear_coefficient, hardness, apparent_area):
        normal, stored, _, _ = hertz_elastic(max(depth - wear, 0.0), stiffness)
        worn = normal * wear_rate(normal, slip, wear_coefficient, hardness, apparent_area)
        return normal, friction_coefficient * normal, stored, worn

    @staticmethod
    @kernel
    def rate(normal, slip, wear_coefficient, hardness, apparent_area):
        return wear_rate(normal, slip, wear_coefficient, hardness, apparent_area)

    @staticmethod
    @kernel
    def limits(wear):
        return -wear, -wear
