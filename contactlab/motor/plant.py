"""How a small plant was made: the arguments of its function, which are numbers with keys."""

from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, replace
from functools import cache, wraps
from inspect import signature
from typing import Annotated, Any, ParamSpec, TypeVar, final, get_args, get_origin, get_type_hints

from contactlab.checks import Checked, checked_arguments
from contactlab.immutable import Immutable
from contactlab.parameter import DeclaredField, annotated, declared_fields

Arguments = ParamSpec("Arguments")
Made = TypeVar("Made")


@final
@dataclass(frozen=True, eq=False)
class Plant(Immutable):
    """The call that made a small plant.

        >>> import contactlab as cl
        >>> shaken = cl.ball(0.1, table=cl.Vibration("1 mm", "20 Hz")).plant
        >>> shaken.numbers["table.amplitude"][0]
        0.001
        >>> shaken.with_number("table.amplitude", 2e-3).plant.numbers["table.amplitude"][0]
        0.002

    Args:
        make: a function of `contactlab.motor.bodies`.
        arguments: all of the call, defaults included.
    """

    make: Callable[..., Any]
    arguments: Mapping[str, Any]

    def __post_init__(self) -> None:
        self.freeze()

    @property
    def name(self) -> str:
        """Name of the function."""
        return self.make.__name__

    @property
    def numbers(self) -> dict[str, tuple[float, DeclaredField]]:
        """Values and declarations of the numbers by name, those of a motion as `table.amplitude`."""
        numbers: dict[str, tuple[float, DeclaredField]] = {}
        for name, field in declared_arguments(self.make).items():
            value = self.arguments[name]
            if isinstance(value, Checked):
                kind: type = type(value)
                fields = declared_fields(kind).items()
                numbers |= {f"{name}.{leaf}": (getattr(value, leaf), x) for leaf, x in fields if x.is_number}
            elif field.is_number and value is not None:
                numbers[name] = value, field
        return numbers

    @property
    def settings(self) -> dict[str, Any]:
        """Name and numbers as a section of a configuration."""
        section: dict[str, Any] = {"name": self.name}
        for name, (value, _) in self.numbers.items():
            first, _, leaf = name.partition(".")
            section |= {first: {**section.get(first, {}), leaf: value}} if leaf else {first: value}
        return section

    def with_number(self, name: str, value: float) -> Any:
        """Return the plant with another number; a ValueError if it cannot have it."""
        first, _, leaf = name.partition(".")
        changed = replace(self.arguments[first], **{leaf: value}) if leaf else value
        return self.make(**{**self.arguments, first: changed})


@cache
def declared_arguments(make: Callable[..., Any]) -> dict[str, DeclaredField]:
    """Return the arguments of a function as fields of a class are declared."""
    hints, fields = get_type_hints(make, include_extras=True), {}
    for name, each in signature(make).parameters.items():
        hint = hints[name]
        kind = get_args(hint)[0] if get_origin(hint) is Annotated else hint
        default = MISSING if each.default is each.empty else each.default
        fields[name] = DeclaredField(kind, default, annotated(hint)[1])
    return fields


def plant(function: Callable[Arguments, Made]) -> Callable[Arguments, Made]:
    """Check the arguments of a function that makes a motor, and let the motor have them as its `plant`."""

    @wraps(function)
    def recording(*arguments: Arguments.args, **named: Arguments.kwargs) -> Made:
        motor, bound = function(*arguments, **named), signature(function).bind(*arguments, **named)
        bound.apply_defaults()
        # It is no argument of the motor, so that one with something replaced has none.
        object.__setattr__(motor, "plant", Plant(made, bound.arguments))
        return motor

    made = checked_arguments()(recording)
    return made
