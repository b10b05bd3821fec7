"""What somebody who made a slip of the pen, or used another word for the same, may have meant."""

import re
from collections.abc import Iterable
from difflib import SequenceMatcher, get_close_matches
from typing import Final

SAME: Final = {
    "speed": "velocity",
    "max": "peak",
    "maximum": "peak",
    "mu": "friction_coefficient",
    "time": "duration",
}
"""Words that others use, and those that stand for them in names."""

MOST, SHORTEST = 3, 4
"""Names that are offered because they have a word in common, and letters of such a word."""


def suggestion(word: str, known: Iterable[str], otherwise: str = "") -> str:
    """Ask for the known names that are near a word or begin with it, or say the sentence `otherwise`."""
    near = nearest(word, list(known))
    return f"Did you mean {' or '.join(near)}?" if near else otherwise


def nearest(word: str, names: list[str]) -> list[str]:
    """Give the names that begin with a word, that are near it, or that have some of it in common."""
    typed = word.lower()
    begun = [name for name in names if typed and name.lower().startswith(typed)]
    if near := begun or get_close_matches(typed, names, 1):
        return near
    ours = "".join(SAME.get(part, part) for part in re.split(r"([^a-z0-9])", typed))
    if ours in names:
        return [ours]
    words = _words(ours)
    sharing = [name for name in names if words & _words(name.lower())]
    return sorted(sharing, key=lambda name: -SequenceMatcher(None, ours, name).ratio())[:MOST]


def _words(name: str) -> set[str]:
    return {part for part in re.split(r"[^a-z0-9]", name) if len(part) >= SHORTEST}
