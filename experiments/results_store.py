"""Results that pages state: docs/results/*.json, with the digest of the code that made each section.

A file has the unit and the source of each variable (`variables`, by the last part of a key), and sections.
`A/B/rotor_velocity` is a value of section A, `A/B/rotor_velocity_error` its error. A section has its results,
the script that makes it, the parts of contactlab that it depends on, and digests: of the script, of the parts
that made it (`made`), and of later ones (`checked`) under which the sections in `by` were made anew with the
same digits.
"""

import ast
import json
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from hashlib import sha256
from io import StringIO
from math import isclose
from pathlib import Path
from tokenize import COMMENT, generate_tokens
from typing import Any, Final

import yaml

ROOT: Final = Path(__file__).resolve().parents[1]
FOLDER: Final = ROOT / "docs" / "results"

PHYSICS: Final = ("compiler", "config", "engine", "laws", "motor", "settling", "steady_state")
"""Folders of contactlab that decide what a motor does."""

SAME: Final = 1e-9
"""Relative difference of two numbers with the same digits."""

PRESENT, CHECKED, OLDER = "present", "checked", "older"
"""States of a section: made by the present code, checked under it, or neither."""


def code_of(source: str) -> str:
    """Return a module without comments, docstrings and empty lines, in which no number lies."""
    lines = source.splitlines()
    for token in generate_tokens(StringIO(source).readline):
        if token.type == COMMENT:
            row, column = token.start
            lines[row - 1] = lines[row - 1][:column]
    for node in ast.walk(ast.parse(source)):
        match node:
            case ast.Expr(value=ast.Constant(value=str())):
                lines[node.lineno - 1 : node.end_lineno] = [""] * len(
                    lines[node.lineno - 1 : node.end_lineno]
                )
    return "\n".join(line.rstrip() for line in lines if line.strip())


@cache
def digest_of(*paths: str, root: Path = ROOT) -> str:
    """Return the digest of the code in files and folders of the repository, 16 hexadecimal digits."""
    files = [file for path in paths for file in [root / path, *(root / path).rglob("*")]]
    digest = sha256()
    for name, file in sorted((file.relative_to(root).as_posix(), file) for file in files):
        if file.suffix in (".py", ".yaml"):
            digest.update(f"{name}\0{parsed(file)}\0".encode())
    return digest.hexdigest()[:16]


def stamp_of(script: str, parts: Sequence[str]) -> dict[str, str]:
    """Return the digests of a script of experiments/, and of conf/ and folders of contactlab."""
    code = digest_of("conf", *(f"contactlab/{part}" for part in parts))
    return {"script_code": digest_of(f"experiments/{script}.py"), "made": code}


@cache
def parsed(path: Path) -> str:
    """Return what counts of a file: code, or the keys of a configuration."""
    text = path.read_text(encoding="utf-8")
    return code_of(text) if path.suffix == ".py" else json.dumps(yaml.safe_load(text), default=str)


def read(name: str) -> dict[str, Any]:
    """Return a file of results; without sections if there is none yet."""
    path = FOLDER / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {"sections": {}}


def text_of(content: Any) -> str:
    """Return results as JSON, which has no NaN."""
    return json.dumps(content, indent=1, default=float).replace("NaN", "null")


def write(name: str, content: Mapping[str, Any]) -> None:
    """Write a file of results."""
    (FOLDER / f"{name}.json").write_text(text_of(content) + "\n", encoding="utf-8")


def state_of(section: Mapping[str, Any]) -> str:
    """Return whether a section is of the present code."""
    present = stamp_of(section["script"], section["parts"])
    if section["script_code"] != present["script_code"]:
        return OLDER
    if section["made"] == present["made"]:
        return PRESENT
    return CHECKED if section.get("checked") == present["made"] else OLDER


def put(
    name: str, script: str, section: str, make: Callable[[], Any], parts: Sequence[str] = PHYSICS
) -> None:
    """Make a section and write it to its file, with the digests of the code at the beginning."""
    stamp = stamp_of(script, parts)
    results = make()
    content = read(name)
    content["sections"][section] = {"script": script, "parts": [*parts], **stamp, "results": results}
    write(name, content)


def same(a: Any, b: Any) -> bool:
    """Return whether two results have the same digits; errors of numbers are left out."""
    if isinstance(a, Mapping) and isinstance(b, Mapping):
        return a.keys() == b.keys() and all(k.endswith("_error") or same(a[k], b[k]) for k in a)
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(same, a, b))
    numbers = isinstance(a, float) and isinstance(b, float)
    return isclose(a, b, rel_tol=SAME, abs_tol=1e-15) if numbers else bool(a == b)


def different(
    cheap: Mapping[str, Mapping[str, Callable[[], Any]]], states: Sequence[str] = (OLDER,)
) -> list[str]:
    """Make the cheap sections in some states anew; returns those that have other digits now."""
    return [
        f"{file}: {name}"
        for file, makers in cheap.items()
        for name, make in makers.items()
        if state_of(section := read(file)["sections"][name]) in states
        and not same(json.loads(text_of(make())), section["results"])
    ]


def check(cheap: Mapping[str, Mapping[str, Callable[[], Any]]], files: Sequence[str]) -> list[str]:
    """Make cheap sections anew; where their digits are the same, put others down as checked.

    These depend on the parts of the cheap ones alone, and are of their scripts or of ones that have not
    changed since.

    Args:
        cheap: what makes a section, by file and section.
        files: whose sections are checked.

    Returns:
        The sections whose digits differ; the files are left alone then.
    """
    contents = {file: read(file) for file in files}
    sections = {(file, name): each for file in files for name, each in contents[file]["sections"].items()}
    made = {(file, name) for file, makers in cheap.items() for name in makers}
    if others := different(cheap, (PRESENT, CHECKED, OLDER)):
        return others
    covered = {part for key in made for part in sections[key]["parts"]}
    scripts = {sections[key]["script"] for key in made}
    for key, section in sections.items():
        present = stamp_of(section["script"], section["parts"])
        known = section["script"] in scripts or section["script_code"] == present["script_code"]
        if key in made:
            section |= present
            section.pop("checked", None)
        elif section["made"] != present["made"] and known and covered.issuperset(section["parts"]):
            section["script_code"] = present["script_code"]
            section["checked"] = present["made"]
            section["by"] = [": ".join(each) for each in sorted(made)]
    for file, content in contents.items():
        write(file, content)
    return []
