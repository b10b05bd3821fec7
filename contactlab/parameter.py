"""What a class says of each of its values, once: symbol, unit, meaning, range and default.

Configuration, messages, help, completion and documentation follow from it, for laws and their parts,
resonators, materials, drive, rotor, contact and solver alike.
"""

from dataclasses import MISSING, dataclass, fields
from functools import cache, cached_property, partial
from math import inf, isfinite
from types import NoneType, UnionType
from typing import Annotated, Any, Final, Literal, Union, final, get_args, get_origin, get_type_hints

MAGNITUDES: Final = 1e-300, 1e300
"""Least and largest magnitude of a number that is not zero: ratios of others overflow."""

BEYOND: Final = "which is not finite, or neither 0 nor of a magnitude from {:g} to {:g}".format(*MAGNITUDES)
"""What a number of another magnitude is."""

BOUNDED: Final = 100.0
"""Magnitude up to which the bounds of a range are its usual ends too."""

FACTOR: Final = 5.0
"""Ratio of the usual ends to a default, where none are declared."""


@final
@dataclass(frozen=True)
class Parameter:
    """Annotates a field of a dataclass: `mass: Annotated[float, Parameter("m", "kg", "mass", above=0.0)]`.

        >>> Parameter("m", "kg", "mass", above=0.0).range
        'greater than 0 kg'

    The default stands at the field; one that is annotated `float | None` may be None, and its hint says
    what that stands for; one that is annotated `int` must be whole.

    Args:
        symbol: as in the equations; empty where none has it.
        units: SI, in the words of the CF conventions: "N m-1.5"; "1" for a pure number, or no number.
        meaning: a few words.
        above, at_least, at_most, below: the range; above and below are not admitted themselves.
        hint: a sentence that helps who has run into the range more than the default: "0 is no tip."
        spread: half the range within which the value is known, over the value, for `contactlab.compare`
            to vary it; 0 where a comparison leaves it as it is, and says so.
        usual: lower and upper end of the values that are usual, for sliders and first searches; empty where
            they follow from the default, see `usual_range`.
    """

    symbol: str
    units: str
    meaning: str
    above: float = -inf
    at_least: float = -inf
    at_most: float = inf
    below: float = inf
    hint: str = ""
    spread: float = 0.0
    usual: tuple[float, float] | tuple[()] = ()

    def __post_init__(self) -> None:
        if not 0.0 <= self.spread < 1.0:
            raise ValueError(
                f"The spread of {self.symbol} is {self.spread}; it must be at least 0 and below 1."
            )
        if self.usual and not (self.usual[0] < self.usual[1] and all(map(self.admits, self.usual))):
            raise ValueError(
                f"The usual range of {self.symbol} is {self.usual}; it must be two ascending values that are "
                f"{self.range or 'finite'}."
            )

    def admits(self, value: float) -> bool:
        """Return whether a value is in the range, and of a magnitude to compute with."""
        return self._includes(value) and has_magnitude(value, self)

    def _includes(self, value: float) -> bool:
        return self.above < value < self.below and self.at_least <= value <= self.at_most

    @cached_property
    def may_vanish(self) -> bool:
        """Whether 0 is in the range: then nothing is divided by the number, however small it is."""
        return self._includes(0.0)

    def usual_range(self, about: float | None) -> tuple[float, float] | None:
        """Return the ends of the usual values.

        These are the declared ones; else the whole range where both of its bounds are within a factor of
        `BOUNDED` of each other or of 1, a hundredth inside a bound that is not admitted; else from a fifth of
        a value to five times it, within the range.

            >>> positive("m", "kg", "mass").usual_range(2.0)
            (0.4, 10.0)

        Args:
            about: a value that is not zero, as the default; None or 0 where there is none, and then a number
                without declared ends has no usual range.
        """
        if self.usual:
            return self.usual
        low, high = max(self.above, self.at_least), min(self.below, self.at_most)
        if isfinite(low) and isfinite(high) and max(abs(low), abs(high)) <= BOUNDED:
            inside = 0.01 * (high - low)
            return low + inside * (self.above == low), high - inside * (self.below == high)
        if not about:
            return None
        ends = sorted((about / FACTOR, about * FACTOR))
        return max(ends[0], low), min(ends[1], high)

    @property
    def unit(self) -> str:
        """The unit as configurations and sentences write it: "N/m^1.5"."""
        return from_cf(self.units)

    @property
    def label(self) -> str:
        """The unit as it follows a number, empty for a pure number."""
        return "" if self.units == "1" else f" {self.unit}"

    @property
    def range(self) -> str:
        """The range in words, each bound with its unit; empty where every finite number will do."""
        phrases = ("greater than", "at least", "less than", "at most")
        bounds = zip(phrases, (self.above, self.at_least, self.below, self.at_most), strict=True)
        return " and ".join(f"{word} {b:g}{self.label}" for word, b in bounds if isfinite(b))


def has_magnitude(value: float, parameter: Parameter | None = None) -> bool:
    """Return whether a number is in `MAGNITUDES`, or smaller where it may be 0; false if it is not finite."""
    least = 0.0 if parameter is None or parameter.may_vanish or value == 0.0 else MAGNITUDES[0]
    return least <= abs(value) <= MAGNITUDES[1]


positive = partial(Parameter, above=0.0)
not_negative = partial(Parameter, at_least=0.0)


@final
@dataclass(frozen=True)
class DeclaredField:
    """A field of a dataclass with what is declared of it: nothing where it holds an object of a class.

    Its default is `dataclasses.MISSING` where it must be given.
    """

    kind: Any
    default: Any
    parameter: Parameter | None

    @cached_property
    def kinds(self) -> tuple[Any, ...]:
        """The kinds that are admitted, one of them `NoneType` where it may be None."""
        return kinds_of(self.kind)

    @cached_property
    def choices(self) -> tuple[Any, ...]:
        """What is admitted besides numbers: None, and the texts of a `Literal`."""
        texts = (x for kind in self.kinds if get_origin(kind) is Literal for x in get_args(kind))
        return (*texts, None) if NoneType in self.kinds else (*texts,)

    @cached_property
    def is_number(self) -> bool:
        """Whether it holds a declared number, or a choice in place of one."""
        return self.parameter is not None and not {int, float}.isdisjoint(self.kinds)

    @property
    def hint(self) -> str:
        """A sentence that helps somebody who has run into the range: the declared one, or the default."""
        if self.parameter is None or self.parameter.hint or self.default in (None, MISSING):
            return self.parameter.hint if self.parameter else ""
        return f"The default is {self.default:g}{self.parameter.label}."


def kinds_of(hint: Any) -> tuple[Any, ...]:
    """Return the kinds of an annotation, several of a union."""
    return get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)


def annotated(hint: Any) -> tuple[tuple[Any, ...], Parameter | None]:
    """Return the kinds of an annotation and the declaration that it brings, if any."""
    kind, *extras = get_args(hint) if get_origin(hint) is Annotated else (hint,)
    return kinds_of(kind), next((extra for extra in extras if isinstance(extra, Parameter)), None)


@cache
def declared_fields(owner: type) -> dict[str, DeclaredField]:
    """Return the fields of a dataclass by name, in their order."""
    declared, hints = {}, get_type_hints(owner, include_extras=True)
    for field in fields(owner):
        hint, made = hints[field.name], field.default_factory
        kind, *extras = get_args(hint) if get_origin(hint) is Annotated else (hint,)
        parameter = next((extra for extra in extras if isinstance(extra, Parameter)), None)
        declared[field.name] = DeclaredField(kind, field.default if made is MISSING else made(), parameter)
    return declared


@cache
def parameters_of(owner: type) -> dict[str, Parameter]:
    """Return the declared parameters of a dataclass by name; fields without one are left out."""
    return {name: f.parameter for name, f in declared_fields(owner).items() if f.parameter}


def from_cf(units: str) -> str:
    """Write units of the CF conventions as configurations do.

    >>> from_cf("N m-1.5")
    'N/m^1.5'
    """
    sides: dict[bool, list[str]] = {False: [], True: []}
    for factor in units.split():
        word = factor.rstrip("-.0123456789") or factor
        below, power = factor[len(word) :].startswith("-"), factor[len(word) :].lstrip("-")
        sides[below].append(word if power in ("", "1") else f"{word}^{power}")
    return "/".join([" ".join(sides[False]) or "1", *sides[True]])
