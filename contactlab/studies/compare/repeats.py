"""Responses that are no function of their inputs, over motors that are one but for friction and start.

A chaotic motion, or one of several that a motor may come to, gives a number of every run and none of the
motor. Where it differs by more than a margin after a change by a millionth, that difference is stated alone.
"""

from collections.abc import Mapping
from math import inf, isfinite
from typing import Any, Final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.config.nesting import flat, nested
from contactlab.steady_state.basins import reach

TINY: Final = 1e-6
"""Relative change of friction after which a function of the inputs has the same value."""

MARGIN: Final = 0.05
"""Relative difference that matters to few motors."""

NEGLIGIBLE: Final = 1e-3
"""Size below which a response counts as none, over its largest size."""

OF_FRICTION: Final = {"less friction": 1.0 - TINY, "more friction": 1.0 + TINY}
"""Factors of the friction coefficient."""

OF_START: Final = {"backwards at the start": -1.0, "forwards at the start": 1.0}
"""Sense of the rotor at the start."""

REPEATS: Final = (*OF_FRICTION, *OF_START)
"""Motors that are the configured one but for `TINY` changes of friction, or the velocity of the start."""


def repeated(setup: Setup, repeat: str) -> dict[str, Any]:
    """Return the configuration of a motor of `REPEATS`."""
    settings = flat(setup.configuration)
    if repeat in OF_FRICTION:
        settings["contact.friction_coefficient"] *= OF_FRICTION[repeat]
    else:
        settings["rotor.initial_velocity"] = OF_START[repeat] * reach(setup)
    return nested(settings)


def spread_of(values: Array, axis: int = -1, least: float = 0.0) -> Array:
    """Return the range of values along an axis over the largest of them, or over a least size.

    Infinite where some of them, NaN, are none.
    """
    known = np.isfinite(values)
    low = np.where(known, values, inf).min(axis=axis)
    high = np.where(known, values, -inf).max(axis=axis)
    size = np.maximum(np.maximum(np.abs(low), np.abs(high)), least)
    with np.errstate(invalid="ignore"):
        spread = np.where(high > low, (high - low) / size, 0.0)
    return np.where(known.all(axis=axis), spread, inf)


def not_stated(what: str, spreads: Mapping[str, float], response: str, margin: float) -> str:
    """Return the sentence on responses that are no function of their inputs; empty without any.

    Args:
        what: is not stated.
        spreads: of the response by law.
        response: that differs.
        margin: which the spread of a function is below.
    """
    wide = [
        f"{law} ({100.0 * x:.2g} %)" if isfinite(x) else f"{law} (with and without a steady state)"
        for law, x in spreads.items()
        if x > margin
    ]
    if not wide:
        return ""
    return (
        f"No {what} of {', '.join(wide)} is stated: with a millionth more or less of friction, or from "
        f"another start, the {response} differs by more than {100.0 * margin:.3g} %."
    )
