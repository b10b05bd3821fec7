"""Claims of the contract and of closed forms, and the functions that yield them.

def hertz_impact() -> Claims:
    '''A ball against a Hertz contact (Johnson 1985, sec. 11.4).'''
    yield close("Hertz impact: duration", duration, expected, 1e-6, "s")
"""

from collections.abc import Callable
from inspect import isfunction
from types import ModuleType

from contactlab.laws.claim import Claim as Claim, Claims, at_least as at_least, at_most as at_most

__all__ = ["Claim", "Claims", "Proof", "at_least", "at_most", "close", "proofs_of"]


def close(
    statement: str,
    value: float,
    expected: float,
    relative: float,
    units: str = "1",
    scale: float | None = None,
) -> Claim:
    """Claim equality within `relative` of a scale, by default the expected value."""
    size = abs(expected) if scale is None else scale
    return Claim(statement, float(expected), float(value), relative * size, "=", units)


Proof = Callable[..., Claims]
"""Yields claims; the first line of its docstring is their heading."""


def proofs_of(*modules: ModuleType) -> dict[str, Proof]:
    """Return the public functions of modules that are annotated with `Claims`, in the order of the source."""
    return {
        name: each
        for module in modules
        for name, each in vars(module).items()
        if isfunction(each) and each.__annotations__.get("return") is Claims and name[0] != "_"
    }
