"""What the entrants share: a loop over questions, and what is measured on a series. Needs NumPy only."""

import json
import sys
from collections.abc import Callable, Mapping
from time import process_time
from typing import Any

import numpy as np

SETTLING = 0.2
"""Time for which a block rests on a soft contact before it is loaded [s]."""

Numbers = Mapping[str, float]
Values = Mapping[str, float]


def serve(settings: Mapping[str, Any], kinds: Mapping[str, Callable[[Any, Numbers], Values]]) -> None:
    """Print settings and kinds, then an object for each question on standard input, a JSON object a line.

    Args:
        settings: what a function receives first, by the name of the setting.
        kinds: functions that answer, by kind.
    """
    print(json.dumps({"settings": [*settings], "kinds": [*kinds]}), flush=True)
    for line in sys.stdin:
        question = json.loads(line)
        began = process_time()
        try:
            values = kinds[question["kind"]](settings[question["setting"]], question["numbers"])
        except Exception as error:
            # Whatever a simulator raises, there is no answer of it.
            print(f"{question}: {error!r}", file=sys.stderr)
            values = {}
        seconds = process_time() - began
        numbers = {name: float(value) for name, value in values.items()}
        print(json.dumps({"answers": numbers, "seconds": seconds}), flush=True)


def push_at(numbers: Numbers, time: float, way: float) -> float:
    """Return the load along the plane [N]; a belt is the plane in whose frame the spring's clamp moves.

    Args:
        numbers: of the question.
        time: [s].
        way: displacement of the block on the plane [m].
    """
    cone = numbers["friction"] * numbers["mass"] * numbers["gravity"]
    phase = 2.0 * np.pi * numbers.get("frequency", 0.0) * time
    spring = numbers.get("stiffness", 0.0) * (way + numbers.get("belt_velocity", 0.0) * time)
    return float(cone * (numbers["push"] + numbers.get("amplitude", 0.0) * np.cos(phase)) - spring)


def of_block(numbers: Numbers, time: Any, way: Any, velocity: float) -> Values:
    """Return velocity [m/s], drift [m], and with a spring amplitude [m] and period [s] of the oscillation.

    Args:
        numbers: of the question.
        time, way: series of [s] and of the displacement on the plane [m].
        velocity: at the end [m/s].
    """
    time, way = np.asarray(time), np.asarray(way)
    since = numbers.get("since", 0.0)
    values = {"velocity": velocity, "drift": way[-1] - np.interp(since, time, way)}
    if "stiffness" in numbers:
        late = time >= since
        t, x = time[late], (way + numbers["belt_velocity"] * time)[late]
        x = x - 0.5 * (x.max() + x.min())
        up = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
        crossings = t[up] - x[up] * (t[up + 1] - t[up]) / (x[up + 1] - x[up])
        values["period"] = float(np.mean(np.diff(crossings))) if crossings.size > 1 else np.nan
        values["amplitude"] = 0.5 * float(np.ptp(x))
    return values


def thrown(numbers: Numbers) -> dict[str, float]:
    """Return the velocity of the centre [m/s] and the contact point from there [m]."""
    angle, tilt = np.deg2rad(numbers["angle"]), np.deg2rad(numbers["tilt"])
    speed, arm = numbers["speed"], numbers["arm"]
    return {
        "along": speed * np.cos(angle),
        "down": speed * np.sin(angle),
        "lever_x": arm * np.cos(tilt),
        "lever_z": -arm * np.sin(tilt) - numbers["radius"],
    }


def of_impact(numbers: Numbers, gap_rate: float, along: float, up: float, turning: float) -> Values:
    """Return rebound and energy over those before.

    Args:
        numbers: of the question.
        gap_rate: of the contact point after the impact [m/s].
        along, up: velocity of the centre after it [m/s].
        turning: angular velocity after it [rad/s].
    """
    energy = numbers["mass"] * (along**2 + up**2) + numbers["inertia"] * turning**2
    return {
        "rebound": gap_rate / thrown(numbers)["down"],
        "energy": energy / (numbers["mass"] * numbers["speed"] ** 2),
    }


def of_bounce(numbers: Numbers, time: Any, height: Any, speed: float) -> Values:
    """Return the last time above the threshold over the height at the end [s], and the speed then [m/s]."""
    time, height = np.asarray(time), np.asarray(height)
    excess = height - height[-1] - numbers["threshold"]
    i = int(np.flatnonzero(excess > 0.0)[-1])
    last = time[i] + (time[i + 1] - time[i]) * excess[i] / (excess[i] - excess[i + 1])
    return {"time": last, "speed": abs(speed)}
