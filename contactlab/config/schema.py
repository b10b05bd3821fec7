"""The schema of a configuration: pydantic models made from the groups' tables of keys."""

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Annotated, Any, ClassVar, Union

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, create_model, field_validator

from contactlab.config.groups import GROUPS, KINDS, LAW, NOT_OF_A_RUN, Keys, law_keys, part_members
from contactlab.config.quantity import Quantity, describe
from contactlab.laws.declaration import PARTS
from contactlab.laws.registry import law_names
from contactlab.parameter import Declared, Parameter


class Section(BaseModel):
    """A frozen group of keys that refuses every key it does not know.

    A validation with a dictionary as its context leaves each sound value in it under its full
    key, also where other keys are faulty, so that rules on several keys can be checked as far as
    possible.
    """

    model_config = ConfigDict(
        strict=True, extra="forbid", frozen=True, allow_inf_nan=False, protected_namespaces=()
    )
    path: ClassVar[str] = ""
    """Where the section stands, with the trailing dot: 'solver.'."""

    @field_validator("*", mode="after")
    @classmethod
    def _remember(cls, value: object, info: ValidationInfo) -> object:
        if info.context is not None and not isinstance(value, Section):
            info.context[f"{cls.path}{info.field_name}"] = value
        return value


@cache
def configuration_with(law: str = "", parts: tuple[tuple[str, str], ...] = ()) -> type[Section]:
    """Give the schema of a configuration with one law; of any law, whose keys are not looked at, without.

    Args:
        law: its name.
        parts: the name of the part in each field of the law that is one.

    Raises:
        ValueError: a sentence on why the law has no keys.
    """
    fields: dict[str, Any] = {
        LAW: (_section(f"{LAW}.", law_keys(law, parts)) if law else dict[str, Any], ...)
    }
    for group, options in GROUPS.items():
        kinds = tuple(_section(f"{group}.", keys) for keys in options.values())
        found: Any = kinds[0]
        if len(kinds) > 1:
            found = Annotated[Union[kinds], Field(discriminator=KINDS[group])]  # noqa: UP007
        fields[group] = (found | None, None) if group in NOT_OF_A_RUN else (found, ...)
    return create_model("Configuration", __base__=Section, **fields)


def _section(path: str, keys: Keys) -> type[Section]:
    """The pydantic model of a table of keys."""
    fields: dict[str, Any] = {}
    for name, declared in keys.items():
        if name.startswith("_") or hasattr(Section, name):
            raise ValueError(
                f"{path}{name} is a name that configurations use themselves; the parameter must be "
                "named otherwise."
            )
        if not isinstance(declared, Declared):
            kind: Any = _section(f"{path}{name}.", declared)
        elif declared.parameter and {int, float} & {*declared.kinds}:
            kind = Annotated[declared.kind, Quantity(declared, declared.parameter)]
        else:
            kind = declared.kind
        fields[name] = (kind, ...)
    section = create_model(path, __base__=Section, **fields)
    section.path = path
    return section


def chosen_law(given: object) -> tuple[type[Section], dict[str, str], list[str]]:
    """Give the schema that a configuration's law asks for.

    Args:
        given: what stands under the key `law`.

    Returns:
        The schema, the names of law and parts by their keys, and sentences on those that are not known.
    """
    if not isinstance(given, Mapping):
        return configuration_with(), {}, []
    choices: dict[str, str] = {}
    faults: list[str] = []
    name = _choice(given, LAW, law_names(), choices, faults)
    try:
        for member in part_members(name):
            if isinstance(below := given.get(member.name), Mapping):
                known = sorted(PARTS[member.family])
                _choice(below, f"{LAW}.{member.name}", known, choices, faults)
        if not faults:
            return configuration_with(name, parts_of(choices)), choices, []
    except ValueError as error:
        faults = [f"law.name is '{name}', which cannot run. {error}"]
    return configuration_with(), choices, faults


def _choice(
    given: Mapping[str, Any], key: str, known: list[str], choices: dict[str, str], faults: list[str]
) -> str:
    """The name in a section, remembered under the section's key; empty with a fault."""
    way_out = f"Choose one by {key.replace('.', '/')}=NAME."
    if "name" not in given:
        faults.append(f"{key}.name is missing; it must be given. {way_out}")
        return ""
    name = given["name"]
    if not isinstance(name, str) or name not in known:
        expected = ", ".join(f"'{known_name}'" for known_name in known)
        faults.append(f"{key}.name is {describe(name)}; it must be one of {expected}. {way_out}")
        return ""
    choices[key] = name
    return name


def parts_of(choices: Mapping[str, str]) -> tuple[tuple[str, str], ...]:
    """Give the part in each field of the law, from the choices by the keys of their sections."""
    return tuple((k.removeprefix(f"{LAW}."), part) for k, part in choices.items() if k != LAW)


def declared_in(checked: Section) -> dict[str, Parameter]:
    """Give what is declared of every key that holds a number, by full key.

    Args:
        checked: a configuration as `contactlab.config.validate` gives it, or a section of one.
    """
    return dict(_declared(checked))


def _declared(section: Section) -> Iterator[tuple[str, Parameter]]:
    for name, field in type(section).model_fields.items():
        value = getattr(section, name)
        if isinstance(value, Section):
            yield from _declared(value)
        for said in field.metadata:
            if isinstance(said, Quantity):
                yield f"{section.path}{name}", said.parameter
