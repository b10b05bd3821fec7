"""What a class says of each of its numbers, once: symbol, unit, meaning and range.

Configuration, messages, help, completion and documentation follow from it, for laws and their parts,
resonators, materials, drive, rotor, contact and solver alike.
"""

from dataclasses import dataclass
from functools import cache
from math import inf, isfinite
from typing import final, get_type_hints


@final
@dataclass(frozen=True)
class Parameter:
    """Annotates a field of a dataclass: `mass: Annotated[float, Parameter("m", "kg", "mass", above=0.0)]`.

    The default stands at the field itself; a field that is annotated `float | None` may be None, and its
    hint says what that stands for; one that is annotated `int` must be whole.

    Args:
        symbol: as in the equations.
        units: SI, in the words of the CF conventions: "N m-1.5"; "1" for a pure number.
        meaning: a few words.
        above, at_least, at_most, below: the range; above and below are not admitted themselves.
        hint: a sentence that helps somebody who has run into the range: "Steel has 210 GPa."
    """

    symbol: str
    units: str
    meaning: str
    above: float = -inf
    at_least: float = -inf
    at_most: float = inf
    below: float = inf
    hint: str = ""

    def holds(self, value: float) -> bool:
        """Tell whether a value is finite and in the range."""
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


@cache
def parameters_of(owner: type) -> dict[str, Parameter]:
    """The declared parameters of a class by name; a field without declaration is not among them."""
    return {
        name: extra
        for name, hint in get_type_hints(owner, include_extras=True).items()
        for extra in getattr(hint, "__metadata__", ())
        if isinstance(extra, Parameter)
    }
