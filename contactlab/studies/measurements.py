"""Measurements and free numbers as options of the studies `fit` and `validate`."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Final, TypeVar

from contactlab.config import ConfigurationError
from contactlab.inference.law_numbers import Free
from contactlab.studies.study import Range

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
