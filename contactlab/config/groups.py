"""The groups of the configuration, as the classes declare them: options, keys, units, ranges, defaults.

A group is a table of its options, an option a table of its keys. To add a group is to add a line to
`GROUPS`; what binds several keys together is in `contactlab.config.rules`. The keys of a law follow from
the law that is chosen. Options that differ from the declared defaults are files in `conf/`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import MISSING as NONE_DECLARED
from dataclasses import replace
from functools import cache
from typing import Any, Final, Literal

from contactlab.config.nesting import flat
from contactlab.config.quantity import MISSING
from contactlab.laws.declaration import PARTS, SHARED, Member, members_of
from contactlab.laws.lagrange_slip import LagrangeSlip
from contactlab.laws.registry import law_class, law_names
from contactlab.motor.drive import TwoMode
from contactlab.motor.finite_element import FiniteElementResonator
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.materials import Piezoceramic, PiezoceramicDatasheet
from contactlab.motor.motor import Rotor
from contactlab.motor.patched_beam import PatchedBeam
from contactlab.motor.ritz import RitzResonator
from contactlab.parameter import Declared, Parameter, declared_fields
from contactlab.settings import Record, Solver, Sweep

Keys = dict[str, Any]
"""What is declared by key; a section below is such a table itself."""

LAW: Final = "law"
"""The group of the laws; those of the parts lie below it."""

BASES: Final = {"ritz": RitzResonator, "finite_element": FiniteElementResonator}

CERAMICS: Final = {"bending": Piezoceramic, "tensor": PiezoceramicDatasheet}

_OF_OTHER_GROUPS: Final = ("patch_start", "patch_end", "piezoceramic")


def _narrowed(declared: Declared, **changes: Any) -> Declared:
    """A field that the configuration declares more narrowly than its class does."""
    assert declared.parameter is not None
    return replace(declared, parameter=replace(declared.parameter, **changes))


def _told_by(name: str) -> Declared:
    """The key that tells which kind a section is of."""
    return Declared(Literal[name], name, None)


def keys_of(owner: type, *without: str) -> Keys:
    """Give the keys that a class declares, those of the objects that it holds included."""
    return {
        name: declared if declared.parameter else keys_of(declared.kind)
        for name, declared in declared_fields(owner).items()
        if name not in without
    }


_BEAM: Final = declared_fields(PatchedBeam)
_GEOMETRY: Final = declared_fields(ContactGeometry)

GROUPS: Final[Mapping[str, Mapping[str, Keys]]] = {
    "resonator": {
        name: {"basis": _told_by(name), **keys_of(basis, *_OF_OTHER_GROUPS)}
        for name, basis in BASES.items()
    },
    "piezoceramic": {
        option: {"constants": _told_by(kind), **keys_of(CERAMICS[kind])}
        for option, kind in {"pz26_identified": "bending", "pz26_datasheet": "tensor"}.items()
    },
    "placement": {"placement_2": {"start": _BEAM["patch_start"], "end": _BEAM["patch_end"]}},
    "drive": {"two_mode": keys_of(TwoMode)},
    "contact": {
        "default": {
            "tip_length": _GEOMETRY["tip_length"],
            "clearance": _narrowed(
                _GEOMETRY["clearance"],
                at_least=0.0,
                hint="A motor that is pressed together at rest is no option.",
            ),
            SHARED: _narrowed(
                declared_fields(LagrangeSlip)[SHARED],
                at_most=5.0,
                hint="Dry solids have 0.05 to 1.5, and 0 is frictionless.",
            ),
        }
    },
    "rotor": {"default": {"radius": _GEOMETRY["rotor_radius"], **keys_of(Rotor)}},
    "solver": {"default": keys_of(Solver)},
    "record": {"default": keys_of(Record)},
    "sweep": {"default": keys_of(Sweep)},
}
"""The groups whose options are known beforehand, in the order of a configuration."""

NOT_OF_A_RUN: Final = frozenset({"sweep"})
"""The groups that say how runs are made: they may be left out, and a run's own configuration has none."""

KINDS: Final = {
    group: next(iter(next(iter(options.values()))))
    for group, options in GROUPS.items()
    if len(options) > 1
}
"""The groups whose keys depend on a choice, and the key that tells which was made; that of the law is its
name."""


def part_members(law: str) -> list[Member]:
    """Give the fields of a law that are parts; none of no law.

    Raises:
        ValueError: the law cannot be loaded.
    """
    return [member for member in members_of(law_class(law)) if member.family] if law else []


def law_keys(law: str, parts: tuple[tuple[str, str], ...] = ()) -> Keys:
    """Give the keys of a law; parts that are not named are those that it has by default.

    Raises:
        ValueError: a sentence on why there are none.
    """
    keys = _keys_of_numbers(law, members_of(law_class(law)))
    if law == "hertz_penalty":
        # Exactly one of them is given: a choice that no declaration tells of.
        keys["stiffness"] = replace(keys["stiffness"], kind=float | None)
        keys["tip_radius"] = Declared(
            float | None,
            None,
            Parameter(
                *("r", "m", "radius of the spherical tip end"),
                above=0.0,
                hint="Leave it out where law.stiffness is given.",
            ),
        )
    for member in part_members(law):
        default = str(getattr(member.default, "name", ""))
        keys[member.name] = part_keys(member.family, dict(parts).get(member.name) or default)
    return keys


def part_keys(family: str, part: str) -> Keys:
    """Give the keys of a part; one without a name says what is missing."""
    if not part:
        return {"name": Declared(str, NONE_DECLARED, None)}
    return _keys_of_numbers(part, members_of(PARTS[family][part]))


def _keys_of_numbers(owner: str, members: list[Member]) -> Keys:
    keys = {"name": _told_by(owner)}
    for member in members:
        if member.family or member.name == SHARED:
            continue
        said = member.parameter
        assert said is not None, f"{owner}.{member.name} is no part"
        default = NONE_DECLARED if member.default is None else member.default
        hint = said.hint or f"It is the {said.meaning} {said.symbol} of {owner}."
        kind = int if member.whole else float
        keys[member.name] = Declared(kind, default, replace(said, hint=hint))
    return keys


@cache
def known_keys() -> list[str]:
    """Give every full key of every choice, those of the laws first; a law that is broken has none."""
    found = [key for keys in _laws() for key in flat({LAW: keys})]
    for group, options in GROUPS.items():
        found += [key for keys in options.values() for key in flat({group: keys})]
    return list(dict.fromkeys(found))


def _laws() -> Iterator[Keys]:
    """The keys of every law that is installed, with each of its parts."""
    for name in law_names():
        try:
            yield law_keys(name)
            for member in part_members(name):
                for part in PARTS[member.family]:
                    yield law_keys(name, ((member.name, part),))
        except ValueError:
            continue


def group_told_by(key: str) -> str:
    """Give the group whose choice a key tells, 'law/normal' for 'law.normal.name'; empty for other keys."""
    section, _, last = key.rpartition(".")
    told_by = "name" if section.partition(".")[0] == LAW else KINDS.get(section)
    return section.replace(".", "/") if last == told_by else ""


def groups() -> list[str]:
    """Give the groups that have options made from declarations."""
    return [*GROUPS, LAW, *(f"{LAW}/{family}" for family in PARTS)]


def options(group: str) -> list[str]:
    """Give the options of a group that need no file."""
    if group in GROUPS:
        return sorted(GROUPS[group])
    return law_names() if group == LAW else sorted(PARTS[group.removeprefix(f"{LAW}/")])


def content(group: str, option: str) -> dict[str, Any]:
    """Give the keys of an option with their defaults, and a defaults list where a law has parts.

    A law that cannot be loaded has its name alone; the check of the configuration says why.
    """
    if group in GROUPS:
        return _defaults(GROUPS[group][option])
    if group != LAW:
        return _defaults(part_keys(group.removeprefix(f"{LAW}/"), option))
    try:
        parts = part_members(option)
        keys = law_keys(option)
    except ValueError:
        return {"name": option}
    own = _defaults({name: keys[name] for name in keys if isinstance(keys[name], Declared)})
    entries = [
        {m.family if m.name == m.family else f"{m.family}@{m.name}": m.default.name}
        for m in parts
        if m.default is not None
    ]
    return {"defaults": [*entries, "_self_"], **own} if entries else own


def _defaults(keys: Keys) -> dict[str, Any]:
    values = {}
    for name, declared in keys.items():
        if isinstance(declared, Declared):
            values[name] = MISSING if declared.default is NONE_DECLARED else declared.default
        else:
            values[name] = _defaults(declared)
    return values
