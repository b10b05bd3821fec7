"""What somebody who made a slip of the pen may have meant."""

from collections.abc import Iterable
from difflib import get_close_matches


def suggestion(word: str, known: Iterable[str], otherwise: str = "") -> str:
    """Ask for the known names that are near a word or begin with it, or say the sentence `otherwise`."""
    names = list(known)
    typed = word.lower()
    begun = [name for name in names if typed and name.lower().startswith(typed)]
    near = begun or get_close_matches(typed, names, 1)
    return f"Did you mean {' or '.join(near)}?" if near else otherwise
