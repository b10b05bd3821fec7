"""Docstrings of studies and verbs, which are their help: question, text, examples and sections."""

import re
from importlib.util import find_spec
from inspect import cleandoc
from pathlib import Path
from typing import Final

_AT_FIRST: Final = r'\A"""(.*?)"""'
_OF_CLASS: Final = r'^class {}\b[^:]*:\n\s+"""(.*?)"""'
_SECTION: Final = re.compile(r"^(Args|Returns|Raises):\n", re.MULTILINE)


def docstring_of(module: str, name: str = "") -> str:
    """Return the docstring of a module, or of a class of it; empty where its source does not contain one.

    It is read from the source, and nothing is imported: every study would take seconds.
    """
    package, *inner = module.split(".")
    # A script has no specification.
    spec = None if package == "__main__" else find_spec(package)
    folders = (spec.submodule_search_locations or ()) if inner and spec else ()
    places = [Path(folder, *inner) for folder in folders] or [Path(str(spec and spec.origin)).with_suffix("")]
    files = (file for x in places for file in (x.with_suffix(".py"), x / "__init__.py") if file.is_file())
    source = next((file.read_text(encoding="utf-8") for file in files), "")
    match = re.search(_OF_CLASS.format(name) if name else _AT_FIRST, source, re.DOTALL | re.MULTILINE)
    return cleandoc(match[1]) if match else ""


def question_in(docstring: str | None) -> str:
    """Return the first paragraph on one line: the question of a study, or what a verb does."""
    return " ".join(cleandoc(docstring or "").partition("\n\n")[0].split())


def paragraphs_in(docstring: str | None) -> list[str]:
    """Return the paragraphs before the sections; those of examples are indented."""
    text = _SECTION.split(cleandoc(docstring or ""))[0].strip("\n")
    return text.split("\n\n")


def sections_in(docstring: str | None) -> dict[str, str]:
    """Return the text of the sections `Args`, `Returns` and `Raises`, each with its indentation."""
    _, *parts = _SECTION.split(cleandoc(docstring or ""))
    return {title: text.rstrip() for title, text in zip(parts[::2], parts[1::2], strict=True)}


def entries_in(docstring: str | None) -> dict[str, str]:
    """Return the entries of the section `Args` by their first names; one may describe several arguments."""
    entries = re.split(r"\n(?=    \S)", sections_in(docstring).get("Args", ""))
    return {re.split(r"\W", each.strip(), maxsplit=1)[0]: each for each in entries if each}
