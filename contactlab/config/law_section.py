"""The section of the chosen law, made from what the law declares of its fields.

Only the chosen law is imported. Its numbers become keys with the declared unit and range, its parts
become sections of their own, whose key `name` tells which part it is.
"""

from collections.abc import Mapping
from functools import cache
from math import isfinite
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, TypeVar, final

from pydantic import ValidationInfo, create_model, field_validator

from contactlab.config.quantity import Quantity, describe
from contactlab.config.section import Section
from contactlab.config.units import from_cf
from contactlab.laws.declaration import SHARED, Member, members_of
from contactlab.laws.registry import PARTS, law_class, law_names

if TYPE_CHECKING:
    from contactlab.parameter import Parameter

Stiffness = Annotated[
    float | None,
    Quantity(
        "N/m^1.5",
        above=0.0,
        none=True,
        hint="A 5 mm steel tip has about 1e10 N/m^1.5; null takes it from law.tip_radius.",
    ),
]
TipRadius = Annotated[
    float | None,
    Quantity("m", above=0.0, none=True, hint="Leave it out where law.stiffness is given."),
]

Base = TypeVar("Base", bound=Section)


class LawSection(Section):
    """The law's own parameters; what all laws share is in `contact`."""

    path: ClassVar[str] = "law."
    takes_tolerance: ClassVar[bool] = False
    """Whether the law is integrated with error control, as compliant laws are."""

    name: str


@final
class HertzPenaltySection(LawSection):
    """Exactly one of stiffness and tip radius is given: a choice that no declaration tells of."""

    takes_tolerance: ClassVar[bool] = True

    name: Literal["hertz_penalty"]
    stiffness: Stiffness
    tip_radius: TipRadius


@final
class _Unchosen(LawSection):
    """Stands for the section of a law that is not known: nothing more can be said of its keys."""

    model_config = LawSection.model_config | {"extra": "ignore"}

    name: Any = None

    @field_validator("*", mode="after")
    @classmethod
    def _remember(cls, value: object, _info: ValidationInfo) -> object:
        """Remember nothing: a name that nothing is known of is no sound value."""
        return value


_WRITTEN: dict[str, type[LawSection]] = {"hertz_penalty": HertzPenaltySection}
"""Sections with a rule that no declaration tells of."""


def chosen_section(given: object) -> tuple[type[LawSection], dict[str, str], list[str]]:
    """The section that a configuration's law asks for.

    Args:
        given: what stands under the key `law`, or such a section itself.

    Returns:
        The section, the names of law and parts by their keys, and sentences on those that are not
        known.
    """
    if isinstance(given, LawSection):
        return type(given), {}, []
    if not isinstance(given, Mapping):
        return LawSection, {}, []
    choices: dict[str, str] = {}
    faults: list[str] = []
    name = _name(given, "law", law_names(), choices, faults)
    if name is None:
        return _Unchosen, choices, faults
    try:
        parts = _part_names(name, given, choices, faults)
        return (_Unchosen if faults else section_of(name, parts)), choices, faults
    except ValueError as error:
        return _Unchosen, choices, [f"law.name is '{name}', which cannot run. {error}"]


@cache
def section_of(name: str, parts: tuple[tuple[str, str], ...] = ()) -> type[LawSection]:
    """The section of a law with chosen parts.

    Args:
        name: of the law.
        parts: the name of the part in each field that is one; those left out are as they are by
            default.

    Raises:
        ValueError: a sentence on why there is none.
    """
    if name in _WRITTEN:
        return _WRITTEN[name]
    law = law_class(name)
    names = dict(parts)
    keys: dict[str, Any] = {}
    for member in members_of(law):
        if member.family:
            # A part that is not named makes a section all the same, which says what is missing.
            chosen = names.get(member.name) or str(getattr(member.default, "name", ""))
            keys[member.name] = _part_section(member, chosen)
        elif member.name != SHARED:
            keys[member.name] = _quantity(name, member)
    section = _made(LawSection, "law.", name, keys)
    section.takes_tolerance = _is_compliant(law)
    return section


def part_members(name: str) -> list[Member]:
    """The fields of a law that are parts; a law with a section of its own has none.

    Raises:
        ValueError: the law cannot be loaded.
    """
    if name in _WRITTEN:
        return []
    return [member for member in members_of(law_class(name)) if member.family]


def takes_tolerance(name: str) -> bool:
    """Whether a law that is known to load is integrated with error control."""
    if name in _WRITTEN:
        return _WRITTEN[name].takes_tolerance
    return _is_compliant(law_class(name))


def _is_compliant(law: type) -> bool:
    from contactlab.laws.base import PenaltyLaw

    return issubclass(law, PenaltyLaw)


def _name(
    given: Mapping[object, object],
    key: str,
    known: list[str],
    choices: dict[str, str],
    faults: list[str],
) -> str | None:
    """The name in a section, remembered under the section's key; None with a fault."""
    way_out = f"Choose one by {key.replace('.', '/')}=NAME."
    if "name" not in given:
        faults.append(f"{key}.name is missing; it must be given. {way_out}")
        return None
    name = given["name"]
    if not isinstance(name, str) or name not in known:
        expected = ", ".join(f"'{known_name}'" for known_name in known)
        faults.append(f"{key}.name is {describe(name)}; it must be one of {expected}. {way_out}")
        return None
    choices[key] = name
    return name


def _part_names(
    name: str, given: Mapping[object, object], choices: dict[str, str], faults: list[str]
) -> tuple[tuple[str, str], ...]:
    """The part in each field of the law that is one, as far as it is named."""
    names = []
    for member in part_members(name):
        below = given.get(member.name)
        if isinstance(below, Mapping):
            known = sorted(PARTS[member.family])
            found = _name(below, f"law.{member.name}", known, choices, faults)
            names.append((member.name, found or ""))
    return tuple(names)


def _part_section(member: Member, name: str) -> tuple[Any, Any]:
    """The section of a part, as pydantic wants a field."""
    keys: dict[str, Any] = {}
    if name:
        keys = {
            below.name: _quantity(name, below)
            for below in members_of(PARTS[member.family][name])
            if below.name != SHARED
        }
    return _made(Section, f"law.{member.name}.", name, keys), ...


def _made(base: type[Base], path: str, name: str, keys: dict[str, Any]) -> type[Base]:
    """A section of a law or part."""
    if taken := [k for k in keys if k == "name" or k.startswith("_") or hasattr(base, k)]:
        raise ValueError(
            f"{name} has parameters named {', '.join(taken)}, which configurations use themselves; "
            "they must be named otherwise."
        )
    fields: dict[str, Any] = {"name": (Literal[name] if name else str, ...), **keys}
    section = create_model(f"{path}{name}", __base__=base, **fields)
    section.path = path
    return section


def _quantity(owner: str, member: Member) -> tuple[Any, Any]:
    """A number's annotation, as pydantic wants a field."""
    said: Parameter | None = member.parameter
    assert said is not None, f"{owner}.{member.name} is no part"
    bounds: dict[str, Any] = {
        bound: value if isfinite(value) else None
        for bound in ("above", "at_least", "at_most", "below")
        for value in [getattr(said, bound)]
    }
    hint = f"It is the {said.meaning} {said.symbol} of {owner}."
    return Annotated[float, Quantity(from_cf(said.units), **bounds, hint=hint)], ...
