"""Measurements and chosen laws as options of the studies `fit` and `validate`."""

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, TypeVar

from contactlab.config import ConfigurationError

_Data = TypeVar("_Data")

PATTERNS: Final[Mapping[str, re.Pattern[str]]] = {
    "choice": re.compile(r"[^=]+=.*"),
    "data": re.compile(r"[^=]+"),
}
"""Arguments of the command: KEY=VALUE chooses laws and numbers, any other is the file of the data."""


def measured(path: str, read: Callable[[Path], _Data]) -> _Data:
    """Read the file of measurements.

    Raises:
        ConfigurationError: the file is missing, or cannot be read.
    """
    if not path:
        raise ConfigurationError(["study.data is missing; it must be a file of measurements."])
    try:
        return read(Path(path))
    except OSError as error:
        raise ConfigurationError(
            [f"data is '{path}' and cannot be read ({error.strerror or error})."]
        ) from error
    except ValueError as error:
        raise ConfigurationError([f"data: {line}" for line in str(error).splitlines()]) from error


def choice_of(
    laws: Sequence[str],
    free: Mapping[str, tuple[float | str, float | str]] | None,
    fixed: Mapping[str, Any] | None,
) -> list[str]:
    """Return the overrides that choose laws, ranges by key and values by key."""
    choice = [f"law={','.join(laws)}"] if laws else []
    choice += [f"{key}={low}..{high}" for key, (low, high) in (free or {}).items()]
    return [*choice, *(f"{key}={value}" for key, value in (fixed or {}).items())]
