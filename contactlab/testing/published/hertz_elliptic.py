"""Johnson, Contact Mechanics (1985), sec. 4.2: elliptic contacts and their circular limit."""

from contactlab.laws import HertzElliptic
from contactlab.testing.claim import Claims, close


def circular(radius: float = 4e-3, modulus: float = 1e11, depth: float = 1e-6) -> Claims:
    """With equal radii it is N = 4/3 E* R^0.5 d^1.5 (Johnson 1985, eq. 4.23)."""
    normal = HertzElliptic(radius, radius, modulus)
    result = normal.evaluate("elastic", depth=depth)[0]
    expected = 4.0 / 3.0 * modulus * radius**0.5 * depth**1.5
    yield close("elliptic contact of equal radii: force", result, expected, 1e-12, "N")
