"""What is measured on a series, of contactlab and of other simulators alike. Needs NumPy only."""

from collections.abc import Mapping
from typing import Any

import numpy as np

Numbers = Mapping[str, float]


def of_block(numbers: Numbers, time: Any, way: Any, velocity: float) -> dict[str, float]:
    """Return velocity [m/s], drift [m], and with a spring amplitude [m] and period [s] of the oscillation.

    Args:
        numbers: of the question.
        time, way: series of [s] and of the displacement on the plane [m].
        velocity: at the end [m/s].
    """
    time, way = np.asarray(time), np.asarray(way)
    since = numbers.get("since", 0.0)
    values = {"velocity": velocity, "drift": float(way[-1] - np.interp(since, time, way))}
    if "stiffness" in numbers:
        late = time >= since
        t, x = time[late], (way + numbers["belt_velocity"] * time)[late]
        x = x - 0.5 * (x.max() + x.min())
        up = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
        crossings = t[up] - x[up] * (t[up + 1] - t[up]) / (x[up + 1] - x[up])
        values["period"] = float(np.mean(np.diff(crossings))) if crossings.size > 1 else float("nan")
        values["amplitude"] = 0.5 * float(np.ptp(x))
    return values


def of_bounce(numbers: Numbers, time: Any, height: Any, speed: float) -> dict[str, float]:
    """Return the last time above the threshold over the height at the end [s], and the speed then [m/s]."""
    time, height = np.asarray(time), np.asarray(height)
    excess = height - height[-1] - numbers["threshold"]
    i = int(np.flatnonzero(excess > 0.0)[-1])
    last = time[i] + (time[i + 1] - time[i]) * excess[i] / (excess[i] - excess[i + 1])
    return {"time": float(last), "speed": abs(speed)}
