"""What a law or a part is made from, read from its dataclass: numbers with units, and parts of a law.

Configuration, options and listings all follow from this; nothing is written twice.
"""

from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, dataclass, fields
from functools import cache
from typing import TYPE_CHECKING, Any, final, get_type_hints

from contactlab.laws.damping import DAMPINGS
from contactlab.laws.friction import FRICTIONS
from contactlab.laws.normal import NORMAL_FORCES
from contactlab.laws.table import Table

if TYPE_CHECKING:
    from contactlab.laws.base import ContactLaw
    from contactlab.laws.part import Part
    from contactlab.parameter import Parameter

PARTS: Mapping[str, Table[Any]] = {
    "normal": NORMAL_FORCES,
    "damping": DAMPINGS,
    "friction": FRICTIONS,
}
"""The parts of a composed law by family."""

SHARED = "friction_coefficient"
"""The parameter that is the contact's, whatever the law: laws are compared on one motor."""


@final
@dataclass(frozen=True)
class Member:
    """A field of a law or of a part.

    Args:
        name: of the field.
        parameter: what is said of a number; None for a part.
        family: of a part; empty for a number.
        default: a number, a part, or None where it must be given.
        whole: whether it is annotated as a whole number, which a key of a configuration is not.
    """

    name: str
    parameter: "Parameter | None"
    family: str
    default: Any
    whole: bool


@cache
def members_of(owner: "type[ContactLaw | Part]") -> list[Member]:
    """The fields of a law or a part, in their order.

    Raises:
        ValueError: a sentence on a field that is neither a declared number nor a part.
    """
    from contactlab.laws.part import Damping, Friction, NormalForce
    from contactlab.parameter import parameters_of

    families = {NormalForce: "normal", Damping: "damping", Friction: "friction"}
    try:
        hints = get_type_hints(owner)
        declared = parameters_of(owner)
        defaults = {field.name: _default(field) for field in fields(owner)}  # type: ignore[arg-type]
    # An annotation or a default is any expression of somebody else's.
    except Exception as error:
        raise ValueError(
            f"{owner.name} has fields that cannot be read ({type(error).__name__}: {error})."
        ) from error
    members = []
    for field in fields(owner):  # type: ignore[arg-type]
        family = families.get(hints[field.name], "")
        parameter = declared.get(field.name)
        if not family and parameter is None:
            raise ValueError(
                f"{owner.name} has the field {field.name} without a declaration; it must be "
                "Annotated[float, Parameter(...)], or a NormalForce, Damping or Friction."
            )
        whole = hints[field.name] is int
        members.append(Member(field.name, parameter, family, defaults[field.name], whole))
    return members


def made(
    owner: "Callable[..., Any]", values: Mapping[str, Any], friction_coefficient: float
) -> Any:
    """A law or a part from its section of a configuration.

    Raises:
        ValueError: a sentence of the law's own.
    """
    given: dict[str, Any] = {}
    for member in members_of(owner):
        if member.family:
            below = values[member.name]
            part = PARTS[member.family][below["name"]]
            given[member.name] = made(part, below, friction_coefficient)
        else:
            shared = member.name == SHARED
            value = friction_coefficient if shared else values[member.name]
            # One that is not whole the law refuses.
            given[member.name] = int(value) if member.whole and value == value // 1 else value
    return owner(**given)


def takes_shared(owner: "type[ContactLaw | Part]", values: Mapping[str, Any]) -> bool:
    """Whether the parameter that is the contact's is one of a law's, or of its parts as they are chosen."""
    return any(
        takes_shared(PARTS[member.family][values[member.name]["name"]], values[member.name])
        if member.family
        else member.name == SHARED
        for member in members_of(owner)
    )


def _default(field: "Field[Any]") -> Any:
    if field.default is not MISSING:
        return field.default
    return None if field.default_factory is MISSING else field.default_factory()
