"""Results that pages state: docs/results/*.json, with digests of the numbers and of the code that made them.

A file has the unit and the source of each variable (`variables`, by the last part of a key), and sections.
`A/B/rotor_velocity` is a value of section A, `A/B/rotor_velocity_error` its error. A section has its results,
the definitions that ran while they were made (`ran`, by module, see dependencies.py), the configurations that
were read, the digests of these by module (`code`), the seconds that it took, and the digest of all that
(`digest`): a number that is changed by hand does not fit it. A short form, with the definitions that it ran,
stands beside the results. Under a later code it may be made again: `checked` is the code under which its
digits are the same, `different` one under which they are not.
"""

import json
import re
from collections.abc import Iterable, Mapping
from functools import cache
from hashlib import sha256
from math import isclose
from pathlib import Path
from typing import Any, Final

from dependencies import ROOT, digests, present, reached

FOLDER: Final = ROOT / "docs" / "results"

SAME: Final = 1e-9
"""Relative difference of two numbers with the same digits."""

PRESENT, CHECKED, OLDER, DIFFERENT, EDITED = "present", "checked", "older", "different", "edited"
"""States of a section: made by the present code; its short form has the same digits under it, or others; made
by an earlier code; and changed by hand."""


def read(name: str) -> dict[str, Any]:
    """Return a file of results; without sections if there is none yet."""
    path = FOLDER / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {"sections": {}}


def text_of(content: Any) -> str:
    """Return results as JSON, which has no NaN."""
    return json.dumps(content, indent=1, default=float).replace("NaN", "null")


def write(name: str, content: Mapping[str, Any]) -> None:
    """Write a file of results, whole or not at all."""
    path = FOLDER / f"{name}.json"
    made = path.with_suffix(".new")
    made.write_text(text_of(content) + "\n", encoding="utf-8")
    made.replace(path)


def by_module(names: Iterable[str]) -> dict[str, str]:
    """Return definitions "MODULE:NAME" by module, as they are stored."""
    result: dict[str, list[str]] = {}
    for each in sorted(names):
        module, _, name = each.partition(":")
        result.setdefault(module, []).append(name or ".")
    return {module: " ".join(own) for module, own in result.items()}


def names_of(stored: Mapping[str, str], root: Path = ROOT) -> list[str]:
    """Return definitions "MODULE:NAME" from their stored form, of modules by their present names."""
    return [
        f"{present(module, root)}:{'' if name == '.' else name}"
        for module, own in stored.items()
        for name in own.split()
    ]


def unsealed(section: Mapping[str, Any]) -> dict[str, Any]:
    """Return a section without its digest, and without what was noted of it later."""
    return {key: each for key, each in section.items() if key not in ("digest", CHECKED, DIFFERENT)}


def sealed(section: Mapping[str, Any]) -> dict[str, Any]:
    """Return a section with its digest."""
    own = json.loads(text_of(section))
    return {**own, "digest": seal_of(unsealed(own))}


def put(name: str, section: str, content: Mapping[str, Any]) -> None:
    """Write a section to its file."""
    file = read(name)
    file["sections"][section] = sealed(content)
    write(name, file)


@cache
def _code_of(names: tuple[str, ...], files: tuple[str, ...], root: Path) -> dict[str, str]:
    return digests(names, files, root)


def code_of(section: Mapping[str, Any], root: Path = ROOT) -> dict[str, str]:
    """Return the digests of the present code of what made a section, by module."""
    return _code_of(tuple(names_of(section["ran"], root)), tuple(section["files"]), root)


def changed(section: Mapping[str, Any], root: Path = ROOT) -> set[str]:
    """Return the modules and configurations that have changed since a section was made."""
    now, made = code_of(section, root), section["code"]
    pairs = ((now, made), (made, now))
    return {name for own, other in pairs for name in own if own[name] not in other.values()}


def seal_of(content: object) -> str:
    """Return the digest of what can be JSON."""
    return sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def state_of(section: Mapping[str, Any], root: Path = ROOT) -> str:
    """Return whether a section is of the present code."""
    if "ran" not in section:
        return OLDER
    if section["digest"] != seal_of(unsealed(section)):
        return EDITED
    if not changed(section, root):
        return PRESENT
    now = seal_of(code_of(section, root))
    return next((state for state in (CHECKED, DIFFERENT) if section.get(state) == now), OLDER)


TIMES: Final = re.compile(r"[\d.]+(?= ms\b| times\b)")
"""Times and their ratios in a text."""


def same(a: Any, b: Any) -> bool:
    """Return whether two results have the same digits; errors of numbers and times are left out."""
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(is_apart(k) or same(a[k], b[k]) for k in a)
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, str) and isinstance(b, str):
        return TIMES.sub("", a) == TIMES.sub("", b)
    numbers = isinstance(a, float) and isinstance(b, float)
    return isclose(a, b, rel_tol=SAME, abs_tol=1e-15) if numbers else bool(a == b)


def is_apart(key: str) -> bool:
    """Return whether a key of results is left out of a comparison."""
    return key.endswith(("_error", "[ms]", "run over shooting"))


def covers(section: Mapping[str, Any], root: Path = ROOT) -> bool:
    """Return whether the short form of a section reaches all that has changed of what decided its results."""
    there = changed(section, root)
    whole, short = (
        {each for each in reached(names_of(ran, root), root) if each.partition(":")[0] in there}
        for ran in (section["ran"], section["short"]["ran"])
    )
    return short >= whole
