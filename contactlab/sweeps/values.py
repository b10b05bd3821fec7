"""The values of a swept parameter: one grammar for the command line and for Python.

0.5 um, 1 um                  a list, in SI or with units
linspace(0, 2 um, 100)        evenly spaced, both ends among them; geomspace in equal ratios
range(0, 1 um, 0.1 um)        in steps, STOP not among them
"""

import re
from collections.abc import Callable, Collection, Iterable, Sequence
from decimal import Decimal
from math import ceil, isfinite
from typing import Any, Final

import numpy as np

from contactlab.config.nesting import Value

FORMS: Final = (
    "values like 1e-6,2e-6 or '0.5 um,1 um', range(START,STOP,STEP) without STOP, linspace(FIRST,LAST,COUNT) "
    "or geomspace(FIRST,LAST,COUNT)"
)

MOST_RUNS: Final = 10_000_000
"""Runs of a sweep that keeps metrics; its numbers are in memory at the end, about 200 bytes a run."""

_SPACED: Final[dict[str, Callable[..., Any]]] = {"linspace": np.linspace, "geomspace": np.geomspace}
_CALL: Final = re.compile(r"\s*(linspace|geomspace|range)\s*\((.*)\)\s*")
_COMMA: Final = re.compile(r",(?![^(]*\))")
"""One that is not inside brackets."""


class SweepError(ValueError):
    """A sweep that cannot be made, or whose folder is damaged; the message is a sentence."""


def listed(text: str) -> list[str]:
    """Split a text at its commas, but for those inside brackets."""
    return [part.strip().strip("'\"") for part in _COMMA.split(text) if part.strip()]


def is_spaced(value: object) -> bool:
    """Tell whether a value is a text that stands for several."""
    return isinstance(value, str) and _CALL.fullmatch(value) is not None


def spread(key: str, value: Value, number: Callable[[str], float]) -> list[Value]:
    """Give all values that one element of a list stands for.

    Args:
        key: for the sentences.
        value: a number or a text.
        number: the SI number of a text.

    Raises:
        SweepError: it cannot be read, has no end or no value, or too many.
    """
    call = _CALL.fullmatch(value) if isinstance(value, str) else None
    if call is None:
        return [value]
    name, parts = call[1], [part.strip().strip("'\"") for part in call[2].split(",")]
    form = "range(START,STOP,STEP)" if name == "range" else f"{name}(FIRST,LAST,COUNT)"
    if len(parts) not in ((1, 2, 3) if name == "range" else (3,)) or not all(parts):
        raise SweepError(f"{key}={value} does not have three arguments; it must be {form}.")
    if name == "range":
        return _stepped(key, str(value), parts, number)
    # A number of very many digits is none that Python reads.
    if not parts[2].isdecimal() or not 1 <= int(parts[2][:20]) <= MOST_RUNS:
        raise SweepError(
            f"{key}={value} has the count '{parts[2]}'; it must be a whole number of at least 1 and at "
            f"most {MOST_RUNS}."
        )
    first, last = number(parts[0]), number(parts[1])
    if not isfinite(last - first):
        raise SweepError(
            f"{key} goes from {first:g} to {last:g}; both ends must be finite numbers, and so must be what "
            "lies between them. Name others."
        )
    if name == "geomspace" and first * last <= 0.0:
        raise SweepError(
            f"{key} goes from {first:g} to {last:g} by geomspace, whose ends must not be zero and must "
            "have one sign. Use linspace."
        )
    return [float(found) for found in _SPACED[name](first, last, int(parts[2]))]


def _stepped(
    key: str, text: str, parts: Sequence[str], number: Callable[[str], float]
) -> list[Value]:
    """Give the numbers of a range: as decimals, so that no round-off lets one reach STOP."""
    ends = ["0", *parts] if len(parts) == 1 else [*parts]
    ends += ["1"] * (3 - len(ends))
    start, stop, step = (Decimal(repr(number(end))) for end in ends)
    if not all(end.is_finite() for end in (start, stop, step)) or not step:
        raise SweepError(
            f"{key}={text} does not end; START, STOP and STEP must be finite and STEP not 0."
        )
    steps = (stop - start) / step
    # Whoever sorts a range may have added and subtracted floats before.
    whole = abs(steps - round(steps)) < Decimal("1e-9")
    count = max(0, round(steps) if whole else ceil(steps))
    if not count:
        raise SweepError(f"{key}={text} has no values; a range ends before its STOP.")
    if count > MOST_RUNS:
        raise SweepError(
            f"{key}={text} has {count:.4g} values; it must have at most {MOST_RUNS}. Choose a larger STEP."
        )
    kind = int if all(re.fullmatch(r"[+-]?\d+", end) for end in ends) else float
    return [kind(start + place * step) for place in range(count)]


def short_names(keys: Iterable[str], taken: Collection[str] = ()) -> dict[str, str]:
    """Give each key a name that xarray likes: its last part, or the shortest tail that is its own.

    Args:
        keys: full keys or groups, 'contact.clearance' or 'law/normal'.
        taken: names that stand for something else.
    """
    steps = {key: re.split(r"[./]", key) for key in keys}

    def tail(key: str, length: int) -> str:
        return "_".join(steps[key][-length:])

    names = {}
    for key, parts in steps.items():
        own = [
            tail(key, length)
            for length in range(1, len(parts) + 1)
            if tail(key, length) not in taken
            and all(tail(key, length) != tail(other, length) for other in steps if other != key)
        ]
        names[key] = own[0] if own else "_".join(parts)
    return names
