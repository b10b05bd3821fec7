"""Palmgren (1959): the approach of steel rollers."""

from contactlab.laws import Line
from contactlab.testing.claim import Claims, close


def palmgren(length: float = 10e-3, force: float = 500.0) -> Claims:
    """With steel it is d = 3.84e-5 N^0.9 / L^0.8 in newtons and millimetres (Palmgren 1959)."""
    depth = 3.84e-5 * force**0.9 / (1e3 * length) ** 0.8 * 1e-3
    normal = Line(length)
    result = normal.evaluate("elastic", depth=depth)[0]
    # His coefficient is one of measurements; that of the law follows from a modulus.
    yield close("line: force at the approach of Palmgren's rule", result, force, 0.03, "N")
