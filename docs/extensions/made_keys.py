"""The reference of the configuration, from what the classes declare of its keys."""

from collections.abc import Iterable, Iterator
from dataclasses import MISSING
from itertools import chain
from types import NoneType
from typing import Any, get_args

from law_families import FAMILIES
from page_tables import raised, symbol, table

from contactlab.cli.sections import SECTIONS
from contactlab.config.composition import conf_directory
from contactlab.config.groups import FAMILIES as PARTS, GROUPS, LAW, Section
from contactlab.config.options import full_keys
from contactlab.parameter import DeclaredField

HEADS = ("key", "meaning", "default", "range")

_KINDS = {bool: "true, false", str: "text", list[str]: "list of texts"}


def groups() -> str:
    """Return a chapter for every group but the laws', with its options and keys; the command's come last."""
    every = GROUPS | SECTIONS
    parts = list(chain.from_iterable(_group(name, section) for name, section in every.items()))
    return "\n".join([*parts, *_experiments()])


def laws() -> str:
    """Return a chapter for the laws and one for each family of parts, with their keys."""
    parts = ["## `law`\n", "What acts between tip and rotor: `law=NAME`, `law.KEY=VALUE`.\n"]
    for family in FAMILIES:
        prefix, part = family.choice.replace("/", "."), family.page
        if family.choice != "law":
            parts += [
                f"## `law/{part}`\n",
                f"A part of `law=composed`: `law/{part}=NAME`, `law.{part}.KEY=VALUE`.\n",
            ]
        section = PARTS.get(part, LAW)
        for name in family.owners:
            parts += [f"### `{family.choice}={name}`\n", f"[What it is](../{family.address(name)})\n"]
            parts += keys_of(prefix, section.options[name], without={f"{prefix}.name"})
    return "\n".join(parts)


def keys_of(prefix: str, keys: Any, *, without: Iterable[str] = ()) -> list[str]:
    """Return the lines of a table of keys; none where there is no key to set."""
    rows = [
        _row(key, field) for key, field in full_keys(keys, f"{prefix}.", selected=False) if key not in without
    ]
    return table(HEADS, rows) if rows else ["It has no key of its own.\n"]


def _group(name: str, section: Section) -> Iterator[str]:
    yield f"## `{name}`\n"
    files = _files(name)
    for option, keys in section.options.items():
        if len(section.options) > 1 or files:
            yield f"### `{name}={option}`\n"
        yield from keys_of(name, keys, without={f"{name}.{section.selector}"})
    for option, stated in files:
        yield f"### `{name}={option}`\n"
        yield f"{stated}\n"


def _experiments() -> Iterator[str]:
    yield "## `experiment`\n"
    yield "A named set of changes to the default run: `experiment=NAME`.\n"
    yield from table(
        ("name", "what it is"), ((f"`{option}`", stated) for option, stated in _files("experiment"))
    )


def _files(group: str) -> list[tuple[str, str]]:
    """Options that are files, with what their first lines say."""
    result = []
    for path in sorted((conf_directory() / group).glob("*.yaml")):
        lines = path.read_text(encoding="utf-8").splitlines()
        stated = [line.lstrip("# ") for line in lines if line.startswith("#") and "@package" not in line]
        result.append((path.stem, " ".join(stated)))
    return result


def _row(key: str, field: DeclaredField) -> list[str]:
    stated = field.parameter
    if stated is None:
        return [f"`{key}`", "", _default(field), ""]
    text = f"{symbol(stated.symbol)}, {stated.meaning}" if stated.symbol else stated.meaning
    text = f"{text}. {stated.hint}" if stated.hint else text
    bounds = stated.range or ("" if field.is_number else _kinds(field))
    return [f"`{key}`", raised(text), raised(_default(field)), raised(bounds)]


def _default(field: DeclaredField) -> str:
    if field.default is MISSING:
        return "must be given"
    if field.default is None:
        return "null"
    if type(field.default) is float and field.parameter is not None:
        return f"{field.default:.6g}{field.parameter.label}"
    return str(field.default).lower()


def _kinds(field: DeclaredField) -> str:
    """What may stand there in words."""
    text = [_KINDS.get(kind) or " or ".join(map(str, get_args(kind))) for kind in field.kinds]
    return " or ".join(word for word, kind in zip(text, field.kinds, strict=True) if kind is not NoneType)
