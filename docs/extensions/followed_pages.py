"""Pictures of pages, made by the commands that stand before them: a page is followed when it is read."""

import sys
from pathlib import Path
from shutil import copyfile
from tempfile import TemporaryDirectory
from typing import Any, Final

from page_blocks import PageError, pictures, with_pictures
from page_desk import Desk, follow, surroundings
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

MADE: Final = "followed"
"""Folder of the pictures, below that of the pages."""


def filled(app: Sphinx, page: str, source: list[str]) -> None:
    """Follow a page that has pictures, and show them where it names them."""
    named = pictures(source[0])
    if not named:
        return
    path = Path(app.srcdir, f"{page}.md")
    with TemporaryDirectory() as folder:
        try:
            with Desk(Path(folder), surroundings(Path(sys.executable))) as desk:
                for _ in follow(path, Path(folder), desk):
                    pass
        except PageError as error:
            raise ExtensionError(str(error)) from error
        for each in named:
            kept = Path(app.srcdir, MADE, page, each.path)
            kept.parent.mkdir(parents=True, exist_ok=True)
            copyfile(Path(folder, each.path), kept)
    source[0] = with_pictures(source[0], f"/{MADE}/{page}")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register what follows the pages."""
    app.connect("source-read", filled)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
