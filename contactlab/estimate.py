"""A number with its error, and how both are written."""

from collections.abc import Callable
from math import ceil, floor, inf, isinf, isnan, log10
from typing import Final, NamedTuple, final

MOST_DIGITS: Final = 9
"""Significant digits of a value with a small error."""

EXACT_DIGITS: Final = 5
"""Significant digits of a value without an error."""

ROUND_OFF: Final = 1e-9
"""Relative error that is not shown, as the digits of the value do not reach it."""

FIXED: Final = 1e-4, 1e6
"""Sizes of numbers that are written without a power of ten, the second excluded."""


@final
class Estimate(NamedTuple):
    """A number and its error, in one unit; the error is NaN where none is known, infinite without a limit.

    >>> import contactlab as cl
    >>> velocity = cl.steady(cl.build()).velocity
    >>> round(velocity.value, 6), velocity.error < 1e-6
    (-2.191106, True)
    >>> cl.Estimate(-2.19118, 0.00213).text(), cl.Estimate(2.0e-6, 5.9e-5).text()
    ('-2.1912 +- 0.0021', '0 within 6.1e-05')
    """

    value: float
    error: float

    def text(self, plus_minus: str = "+-", digits: int | None = None) -> str:
        """Return the value and its error, both to the second digit of the error.

        A value that is not larger than its error is not distinguished from zero: "0 within B" states the
        bound B = |value| + error. An error that is zero, unknown or beyond the digits of the value is not
        shown.

        Args:
            plus_minus: sign between the two.
            digits: significant digits of the value at most; `MOST_DIGITS` and `EXACT_DIGITS` without.
        """
        # Adding zero removes the sign of a negative zero.
        value, error = self.value + 0.0, self.error
        size = abs(value)
        if isinf(error) or size < inf == size + error:
            return "no limit"
        if (
            isinf(value)
            or isnan(value + error)
            or error <= size * (10.0 ** (1 - digits) if digits else ROUND_OFF)
        ):
            return exact(value, digits)
        if error >= size:
            return f"0 within {_two_digits(size + error, ceil)}"
        # The error is rounded first: 0.0999 is 0.10.
        last = 1 - floor(log10(float(f"{error:.1e}")))
        last = min(last, (digits or MOST_DIGITS) - 1 - floor(log10(size)))
        return f"{_to_place(round(value, last), last)} {plus_minus} {_two_digits(error, round)}"


def exact(value: float, digits: int | None = None) -> str:
    """Return a number without an error; empty for NaN."""
    if isnan(value):
        return ""
    if isinf(value):
        return "infinite" if value > 0.0 else "-infinite"
    rounded = float(f"{value:.{digits or EXACT_DIGITS}g}") + 0.0
    return f"{rounded:.{MOST_DIGITS if digits else EXACT_DIGITS}g}"


def _two_digits(size: float, rounded: Callable[[float], int]) -> str:
    """Return a positive number to two digits, rounded to whole units of the second one."""
    place = floor(log10(size)) - 1
    # A bound is not raised by the round-off of its quotient.
    number = float(f"{rounded(float(f'{size / 10.0**place:.9g}'))}e{place}")
    return _to_place(number, 1 - floor(log10(number)))


def _to_place(number: float, last: int) -> str:
    """Return a number with so many decimals, with a power of ten if it is very small or large."""
    if FIXED[0] <= abs(number) < FIXED[1]:
        return f"{number:.{max(last, 0)}f}"
    return f"{number:.{max(floor(log10(abs(number))) + last, 0)}e}"
