"""The folders of the kernels' machine code: one that this machine fills, and others that are read alone."""

import ast
import os
import shutil
import sys
import tempfile
import time
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Final

PACKAGE = Path(__file__).parents[1]
SOURCES: Final = ("compiler/*.py", "motor/geometry.py", "variables.py", "laws/**/*.py", "engine/*.py")
"""Where kernels stand, and the constants that are compiled into them."""

PREFIX: Final = "kernels-"
OLD: Final = 30 * 86400.0
"""Age in seconds at which the code of other sources is given up."""


def code_name() -> str:
    """Return the name of a folder of the code of exactly these sources, but for their comments."""
    written = _sources()
    # Parsing takes half a second: a folder names the texts that it is known to be of.
    for parent in _parents():
        for known in parent.glob(f"{PREFIX}*/{_digest(written)}"):
            return known.parent.name
    trees = {name: ast.dump(ast.parse(text)).encode() for name, text in written.items()}
    return f"{PREFIX}{_digest(trees)}"


def _sources() -> dict[str, bytes]:
    """Return the texts of the sources by path."""
    paths = sorted(path for name in SOURCES for path in PACKAGE.glob(name))
    return {path.relative_to(PACKAGE).as_posix(): path.read_bytes() for path in paths}


def _digest(parts: dict[str, bytes]) -> str:
    """Return the digest of parts by name, for this Python, by whose grammar they are read."""
    digest = sha256(repr(sys.version_info[:2]).encode())
    for name, part in parts.items():
        digest.update(name.encode())
        digest.update(part)
    return digest.hexdigest()[:16]


@cache
def code_folder() -> Path:
    """Return the folder in which this machine keeps the code of exactly these sources."""
    name = code_name()
    for parent in _parents():
        try:
            (parent / name).mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=parent / name):
                # The code of other sources that has not been added to for a month.
                for folder in parent.glob(f"{PREFIX}*"):
                    if folder.name != name and time.time() - folder.stat().st_mtime > OLD:
                        shutil.rmtree(folder, ignore_errors=True)
                (parent / name / _digest(_sources())).touch()
                return parent / name
        except OSError:
            continue
    # Nowhere to keep it: compile for this process alone.
    return Path(tempfile.mkdtemp(prefix="contactlab-"))


def _parents() -> list[Path]:
    """Return where code may be kept, by preference."""
    if chosen := os.environ.get("NUMBA_CACHE_DIR"):
        return [Path(chosen)]
    users = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return [PACKAGE / "__pycache__", users / "contactlab"]


@cache
def read_only_folder() -> Path | None:
    """Return the first folder of the code of exactly these sources, if it cannot be added to."""
    name, kept = code_name(), code_folder()
    first = next((folder for parent in _parents() if (folder := parent / name).is_dir()), kept)
    return None if first == kept else first


def shipped() -> Path:
    """Return the folder of the code that came with the package, if it is from a platform's wheel."""
    return PACKAGE / "compiled"


def of_version(version: str) -> str:
    """Return the name of the folder of code made with a version of Numba."""
    return f"numba-{version}"


@cache
def shipped_folder() -> Path | None:
    """Return the folder of the code that came with the package for exactly these sources and this Numba."""
    from numba import __version__

    folder = shipped() / of_version(__version__) / code_name()
    return folder if folder.is_dir() else None
