"""Free parameters of a law: which numbers of it a fit may change, and within what range of each."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import exp, inf, isfinite, log
from typing import Any, Final, TypeVar, final

import numpy as np

from contactlab.arrays import Array
from contactlab.laws import Composed, ContactLaw
from contactlab.laws.declaration import Declared
from contactlab.parameter import DeclaredField, Parameter, declared_fields
from contactlab.suggestion import suggestion

WIDE: Final = 100.0
"""End over start of a positive range from which it is searched in its logarithm."""

DECADES: Final = {True: 1.0, False: 3.0}
"""Of a positive number without a largest value, both ways from the law's own: of a pure number, and of one
with a unit."""

TIMES: Final = 4.0
"""How often the law's own distance from its one bound goes into a range that begins there."""

INSIDE: Final = 1e-3
"""Share of a range by which its end keeps off a bound that is not admitted itself."""

_Law = TypeVar("_Law", bound=Declared)


@final
@dataclass(frozen=True)
class Free:
    """A number of a law that is free within a range: the search's bounds, or a prior's.

    Args:
        name: the field, "friction_coefficient", or that of a part, "normal.stiffness".
        low, high: the range, SI.
        logarithmic: whether it is the logarithm that is spread evenly over the range.
        parameter: what the law declares of it.
    """

    name: str
    low: float
    high: float
    logarithmic: bool
    parameter: Parameter

    def from_unit(self, share: float) -> float:
        """Give the value at a share of the range, 0 at its low and 1 at its high end."""
        if share <= 0.0 or share >= 1.0:
            # The ends are bounds that the law admits; round-off may lie beyond.
            return self.low if share <= 0.0 else self.high
        if self.logarithmic:
            return exp(log(self.low) + share * log(self.high / self.low))
        return self.low + share * (self.high - self.low)

    def to_unit(self, value: float) -> float:
        """Give the share of the range at which a value lies; beyond 0 and 1 where it is outside."""
        if self.logarithmic:
            return log(value / self.low) / log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)

    def __str__(self) -> str:
        return f"{self.name} in {self.low:.4g} to {self.high:.4g}{self.parameter.label}"


def free_parameters(
    law: Declared, chosen: Mapping[str, tuple[float, float] | None] | None = None
) -> tuple[Free, ...]:
    """Give the free parameters of a law and of its parts, in the order of their fields.

    A range is the declared one where that has two ends. Else it is about the law's own value x: a decade
    both ways of a positive pure number, three of one with a unit, in the logarithm; [b, b + 4 |x - b|] of
    one that may be on its only bound b, four being one where x = b; x +- 4 |x| of one without bounds. Whole
    numbers, and what the law leaves open, are not free.

    Args:
        law: any law or part.
        chosen: the names of those that are free, no others, each with its range or None for its own;
            a range of 100-fold and more is searched in the logarithm.

    Raises:
        ValueError: with a sentence on a name that the law has not, or on a range that it does not admit.
    """
    known = dict(_numbers(law))
    if chosen is None:
        return tuple(_own(name, value, said) for name, (value, said) in known.items())
    for name in chosen:
        if name not in known:
            hint = suggestion(name, known, f"It has {', '.join(known) or 'none'}.")
            raise ValueError(f"{law.name} has no number {name!r} that could be free. {hint}")
    return tuple(
        _own(name, value, said) if (span := chosen[name]) is None else _given(law.name, name, span, said)
        for name, (value, said) in known.items()
        if name in chosen
    )


def with_values(law: _Law, free: Sequence[Free], values: Sequence[float] | Array) -> _Law:
    """Give the law with these values [SI] of its free parameters, all at once.

    Raises:
        ValueError: the law does not admit them together; its own sentence.
    """
    return _replaced(law, {one.name: float(value) for one, value in zip(free, values, strict=True)})


def label_of(law: ContactLaw) -> str:
    """Return the name of a law, or those of a composed law's parts: "hertz_point + flores + mindlin"."""
    if not isinstance(law, Composed):
        return law.name
    damping = [] if law.damping.name == "none" else [law.damping.name]
    return " + ".join([law.normal.name, *damping, law.friction.name])


def from_cube(free: Sequence[Free], shares: Sequence[float] | Array) -> Array:
    """Give the values [SI] at a point of the unit cube, shape (parameter,)."""
    return np.array([one.from_unit(float(share)) for one, share in zip(free, shares, strict=True)])


def to_cube(free: Sequence[Free], values: Sequence[float] | Array) -> Array:
    """Give the point of the unit cube at which values [SI] lie, shape (parameter,)."""
    return np.array([one.to_unit(float(value)) for one, value in zip(free, values, strict=True)])


def _numbers(law: Declared, before: str = "") -> Iterator[tuple[str, tuple[float, Parameter]]]:
    """Give name, value and declaration of every number that may vary continuously."""
    owner: Any = type(law)
    for name, field in declared_fields(owner).items():
        value = getattr(law, name)
        if isinstance(value, Declared):
            yield from _numbers(value, f"{before}{name}.")
        elif field.parameter is not None and value is not None and _is_continuous(field):
            yield f"{before}{name}", (float(value), field.parameter)


def _is_continuous(field: DeclaredField) -> bool:
    return field.is_number and int not in field.kinds


def _own(name: str, value: float, said: Parameter) -> Free:
    """Give a parameter with the range that follows from its declaration and the law's value."""
    low, high = max(said.above, said.at_least), min(said.below, said.at_most)
    if isfinite(low) and isfinite(high):
        margin = INSIDE * (high - low)
        return Free(
            name,
            low if said.admits(low) else low + margin,
            high if said.admits(high) else high - margin,
            False,
            said,
        )
    if low == said.above == 0.0:
        factor = 10.0 ** DECADES[said.units == "1"]
        return Free(name, value / factor, value * factor, True, said)
    bound = low if isfinite(low) else high
    if not isfinite(bound):
        reach = TIMES * (abs(value) or 1.0)
        return Free(name, value - reach, value + reach, False, said)
    reach = TIMES * abs(value - bound) or max(abs(bound), 1.0)
    margin = 0.0 if said.admits(bound) else INSIDE * reach
    ends = (low + margin, low + reach) if isfinite(low) else (high - reach, high - margin)
    return Free(name, *ends, False, said)


def _given(law: str, name: str, span: tuple[float, float], said: Parameter) -> Free:
    """Give a parameter with a range that somebody asks for."""
    low, high = span
    shown = f"{law}: {name} is free from {low:g} to {high:g}{said.label}"
    if not -inf < low < high < inf:
        raise ValueError(f"{shown}; the end must be greater than the start, and both finite.")
    for end in span:
        if not said.admits(end):
            raise ValueError(f"{shown}; it must be {said.range}. {said.hint}".rstrip())
    return Free(name, low, high, low > 0.0 and high / low >= WIDE, said)


def _replaced(owner: _Law, values: Mapping[str, float]) -> _Law:
    """Give a law or part with other values, those of a part together, since they may be bound to others."""
    own: Any = owner
    given: dict[str, Any] = {name: value for name, value in values.items() if "." not in name}
    for part in dict.fromkeys(name.partition(".")[0] for name in values if "." in name):
        below = {name.partition(".")[2]: x for name, x in values.items() if name.startswith(f"{part}.")}
        given[part] = _replaced(getattr(owner, part), below)
    made: _Law = replace(own, **given)
    return made
