"""What a build need not make again: pictures of scripts and pages that are as they were, as is the code."""

import sys
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[2]
# Its digest leaves out comments and docstrings.
sys.path.insert(0, str(ROOT / "experiments"))
from dependencies import digest_of  # noqa: E402

MARK: Final = "made_by"
"""File in a folder of pictures, with the digest of what made them."""


def digest(*paths: Path, root: Path = ROOT) -> str:
    """Return the digest of the package, the style of the pictures, and files beside them."""
    code = digest_of("conf", "contactlab", "docs/extensions/gallery_figures.py", root=root)
    return "\n".join([code, *(path.read_text(encoding="utf-8") for path in paths)])


def is_current(folder: Path, made_by: str) -> bool:
    """Return whether the pictures in a folder were made by that."""
    mark = folder / MARK
    return mark.is_file() and mark.read_text(encoding="utf-8") == made_by


def keep(folder: Path, made_by: str) -> None:
    """Note by what the pictures in a folder were made."""
    (folder / MARK).write_text(made_by, encoding="utf-8")
