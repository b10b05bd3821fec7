"""Free numbers and setups as arguments of the studies `fit`, `validate` and `bench`."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from contactlab.checks import check_kind
from contactlab.config import ConfigurationError, Setup, build
from contactlab.laws import ContactLaw
from contactlab.studies.study import Range, Setups
from contactlab_data.inference.law_numbers import Free

FreeNumbers = Free | list[Range] | None
"""Ranges of free numbers, by key in Python, KEY=LOW..HIGH in a command or file."""


def by_key(free: FreeNumbers, known: Sequence[str] | None) -> Free:
    """Return the ranges of free numbers by key.

    Raises:
        ConfigurationError: a number has two, or is known.
    """
    pairs = [(x.name, (x.start, x.end)) for x in free] if isinstance(free, list) else [*(free or {}).items()]
    keys = [*(key for key, _ in pairs), *(known or ())]
    if twice := sorted({key for key in keys if keys.count(key) > 1}):
        raise ConfigurationError([f"{key} occurs twice; it must occur once. Leave one out." for key in twice])
    return dict(pairs)


def by_label(setups: Setup | ContactLaw | Sequence[Any] | Mapping[str, Any]) -> Setups:
    """Return setups by label; a law alone stands for the default motor under it.

    Raises:
        TypeError: one is neither setup nor law.
    """
    if isinstance(setups, Setup | ContactLaw):
        setups = [setups]
    if not isinstance(setups, Mapping):
        setups = {"" if len(setups) == 1 else str(place): each for place, each in enumerate(setups, 1)}
    for label, each in setups.items():
        check_kind(f"setups[{label!r}]", each, Setup | ContactLaw)
    return {x: replace(build(), law=y) if isinstance(y, ContactLaw) else y for x, y in setups.items()}
