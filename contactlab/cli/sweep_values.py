"""The values of a swept parameter as they are typed: sweep.KEY=VALUES, or KEY=VALUES of -m."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from math import ceil, isfinite
from typing import Any, Final, final

import numpy as np
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override, QuotedString, RangeSweep, Transformer
from hydra.errors import HydraException

from contactlab.config.nesting import Value

PREFIX: Final = "sweep."
FORMS: Final = (
    "values like 1e-6,2e-6 or '0.5 um,1 um', range(START,STOP,STEP) without STOP, linspace(FIRST,LAST,COUNT) "
    "or geomspace(FIRST,LAST,COUNT)"
)

MOST_CELLS: Final = 10_000_000
"""Runs of a map; its numbers are in memory at the end, about 200 bytes a run."""

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

    def __len__(self) -> int:
        return self.count if self.spacing else len(self.listed)

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
        if not isfinite(last - first):
            raise SweepError(
                f"{PREFIX}{self.key} goes from {first:g} to {last:g}; both ends must be finite numbers, and "
                "so must be what lies between them. Name others."
            )
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
        found = _values(override)
    except SweepError as error:
        raise SweepError(f"{PREFIX}{error}") from None
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


def _values(override: Override) -> list[Any]:
    """The values as Hydra reads them.

    Raises:
        HydraException: they are no list.
        SweepError: they are too many.
    """
    if not override.is_sweep_override():
        return [override.value()]
    if override.is_range_sweep():
        return list(range_values(override, MOST_CELLS))
    if not override.is_discrete_sweep():
        raise HydraException
    return list(override.sweep_iterator(Transformer.identity))


def _spaced(line: str, name: str, arguments: str) -> Typed:
    """Evenly spaced values, in steps or in ratios."""
    parts = [part.strip().strip("'\"") for part in arguments.split(",")]
    if len(parts) != 3 or not all(parts):
        raise SweepError(
            f"{PREFIX}{line} does not have three arguments; it must be {name}(FIRST,LAST,COUNT)."
        )
    # A number of very many digits is none that Python reads.
    if not parts[2].isdecimal() or not 1 <= int(parts[2][:20]) <= MOST_CELLS:
        raise SweepError(
            f"{PREFIX}{line} has the count '{parts[2]}'; it must be a whole number of at least 1 and at "
            f"most {MOST_CELLS}."
        )
    return Typed(line.partition("=")[0], tuple(parts[:2]), name, int(parts[2]))


def range_values(override: Override, most: int) -> list[int | float]:
    """The numbers of range(START,STOP,STEP), STOP not among them.

    Hydra's own adds up floats, whose round-off lets it reach a STOP that is a multiple of the STEP. Here the
    numbers are those that were typed, as decimals.

    Args:
        override: KEY=range(...).
        most: how many there may be.

    Raises:
        SweepError: they do not end, or there are too many.
    """
    said: Any = override.value()
    assert isinstance(said, RangeSweep)
    ends = said.start, said.stop, said.step
    start, stop, step = (Decimal(str(end)) for end in ends)
    if not all(end.is_finite() for end in (start, stop, step)) or not step:
        raise SweepError(
            f"{override.input_line} does not end; START, STOP and STEP must be finite and STEP not 0."
        )
    steps = (stop - start) / step
    # Hydra's sort() adds and subtracts floats before.
    whole = abs(steps - round(steps)) < Decimal("1e-9")
    count = max(0, round(steps) if whole else ceil(steps))
    if count > most:
        raise SweepError(
            f"{override.input_line} has {count:.4g} values; it must have at most {most}. "
            "Choose a larger STEP."
        )
    kind = int if all(isinstance(end, int) for end in ends) else float
    return [kind(start + place * step) for place in range(count)]
