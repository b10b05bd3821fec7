"""The values of a swept parameter: one grammar for the command line and for Python.

0.5 um, 1 um                  a list, in SI or with units
linspace(0, 2 um, 100)        evenly spaced, both ends among them; geomspace in equal ratios
range(0, 1 um, 0.1 um)        in steps, STOP not among them
"""

import re
from collections.abc import Collection, Iterable
from contextlib import suppress
from decimal import Decimal
from math import ceil, isfinite
from typing import Final

import numpy as np

from contactlab.config.faults import ConfigurationError
from contactlab.config.nesting import Value
from contactlab.parameter import from_cf
from contactlab.quantity import UnitError, describe, to_si

FORMS: Final = (
    "values like 1e-6,2e-6 or '0.5 um,1 um', range(START,STOP,STEP) without STOP, linspace(FIRST,LAST,COUNT) "
    "or geomspace(FIRST,LAST,COUNT)"
)

MOST_RUNS: Final = 10_000_000
"""Runs of a sweep that keeps numbers; they are in memory at the end, about 200 bytes a run."""

_CALL: Final = re.compile(r"\s*(linspace|geomspace|range)\s*\((.*)\)\s*")
_COMMA: Final = re.compile(r",(?![^(]*\))")
"""A comma outside of brackets."""


class SweepError(ValueError):
    """A folder of a sweep that is damaged, has another sweep, or has no runs that can be joined."""


def listed(text: str) -> list[str]:
    """Split a text at its commas, but for those inside brackets."""
    return [part.strip().strip("'\"") for part in _COMMA.split(text) if part.strip()]


def call_in(value: object) -> tuple[str, list[str]] | None:
    """Return name and arguments of a text that stands for several values; None for another value."""
    call = _CALL.fullmatch(value) if isinstance(value, str) else None
    return call and (call[1], [part.strip().strip("'\"") for part in call[2].split(",")])


def in_si(value: Value, units: str) -> Value:
    """Return the text of a number in SI, its units those of CF; any other value as it is."""
    with suppress(UnitError):
        return to_si(value, from_cf(units)) if isinstance(value, str) and units else value
    return value


def spread(key: str, value: Value, units: str = "") -> list[Value]:
    """Return all values that one element of a list stands for, numbers in SI.

    Raises:
        ConfigurationError: it cannot be read in the units, has no end or no value, or too many.
    """
    if (call := call_in(value)) is None:
        return [in_si(value, units)]
    name, parts = call
    line = f"{key}={value}"
    if len(parts) not in ((1, 2, 3) if name == "range" else (3,)) or not all(parts):
        raise ConfigurationError(f"{line} has {len(parts)} arguments; a swept parameter must have {FORMS}.")
    if name == "range":
        return _stepped(line, key, parts, units)
    # A number of very many digits is none that Python reads.
    if not parts[2].isdecimal() or not 1 <= int(parts[2][:20]) <= MOST_RUNS:
        raise ConfigurationError(
            f"{line} has the count '{parts[2]}'; it must be a whole number of 1 to {MOST_RUNS}."
        )
    first, last = (_number(key, end, units) for end in parts[:2])
    if not isfinite(last - first) or (name == "geomspace" and first * last <= 0.0):
        raise ConfigurationError(
            f"{line} has the ends {first:g} and {last:g}; they must be finite, and of one sign."
        )
    spaced = np.linspace if name == "linspace" else np.geomspace
    return list(spaced(first, last, int(parts[2])).tolist())


def _number(key: str, text: str, units: str) -> float:
    try:
        return to_si(text, from_cf(units) if units else "1")
    except UnitError as error:
        raise ConfigurationError(f"{key}: {describe(text)}, {error}.") from None


def _stepped(line: str, key: str, parts: list[str], units: str) -> list[Value]:
    """Return the numbers of a range: as decimals, so that no round-off lets one reach STOP."""
    ends = [*(["0"] if len(parts) == 1 else []), *parts, "1"][:3]
    start, stop, step = (Decimal(repr(_number(key, end, units))) for end in ends)
    if not all(end.is_finite() for end in (start, stop, step)) or not step:
        raise ConfigurationError(f"{line} does not end; START, STOP and STEP must be finite and STEP not 0.")
    steps = (stop - start) / step
    # A range that was sorted may contain sums and differences of floats.
    whole = abs(steps - round(steps)) < Decimal("1e-9")
    count = max(0, round(steps) if whole else ceil(steps))
    if not 1 <= count <= MOST_RUNS:
        raise ConfigurationError(
            f"{line} has {count:.4g} values; it must have 1 to {MOST_RUNS}, without STOP."
        )
    kind = int if all(re.fullmatch(r"[+-]?\d+", end) for end in ends) else float
    return [kind(start + place * step) for place in range(count)]


def short_names(keys: Iterable[str], taken: Collection[str] = ()) -> dict[str, str]:
    """Return for each key or group its last part, or the shortest tail that no other has.

    Args:
        keys: full keys or groups.
        taken: names that are used already.
    """
    tails = {}
    for key in keys:
        parts = re.split(r"[./]", key)
        tails[key] = ["_".join(parts[at:]) for at in reversed(range(len(parts)))]
    several = [*taken, *(tail for ends in tails.values() for tail in ends)]
    return {key: next((t for t in ends if several.count(t) == 1), ends[-1]) for key, ends in tails.items()}
