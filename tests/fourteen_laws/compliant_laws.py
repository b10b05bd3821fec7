"""Normal forces of the literature: a power of the depth, a spring and dashpot, and a damped Hertz contact."""

from dataclasses import dataclass
from math import log, pi, sqrt
from types import MappingProxyType
from typing import Annotated

from contactlab.compiled import kernel
from contactlab.laws import FRICTION_COEFFICIENT, NormalForce, Parameter, PenaltyLaw
from contactlab.parameter import positive

RESTITUTION = Parameter("e", "1", "restitution of a free impact", above=0.0, at_most=1.0)


@dataclass(frozen=True)
class Power(NormalForce):
    """A force that grows with a power of the depth, as that of a rough surface or an axisymmetric punch."""

    name = "power"
    equation = "N = P (d/d_0)^n"
    source = "Galin (1946); Johnson, Contact Mechanics (1985), sec. 5.3"

    load: Annotated[float, positive("P", "N", "load at d_0")] = 10.0
    unit_depth: Annotated[float, positive("d_0", "m", "depth at P")] = 1e-6
    exponent: Annotated[float, Parameter("n", "1", "exponent", at_least=1.0, at_most=4.0)] = 2.0

    @staticmethod
    @kernel
    def elastic(depth, load, unit_depth, exponent):
        n = exponent
        stiffness = n * load / unit_depth * (depth / unit_depth) ** (n - 1.0)
        slope = (n - 1.0) * stiffness / depth if depth > 0.0 else 0.0
        return stiffness * depth / n, stiffness * depth**2 / (n * (n + 1.0)), stiffness, slope


@dataclass(frozen=True)
class KelvinVoigt(PenaltyLaw):
    """A spring and dashpot side by side; it pulls before the gap opens."""

    name = "kelvin_voigt"
    equation = "N = k d + c dd/dt, |F| <= mu max(N, 0)"
    source = "Goldsmith, Impact (1960)"
    default_contact_step = 4e-6
    allows_tension = True
    violations = MappingProxyType(
        {"inside_the_cone": "friction ends with a kink where the dashpot begins to pull, inside of a step."}
    )

    stiffness: Annotated[float, positive("k", "N m-1", "contact stiffness")] = 1e7
    damping: Annotated[float, positive("c", "N s m-1", "contact damping")] = 20.0
    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    @staticmethod
    @kernel
    def force(depth, depth_rate, stiffness, damping, friction_coefficient):
        normal = stiffness * depth + damping * depth_rate
        bound, stored = friction_coefficient * max(normal, 0.0), 0.5 * stiffness * depth * depth
        return normal, bound, stored, damping * depth_rate * depth_rate


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
