"""The engine's form of a law's kernels: each reads a row, the law's memory before its parameters.

    z_0, ..., z_(m-1), length of the step [s], 1 in an impact, no number, parameters

A law that remembers nothing and is told nothing has its parameters alone there, and its kernels as they are.
So one compiled loop serves all laws.
"""

from collections.abc import Callable
from typing import Any, Final

from numba import types

from contactlab.laws.base import FRICTION_SIGNATURE, MULTIPLIER_SIGNATURE, PENALTY_SIGNATURE, ContactLaw
from contactlab.laws.intake import BETWEEN, has_row

_real, _whole = types.float64, types.int64
_row = PENALTY_SIGNATURE.args[-1]

SIGNATURES: Final = {
    "force": PENALTY_SIGNATURE,
    "friction_force": FRICTION_SIGNATURE,
    "solve": MULTIPLIER_SIGNATURE,
    "rate": _real(_whole, *[_real] * 4, _row),
    "guard": _real(_whole, *[_real] * 4, _row),
    "jump": _real(_whole, _whole, *[_real] * 4, _row),
    "limits": types.UniTuple(_real, 2)(_row),
    "moment": types.UniTuple(_real, 3)(*[_real] * 4, _row),
}
"""The kernels of a law by name, in the order in which the loop takes them."""


def own_signature(law: ContactLaw, name: str) -> Any:
    """Give the signature that a law's kernel has by itself, see `contactlab.laws.base`."""
    signature = SIGNATURES[name]
    if not has_row(law):
        return signature
    *given, _ = signature.args
    if name == "solve":
        return signature.return_type(*given, _real, types.boolean, _row, _row)
    if name == "friction_force" and law.friction_remembers:
        # The rates are those of the kernel `rate`.
        return types.UniTuple(_real, 3)(*given[:-1], _row, _row)
    return signature.return_type(*given, _row, _row)


def reading_row(name: str, kernel: Callable[..., Any], m: int, of_three: bool) -> Callable[..., Any]:
    """Give a function of a row with m internal variables that asks a law's kernel by itself.

    A kernel of friction `of_three` gives no rate.
    """
    if name == "friction_force" and of_three:
        return _of_friction(kernel, m, m + BETWEEN)
    return _READING[name](kernel, m, m + BETWEEN)


def _of_friction(kernel: Any, m: int, own: int) -> Callable[..., Any]:
    def friction(gap: Any, gap_rate: Any, slip: Any, normal: Any, _: Any, row: Any) -> Any:
        force, stored, stiffness = kernel(gap, gap_rate, slip, normal, row[:m], row[own:])
        return force, 0.0, stored, stiffness

    return friction


def _of_row(kernel: Any, m: int, own: int) -> Callable[..., Any]:
    return lambda row: kernel(row[:m], row[own:])


def _of_five(kernel: Any, m: int, own: int) -> Callable[..., Any]:
    return lambda a, b, c, d, row: kernel(a, b, c, d, row[:m], row[own:])


def _of_six(kernel: Any, m: int, own: int) -> Callable[..., Any]:
    return lambda a, b, c, d, e, row: kernel(a, b, c, d, e, row[:m], row[own:])


def _of_seven(kernel: Any, m: int, own: int) -> Callable[..., Any]:
    return lambda a, b, c, d, e, f, row: kernel(a, b, c, d, e, f, row[:m], row[own:])


def _of_impulse(kernel: Any, m: int, own: int) -> Callable[..., Any]:
    return lambda a, b, c, d, e, f, g, row: kernel(
        a, b, c, d, e, f, g, row[m], row[m + 1] != 0.0, row[:m], row[own:]
    )


_READING: Final = {
    "force": _of_five,
    "friction_force": _of_six,
    "solve": _of_impulse,
    "rate": _of_six,
    "guard": _of_six,
    "jump": _of_seven,
    "limits": _of_row,
    "moment": _of_five,
}
