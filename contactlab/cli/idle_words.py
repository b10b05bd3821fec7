"""Words of a run that have no say in what a verb does: refused, as they would be passed over in silence."""

import re
from collections.abc import Iterable, Sequence
from typing import Final

from contactlab.cli.terminal import RefusalError

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


def refuse_idle(words: Sequence[str], what: str, *keys: str) -> None:
    """Refuse words that set one of these keys, since `what` is being made and has none of them.

    Raises:
        RefusalError: a sentence for each.
    """
    faults = [
        f"{word} says how runs are made or kept; {what} has nothing of that. Leave it out"
        + ("; --output DIR says where its files go." if idle([word], "hydra") else ".")
        for word in idle(words, *keys)
    ]
    if faults:
        raise RefusalError("\n".join(faults))


def refuse_of_motor(words: Iterable[str]) -> None:
    """Refuse words that are not of the law, where impacts are all that there is.

    Raises:
        RefusalError: a sentence for each.
    """
    # Imported here: it brings the motor, which --help does not need.
    from contactlab.config.schema import FRICTION

    keys = [(word, word.lstrip("+~").partition("=")[0].strip()) for word in words]
    faults = [
        f"{word} is none of a law, and impacts are of the law alone; it must be a choice of law, a number "
        f"law.NAME or {FRICTION}. Leave it out."
        for word, key in keys
        if key != FRICTION and not re.fullmatch(r"law([./].*)?", key)
    ]
    if faults:
        raise RefusalError("\n".join(faults))
