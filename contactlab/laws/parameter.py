"""What a law says of each of its parameters: symbol, unit, meaning and range."""

from dataclasses import dataclass
from functools import cache
from math import inf, isfinite
from typing import Any, final, get_type_hints

from contactlab.checks import check_fields


@final
@dataclass(frozen=True)
class Parameter:
    """The annotation of a law's field.

    Args:
        symbol: as in the law's equation.
        units: SI, in the words of the CF conventions: "N m-1.5".
        meaning: a few words.
        above, at_least, at_most, below: the range.
    """

    symbol: str
    units: str
    meaning: str
    above: float = -inf
    at_least: float = -inf
    at_most: float = inf
    below: float = inf

    def holds(self, value: float) -> bool:
        """Whether a value is finite and in the range."""
        inside = self.above < value < self.below and self.at_least <= value <= self.at_most
        return isfinite(value) and inside

    @property
    def range(self) -> str:
        """The range in words."""
        words = {
            "above": self.above,
            "at least": self.at_least,
            "at most": self.at_most,
            "below": self.below,
        }
        given = [f"{word} {bound:g}" for word, bound in words.items() if isfinite(bound)]
        return " and ".join(given) or "finite"


FRICTION_COEFFICIENT = Parameter("mu", "1", "friction coefficient", at_least=0.0)
"""Shared by the laws with Coulomb friction of one coefficient."""

RESTITUTION = Parameter("e", "1", "coefficient of restitution", at_least=0.0, at_most=1.0)
"""Shared by the laws with a restitution, whichever of velocity, impulse or energy it is of."""


@cache
def parameters_of(law: type) -> dict[str, Parameter]:
    """The declared parameters of a law by name; a field without declaration is not among them."""
    return {
        name: extra
        for name, hint in get_type_hints(law, include_extras=True).items()
        for extra in getattr(hint, "__metadata__", ())
        if isinstance(extra, Parameter)
    }


def check_parameters(law: Any) -> None:
    """Refuse a law or a part with a parameter that is none, or outside of its range.

    Raises:
        TypeError: with a sentence for each that is no number, or no part of the wanted family.
        ValueError: with a sentence for each that is out of range.
    """
    kind: type = type(law)
    check_fields(law, law.name)
    faults = [
        f"{law.name}: {name} is {getattr(law, name)} {declared.units}; it must be {declared.range}."
        for name, declared in parameters_of(kind).items()
        if not declared.holds(getattr(law, name))
    ]
    if faults:
        raise ValueError(" ".join(faults))
