"""The groups of the configuration, as the classes declare them: options, keys, units, ranges, defaults.

To add a group is to add a line to `GROUPS`; what binds several keys together is in
`contactlab.config.rules`. Options that differ from the declared defaults are files in `conf/`.
"""

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import MISSING, dataclass, replace
from functools import cache, cached_property
from types import NoneType
from typing import Any, Final, Literal, final

from contactlab.config import quantity
from contactlab.laws.declaration import SHARED, family_of, members_of
from contactlab.laws.lagrange import LagrangeSlip
from contactlab.laws.registry import LAWS, PARTS, law_class, law_names
from contactlab.motor import (
    ContactGeometry,
    FiniteElementResonator,
    PatchedBeam,
    Piezoceramic,
    PiezoceramicDatasheet,
    RitzResonator,
    Rotor,
    TwoMode,
)
from contactlab.parameter import DeclaredField, declared_fields
from contactlab.settings import Record, Solver, Sweep

Keys = dict[str, Any]
"""What is declared, by key: a field; a table of the keys of a section below; or a choice between such."""


@final
@dataclass(frozen=True)
class Choice:
    """A section that is one of several.

    Args:
        options: the keys of each, by name.
        told_by: the key that tells which it is; empty where there is one option only.
        group, default: of a part of a law: its family, and the usual option if there is one.
    """

    options: Mapping[str, Keys]
    told_by: str = ""
    group: str = ""
    default: str = ""

    @cached_property
    def told(self) -> dict[str, tuple[str, Keys]]:
        """Each option with its keys, by the word of the key that tells it."""
        return {keys[self.told_by].default: (o, keys) for o, keys in self.options.items()}


def keys_of(owner: type, *without: str) -> Keys:
    """Give the keys that a class declares, those of the objects that it holds included."""
    return {
        name: field if field.parameter else keys_of(field.kind)
        for name, field in declared_fields(owner).items()
        if name not in without
    }


def _named(key: str, name: str, keys: Keys) -> Keys:
    """The keys of a section that is told by its name."""
    return {key: DeclaredField(Literal[name], name, None), **keys}


def _narrowed(field: DeclaredField, **changes: Any) -> DeclaredField:
    """A field that the configuration declares more narrowly than its class does."""
    assert field.parameter is not None
    return replace(field, parameter=replace(field.parameter, **changes))


BASES: Final = {"ritz": RitzResonator, "finite_element": FiniteElementResonator}

_BEAM: Final = declared_fields(PatchedBeam)
_CONTACT: Final = declared_fields(ContactGeometry)

GROUPS: Final[dict[str, Choice]] = {
    "resonator": Choice(
        {
            name: _named("basis", name, keys_of(basis, "patch_start", "patch_end", "piezoceramic"))
            for name, basis in BASES.items()
        },
        "basis",
    ),
    "piezoceramic": Choice(
        {
            "pz26_identified": _named("constants", "bending", keys_of(Piezoceramic)),
            "pz26_datasheet": _named("constants", "tensor", keys_of(PiezoceramicDatasheet)),
        },
        "constants",
    ),
    "placement": Choice(
        {"placement_2": {"start": _BEAM["patch_start"], "end": _BEAM["patch_end"]}}
    ),
    "drive": Choice({"two_mode": keys_of(TwoMode)}),
    "contact": Choice(
        {
            "default": {
                "tip_length": _CONTACT["tip_length"],
                "clearance": _narrowed(
                    _CONTACT["clearance"],
                    at_least=0.0,
                    hint="A motor that is pressed together at rest is no option.",
                ),
                SHARED: _narrowed(
                    declared_fields(LagrangeSlip)[SHARED],
                    at_most=5.0,
                    hint="Dry solids have 0.05 to 1.5, and 0 is frictionless.",
                ),
            }
        }
    ),
    "rotor": Choice({"default": {"radius": _CONTACT["rotor_radius"], **keys_of(Rotor)}}),
    "solver": Choice({"default": keys_of(Solver)}),
    "record": Choice({"default": keys_of(Record)}),
    "sweep": Choice({"default": keys_of(Sweep)}),
}
"""The groups but that of the laws, in the order of a configuration."""

NOT_OF_A_RUN: Final = frozenset({"sweep"})
"""The groups that say how runs are made: they may be left out, and a run's own configuration has none."""


def keys_of_law(owner: Any) -> Keys:
    """Give the keys of a law or a part.

    Raises:
        ValueError: it has fields that cannot be keys.
    """
    keys = {
        name: replace(FAMILIES[family], default=getattr(field.default, "name", ""))
        if (family := family_of(field))
        else field
        for name, field in members_of(owner).items()
        if name != SHARED
    }
    return _named("name", owner.name, keys)


FAMILIES: Final = {
    family: Choice({name: keys_of_law(part) for name, part in parts.items()}, "name", family)
    for family, parts in PARTS.items()
}
"""The parts of the composed law."""


@cache
def laws(*names: str) -> Choice:
    """Give the choice between the laws of this package and some of others; one that is broken is none."""
    options = {}
    for name in (*LAWS, *names):
        with suppress(ValueError):
            options[name] = keys_of_law(law_class(name))
    return Choice(options, "name")


def groups() -> dict[str, list[str]]:
    """Give the options that need no file, by group; no law of another package is imported to list it."""
    return (
        {"law": law_names()}
        | {f"law/{family}": sorted(parts) for family, parts in PARTS.items()}
        | {group: sorted(choice.options) for group, choice in GROUPS.items()}
    )


def content(group: str, option: str) -> dict[str, Any]:
    """Give the keys of an option with their defaults, and a defaults list where a law has parts.

    A law that cannot be loaded has its name alone; the check of the configuration says why.
    """
    below = group.removeprefix("law/")
    choice = GROUPS.get(group) or FAMILIES.get(below) or laws(option)
    keys = choice.options.get(option, _named("name", option, {}))
    entries = [
        {part.group if name == part.group else f"{part.group}@{name}": part.default}
        for name, part in keys.items()
        if isinstance(part, Choice) and part.default
    ]
    return {"defaults": [*entries, "_self_"], **_defaults(keys)} if entries else _defaults(keys)


def _defaults(keys: Keys) -> dict[str, Any]:
    return {
        name: _defaults(found)
        if isinstance(found, dict)
        else (quantity.MISSING if found.default is MISSING else found.default)
        for name, found in keys.items()
        if not isinstance(found, Choice)
    }


def full_keys(found: Any, path: str) -> Iterator[tuple[str, DeclaredField]]:
    """Give what is declared of every full key below a path, of every choice."""
    if isinstance(found, DeclaredField):
        yield path, found
        return
    for keys in found.options.values() if isinstance(found, Choice) else [found]:
        for name, below in keys.items():
            yield from full_keys(below, f"{path}.{name}" if path else name)


@cache
def known_keys(law: str = "") -> list[str]:
    """Give every full key of every choice, or of one law alone where it is named; a broken one has none."""
    choice = laws(*([law] if law else law_names()))
    own = choice.options.get(law, _named("name", law, {})) if law else choice
    return list(dict(full_keys({"law": own, **GROUPS}, "")))


def help_on_keys() -> str:
    """Give a line for every key but those of laws: what it is, its unit, and what null stands for."""
    return "\n  ".join(
        f"{key:<31} {said.meaning}{said.label and f' [{said.unit}]'}"
        f"{'. ' + said.hint if NoneType in field.kinds else ''}"
        for key, field in dict(full_keys(GROUPS, "")).items()
        if (said := field.parameter)
    )


def group_told_by(key: str) -> str:
    """Give the group whose choice a key tells, 'law/normal' for 'law.normal.name'; empty for other keys."""
    section, _, last = key.rpartition(".")
    group = section.replace(".", "/")
    if section in GROUPS:
        return group if last == GROUPS[section].told_by else ""
    return group if last == "name" and section.partition(".")[0] == "law" else ""
