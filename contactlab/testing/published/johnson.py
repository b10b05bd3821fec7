"""Johnson (1985), eqs. 11.46 and 11.47: the restitution of a ball that yields."""

from math import sqrt

from contactlab.laws import Johnson
from contactlab.testing.claim import Claims, close
from contactlab.testing.plants import impulses_of


def restitution(modulus: float = 115e9, strength: float = 3e8, radius: float = 4.5e-3) -> Claims:
    """Johnson's e over (Y/E*)^(1/2) (m V^2/(2 Y R^3))^(-1/8), printed as 3.8; derived it is 3.743."""
    law, mass, speed = Johnson(0.3, modulus, strength, radius), 2e-3, 3.0
    p_n, _, _ = impulses_of(law, -speed, 0.0, (1.0 / mass, 0.0, 1.0 / mass))
    shape = sqrt(strength / modulus) * (0.5 * mass * speed**2 / (strength * radius**3)) ** -0.125
    yield close("factor of eq. 11.47", (p_n / (mass * speed) - 1.0) / shape, 3.8, 0.016)
