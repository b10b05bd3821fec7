"""The Python blocks of a page of the documentation, and what stands in its namespace once they have run."""

import re
from pathlib import Path
from typing import Any

DOCS = Path(__file__).resolve().parents[2] / "docs"


def blocks(page: Path) -> list[tuple[int, str]]:
    """The Python blocks of a page, each with the number of lines before it."""
    text = page.read_text(encoding="utf-8")
    result = re.finditer(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    return [(text[: each.start(1)].count("\n"), each[1]) for each in result]


def names_of(page: Path) -> dict[str, Any]:
    """What stands in the namespace of a page, called as its file, once all its blocks have run in order."""
    made: dict[str, Any] = {"__name__": page.stem}
    for line, block in blocks(page):
        # As many lines before it as on the page, so that a failure names the line there.
        exec(compile("\n" * line + block, page, "exec"), made)
    return made
