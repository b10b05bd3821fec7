"""A compliant law of the literature: a Hertz contact with one restitution at all speeds."""

from dataclasses import dataclass
from math import log, pi, sqrt
from typing import Annotated

from contactlab.compiler.kernels import kernel
from contactlab.laws import FRICTION_COEFFICIENT, Parameter, PenaltyLaw
from contactlab.parameter import positive

RESTITUTION = Parameter("e", "1", "restitution of a free impact", above=0.0, at_most=1.0)


@dataclass(frozen=True)
class Tsuji(PenaltyLaw):
    """A Hertz contact whose damping gives one restitution at all speeds; it pulls before the gap opens.

    alpha = -sqrt(5) ln(e) / sqrt(ln(e)^2 + pi^2), by Antypov and Elliott (2011), EPL 94, 50004.
    """

    name = "tsuji"
    equation = "N = K d^1.5 + alpha sqrt(m K) d^0.25 dd/dt, |F| <= mu max(N, 0)"
    source = "Tsuji, Tanaka and Ishida (1992), Powder Technol. 71, 239"
    default_contact_step = 4e-6
    allows_tension = True

    stiffness: Annotated[float, positive("K", "N m-1.5", "contact stiffness")] = 1e10
    effective_mass: Annotated[float, positive("m", "kg", "mass of the impact")] = 2e-3
    restitution: Annotated[float, RESTITUTION] = 0.8
    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    def coefficients(self):
        lost = -log(self.restitution)
        alpha = sqrt(5.0) * lost / sqrt(lost * lost + pi * pi)
        damping = alpha * sqrt(self.effective_mass * self.stiffness)
        return {
            "stiffness": self.stiffness,
            "damping": damping,
            "friction_coefficient": self.friction_coefficient,
        }

    @staticmethod
    @kernel
    def force(depth, depth_rate, stiffness, damping, friction_coefficient):
        spring, dashpot = stiffness * depth * sqrt(depth), damping * sqrt(sqrt(depth))
        normal = spring + dashpot * depth_rate
        bound, loss = friction_coefficient * max(normal, 0.0), dashpot * depth_rate * depth_rate
        return normal, bound, 0.4 * spring * depth, loss
