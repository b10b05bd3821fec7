"""The documentation is right: every command and Python block of a page runs, in order, in an empty folder.

A block that cannot run on a desk is marked by a line before it, `<!-- not run: why -->`.
"""

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import pytest

TESTS = Path(__file__).resolve().parents[1]
DOCS = TESTS.parent / "docs"
PAGES = [
    "tutorial.md",
    "install.md",
    "steady.md",
    "datasheet.md",
    *(f"howto/{path.name}" for path in sorted((DOCS / "howto").glob("*.md"))),
]
BLOCK = re.compile(r"(<!-- not run: [^>\n]+ -->\n)?^```(bash|python)\n(.*?)^```", re.DOTALL | re.MULTILINE)


class Block(NamedTuple):
    """A block of a page, with the number of lines before it."""

    language: str
    code: str
    line: int


def blocks(page: str) -> list[Block]:
    """The blocks of a page that run, in their order."""
    text = (DOCS / page).read_text(encoding="utf-8")
    return [
        Block(each[2], each[3], text[: each.start(3)].count("\n"))
        for each in BLOCK.finditer(text)
        if not each[1]
    ]


def run_in_shell(block: Block, page: str) -> None:
    """Run a block as a shell with the command on its path does."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", block.code],
        env={**os.environ, "PATH": path},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, f"{page}, line {block.line}:\n{block.code}\n{done.stdout}{done.stderr}"


@pytest.mark.long
@pytest.mark.parametrize("page", PAGES)
def test_every_block_of_a_page_runs_in_order(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {"__name__": "documentation"}
    for block in blocks(page):
        if block.language == "bash":
            run_in_shell(block, page)
        else:
            # As many lines before it as on the page, so that a failure names the line there.
            exec(compile("\n" * block.line + block.code, DOCS / page, "exec"), names)
            plt.close("all")


def test_no_page_of_tasks_is_without_a_block_that_runs() -> None:
    without = [page for page in PAGES if not blocks(page)]
    assert set(without) <= {"howto/index.md"}


def test_no_block_of_the_documentation_is_without_a_test() -> None:
    for path in sorted(DOCS.rglob("*.md")):
        page = path.relative_to(DOCS).as_posix()
        if page not in PAGES and not page.startswith("examples/") and blocks(page):
            tests = (test for test in TESTS.rglob("test_*.py") if test != Path(__file__).resolve())
            assert any(path.name in test.read_text(encoding="utf-8") for test in tests), page


def test_every_python_block_can_be_compiled() -> None:
    for page in PAGES:
        for block in blocks(page):
            if block.language == "python":
                compile("\n" * block.line + block.code, DOCS / page, "exec")
