"""What every group of keys has in common: nothing unknown passes, and sound values are remembered."""

from functools import lru_cache
from typing import ClassVar

from pydantic import BaseModel, ConfigDict, ValidationInfo, field_validator


class Section(BaseModel):
    """A frozen group of keys that refuses every key it does not know.

    A validation with a dictionary as its context leaves each sound value in it under its full
    key, also where other keys are faulty, so that rules on several keys can be checked as far as
    possible.
    """

    model_config = ConfigDict(
        strict=True, extra="forbid", frozen=True, allow_inf_nan=False, protected_namespaces=()
    )
    path: ClassVar[str]
    """Where the section stands, with the trailing dot: 'solver.'."""

    # Caches of what follows from a section ask both of these again and again; pydantic's take long.
    def __hash__(self) -> int:
        return hash((type(self), *self.__dict__.values()))

    def __eq__(self, other: object) -> bool:
        return self is other or (type(self) is type(other) and self.__dict__ == other.__dict__)

    @field_validator("*", mode="after")
    @classmethod
    def _remember(cls, value: object, info: ValidationInfo) -> object:
        if info.context is not None and not isinstance(value, Section):
            info.context[f"{cls.path}{info.field_name}"] = value
        return value


# A sweep asks for the same sections again and again.
@lru_cache(maxsize=4096)
def sound_values(section: Section) -> dict[str, object]:
    """The values of a section that is checked already, under their full keys; not to be changed."""
    found: dict[str, object] = {}
    for name in type(section).model_fields:
        value = getattr(section, name)
        found |= (
            sound_values(value) if isinstance(value, Section) else {f"{section.path}{name}": value}
        )
    return found
