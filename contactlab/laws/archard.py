"""A Hertz contact with Coulomb friction whose surfaces wear."""

from dataclasses import dataclass
from typing import Annotated, Any, final

from contactlab.compiled import inner_kernel, kernel
from contactlab.laws.base import PenaltyLaw
from contactlab.laws.declaration import FRICTION_COEFFICIENT
from contactlab.laws.memory import InternalVariable
from contactlab.laws.normal import hertz_elastic
from contactlab.parameter import not_negative, positive


@inner_kernel
def wear_rate(normal, slip, parameters):
    """Give the rate of the depth worn off [m/s]."""
    return parameters[2] * max(normal, 0.0) * abs(slip) / (parameters[3] * parameters[4])


@kernel
def worn_hertz(gap, gap_rate, slip, impact_speed, z, parameters):
    """Give force and bound [N], stored energy [J] and what wears off with it [W]; z[0] = w [m]."""
    normal, stored, _, _ = hertz_elastic(max(-gap - z[0], 0.0), parameters, 0)
    return normal, parameters[1] * normal, stored, normal * wear_rate(normal, slip, parameters)


@final
@dataclass(frozen=True)
class Archard(PenaltyLaw):
    """A Hertz point contact whose surface recedes by w, in proportion to load and way (Archard's law).

        A dw/dt = (k/H) N |v|,  N = K max(-g - w, 0)^1.5,  V = 2/5 K max(-g - w, 0)^2.5

    The volume worn off, A w = (k/H) int N |v| dt, stays for the whole run, and what comes down later has
    the more clearance. The apparent area A over which it is spread is a constant, of the order of the
    contact's radius squared or that of a patch already run in, and the curvature keeps its value too. What
    was pressed and wears off takes its elastic energy along, N dw/dt, a loss of the contact.
    """

    name = "archard"
    equation = (
        "dw/dt = k N |v| / (H A), N = K max(-g - w, 0)^1.5, |F| <= mu N, F = -mu N sign(v) where v != 0"
    )
    source = "Archard (1953), J. Appl. Phys. 24, 981; Hertz (1881)"
    default_contact_step = 4e-6
    internal_variables = (InternalVariable("wear", "w", "m", "depth worn off", life="run"),)

    stiffness: Annotated[float, positive("K", "N m-1.5", "contact stiffness")] = 1e10
    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    wear_coefficient: Annotated[float, not_negative("k", "1", "wear coefficient")] = 1e-4
    hardness: Annotated[float, positive("H", "Pa", "hardness of the softer body")] = 2e9
    apparent_area: Annotated[float, positive("A", "m2", "apparent area of contact")] = 1e-8

    @property
    def force(self) -> Any:
        """See `PenaltyLaw.force`."""
        return worn_hertz

    @staticmethod
    @kernel
    def rate(which, gap, gap_rate, slip, normal, z, parameters):
        """See `contactlab.laws.memory`: dw/dt [m/s]."""
        return wear_rate(normal, slip, parameters)

    @staticmethod
    @kernel
    def limits(z, parameters):
        """See `contactlab.laws.memory`: the contact is where the surface has receded to."""
        return -z[0], -z[0]
