"""Free parameters of a law or a motor: bounds of a search, and priors."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import exp, inf, isfinite, log
from typing import Any, Final, TypeVar, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import ConfigurationError
from contactlab.laws.declaration import Declared
from contactlab.parameter import Parameter, declared_fields
from contactlab.quantity import UnitError, to_si
from contactlab.suggestion import suggestion

WIDE: Final = 100.0
"""Ratio of the ends of a positive range from which on its logarithm is uniform."""

DECADES: Final = {True: 1.0, False: 3.0}
"""Half-width of the range of a positive number without upper bound: of a pure number, of one with a unit."""

TIMES: Final = 4.0
"""Width of a half-bounded range, in units of the value's distance from the bound."""

INSIDE: Final = 1e-3
"""Distance of an end of a range from an open bound, as a share of the range."""

_Law = TypeVar("_Law", bound=Declared)


@final
@dataclass(frozen=True)
class FreeParameter:
    """A free number: its range is the bounds of a search, or a prior.

    Args:
        name: key of a configuration or name of a law's field, "normal.stiffness".
        low, high: the range, SI.
        logarithmic: whether the logarithm is uniform over the range.
        parameter: the declaration.
        field: the law's field where `name` is a key.
    """

    name: str
    low: float
    high: float
    logarithmic: bool
    parameter: Parameter
    field: str = ""

    def from_unit(self, share: float) -> float:
        """Return the value at a share of the range, 0 at its low and 1 at its high end."""
        if share <= 0.0 or share >= 1.0:
            # The ends are bounds that the law admits; round-off may lie beyond.
            return self.low if share <= 0.0 else self.high
        if self.logarithmic:
            return exp(log(self.low) + share * log(self.high / self.low))
        return self.low + share * (self.high - self.low)

    def to_unit(self, value: float) -> float:
        """Return the share of the range at which a value lies; outside of 0 to 1 for values outside."""
        if self.logarithmic:
            return log(value / self.low) / log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def slope(self, value: float) -> float:
        """Return the derivative of the value by the share of the range."""
        return value * log(self.high / self.low) if self.logarithmic else self.high - self.low

    def __str__(self) -> str:
        return f"{self.name} in {self.low:.4g} to {self.high:.4g}{self.parameter.label}"


def free_parameters(
    law: Declared, chosen: Mapping[str, tuple[float, float] | None] | None = None
) -> tuple[FreeParameter, ...]:
    """Return the free parameters of a law and of its parts, in the order of their fields.

    The range is the declared one if that has two ends. Otherwise it depends on the law's value x: one decade
    about a positive pure number, three about one with a unit, both logarithmic; [b, b + 4 |x - b|] for one
    bound b, with a width of one where x = b; x +- 4 |x| without bounds. Integers and numbers that are None
    are not free.

    Args:
        law: any law or part.
        chosen: names of the free parameters, each with its range or None for the one above; a range whose
            ends differ 100-fold and more is logarithmic.

    Raises:
        ValueError: the law has no such number, or does not admit the range.
    """
    known = dict(_numbers(law))
    spans = dict.fromkeys(known) if chosen is None else chosen
    for name in spans:
        if name not in known:
            hint = suggestion(name, known, f"It has {', '.join(known) or 'none'}.")
            raise ValueError(f"{law.name} has no free number {name!r}. {hint}")
    return tuple(
        _declared_range(name, value, declared)
        if (span := spans[name]) is None
        else chosen_range(name, span, declared)
        for name, (value, declared) in known.items()
        if name in spans
    )


def with_values(law: _Law, free: Sequence[FreeParameter], values: Sequence[float] | Array) -> _Law:
    """Return the law with these values [SI] of its free parameters.

    Raises:
        ValueError: the law does not admit them together.
    """
    changed = {item.field or item.name: float(x) for item, x in zip(free, values, strict=True)}
    return _replaced(law, changed)


def from_cube(free: Sequence[FreeParameter], shares: Sequence[float] | Array) -> Array:
    """Return the values [SI] at a point of the unit cube, shape (parameter,)."""
    return np.array([item.from_unit(float(share)) for item, share in zip(free, shares, strict=True)])


def to_cube(free: Sequence[FreeParameter], values: Sequence[float] | Array) -> Array:
    """Return the point of the unit cube of values [SI], shape (parameter,)."""
    return np.array([item.to_unit(float(value)) for item, value in zip(free, values, strict=True)])


def fields_of(law: Declared, before: str = "") -> Iterator[str]:
    """Yield the name of every real number of a law and its parts, whether it has a value or None."""
    owner: Any = type(law)
    for name, field in declared_fields(owner).items():
        value = getattr(law, name)
        if isinstance(value, Declared):
            yield from fields_of(value, f"{before}{name}.")
        elif field.parameter is not None and field.is_number and int not in field.kinds:
            yield f"{before}{name}"


def _numbers(law: Declared) -> Iterator[tuple[str, tuple[float, Parameter]]]:
    """Yield name, value and declaration of every real number that has a value."""
    for name in fields_of(law):
        *parts, last = name.split(".")
        owner: Any = law
        for part in parts:
            owner = getattr(owner, part)
        kind: Any = type(owner)
        value, declared = getattr(owner, last), declared_fields(kind)[last].parameter
        if value is not None:
            assert declared is not None
            yield name, (float(value), declared)


def _declared_range(name: str, value: float, declared: Parameter) -> FreeParameter:
    """Return a parameter with the range that follows from its declaration and the law's value."""
    low, high = max(declared.above, declared.at_least), min(declared.below, declared.at_most)
    if isfinite(low) and isfinite(high):
        margin = INSIDE * (high - low)
        ends = low if declared.admits(low) else low + margin, high if declared.admits(high) else high - margin
        return FreeParameter(name, *ends, False, declared)
    if low == declared.above == 0.0:
        factor = 10.0 ** DECADES[declared.units == "1"]
        return FreeParameter(name, value / factor, value * factor, True, declared)
    bound = low if isfinite(low) else high
    if not isfinite(bound):
        reach = TIMES * (abs(value) or 1.0)
        return FreeParameter(name, value - reach, value + reach, False, declared)
    reach = TIMES * abs(value - bound) or max(abs(bound), 1.0)
    margin = 0.0 if declared.admits(bound) else INSIDE * reach
    ends = (low + margin, low + reach) if isfinite(low) else (high - reach, high - margin)
    return FreeParameter(name, *ends, False, declared)


def chosen_range(
    name: str, ends: Sequence[float | str], declared: Parameter, field: str = ""
) -> FreeParameter:
    """Return a parameter with an explicit range, both ends in SI or as texts with units.

    Raises:
        ConfigurationError: the range has other units, is empty or not admitted.
    """
    if isinstance(ends, str) or len(ends) != 2:
        raise ConfigurationError(f"{name} is free in {ends!r}; it must have two ends, LOW and HIGH.")
    try:
        low, high = (to_si(x.strip(), declared.unit) if isinstance(x, str) else float(x) for x in ends)
    except UnitError as error:
        raise ConfigurationError(f"{name}={'..'.join(map(str, ends))} has an end {error}.") from error
    shown = f"{name} is free from {low:g} to {high:g}{declared.label}"
    if not -inf < low < high < inf:
        raise ConfigurationError(f"{shown}; the end must be greater than the start, and both finite.")
    if not (declared.admits(low) and declared.admits(high)):
        raise ConfigurationError(f"{shown}; both must be {declared.range}. {declared.hint}".rstrip())
    return FreeParameter(name, low, high, low > 0.0 and high / low >= WIDE, declared, field)


def _replaced(owner: _Law, values: Mapping[str, float]) -> _Law:
    """Return a law or part with other values; those of a part together, as bounds may couple them."""
    own: Any = owner
    changed: dict[str, Any] = {name: value for name, value in values.items() if "." not in name}
    for part in dict.fromkeys(name.partition(".")[0] for name in values if "." in name):
        below = {name.partition(".")[2]: x for name, x in values.items() if name.startswith(f"{part}.")}
        changed[part] = _replaced(getattr(owner, part), below)
    made: _Law = replace(own, **changed)
    return made
