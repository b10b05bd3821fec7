"""Measurements and free numbers as options of the studies `fit` and `validate`."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, TypeVar

from contactlab.checks import check_kind
from contactlab.config import ConfigurationError, Setup, build
from contactlab.inference.law_numbers import Free
from contactlab.laws import ContactLaw
from contactlab.studies.study import Range, Setups

_Data = TypeVar("_Data")

FreeNumbers = Free | list[Range] | None
"""Ranges of free numbers, by key in Python, KEY=LOW..HIGH in a command or file."""

OF_MOTOR: Final = (
    *("resonator", "piezoceramic", "placement", "drive", "rotor", "solver", "record"),
    *("contact.tip_length", "contact.clearance", "contact.preload"),
)
"""Groups and keys of a configuration on which impacts do not depend."""


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


def read_file(data: str | Path, read: Callable[[Path], _Data]) -> _Data:
    """Return the measurements of a file.

    Raises:
        ConfigurationError: the file is missing, or cannot be read.
    """
    if not str(data):
        raise ConfigurationError("study.data is missing; it must be a file of measurements.")
    try:
        return read(Path(data))
    except OSError as error:
        raise ConfigurationError(
            f"data is '{data}' and cannot be read ({error.strerror or error})."
        ) from error
    except ValueError as error:
        raise ConfigurationError([f"data: {line}" for line in str(error).splitlines()]) from error


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
