"""One statement that can be wrong, and functions that make such statements.

def hertz_impact() -> Claims:
    '''A ball against a Hertz contact (Johnson 1985, sec. 11.4).'''
    yield close("Hertz impact: duration", duration, expected, 1e-6, "s")
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from inspect import isfunction
from types import ModuleType
from typing import final


@final
@dataclass(frozen=True)
class Claim:
    """A value that is expected within a tolerance, or within a bound ("<=" or ">=").

    An excuse is the reason why a law declares to break the claim; then it must be broken.
    """

    statement: str
    expected: float
    value: float
    tolerance: float = 0.0
    relation: str = "="
    units: str = "1"
    excuse: str = ""

    @property
    def true(self) -> bool:
        """Whether the statement itself is true; a NaN never is."""
        if self.relation == "<=":
            return self.value <= self.expected
        if self.relation == ">=":
            return self.value >= self.expected
        return abs(self.value - self.expected) <= self.tolerance

    @property
    def holds(self) -> bool:
        """Whether the verdict is as it should be: true, or broken as declared."""
        return self.true != bool(self.excuse)

    @property
    def verdict(self) -> str:
        """The verdict in words."""
        if self.excuse:
            return "HOLDS, declared broken" if self.true else "broken, as declared"
        return "holds" if self.true else "FAILS"

    def excused(self, excuse: str) -> "Claim":
        """Return the same claim, declared to be broken where there is an excuse."""
        return replace(self, excuse=excuse)

    def __str__(self) -> str:
        unit = "" if self.units == "1" else f" {self.units}"
        within = f" within {self.tolerance:.3g}" if self.relation == "=" else ""
        text = (
            f"{self.statement}: {self.value:.9g}{unit}, expected {self.relation} "
            f"{self.expected:.9g}{unit}{within}: {self.verdict}."
        )
        return f"{text} Declared: {self.excuse}" if self.excuse else text


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


def at_most(statement: str, value: float, bound: float, units: str = "1") -> Claim:
    """Claim an upper bound."""
    return Claim(statement, float(bound), float(value), 0.0, "<=", units)


def at_least(statement: str, value: float, bound: float) -> Claim:
    """Claim a lower bound of a number without unit."""
    return Claim(statement, float(bound), float(value), 0.0, ">=")


Claims = Iterator[Claim]
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
