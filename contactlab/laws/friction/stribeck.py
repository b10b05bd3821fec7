"""Set-valued friction that falls from its static to its kinetic value as slip grows."""

from dataclasses import dataclass
from math import exp
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import Friction
from contactlab.laws.friction.coulomb import STATIC_RATIO
from contactlab.parameter import positive


@final
@dataclass(frozen=True)
class Stribeck(Friction):
    """Coulomb's cone with a Stribeck curve for its coefficient: rigid stick, and no jump where it ends.

    Steady sliding of a mass m on a spring without damping grows at the rate -N mu'(v)/(2 m): it chatters
    wherever the curve falls. p is 1 with Tustin, 2 with Armstrong-Helouvry, 0.5 to 1 with Bo and Pavelescu
    (1982), Wear 82, 277; for p below 1 the curve is infinitely steep at v = 0. As v_s goes to 0 it becomes
    `coulomb`.
    """

    name = "stribeck"
    equation = "|F| <= mu(v) N, F = -mu(v) N sign(v) where v != 0, mu(v) = mu + (mu_s - mu) exp(-(|v|/v_s)^p)"
    source = "Armstrong-Helouvry, Dupont, Canudas de Wit (1994), Automatica 30, 1083"
    validity = "speeds at which viscous friction is small"

    static_ratio: Annotated[float, STATIC_RATIO] = 1.3
    stribeck_velocity: Annotated[float, positive("v_s", "m s-1", "Stribeck velocity")] = 1e-2
    stribeck_exponent: Annotated[float, positive("p", "1", "exponent of the Stribeck curve")] = 1.0

    @staticmethod
    @kernel
    def bound(normal, slip, friction_coefficient, static_ratio, stribeck_velocity, stribeck_exponent):
        fall = exp(-((abs(slip) / stribeck_velocity) ** stribeck_exponent))
        lifted = 1.0 + (static_ratio - 1.0) * fall
        return friction_coefficient * lifted * max(normal, 0.0)
