"""The built pages as a browser finds them: links lead somewhere, pictures have words, nothing is fetched.

Sphinx holds references in the sources to this, and no link that a theme, a gallery or plain HTML makes.
"""

from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

from sphinx.application import Sphinx
from sphinx.util import logging

LOADED = {"img": "src", "script": "src", "link": "href", "iframe": "src", "video": "src", "source": "src"}
"""Elements for which a browser fetches something at once, and the attribute that says what."""


class Page(HTMLParser):
    """Reads a page: the names that links may lead to, its links, and faults that it has by itself."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.names: set[str] = set()
        self.links: set[str] = set()
        self.faults: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note what an element says."""
        options = dict(attrs)
        self.names |= {value for name in ("id", "name") if (value := options.get(name))}
        address = options.get("href" if tag == "a" else LOADED.get(tag, ""))
        if address:
            self.links.add(address)
            if tag in LOADED and urlsplit(address).netloc:
                self.faults.append(f"it fetches {address}")
        if tag == "img" and "alt" not in options:
            self.faults.append(f"the picture {options.get('src')} has no words in its place")


def faults_in(site: Path) -> Iterator[str]:
    """Return what is wrong with the pages of a folder, a sentence each."""
    # The theme's own files hold a template.
    written = [path for path in sorted(site.rglob("*.html")) if path.relative_to(site).parts[0] != "_static"]
    pages = {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in written}
    for path, page in pages.items():
        where = path.relative_to(site.resolve())
        yield from (f"{where}: {fault}." for fault in page.faults)
        for link in sorted(page.links):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            name = unquote(parts.fragment)
            if not target.exists():
                yield f"{where}: the link {link} leads nowhere."
            elif name and target in pages and name not in pages[target].names:
                yield f"{where}: the link {link} leads to a page that has no such place."


def setup(app: Sphinx) -> None:
    """Report the faults once all pages are written."""
    app.connect("build-finished", _tell)


def _tell(app: Sphinx, fault: Exception | None) -> None:
    if fault is None and app.builder.format == "html":
        for sentence in faults_in(Path(app.outdir)):
            logging.getLogger(__name__).warning(sentence)
