"""What there is to choose and to set: the options of every group, every key in full, and help on them."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import MISSING
from functools import cache
from types import NoneType
from typing import Any

from contactlab.config import quantity
from contactlab.config.groups import FAMILIES, GROUPS, LAW, Keys
from contactlab.config.nesting import nested
from contactlab.laws.declaration import family_of, members_of
from contactlab.laws.registry import class_of
from contactlab.parameter import DeclaredField


def groups() -> dict[str, list[str]]:
    """Give the options that need no file, by group; nothing of another package is imported to list it."""
    sections = {"law": LAW} | {f"law/{family}": section for family, section in FAMILIES.items()} | GROUPS
    return {group: sorted(section.options) for group, section in sections.items()}


def content(group: str, option: str) -> dict[str, Any]:
    """Give the keys of an option with their defaults, and a defaults list where a law has parts.

    A law or part that cannot be loaded has its name alone; the check of the configuration says why.
    """
    section = GROUPS.get(group) or FAMILIES.get(group.removeprefix("law/")) or LAW
    try:
        keys = section.options[option]
    except (KeyError, ValueError):
        return {"name": option}
    members = members_of(class_of(option)) if section is LAW else {}
    entries = [
        {family if name == family else f"{family}@{name}": member.default.name}
        for name, member in members.items()
        if (family := family_of(member)) and member.default is not MISSING
    ]
    values = nested(
        {
            key: quantity.MISSING if field.default is MISSING else field.default
            for key, field in full_keys(keys, told=False)
        }
    )
    return {"defaults": [*entries, "_self_"], **values} if entries else values


def full_keys(keys: Keys, before: str = "", *, told: bool = True) -> Iterator[tuple[str, DeclaredField]]:
    """Give what is declared of every full key, without those of sections whose option is told, if asked.

    A law or part that cannot be loaded has none.
    """
    for name, below in keys.items():
        if isinstance(below, DeclaredField):
            yield f"{before}{name}", below
        elif told or not below.told_by:
            for option in below.options:
                with suppress(ValueError):
                    yield from full_keys(below.options[option], f"{before}{name}.", told=told)


@cache
def known_keys(law: str = "") -> list[str]:
    """Give every full key of every option, or of one law alone where it is named; a broken one has none."""
    found = dict.fromkeys(["law.name"])
    for name in LAW.options:
        if law in ("", name):
            with suppress(ValueError):
                found |= dict.fromkeys(dict(full_keys(LAW.options[name], "law.")))
    return [*found, *dict(full_keys({**GROUPS}))]


def help_on_keys() -> str:
    """Give a line for every key but those of laws: what it is, its unit, and what null stands for."""
    return "\n  ".join(
        f"{key:<31} {said.meaning}{said.label and f' [{said.unit}]'}"
        f"{'. ' + said.hint if NoneType in field.kinds else ''}"
        for key, field in dict(full_keys({**GROUPS})).items()
        if (said := field.parameter)
    )


def group_told_by(key: str) -> str:
    """Give the group whose choice a key tells, 'law/normal' for 'law.normal.name'; empty for other keys."""
    section, _, last = key.rpartition(".")
    is_law = section.partition(".")[0] == "law"
    told_by = "name" if is_law else GROUPS[section].told_by if section in GROUPS else ""
    return section.replace(".", "/") if last == told_by else ""
