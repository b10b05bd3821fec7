"""The reference of the configuration, from what the classes declare of its keys."""

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import MISSING
from itertools import chain
from types import NoneType
from typing import Any, get_args

from contactlab.cli.start import SECTIONS
from contactlab.config.composition import conf_directory
from contactlab.config.groups import FAMILIES, GROUPS, LAW, Section
from contactlab.config.options import full_keys
from contactlab.laws import LAWS, PARTS
from contactlab.parameter import DeclaredField

HEAD = "| key | meaning | default | range |\n|---|---|---|---|"

_KINDS = {bool: "true, false", str: "text", list[str]: "list of texts"}


def groups() -> str:
    """Return a chapter for every group but the laws', with its options and keys; the command's come last."""
    every = GROUPS | SECTIONS
    parts = list(chain.from_iterable(_group(name, section) for name, section in every.items()))
    return "\n".join([*parts, *_experiments()])


def laws() -> str:
    """Return a chapter for the laws and one for each family of parts, with their keys."""
    parts = ["## `law`\n", "What acts between tip and rotor: `law=NAME`, `law.KEY=VALUE`.\n"]
    seen: Counter[str] = Counter()
    parts += chain.from_iterable(_law("law", name, LAW, seen) for name in LAWS)
    for family, section in FAMILIES.items():
        parts += [
            f"## `law/{family}`\n",
            f"A part of `law=composed`: `law/{family}=NAME`, `law.{family}.KEY=VALUE`.\n",
        ]
        parts += chain.from_iterable(_law(f"law.{family}", n, section, seen) for n in PARTS[family])
    return "\n".join(parts)


def table(prefix: str, keys: Any, *, without: Iterable[str] = ()) -> list[str]:
    """Return the lines of a table of keys; none where there is no key to set."""
    rows = [
        _row(key, field) for key, field in full_keys(keys, f"{prefix}.", selected=False) if key not in without
    ]
    return [HEAD, *rows, ""] if rows else ["It has no key of its own.\n"]


def _group(name: str, section: Section) -> Iterator[str]:
    yield f"## `{name}`\n"
    files = _files(name)
    for option, keys in section.options.items():
        if len(section.options) > 1 or files:
            yield f"### `{name}={option}`\n"
        yield from table(name, keys, without={f"{name}.{section.selector}"})
    for option, stated in files:
        yield f"### `{name}={option}`\n"
        yield f"{stated}\n"


def _law(prefix: str, name: str, section: Section, seen: Counter[str]) -> Iterator[str]:
    yield f"### `{prefix.replace('.', '/')}={name}`\n"
    # Where a name comes again, its heading there gets a number.
    anchor = f"{name}-{seen[name]}" if seen[name] else name
    seen[name] += 1
    yield f"[What it is](../laws.md#{anchor})\n"
    yield from table(prefix, section.options[name], without={f"{prefix}.name"})


def _experiments() -> Iterator[str]:
    yield "## `experiment`\n"
    yield "A named set of changes to the default run: `experiment=NAME`.\n"
    yield "| name | what it is |\n|---|---|"
    for option, stated in _files("experiment"):
        yield f"| `{option}` | {stated} |"
    yield ""


def _files(group: str) -> list[tuple[str, str]]:
    """Options that are files, with what their first lines say."""
    result = []
    for path in sorted((conf_directory() / group).glob("*.yaml")):
        lines = path.read_text(encoding="utf-8").splitlines()
        stated = [line.lstrip("# ") for line in lines if line.startswith("#") and "@package" not in line]
        result.append((path.stem, " ".join(stated)))
    return result


def _row(key: str, field: DeclaredField) -> str:
    stated = field.parameter
    if stated is None:
        return f"| `{key}` | | {_default(field)} | |"
    text = f"`{stated.symbol}`, {stated.meaning}" if stated.symbol else stated.meaning
    text = f"{text}. {stated.hint}" if stated.hint else text
    bounds = stated.range or ("" if field.is_number else _kinds(field))
    return f"| `{key}` | {text} | {_default(field)} | {bounds} |"


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
