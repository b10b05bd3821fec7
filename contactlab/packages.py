"""What other packages of this project bring: for what is said where one is not installed."""

from typing import Final

BROUGHT: Final = {
    "contactlab-data": (
        *("bench", "fit", "identify", "synthetic", "validate"),
        *("Bench", "Fit", "Identification", "Synthetic", "Validate", "ValidationError"),
        *("read_impacts", "read_measurements", "write_impacts"),
    )
}
"""Verbs and names of `contactlab` by the package that brings them."""


def bringing(name: str) -> str:
    """Return a sentence on the package that brings a verb or a name; empty if none of this project does.

    >>> bringing("fit")
    'fit is in the package contactlab-data: pip install contactlab-data'
    """
    packages = [package for package, brought in BROUGHT.items() if name in brought]
    return "".join(f"{name} is in the package {package}: pip install {package}" for package in packages)
