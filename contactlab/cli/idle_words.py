"""Words of a run that have no say in what a verb does: refused, as they would be passed over in silence."""

import re
from collections.abc import Iterable
from typing import Final

KEPT: Final = ("hydra", "sweep", "record", "uncertainty")
"""Groups that say how runs are made, kept or compared: no motion depends on them."""

LASTING: Final = ("solver.duration", "solver.until", "solver.precision")
"""Keys that say how long a run lasts."""


def idle(words: Iterable[str], *keys: str) -> list[str]:
    """Give those words that set one of these keys, or one below it."""
    return [word for word in words if any(_sets(word, key) for key in keys)]


def acting(words: Iterable[str], *keys: str) -> list[str]:
    """Give the words without those that set one of these keys."""
    return [word for word in words if not idle([word], *keys)]


def _sets(word: str, key: str) -> bool:
    name, _, value = word.lstrip("+~").partition("=")
    name = name.split("@")[0].strip().replace("/", ".")
    group, _, leaf = key.partition(".")
    # A group may be given as {leaf: value}.
    within = name == group and bool(leaf) and re.search(rf"\b{leaf}\s*:", value)
    return name == key or name.startswith(f"{key}.") or bool(within)
