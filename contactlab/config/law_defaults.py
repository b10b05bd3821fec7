"""The options of the group `law` that need no file: every law and part, as it is by default.

A file of the same name in `conf/law`, or elsewhere on the search path, has precedence.
"""

from typing import Any

from contactlab.config.quantity import MISSING
from contactlab.laws.declaration import SHARED, Member, members_of
from contactlab.laws.registry import PARTS, law_class, law_names

LAW = "law"
"""The group of the laws; those of the parts lie below it."""


def groups() -> list[str]:
    """The groups that have such options."""
    return [LAW, *(f"{LAW}/{family}" for family in PARTS)]


def options(group: str) -> list[str]:
    """The options of a group; nothing is imported to list them."""
    if group == LAW:
        return law_names()
    return sorted(PARTS[group.removeprefix(f"{LAW}/")])


def content(group: str, option: str) -> dict[str, Any]:
    """The keys of an option, with a defaults list where a law has parts.

    A law that cannot be loaded has its name alone; the check of the configuration says why.
    """
    try:
        if group == LAW:
            members = members_of(law_class(option))
        else:
            members = members_of(PARTS[group.removeprefix(f"{LAW}/")][option])
    except ValueError:
        return {"name": option}
    numbers = [member for member in members if not member.family and member.name != SHARED]
    parts = [member for member in members if member.family and member.default is not None]
    keys: dict[str, Any] = {"name": option} | {
        member.name: MISSING if member.required else member.default for member in numbers
    }
    if parts:
        keys = {"defaults": [*map(_default_part, parts), "_self_"], **keys}
    return keys


def _default_part(member: Member) -> dict[str, str]:
    """The entry of a defaults list for a part."""
    same = member.name == member.family
    return {member.family if same else f"{member.family}@{member.name}": member.default.name}
