"""Lanes: five float64, one of each node of a step, in one register of the processor, computed with at once.

A register has eight, which rows of arrays and the functions "of all" use; others leave the last three as they
come.

Lanes are a number type of the compiler (`contactlab.compiler.registers`): `+ - * /`, `abs` and the functions
below act on every lane as on a float64, so that the bits are those of a loop over the nodes, whatever the
width of the processor's registers. A number beside lanes is that number in each; `lanes[i]` is lane i. There
is no `+=`: lanes are values. Without machine code they are arrays of NumPy, with the same bits.
"""

from math import sqrt
from typing import Any, Final

import numpy as np

from contactlab.arrays import Array

COUNT: Final = 5
"""Lanes that are used, of eight in a register: nodes of a step."""

WIDTH: Final = 8
"""Lanes of a register: nodes of the ledger in flight, or coordinates."""

Lanes = Array
"""Type of lanes without machine code, shape (WIDTH,)."""


def fill(value: float) -> Lanes:
    """Return lanes that all are one number, in a whole register."""
    return np.full(WIDTH, value, np.float64)


def load(values: Array) -> Lanes:
    """Return the first numbers of an array as lanes; those that are not used have any value."""
    return np.append(values[:COUNT], [values[COUNT - 1]] * (WIDTH - COUNT))


def load_all(values: Array) -> Lanes:
    """Return the first numbers of an array as lanes of a whole register, at which it has room for one."""
    return np.array(values[:WIDTH])


def store(values: Array, lanes: Lanes) -> None:
    """Set the first numbers of an array to lanes."""
    values[:COUNT] = lanes[:COUNT]


def entry(values: Array, m: int) -> Any:
    """Return number m of an array of numbers, shape (n,), or lanes m of one of lanes.

    An array of two axes is one of lanes, WIDTH numbers after WIDTH numbers: a row has lanes once or more.
    """
    return values[m] if values.ndim == 1 else values.reshape(-1, WIDTH)[m].copy()


def set_entry(values: Array, m: int, value: Any) -> None:
    """Set number m of an array of numbers, or lanes m of an array of lanes, see `entry`."""
    if values.ndim > 1:
        values = values.reshape(-1, WIDTH)
    values[m] = value


def put(lanes: Lanes, i: int, value: float) -> Lanes:
    """Return lanes of which lane i is another number."""
    changed = lanes.copy()
    changed[i] = value
    return changed


def larger(left: Any, right: Any) -> Any:
    """Return the larger of two numbers in every lane, the left one where they do not compare, as `max`."""
    return np.where(right > left, right, left)


def smaller(left: Any, right: Any) -> Any:
    """Return the smaller of two numbers in every lane, the left one where they do not compare, as `min`."""
    return np.where(right < left, right, left)


def where_less(left: Any, right: Any, value: Any, other: Any) -> Any:
    """Return in every lane a value where the left number is less than the right one, else another."""
    return np.where(left < right, value, other)


def root(value: Any) -> Any:
    """Return the square root of a number, or of every lane."""
    return np.sqrt(value) if isinstance(value, np.ndarray) else sqrt(value)


def largest(lanes: Lanes) -> float:
    """Return the largest lane, as `max` of the lanes in their order."""
    return float(max(lanes[:COUNT]))


def largest_of_all(lanes: Lanes) -> float:
    """Return the largest lane of a whole register, as `largest`."""
    return float(max(lanes))


def total_of_all(lanes: Lanes) -> float:
    """Return the sum of the lanes of a whole register, as `total_of`."""
    return float(sum(lanes[1:], start=lanes[0]))


def total_of(lanes: Lanes) -> float:
    """Return the sum of the lanes, in their order."""
    return float(sum(lanes[1:COUNT], start=lanes[0]))
