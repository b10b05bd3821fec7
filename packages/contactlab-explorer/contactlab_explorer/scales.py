"""Positions of a slider over the usual values of a number, on a linear or a logarithmic scale."""

from math import exp, log
from typing import Final

from contactlab.config.numbers import Number

STEPS: Final = 200
"""Of a slider from end to end, of a number that need not be whole."""


def steps_of(number: Number) -> int:
    """Return the number of steps from end to end; each of a whole number is one."""
    low, high = number.usual or (0.0, 1.0)
    return round(high - low) if number.whole else STEPS


def position(number: Number, value: float | str | None) -> int:
    """Return the step next to a value, the nearest end to one outside of the usual values or to none."""
    low, high = number.usual or (0.0, 1.0)
    if not isinstance(value, float | int):
        return 0
    value = min(max(value, low), high)
    if number.scale == "log":
        return round(steps_of(number) * log(value / low) / log(high / low))
    return round(steps_of(number) * (value - low) / (high - low))


def value_at(number: Number, step: float) -> float:
    """Return the value at a step, with four digits of the scale and the ends as they are."""
    low, high = number.usual or (0.0, 1.0)
    most = steps_of(number)
    if step <= 0 or step >= most:
        return low if step <= 0 else high
    share = step / most
    if number.scale == "log":
        value = float(f"{low * exp(share * log(high / low)):.4g}")
    else:
        # A step's digits follow from the width of the range, so that zero is zero.
        value = float(f"{low + share * (high - low):.12g}")
        value = 0.0 if abs(value) < 1e-9 * (high - low) else value
    return float(round(value)) if number.whole else min(max(value, low), high)
