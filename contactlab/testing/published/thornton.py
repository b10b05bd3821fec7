"""Thornton (1997): the restitution of an elastic, perfectly plastic sphere."""

from math import sqrt

from contactlab.laws import Composed, Coulomb
from contactlab.laws.normal import Thornton
from contactlab.testing.claim import Claims, close
from contactlab.testing.closed_forms import restitution
from contactlab.testing.plants import block, run


def rebound(mass: float = 2e-3, ratio: float = 4.0) -> Claims:
    """e^2 = 6 sqrt(3)/5 (1 - s^2/6) [s/(s + 2 sqrt(6/5 - s^2/5))]^(1/2), s = V_y/V (1997, eq. 35)."""
    normal = Thornton(yield_pressure=5e8)
    stiffness, depth = normal.parameters()
    first_yield = sqrt(0.8 * stiffness * depth**2.5 / mass)
    speed, s = ratio * first_yield, 1.0 / ratio
    square = 1.2 * sqrt(3.0) * (1.0 - s * s / 6.0) * sqrt(s / (s + 2.0 * sqrt(1.2 - 0.2 * s * s)))
    law = Composed(normal, friction=Coulomb(0.0))
    motor = block(mass, height=1e-7, gap_rate=-speed)
    result = restitution(run(motor, law, 1e-7 / speed + 20.0 * depth / first_yield))
    yield close(f"restitution at {ratio:g} times the speed of yield", result, sqrt(square), 1e-6)
