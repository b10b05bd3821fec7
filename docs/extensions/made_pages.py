"""Parts of pages made from the code at build: a line `<!-- made: NAME -->` becomes what NAME gives."""

import re
from collections.abc import Callable
from typing import Any, Final

import made_api
import made_dataset
import made_keys
import made_verbs
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

from contactlab.cli.verbs.cite import bibtex

_MARK: Final = re.compile(r"^<!-- made: (\w+) -->$", re.MULTILINE)

MAKERS: Final[dict[str, Callable[[], str]]] = {
    "front_door": made_api.front_door,
    "further": made_api.further,
    "tiers": made_api.tiers,
    "citation": lambda: f"```text\n{bibtex()}\n```",
    "keys": made_keys.groups,
    "law_keys": made_keys.laws,
    "verbs": made_verbs.verbs,
    "variables": made_dataset.variables,
}
"""What gives Markdown, by its name."""


def filled(app: Sphinx, page: str, source: list[str]) -> None:
    """Put what is made into a page that has been read."""

    def made(mark: re.Match[str]) -> str:
        if mark[1] not in MAKERS:
            raise ExtensionError(f"{page} asks for '{mark[1]}'; it must be one of {', '.join(MAKERS)}.")
        return MAKERS[mark[1]]()

    source[0] = _MARK.sub(made, source[0])


def setup(app: Sphinx) -> dict[str, Any]:
    """Register what fills the pages."""
    app.connect("source-read", filled)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
