"""Public names and options of studies that no page, gallery script, experiment or configuration uses.

python docs/tools/public_names.py

A name counts as used where a page takes it from contactlab or one of its modules: `cl.NAME`, or an import. An
option counts where `OPTION=` stands in a page that calls its study. The exit status is 1 where more are
without a use than `ratchets.yaml` admits.
"""

import ast
import inspect
import re
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path

import yaml

import contactlab as cl
from contactlab.studies.registry import studies, study_class
from contactlab.studies.study import Study

ROOT = Path(__file__).resolve().parents[2]
RATCHETS = Path(__file__).with_name("ratchets.yaml")

PAGES = (
    "README.md",
    "docs/**/*.md",
    "docs/gallery/*.py",
    "experiments/*.py",
    "conf/**/*.yaml",
    "packages/*/docs/**/*.md",
)
"""Where a name or an option is used."""

NAMES = "contactlab.names"
"""Entry points by which a package of this repository adds names to `contactlab`."""


def pages() -> list[str]:
    """Return the texts of all pages, scripts and configurations."""
    paths = {path for pattern in PAGES for path in ROOT.glob(pattern)}
    return [path.read_text(encoding="utf-8") for path in sorted(paths)]


def public_names() -> Iterator[str]:
    """Yield the names that `contactlab` exports, and those that the packages of this repository add."""
    stub = ast.parse((ROOT / "contactlab/__init__.pyi").read_text(encoding="utf-8"))
    for node in stub.body:
        if isinstance(node, ast.ImportFrom):
            yield from (alias.name for alias in node.names)
    for path in ROOT.glob("packages/*/pyproject.toml"):
        project = tomllib.loads(path.read_text(encoding="utf-8"))["project"]
        yield from project.get("entry-points", {}).get(NAMES, {})


def names_in(text: str) -> set[str]:
    """Return the names that a text takes from contactlab, by attribute or import."""
    taken = set(re.findall(r"(?<!from )(?<!import )\b(?:cl|contactlab(?:\.\w+)*)\.(\w+)", text))
    for imported in re.findall(r"from contactlab[\w.]* import (?:\(([^)]*)\)|([^\n(]+))", text):
        taken.update(re.findall(r"\w+", " ".join(imported)))
    return taken


def options() -> Iterator[tuple[str, str, str]]:
    """Yield study, option and how it is written; those that all studies have are of `study`.

    Files are words of the command line without a name, and ranges are words KEY=START..END.
    """
    common = [field.name for field in fields(Study)]
    yield from (("study", name, f"{name}=") for name in common)
    for study, entry in studies().items():
        if entry.module.startswith("contactlab"):
            for field in fields(study_class(study)):
                if field.name not in (*common, study_class(study).files):
                    ranges = re.search(r"\b(?:Range|Mapping)\b", str(field.type))
                    yield study, field.name, "=START..END" if ranges else f"{field.name}="
    arguments = inspect.signature(cl.sweep).parameters
    yield from (
        ("sweep", name, f"{name}=") for name, each in arguments.items() if each.kind is each.KEYWORD_ONLY
    )


def without_use() -> list[str]:
    """Return the public names and the options of studies that no page uses."""
    texts = pages()
    used = set().union(*map(names_in, texts))
    result = [f"cl.{name}" for name in public_names() if name not in used]
    for study, option, written in options():
        calls = re.compile(rf"\bcontactlab (?:-m )?{study}\b|\bcl\.{study}\(|\b{study}\.{option}=")
        uses = re.compile(r"=\S[^=\n]*\.\." if ".." in written else rf"\b{option}\s?=")
        if not any(calls.search(text) and uses.search(text) for text in texts):
            result.append(f"{study} {written}")
    return result


def main() -> int:
    """Print the names and options, and return the exit status."""
    most = yaml.safe_load(RATCHETS.read_text(encoding="utf-8"))["public names without a use"]
    every = without_use()
    print(*every, sep="\n", end="\n" if every else "")
    print(f"{len(every)} without a page or use; at most {most}.")
    return int(len(every) > most)


if __name__ == "__main__":
    sys.exit(main())
