"""Verdicts on numbers with their uncertainty: true, false, or None where that leaves it open.

A number is compared by `less` alone, which knows its ends; arithmetic carries these. A number whose error
nothing states is off by what a repetition of it may be (`SAME`); one that a closed form gives is `exact`; one
that is not recorded is `NONE`, of which nothing is known.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import product
from math import floor, inf, isfinite, log10, nan
from operator import add, mul, sub, truediv
from typing import Final, NoReturn, Self

from results_store import SAME

from contactlab.studies.compare.paired import binomial_interval


@dataclass(frozen=True, eq=False)
class Number:
    """A number with the ends of its interval at 95 %, or of its stated error."""

    value: float
    low: float
    high: float

    @classmethod
    def of(cls, value: float, error: float | None = None) -> Self:
        """Return a number with its error; None is that of a number which a repetition has to `SAME`."""
        error = SAME * abs(value) if error is None else error
        return cls(value, value - error, value + error)

    @property
    def error(self) -> float:
        """The larger distance to an end."""
        return max(self.high - self.value, self.value - self.low)

    def __eq__(self, other: object) -> NoReturn:
        raise TypeError("Numbers with uncertainty are compared by less().")

    def __bool__(self) -> NoReturn:
        raise TypeError("A number with uncertainty is no verdict.")

    def __float__(self) -> float:
        return self.value

    def __abs__(self) -> "Number":
        ends = sorted((abs(self.low), abs(self.high)))
        return Number(abs(self.value), 0.0 if self.low < 0.0 < self.high else ends[0], ends[1])

    def __add__(self, other: "float | Number") -> "Number":
        return _combined(add, self, number(other))

    def __sub__(self, other: "float | Number") -> "Number":
        return _combined(sub, self, number(other))

    def __mul__(self, other: "float | Number") -> "Number":
        return _combined(mul, self, number(other))

    def __truediv__(self, other: "float | Number") -> "Number":
        other = number(other)
        if other.low <= 0.0 <= other.high:
            return Number(self.value / other.value if other.value else nan, -inf, inf)
        return _combined(truediv, self, other)

    def __rsub__(self, other: float) -> "Number":
        return number(other) - self

    def __rtruediv__(self, other: float) -> "Number":
        return number(other) / self

    __radd__, __rmul__ = __add__, __mul__

    def __format__(self, spec: str) -> str:
        return str(self) if not spec else format(self.value, spec) if isfinite(self.value) else "none"

    def __str__(self) -> str:
        """Return the number with the digits that its error leaves, and the error where it shows in four."""
        if not isfinite(self.value):
            return "none"
        if not 5e-5 <= self.error < inf:
            return f"{self.value:.4f}"
        digits = max(-floor(log10(self.error)), 0)
        error = f"{self.error:.{digits}f}" if digits < 3 else f"{self.error:.0e}".replace("e-0", "e-")
        return f"{self.value:.{digits}f} +- {error}"


NONE: Final = Number(nan, -inf, inf)
"""A number that is not recorded."""


def number(x: float | Number) -> Number:
    """Return a number; a float or an integer is exact."""
    return x if isinstance(x, Number) else exact(x)


def exact(x: float) -> Number:
    """Return a number without error, as of a closed form or a count of all there are."""
    return Number(x, x, x)


def _combined(operation: Callable[[float, float], float], a: Number, b: Number) -> Number:
    ends = [operation(x, y) for x, y in product((a.low, a.high), (b.low, b.high))]
    # Of unbounded ends nothing is known.
    if not all(map(isfinite, ends)):
        return Number(operation(a.value, b.value), -inf, inf)
    return Number(operation(a.value, b.value), min(ends), max(ends))


def less(a: float | Number, b: float | Number) -> bool | None:
    """Return whether a number is less than another; None where their intervals have a number in common."""
    a, b = number(a), number(b)
    return True if a.high < b.low else False if b.high <= a.low else None


def every(verdicts: Iterable[bool | None]) -> bool | None:
    """Return whether all verdicts are true; None if some are open and none is false."""
    known = [*verdicts]
    return False if False in known else None if None in known else True


def no(verdict: bool | None) -> bool | None:
    """Return whether a verdict is false; None if it is open."""
    return None if verdict is None else not verdict


def some(verdicts: Iterable[bool | None]) -> bool | None:
    """Return whether any verdict is true; None if some are open and none is true."""
    return no(every(no(each) for each in verdicts))


def within(x: float | Number, low: float | Number, high: float | Number) -> bool | None:
    """Return whether a number lies between two others."""
    return every((less(low, x), less(x, high)))


def least(numbers: Iterable[float | Number]) -> Number:
    """Return the least of some numbers, with the interval in which it lies."""
    known = [*map(number, numbers)]
    return Number(*(min(getattr(x, name) for x in known) for name in ("value", "low", "high")))


def greatest(numbers: Iterable[float | Number]) -> Number:
    """Return the greatest of some numbers, with the interval in which it lies."""
    known = [*map(number, numbers)]
    return Number(*(max(getattr(x, name) for x in known) for name in ("value", "low", "high")))


def share(times: int, trials: int) -> Number:
    """Return a share of independent trials with the interval of Clopper and Pearson of its probability."""
    low, high = map(float, binomial_interval(times, trials))
    return Number(times / trials if trials else nan, low, high)
