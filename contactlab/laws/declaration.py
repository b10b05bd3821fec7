"""What a law, or a part of one, says of itself: its words, and its fields with symbol, unit and range.

Refusals, configuration, options and listings all follow from this.
"""

from abc import ABC
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import cache
from inspect import get_annotations, isabstract, signature
from math import nan
from typing import Any, ClassVar, Self

import numpy as np

from contactlab.arrays import Array
from contactlab.checks import check_fields, shown
from contactlab.parameter import DeclaredField, Parameter, declared_fields

SHARED = "friction_coefficient"
"""The parameter that is the contact's, whatever the law: laws are compared on one motor."""

FRICTION_COEFFICIENT = Parameter("mu", "1", "friction coefficient", at_least=0.0)
RESTITUTION = Parameter("e", "1", "coefficient of restitution", at_least=0.0, at_most=1.0)


Coefficient = float | tuple[float, ...]
"""A number that a kernel may name, or several of a kind."""


class LawError(RuntimeError):
    """A law contradicts itself, or its own code raised an exception, which is the cause of this one."""


class Declared(ABC):
    """What laws and parts share: an immutable dataclass whose fields are its parameters in SI units.

    A field is `Annotated[float, Parameter(...)]`, `float | None` where it may be left open. What is no
    number, and a class that lacks a word, is refused by a TypeError, a value out of range by a ValueError.
    """

    WORDS: ClassVar[tuple[str, ...]] = ("name", "equation", "source")
    """What it has to say of itself."""
    family: ClassVar[str] = ""
    """Which part of a law it is: the word of its configuration group; empty for a law."""
    name: ClassVar[str]
    """Its word everywhere: option, listing and attribute."""
    equation: ClassVar[str]
    """What it says, in one line."""
    source: ClassVar[str]
    """Where it is published."""
    validity: ClassVar[str] = ""
    """Where it holds, in a few words; empty where its source sets no limit."""

    def __init__(self, *positional: object, **named: object) -> None:
        # A dataclass has its own: this one is reached where the decorator is missing.
        refuse_unsound(type(self))

    def __post_init__(self) -> None:
        refuse_unsound(type(self))
        check_fields(self, self.name)

    def effective(self) -> Iterator[tuple[str, float, Parameter | None]]:
        """Yield name ("part.name" for one of a part), value [SI] and declaration of numbers not left open."""
        kind: Any = type(self)
        for name, member in declared_fields(kind).items():
            value = getattr(self, name)
            if isinstance(value, Declared):
                yield from ((f"{name}.{below}", x, text) for below, x, text in value.effective())
            elif value is not None and not isinstance(value, str):
                yield name, value, member.parameter

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return the numbers that kernels may name, SI: by default the fields, with NaN for None."""
        named: Any = type(self)
        values = {name: getattr(self, name) for name in declared_fields(named)}
        return {k: nan if v is None else v for k, v in values.items() if not isinstance(v, Declared)}

    def parameters(self) -> Array:
        """Return the coefficients as one array, shape (parameter,)."""
        return np.array(
            [x for value in self.coefficients().values() for x in np.atleast_1d(value)], np.float64
        )

    def evaluate(self, kernel: str, **quantities: Any) -> Any:
        """Evaluate one of its kernels: coefficients are its own, all else that the kernel names is given.

        Internal variables that are not given have their initial values.

        >>> import contactlab as cl
        >>> float(cl.HertzPoint(1e10).evaluate("elastic", depth=1e-6)[0])
        10.0
        """
        function: Any = getattr(self, kernel)
        initial = {each.name: each.initial for each in getattr(self, "internal_variables", ())}
        known = {**initial, **self.coefficients(), "parameters": self.parameters(), **quantities}
        values = (known[name] for name in names_of(function))
        return function(*(np.array(v) if isinstance(v, tuple) else v for v in values))

    def describe(self) -> dict[str, float]:
        """Return the effective parameters by name, SI."""
        return {name: value for name, value, _ in self.effective()}

    def changed(self, name: str, value: float) -> Self:
        """Return the law with another value of a parameter, or raise a ValueError if that is out of range."""
        own: Any = self
        field, _, below = name.partition(".")
        arguments: Any = getattr(own, field).changed(below, value) if below else value
        return replace(own, **{field: arguments})  # type: ignore[no-any-return]


def names_of(function: Any) -> tuple[str, ...]:
    """Return the names of a kernel's arguments."""
    return tuple(signature(getattr(function, "py_func", function)).parameters)


@cache
def fault_of(kind: Any) -> str:
    """Return why a class is no law or part, as the end of a sentence; empty for a sound one."""
    if isabstract(kind):
        return f"lacks {', '.join(sorted(kind.__abstractmethods__))}"
    # A subclass of a dataclass that says nothing of fields is one too.
    undecorated = "__dataclass_fields__" not in vars(kind) and get_annotations(kind)
    sound = is_dataclass(kind) and not undecorated
    if not sound:
        return "is no dataclass; decorate it with @dataclass(frozen=True)"
    if not kind.__dataclass_params__.frozen:
        return "can be changed; decorate it with @dataclass(frozen=True)"
    if missing := [word for word in kind.WORDS if not hasattr(kind, word)]:
        return f"does not say its {', '.join(missing)}"
    if among := [field.name for field in fields(kind) if field.name in kind.WORDS]:
        return f"has its {', '.join(among)} among its parameters; annotate it with ClassVar"
    return "" if isinstance(kind.name, str) else f"has a name that is no text, {shown(kind.name)}"


def refuse_unsound(kind: type) -> None:
    """Refuse a class that cannot be a law or a part by a TypeError with a sentence."""
    if fault := fault_of(kind):
        raise TypeError(f"{kind.__name__} {fault}.")


@cache
def members_of(owner: type[Declared]) -> dict[str, DeclaredField]:
    """Return the fields by name, declared numbers and parts, or raise a ValueError on one that is neither."""
    try:
        members = declared_fields(owner)
    # An annotation or a default is any expression of somebody else's.
    except Exception as error:
        raise ValueError(
            f"{owner.name} has fields that cannot be read ({type(error).__name__}: {error})."
        ) from error
    for name, member in members.items():
        if member.parameter is None and not family_of(member):
            raise ValueError(
                f"{owner.name} has the field {name} without a declaration; it must be "
                "Annotated[float, Parameter(...)], or a NormalForce, Damping or Friction."
            )
    return members


def family_of(member: DeclaredField) -> str:
    """Return the family of a field that is a part; empty for a number."""
    is_part = isinstance(member.kind, type) and issubclass(member.kind, Declared)
    return str(member.kind.family) if is_part else ""
