"""A number with its error, and how both are written."""

from math import floor, isfinite, log10
from typing import Final, NamedTuple, final

MOST_DIGITS: Final = 9
"""Significant digits of a value with a small error, or with none."""


@final
class Estimate(NamedTuple):
    """A number and its error, in one unit; the error is NaN where none is known.

    >>> import contactlab as cl
    >>> velocity = cl.steady(cl.build()).velocity
    >>> round(velocity.value, 6), velocity.error < 1e-6
    (-2.191106, True)
    >>> cl.Estimate(-2.19118, 0.00213).text()
    '-2.1912 +- 0.0021'
    """

    value: float
    error: float

    def text(self, plus_minus: str = "+-", most: int = MOST_DIGITS) -> str:
        """Return the value, rounded to the second digit of the error, and the error.

        Args:
            plus_minus: sign between the two.
            most: significant digits of the value at most.
        """
        # Adding zero removes the sign of a negative zero.
        value, error = self.value + 0.0, self.error
        if not (isfinite(value) and isfinite(error)):
            return f"{value:.4g} {plus_minus} {error:.2g}"
        if error <= 0.0:
            return f"{value:.{most}g} {plus_minus} 0"
        # What is left of a value far below its error is round-off.
        value = round(value, 1 - floor(log10(error))) + 0.0
        size = max(abs(value), error)
        digits = min(floor(log10(size)) - floor(log10(error)) + 2, most)
        return f"{value:#.{digits}g}".removesuffix(".") + f" {plus_minus} {error:.2g}"
