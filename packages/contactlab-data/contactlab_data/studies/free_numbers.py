"""Free numbers as an option of the studies `fit` and `validate`."""

from collections.abc import Sequence

from contactlab.config import ConfigurationError
from contactlab.studies.study import Range
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
