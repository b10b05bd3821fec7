"""The options of every group, every full key, and help on them."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import MISSING
from functools import cache
from pathlib import Path
from types import NoneType
from typing import Any

from contactlab import quantity
from contactlab.config.groups import FAMILIES, GROUPS, LAW, Section
from contactlab.config.nesting import nested
from contactlab.laws.declaration import family_of, members_of
from contactlab.laws.registry import class_of
from contactlab.parameter import DeclaredField
from contactlab.suggestion import suggestion


def conf_directory() -> Path:
    """Return the folder of the configuration files: in the package in a wheel, beside it in a checkout."""
    inside = Path(__file__).resolve().parents[1] / "conf"
    return inside if inside.is_dir() else inside.parents[1] / "conf"


_sections: dict[str, Section] = {
    "law": LAW,
    **{f"law/{family}": section for family, section in FAMILIES.items()},
    **GROUPS,
}
"""The sections of compositions by group: those of a run, and what `declare` adds."""


def declare(sections: Mapping[str, Section]) -> None:
    """Let compositions have other groups beside those of a run, as the command has."""
    _sections.update(sections)
    known_keys.cache_clear()


def groups() -> dict[str, list[str]]:
    """Return the options that need no file, by group; nothing of another package is imported."""
    return {group: sorted(section.options) for group, section in _sections.items()}


def content(group: str, option: str) -> dict[str, Any]:
    """Return the keys of an option with their defaults, and a defaults list where a law has parts.

    A law or part that cannot be loaded has its name alone; the check of the configuration says why.
    """
    section = _sections.get(group, LAW)
    try:
        keys = section.options[option]
    except (KeyError, ValueError):
        return {section.selector or "name": option}
    members = members_of(class_of(option)) if section is LAW else {}
    entries = [
        {family if name == family else f"{family}@{name}": member.default.name}
        for name, member in members.items()
        if (family := family_of(member)) and member.default is not MISSING
    ]
    values = nested(
        {
            key: quantity.MISSING if field.default is MISSING else field.default
            for key, field in full_keys(keys, selected=False)
        }
    )
    return {"defaults": [*entries, "_self_"], **values} if entries else values


def fault_of_option(group: str, option: str) -> str:
    """Return why the keys of an option cannot be read, as those of a broken law; empty for a sound one."""
    try:
        _sections.get(group, LAW).options[option]
    except KeyError:
        return ""
    except ValueError as error:
        return str(error)
    return ""


def full_keys(
    keys: Mapping[str, DeclaredField | Section], before: str = "", *, selected: bool = True
) -> Iterator[tuple[str, DeclaredField]]:
    """Yield the declaration of every full key, those of sections with a selector only if `selected`.

    A law or part that cannot be loaded has none.
    """
    for name, below in keys.items():
        if isinstance(below, DeclaredField):
            yield f"{before}{name}", below
        elif selected or not below.selector:
            for option in below.options:
                with suppress(ValueError):
                    yield from full_keys(below.options[option], f"{before}{name}.", selected=selected)


@cache
def known_keys(law: str = "") -> list[str]:
    """Return every full key of every option, or of one law alone; a law that cannot be loaded has none."""
    keys: dict[str, object] = {"law.name": None}
    for name in LAW.options:
        if law in ("", name):
            with suppress(ValueError):
                keys |= dict(full_keys(LAW.options[name], "law."))
    others = {group: section for group, section in _sections.items() if group.partition("/")[0] != "law"}
    return [*keys, *dict(full_keys(others))]


def unknown_key(key: str, kind: str, known: Sequence[str]) -> str:
    """Return the fault of a key that is unknown, or does not belong to the chosen option of its group."""
    group = key.rpartition(".")[0].replace(".", "/")
    if kind and any(f"{name}.".startswith(f"{key}.") for name in known_keys()):
        text = f"{key} does not belong to {kind}; it must be absent with this choice of {group}."
        first, _, rest = key.partition(".")
        family = rest.partition(".")[0]
        if first != "law" or family not in FAMILIES:
            return text
        normal = "" if family == "normal" else "law/normal=hertz_point "
        return f"{text} Parts are chosen as in law=composed {normal}law/{family}=NAME."
    *path, _ = key.split(".")
    depth = len(path) + 1
    # Keys and groups beside it.
    siblings = [".".join(parts[:depth]) for name in known if (parts := name.split("."))[: len(path)] == path]
    expected = ", ".join(dict.fromkeys(siblings or ("law", *GROUPS)))
    return f"{key} is not a known key. {key_meant(key, known, f'It must be one of {expected}.')}"


def key_meant(key: str, known: Sequence[str], otherwise: str) -> str:
    """Return a sentence on the key that was meant: one of nearly this name, or of this symbol, as mu."""
    every = dict(full_keys({group: section for group, section in GROUPS.items() if not section.selector}))
    symbols = [name for name, field in every.items() if field.parameter and field.parameter.symbol == key]
    meant = f"Did you mean {' or '.join(symbols)}?" if symbols else otherwise
    # Those of small plants, whose numbers have the names of a motor's, come last.
    plants = [name for name in known if name.startswith("plant.")]
    return suggestion(key, [name for name in known if name not in plants], suggestion(key, plants, meant))


def help_on_keys() -> str:
    """Return a line for every key but those of laws and studies: meaning, unit, and what null stands for."""
    listed = {group: s for group, s in _sections.items() if group.partition("/")[0] not in ("law", "study")}
    return "\n  ".join(
        f"{key:<31} {declared.meaning}{declared.label and f' [{declared.unit}]'}"
        f"{'. ' + declared.hint if NoneType in field.kinds else ''}"
        for key, field in dict(full_keys(listed)).items()
        if (declared := field.parameter)
    )


def group_selected_by(key: str) -> str:
    """Return the group that a key selects an option of, 'law/normal' for 'law.normal.name'; else empty."""
    section, _, last = key.rpartition(".")
    is_law = section.partition(".")[0] == "law"
    selector = "name" if is_law else _sections[section].selector if section in _sections else ""
    return section.replace(".", "/") if last == selector else ""
