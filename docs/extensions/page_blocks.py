"""What a page tells its reader to run: blocks in their order, what they print, and pictures that they make.

A block that cannot run on a desk is marked by a line before it, `<!-- not run: why -->`. A block of text is
what the block before it prints, where `...` stands for anything and white space for any other. A line
`<!-- picture: PATH, words -->` is a picture that what stands before it has made.
"""

import re
from dataclasses import dataclass
from typing import Any, Final, final

_ITEM: Final = re.compile(
    r"^(?P<mark><!-- not run: [^>\n]+ -->\n)?```(?P<language>bash|python|text)\n(?P<code>.*?)^```$"
    r"|^<!-- picture: (?P<path>\S+), (?P<words>[^>\n]+) -->$",
    re.DOTALL | re.MULTILINE,
)


@final
@dataclass(frozen=True)
class Block:
    """What is pasted into a shell or a Python session.

    Args:
        language: bash or python.
        code: as it stands on the page.
        line: how many lines stand before it.
        output: what it prints, as the page says; None if the page says nothing.
    """

    language: str
    code: str
    line: int
    output: str | None = None


@final
@dataclass(frozen=True)
class Picture:
    """A file that the blocks before it have made, and what it shows in words."""

    path: str
    label: str
    line: int


class PageError(ValueError):
    """What is wrong with a page; a sentence."""


def items(text: str) -> list[Block | Picture]:
    """Return what is run on a page, and its pictures, in their order.

    Raises:
        PageError: a block of text that follows nothing whose output it could be.
    """
    result: list[Block | Picture] = []
    last: re.Match[str] | None = None
    for each in _ITEM.finditer(text):
        line = text[: each.start()].count("\n") + bool(each["mark"]) + 1
        if each["path"]:
            result.append(Picture(each["path"], each["words"], line))
        elif each["language"] != "text":
            last = each
            if not each["mark"]:
                result.append(Block(each["language"], each["code"], line))
        elif not each["mark"]:
            if last is None:
                raise PageError(f"Line {line} has a text that is the output of nothing; mark it as not run.")
            if not last["mark"]:
                place = max(i for i, item in enumerate(result) if isinstance(item, Block))
                ran = result[place]
                assert isinstance(ran, Block)
                result[place] = Block(ran.language, ran.code, ran.line, each["code"])
            last = None
    return result


def blocks(text: str) -> list[Block]:
    """Return what is run on a page, in its order."""
    return [item for item in items(text) if isinstance(item, Block)]


def pictures(text: str) -> list[Picture]:
    """Return the pictures of a page, in their order, whatever its blocks are, which may be made at build."""
    return [
        Picture(each["path"], each["words"], text[: each.start()].count("\n") + 1)
        for each in _ITEM.finditer(text)
        if each["path"]
    ]


NOTEBOOK: Final = "<!-- notebook -->"
"""Line of a page that leads to the page as a notebook."""


def with_pictures(text: str, folder: str) -> str:
    """Show the pictures of a page, which are in a folder, where they are named."""
    return _ITEM.sub(
        lambda each: f"![{each['words']}]({folder}/{each['path']})" if each["path"] else each[0], text
    )


def notebook(text: str) -> dict[str, Any]:
    """Return a page as a Jupyter notebook: what is run as cells of code, all else between them."""
    cells: list[tuple[str, str]] = []
    at = 0
    for each in _ITEM.finditer(text):
        # Pictures are made by running it.
        if each["path"] or (each["language"] != "text" and not each["mark"]):
            cells.append(("markdown", text[at : each.start()]))
            at = each.end()
        if each["path"]:
            cells.append(("markdown", f"![{each['words']}]({each['path']})"))
        elif at == each.end():
            cells.append(("code", ("%%bash\n" if each["language"] == "bash" else "") + each["code"]))
    cells.append(("markdown", text[at:]))
    code = {"outputs": [], "execution_count": None}
    return {
        "cells": [
            {"cell_type": kind, "metadata": {}, "source": source.strip(), **(code if kind == "code" else {})}
            for kind, source in cells
            if source.strip()
        ],
        "metadata": {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}},
        "nbformat": 4,
        "nbformat_minor": 4,
    }


def agrees(output: str, printed: str) -> bool:
    """Return whether something was printed as a page says it: `...` is anything, white space any other."""
    parts = [re.escape(part) for part in " ".join(output.split()).split("...")]
    return re.fullmatch(".*".join(parts), " ".join(printed.split())) is not None
