"""How many 90 % intervals of least squares hold the truth: loops, impacts and operating points.

Data are drawn by the noise of the problem from predictions at truths in the middle of the ranges; each set is
fitted as by `contactlab fit method=least_squares`. Sections of docs/results/accuracy.json, by remake.py.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, Final

import numpy as np
import xarray

import contactlab as cl
from contactlab.motor.table import Table
from contactlab_data.inference.candidates import candidates_of
from contactlab_data.inference.determination import determinations
from contactlab_data.inference.free_parameters import from_cube
from contactlab_data.inference.impact_problem import ImpactProblem
from contactlab_data.inference.maximum_likelihood import followed_search
from contactlab_data.inference.problem import Problem
from contactlab_data.inference.synthetic import made_impacts
from contactlab_data.measured.series import VELOCITY, MeasuredPoints, MeasuredSeries

STARTS: Final = 4

INSIDE: Final = (0.2, 0.8)
"""Shares of the ranges within which truths are drawn."""


def loop() -> Problem:
    """Return Dahl's friction on a swing of two tones, with noise of a hundredth of the force."""
    time = np.linspace(0.0, 0.2, 161)
    slip = 4e-6 * np.sin(62.8 * time) * (1.0 + 0.3 * np.sin(31.4 * time))
    path = {"slip": slip, "normal": np.full(time.size, 10.0)}
    noise = {"friction_force": np.full(time.size, 0.03)}
    data = MeasuredSeries(time, {"friction_force": 0.0 * time}, noise, {}, {}, "", path)
    free = {"contact.friction_coefficient": (0.1, 0.6), "law.friction.rest_stiffness": (3e4, 3e5)}
    return _problem(data, ["law=composed", "law/friction=dahl"], free)


def impacts() -> Problem:
    """Return 40 impacts under Newton's law, whose error of 5 % is not stated."""
    data = replace(made_impacts(cl.Newton(), 40, 0.05, 1), covariance=None)
    free = {"law.restitution": (0.2, 0.9), "contact.friction_coefficient": (0.05, 0.4)}
    return _problem(data, ["law=newton"], free)


def points() -> Problem:
    """Return four operating points of the default motor under a Hertz contact."""
    loads = np.array([0.0, -1e-3, -2e-3, -3e-3])
    columns = {
        "rotor.load_torque": ("point", loads, {"units": "N m"}),
        VELOCITY: ("point", np.zeros(loads.size), {"units": "rad/s"}),
    }
    table = Table(xarray.Dataset(columns), "point", [f"row {i}" for i in range(loads.size)])
    noise = {VELOCITY: np.full(loads.size, 0.01)}
    data = MeasuredPoints(table, {VELOCITY: np.zeros(loads.size)}, noise, {})
    free = {"contact.friction_coefficient": (0.15, 0.5), "drive.voltage_1": (90.0, 110.0)}
    return _problem(data, ["law=hertz_penalty"], free)


KINDS: Final[dict[str, Callable[[], Problem]]] = {"loop": loop, "impacts": impacts, "points": points}


def _problem(data: Any, overrides: list[str], free: Any) -> Problem:
    (candidate,) = candidates_of(data, {"": cl.build(overrides)}, free)
    return candidate.problem


def covered(problem: Any, seed: int) -> dict[str, bool]:
    """Return whether the interval of each number holds the truth, of one set of data."""
    draws = np.random.default_rng([seed, 5])
    truth = from_cube(problem.parameters, draws.uniform(*INSIDE, len(problem.parameters)))
    # Noise that is not stated has the size that it is found with in the impacts above.
    values = np.append(truth, [0.05] * len(problem.nuisances))
    predicted = problem.predict(truth)
    made = problem.replicate(predicted, values, draws)
    own = made if not isinstance(problem, ImpactProblem) else made["velocity_after"]
    name = "velocity_after" if isinstance(problem, ImpactProblem) else "values"
    problem = replace(problem, measured=replace(problem.measured, **{name: own}))
    near, best = followed_search(problem, STARTS, 0)
    rows = zip(truth, determinations(near, best), strict=True)
    return {item.number.name: bool(item.interval[0] <= x <= item.interval[1]) for x, item in rows}


def coverage(kind: str, sets: int) -> dict[str, Any]:
    """Return how many of the intervals of so many sets of data hold the truth, by number."""
    problem = KINDS[kind]()
    every = [covered(problem, seed) for seed in range(sets)]
    return {"sets": sets, "covered": {name: sum(each[name] for each in every) for name in every[0]}}
