"""One statement that can be wrong: what is expected, what is found, and how far they may be apart."""

from dataclasses import dataclass, replace
from typing import final


@final
@dataclass(frozen=True)
class Claim:
    """A checked statement.

    Args:
        statement: the claim in words.
        expected: value or bound.
        found: what came out.
        tolerance: largest |found - expected| of a value; 0 for a bound.
        relation: "=", "<=" or ">=" of found to expected.
        units: of all three, "1" without.
        excuse: reason why a law declares to break the claim; then it must be broken.
    """

    statement: str
    expected: float
    found: float
    tolerance: float = 0.0
    relation: str = "="
    units: str = "1"
    excuse: str = ""

    @property
    def true(self) -> bool:
        """Whether the statement itself is true; a NaN never is."""
        if self.relation == "<=":
            return self.found <= self.expected
        if self.relation == ">=":
            return self.found >= self.expected
        return abs(self.found - self.expected) <= self.tolerance

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
        """The same claim, declared to be broken."""
        return replace(self, excuse=excuse)

    def __str__(self) -> str:
        unit = "" if self.units == "1" else f" {self.units}"
        within = f" within {self.tolerance:.3g}" if self.relation == "=" else ""
        text = (
            f"{self.statement}: found {self.found:.9g}{unit}, expected {self.relation} "
            f"{self.expected:.9g}{unit}{within}: {self.verdict}."
        )
        return f"{text} Declared: {self.excuse}" if self.excuse else text


def close(
    statement: str,
    found: float,
    expected: float,
    relative: float,
    *,
    scale: float | None = None,
    units: str = "1",
) -> Claim:
    """A claim of equality within `relative` of a scale, by default the expected value."""
    size = abs(expected) if scale is None else scale
    return Claim(statement, float(expected), float(found), relative * size, "=", units)


def at_most(statement: str, found: float, bound: float, units: str = "1") -> Claim:
    """A claim of an upper bound."""
    return Claim(statement, float(bound), float(found), 0.0, "<=", units)


def at_least(statement: str, found: float, bound: float, units: str = "1") -> Claim:
    """A claim of a lower bound."""
    return Claim(statement, float(bound), float(found), 0.0, ">=", units)
