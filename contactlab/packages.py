"""Names that other packages add to `contactlab`, and which package of this project brings what.

A package adds a name by an entry point:

    [project.entry-points."contactlab.names"]
    fit = "contactlab_data.studies.fit:fit"
"""

from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Final

NAMES: Final = "contactlab.names"

BROUGHT: Final = {
    "contactlab-data": (
        *("bench", "fit", "identify", "synthetic", "validate"),
        *("Bench", "Fit", "Identification", "Synthetic", "Validate", "ValidationError"),
        *("read_impacts", "read_measurements", "write_impacts"),
    ),
    "contactlab-explorer": ("explore",),
}
"""Verbs and names by the package of this project that brings them: for what is said where it is missing."""


@cache
def names() -> dict[str, EntryPoint]:
    """Return the names that installed packages add, with their entry points."""
    return {point.name: point for point in entry_points(group=NAMES)}


def added(name: str) -> object:
    """Return what an installed package adds by a name, or raise an AttributeError."""
    if name in names():
        return names()[name].load()
    raise AttributeError(f"module 'contactlab' has no attribute {name!r}. {bringing(name)}".rstrip())


def bringing(name: str) -> str:
    """Return a sentence on the package that brings a verb or a name; empty if none of this project does.

    >>> bringing("fit")
    'fit is in the package contactlab-data: pip install contactlab-data'
    """
    packages = [package for package, brought in BROUGHT.items() if name in brought]
    return "".join(f"{name} is in the package {package}: pip install {package}" for package in packages)
