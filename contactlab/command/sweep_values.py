"""The values of a swept parameter as they are typed: sweep.KEY=VALUES."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import QuotedString, Transformer
from hydra.errors import HydraException

from contactlab.sweep.cells import Value

PREFIX: Final = "sweep."
FORMS: Final = (
    "values like 1e-6,2e-6 or '0.5 um,1 um', range(START,STOP,STEP), linspace(FIRST,LAST,COUNT) or "
    "geomspace(FIRST,LAST,COUNT)"
)

_SPACED: Final[dict[str, Callable[..., Any]]] = {"linspace": np.linspace, "geomspace": np.geomspace}
_CALL = re.compile(rf"\s*(?P<name>{'|'.join(_SPACED)})\s*\((?P<arguments>.*)\)\s*")


class SweepError(ValueError):
    """Values that cannot be read; the message is a sentence."""


@final
@dataclass(frozen=True)
class Typed:
    """Values as they were typed.

    Args:
        key: key or group.
        listed: the values, or the two ends of what is spaced.
        spacing: linspace or geomspace; empty for a list.
        count: number of values of what is spaced.
    """

    key: str
    listed: tuple[Value, ...]
    spacing: str = ""
    count: int = 0

    def values(self, number: Callable[[Value], float]) -> tuple[Value, ...]:
        """All of the values.

        Args:
            number: the SI number of a value.

        Raises:
            SweepError: they cannot be spaced so.
        """
        if not self.spacing:
            return self.listed
        first, last = (number(end) for end in self.listed)
        if self.spacing == "geomspace" and first * last <= 0.0:
            raise SweepError(
                f"{PREFIX}{self.key} goes from {first:g} to {last:g} by geomspace, whose ends must not be "
                "zero and must have one sign. Use linspace."
            )
        return tuple(float(value) for value in _SPACED[self.spacing](first, last, self.count))


def typed(line: str, parser: OverridesParser) -> Typed:
    """What an argument names.

    Args:
        line: KEY=VALUES, without the prefix.
        parser: Hydra's, for everything that Hydra knows.

    Raises:
        SweepError: it cannot be read, or names no value.
    """
    key, _, text = line.partition("=")
    if call := _CALL.fullmatch(text):
        return _spaced(line, call["name"], call["arguments"])
    try:
        (override,) = parser.parse_overrides([line])
        if override.key_or_group != key or not key or not text.strip():
            raise HydraException
        if not override.is_sweep_override():
            found: list[Any] = [override.value()]
        elif override.is_discrete_sweep():
            found = list(override.sweep_iterator(Transformer.identity))
        else:
            raise HydraException
    except (HydraException, ValueError):
        raise SweepError(
            f"{PREFIX}{line} cannot be read; a swept parameter must have {FORMS}. Quote an argument that "
            "has spaces or brackets."
        ) from None
    if not found:
        raise SweepError(
            f"{PREFIX}{line} has no values; it must have one at least. A range ends before its STOP."
        )
    found = [value.text if isinstance(value, QuotedString) else value for value in found]
    for value in found:
        if not isinstance(value, float | int | str):
            raise SweepError(
                f"{PREFIX}{line} has the value {value}; each must be a number, a text or true or false."
            )
    return Typed(key, tuple(found))


def _spaced(line: str, name: str, arguments: str) -> Typed:
    """Evenly spaced values, in steps or in ratios."""
    parts = [part.strip().strip("'\"") for part in arguments.split(",")]
    if len(parts) != 3 or not all(parts):
        raise SweepError(
            f"{PREFIX}{line} does not have three arguments; it must be {name}(FIRST,LAST,COUNT)."
        )
    if not parts[2].isdecimal() or int(parts[2]) < 1:
        raise SweepError(
            f"{PREFIX}{line} has the count '{parts[2]}'; it must be a whole number of at least 1."
        )
    return Typed(line.partition("=")[0], tuple(parts[:2]), name, int(parts[2]))
