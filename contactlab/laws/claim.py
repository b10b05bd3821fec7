"""One statement that can be wrong: a value against what is expected of it.

The engine raises the first broken claim about a law, see `contactlab.laws.consistency`; the contract of
`contactlab.testing` prints all.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import final


@final
@dataclass(frozen=True)
class Claim:
    """A value that is expected within a tolerance, or within a bound ("<=" or ">=").

    An excuse is the reason why a law declares to break the claim; then it must be broken. The refusal
    makes the sentence, with the state and its numbers, by which a law that breaks the claim is refused.
    """

    statement: str
    expected: float
    value: float
    tolerance: float = 0.0
    relation: str = "="
    units: str = "1"
    excuse: str = ""
    refusal: Callable[[], str] = field(default=str, compare=False)

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


def at_most(
    statement: str, value: float, bound: float, units: str = "1", refusal: Callable[[], str] = str
) -> Claim:
    """Claim an upper bound."""
    return Claim(statement, float(bound), float(value), 0.0, "<=", units, refusal=refusal)


def at_least(statement: str, value: float, bound: float) -> Claim:
    """Claim a lower bound of a number without unit."""
    return Claim(statement, float(bound), float(value), 0.0, ">=")


Claims = Iterator[Claim]
