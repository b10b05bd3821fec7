"""Refuse private words in names, docstrings, comments and pages: the nouns of the field are used.

    python docs/tools/plain_words.py

The exit status is 1 where a file fails.
"""

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("contactlab", "hydra_plugins", "experiments", "benchmarks", "tests", "docs", "paper")
MADE = ("docs/examples", "docs/followed", "docs/laws.md", "docs/laws/", "docs/plausibility.md")
"""Pages made from docstrings, which are checked themselves."""

NAMES = re.compile(
    r"(?:^|_)(?:one|found|given|said|told|words|answers?|asked|held|lures?|struck|strikes?)(?:_|$)"
)
TERMS = re.compile(r"one_line|one_sided|held_out|struck_discs")
"""Names of the field or of Python that contain a private word."""

OPENINGS = re.compile(r"(?:Give|Tell|Say|Of|And|The same)\b")
PHRASES = re.compile(
    r"\b(?:is|are|was|were|be) (?:told|asked|taken in)\b|\bcannot (?:be told|tell)\b|\bopen ledger\b"
    r"|\b(?:strobes?|lures?|struck|front door|exact stick|due to the law|closed books|in our words)\b"
    # A line of a page that begins so is a comment, and is not shown.
    r"|^% ",
    re.IGNORECASE | re.MULTILINE,
)


def private(name: str) -> bool:
    """Return whether a name contains a private word."""
    return NAMES.search(TERMS.sub("", name)) is not None


def faults_of_module(source: str) -> Iterator[tuple[int, str]]:
    """Yield line and text of each private word of a Python module."""
    tree = ast.parse(source)
    # Options of a base class are named there.
    inherited = {
        id(node.target)
        for node in ast.walk(tree)
        if isinstance(node, ast.AnnAssign) and ast.unparse(node.annotation).startswith("ClassVar[Mapping")
    }
    for node in ast.walk(tree):
        if id(node) in inherited:
            continue
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and private(node.id):
            yield node.lineno, node.id
        elif isinstance(node, ast.arg) and private(node.arg):
            yield node.lineno, node.arg
        elif isinstance(node, ast.FunctionDef | ast.ClassDef | ast.Module):
            name = "" if isinstance(node, ast.Module) else node.name
            # A test's name is a sentence.
            if private(name.lower()) and not name.startswith("test_"):
                yield node.lineno, name
            text = ast.get_docstring(node) or ""
            if (opening := OPENINGS.match(text)) and node.body:
                yield node.body[0].lineno, opening[0]
    for number, line in enumerate(source.splitlines(), 1):
        yield from ((number, phrase) for phrase in PHRASES.findall(line))


def faults_of(path: Path) -> list[tuple[int, str]]:
    """Return line and text of each private word of a file."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        return [*faults_of_module(text)]
    return [(text[: each.start()].count("\n") + 1, each[0]) for each in PHRASES.finditer(text)]


def main() -> int:
    """Check all files and return the exit status."""
    paths = [p for folder in FOLDERS for p in (ROOT / folder).rglob("*") if p.suffix in (".py", ".md")]
    names = {p.relative_to(ROOT).as_posix(): p for p in [*paths, *ROOT.glob("*.md")]}
    this = Path(__file__).relative_to(ROOT).as_posix()
    checked = {n: p for n, p in names.items() if not n.startswith(MADE) and n not in ("CHANGELOG.md", this)}
    faults = [
        f"{name}:{line}: {text}"
        for name, path in sorted(checked.items())
        for line, text in sorted(faults_of(path))
    ]
    print(*faults, sep="\n", end="\n" if faults else "")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
