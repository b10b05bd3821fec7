"""What pages share: their look, lists of sentences, pictures inside the page."""

from base64 import b64encode
from collections.abc import Iterable, Mapping
from html import escape
from pathlib import Path
from string import Template
from typing import Final

STYLE: Final = Path(__file__).with_name("page.css")


def filled(template: Path, said: Mapping[str, str]) -> str:
    """Put words, HTML, into a page without its words; it holds its look and fetches nothing."""
    style = STYLE.read_text(encoding="utf-8")
    page = Template(template.read_text(encoding="utf-8")).substitute(said, style=style)
    return page.replace("&lt;=", "\u2264")


def bulleted(sentences: Iterable[str]) -> str:
    """Give sentences as a list; nothing for none."""
    items = "".join(f"<li>{escape(sentence)}</li>" for sentence in sentences)
    return items and f"<ul>{items}</ul>"


def pictured(path: Path, caption: str) -> str:
    """Give a PNG file as a figure that the page holds itself."""
    said, data = escape(caption), b64encode(path.read_bytes()).decode()
    image = f"<img alt='{said}' src='data:image/png;base64,{data}'>"
    return f"<figure>{image}<figcaption>{said}</figcaption></figure>"
