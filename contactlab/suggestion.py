"""Texts of a user or a file as messages show them, and the name that was meant by one nearly right."""

from collections.abc import Iterable
from difflib import get_close_matches
from typing import Final

ALIKE: Final = 0.75
"""Similarity of names from 0 to 1 from which one is suggested."""

MOST: Final = 3
"""Names that are suggested at most."""

LONGEST: Final = 60
"""Characters of a file that a message shows at most: the file may be one that nobody meant to show."""


def excerpt(text: object) -> str:
    r"""Return the beginning of a text of a file, without control characters.

    >>> excerpt("frequency\x1b[31m")
    'frequency [31m'
    """
    line = "".join(each if each.isprintable() else " " for each in str(text))
    return line if len(line) <= LONGEST else f"{line[: LONGEST - 3]}..."


def suggestion(word: str, known: Iterable[str], otherwise: str = "") -> str:
    """Ask for the known names that are nearly a word, by all of it or by its last part.

    >>> suggestion("contact.clearnce", ["contact.clearance", "rotor.inertia"])
    'Did you mean contact.clearance?'
    >>> suggestion("clearance", ["contact.clearance", "rotor.inertia"])
    'Did you mean contact.clearance?'

    Args:
        word: as it was written.
        known: the names that there are.
        otherwise: returned where no name is near.
    """
    names, typed = [*known], word.lower()
    ends = {name: name.rpartition(".")[2] for name in names}
    near = get_close_matches(typed, names, 1, ALIKE)
    if not near:
        alike = get_close_matches(typed.rpartition(".")[2], {*ends.values()}, 1, ALIKE)
        near = [name for name, end in ends.items() if end in alike]
    return f"Did you mean {' or '.join(near)}?" if 0 < len(near) <= MOST else otherwise
