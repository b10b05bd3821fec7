"""Rigid impacts of a ball that yields: the restitution falls with the speed of each."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import MultiplierLaw
from contactlab.laws.declaration import FRICTION_COEFFICIENT, Coefficient
from contactlab.laws.impact.newton import OF_THE_GAP_RATE
from contactlab.laws.lagrange import stick_or_slip_impulse
from contactlab.parameter import positive

HARDNESS = 3.0
"""Pressure at which a ball yields all over, in yield strengths."""

FIRST_YIELD = 1.6
"""Peak pressure at which a ball begins to yield under its surface, in yield strengths."""


@final
@dataclass(frozen=True)
class Johnson(MultiplierLaw):
    """Newton's impact with the restitution of a ball that yields all over and springs back as of Hertz.

    At the pressure p_d = 3 Y the dent takes m V^2/2 = pi a^4 p_d/(4 R); from it P = pi a^2 p_d gives back
    3 P^2/(10 a E*). Their ratio is e^2, and e falls as V^(-1/4). The mass is that of the impact, 1/d_nn.
    The factor of the equation is 3.743; Johnson's eq. 11.47 prints 3.8. Up to 27 times the speed of
    `first_yield` that form gives back more than came, and e is one; in truth e falls below one at first yield
    and meets the form from below.
    """

    name = "johnson"
    equation = "gdot+ = -e gdot-, e = min(1, 3.74 (Y/E*)^(1/2) (m gdot-^2/(2 Y R^3))^(-1/8)), m = 1/d_nn"
    source = "Johnson (1985), Contact Mechanics, eqs. 11.46 and 11.47"
    validity = "balls that have yielded all over, with a small dent"
    default_contact_step = 5e-8
    violations = OF_THE_GAP_RATE

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    modulus: Annotated[float, positive("E*", "Pa", "effective modulus")] = 59e9
    yield_strength: Annotated[float, positive("Y", "Pa", "yield strength of the softer body")] = 1e8
    radius: Annotated[float, positive("R", "m", "effective radius, 1/(1/R1 + 1/R2)")] = 4.5e-3

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return mu, and the energy m V^2 below which e is one [J]: e = (that / (m V^2))^(1/8)."""
        pressure = HARDNESS * self.yield_strength
        square = 0.3 * pi**1.25 * 4.0**0.75 * pressure / self.modulus
        energy = 2.0 * pressure * self.radius**3 * square**4
        return {"friction_coefficient": self.friction_coefficient, "elastic_energy": energy}

    def first_yield(self, mass: float) -> float:
        """Return the speed at which a mass [kg] begins to dent [m/s]: p_0 = 1.6 Y of Hertz.

        m V^2/2 = pi^5 p_0^5 R^3/(60 E*^4), about 53 Y^5 R^3/E*^4.
        """
        pressure = FIRST_YIELD * self.yield_strength
        energy = pi**5 * pressure**5 * self.radius**3 / (60.0 * self.modulus**4)
        return float((2.0 * energy / mass) ** 0.5)

    @staticmethod
    @kernel
    def impact(approach, slip, d_nn, d_nt, d_tt, friction_coefficient, elastic_energy):
        share = elastic_energy * d_nn
        square = approach * approach
        e = 1.0 if square <= share else (share / square) ** 0.125
        missing = approach + e * approach
        return stick_or_slip_impulse(missing, slip, d_nn, d_nt, d_tt, friction_coefficient)
