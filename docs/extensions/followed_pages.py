"""Pictures of pages, made by the commands that stand before them: a page is followed while the gallery runs.

It is not followed again as long as the page and the code are as they were.
"""

import json
import sys
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from shutil import copyfile
from tempfile import TemporaryDirectory
from typing import Any, Final

import kept_pages
from page_blocks import NOTEBOOK, PageError, blocks, notebook, pictures, with_pictures
from page_desk import Desk, follow, surroundings
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.util import logging

MADE: Final = "followed"
"""Folder of the pictures, below that of the pages."""

BEFORE_GALLERY: Final = 100
"""Priority of what happens before the gallery runs, which has the usual one, 500."""


class Followed:
    """Follows the pages whose pictures are not current, one after the other, beside everything else."""

    def __init__(self) -> None:
        self._pages: dict[str, Future[None]] = {}

    def begin(self, app: Sphinx) -> None:
        """Begin to follow every page with pictures that are not current."""
        self._pages.clear()
        pages = ThreadPoolExecutor(1)
        for path in sorted(Path(app.srcdir).rglob("*.md")):
            name = path.relative_to(app.srcdir).with_suffix("").as_posix()
            kept, made_by = Path(app.srcdir, MADE, name), kept_pages.digest(path)
            if pictures(path.read_text(encoding="utf-8")) and not kept_pages.is_current(kept, made_by):
                self._pages[name] = pages.submit(made, path, kept, made_by)
        pages.shutdown(wait=False)

    def outdated(self, *_: Any) -> list[str]:
        """Return the pages to read again, as their pictures change."""
        return [*self._pages]

    def fill(self, app: Sphinx, page: str, source: list[str]) -> None:
        """Show the pictures of a page where it names them, and lead to the page as a notebook."""
        if not pictures(source[0]):
            return
        try:
            if page in self._pages:
                self._pages[page].result()
        except PageError as error:
            raise ExtensionError(str(error)) from error
        name = f"{Path(page).name}.ipynb"
        text = json.dumps(notebook(source[0]), indent=1)
        Path(app.srcdir, MADE, page, name).write_text(text, encoding="utf-8")
        link = f"Download: {{download}}`the page as a notebook </{MADE}/{page}/{name}>`."
        source[0] = with_pictures(source[0], f"/{MADE}/{page}").replace(NOTEBOOK, link)


def made(path: Path, kept: Path, made_by: str) -> None:
    """Do what a page says, keep the pictures that it names in a folder, and note what they are made by.

    Raises:
        PageError: the page is wrong.
    """
    text, logger = path.read_text(encoding="utf-8"), logging.getLogger(__name__)
    with TemporaryDirectory() as folder:
        with Desk(Path(folder), surroundings(Path(sys.executable))) as desk:
            for number, _ in enumerate(follow(path, Path(folder), desk), 1):
                logger.info("following %s: block %d of %d", path.name, number, len(blocks(text)))
        for each in pictures(text):
            picture = kept / each.path
            picture.parent.mkdir(parents=True, exist_ok=True)
            copyfile(Path(folder, each.path), picture)
    kept_pages.keep(kept, made_by)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register what follows the pages."""
    followed = Followed()
    app.connect("builder-inited", followed.begin, priority=BEFORE_GALLERY)
    app.connect("env-get-outdated", followed.outdated)
    app.connect("source-read", followed.fill)
    return {"version": "1", "parallel_read_safe": False, "parallel_write_safe": True}
