"""What the entrants share: a loop over questions, and what is measured on a series. Needs NumPy only."""

import json
import sys
from collections.abc import Callable, Mapping
from time import process_time
from typing import Any

import numpy as np

# The module of the bench, by its folder: an environment of simulators has no contactlab.
from measures import Numbers, of_block, of_bounce

__all__ = [
    "SETTLING",
    "Numbers",
    "Values",
    "is_constant",
    "of_block",
    "of_bounce",
    "of_impact",
    "push_at",
    "serve",
]

SETTLING = 0.2
"""Time for which a block rests on a soft contact before it is loaded [s]."""

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


def is_constant(numbers: Numbers) -> bool:
    """Return whether the load along the plane stays as it is."""
    return not (numbers.get("amplitude") or numbers.get("stiffness"))


def of_impact(numbers: Numbers, gap_rate: float, along: float, up: float, turning: float) -> Values:
    """Return rebound and energy over those before, and the slip velocity [m/s].

    Args:
        numbers: of the question.
        gap_rate: of the contact point after the impact [m/s].
        along, up: velocity of the centre after it [m/s].
        turning: angular velocity after it [rad/s].
    """
    energy = numbers["mass"] * (along**2 + up**2) + numbers["inertia"] * turning**2
    return {
        "rebound": -gap_rate / numbers["rate"],
        "energy": 0.5 * energy / numbers["kinetic"],
        "slip": abs(along + numbers["lever_z"] * turning),
    }
