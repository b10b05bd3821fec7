"""The schema of a configuration: pydantic models made from the groups' tables of keys."""

from functools import cache
from typing import Annotated, Any, ClassVar, Union

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, create_model, field_validator

from contactlab.config.groups import GROUPS, NOT_OF_A_RUN, Choice, Keys, laws
from contactlab.config.quantity import Quantity
from contactlab.parameter import DeclaredField, Parameter


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
def configuration_with(*others: str) -> type[Section]:
    """Give the schema of a configuration; the names are those of laws of other packages that it may have."""
    fields: dict[str, Any] = {}
    for group, choice in {"law": laws(*others), **GROUPS}.items():
        kind = _annotation(choice, f"{group}.")
        fields[group] = (kind | None, None) if group in NOT_OF_A_RUN else (kind, ...)
    return create_model("Configuration", __base__=Section, **fields)


def _annotation(found: DeclaredField | Keys | Choice, path: str) -> Any:
    """What pydantic wants of a field, a section or a choice between sections."""
    if isinstance(found, dict):
        return _section(found, path)
    if isinstance(found, Choice):
        kinds = tuple(_section(keys, path) for keys in found.options.values())
        if not found.told_by:
            return kinds[0]
        return Annotated[Union[kinds], Field(discriminator=found.told_by)]  # noqa: UP007
    if found.parameter and {int, float} & {*found.kinds}:
        return Annotated[found.kind, Quantity(found, found.parameter)]
    return found.kind


def _section(keys: Keys, path: str) -> type[Section]:
    """The model of a table of keys."""
    fields: dict[str, Any] = {
        name: (_annotation(found, f"{path}{name}."), ...) for name, found in keys.items()
    }
    section = create_model(path, __base__=Section, **fields)
    section.path = path
    return section


def declared_in(checked: Section) -> dict[str, Parameter]:
    """Give what is declared of every key that holds a number, by full key.

    Args:
        checked: a configuration as `contactlab.config.validate` gives it, or a section of one.
    """
    found: dict[str, Parameter] = {}
    for name, field in type(checked).model_fields.items():
        if isinstance(value := getattr(checked, name), Section):
            found |= declared_in(value)
        for said in field.metadata:
            if isinstance(said, Quantity):
                found[f"{checked.path}{name}"] = said.parameter
    return found
