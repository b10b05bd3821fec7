"""Free numbers of a law without influence on the data, such as a stiffness under a prescribed load."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from contactlab.arrays import Array
from contactlab_data.inference.cross_validation import without_idle
from contactlab_data.inference.free_parameters import FreeParameter, from_cube
from contactlab_data.inference.impact_problem import ImpactProblem, LawPredictor
from contactlab_data.inference.joint_problem import JointProblem
from contactlab_data.inference.least_squares import starting_points
from contactlab_data.inference.motor_problem import MotorProblem
from contactlab_data.inference.problem import Problem

POINTS: Final = 16
"""Latin-hypercube samples of the other numbers."""

SHARES: Final = (0.1, 0.5, 0.9)
"""Places in the range of a number."""

CHANGE: Final = 1e-7
"""Change of a quantity over its largest value from which on a number has influence; integration errs less."""


def without_influence(problem: Problem) -> Problem:
    """Return the problem without the numbers that change no prediction.

    Each number runs through its range, with several samples of the others. What has no influence keeps the
    value of the law.
    """
    if isinstance(problem, JointProblem):
        return replace(problem, parts={name: without_influence(x) for name, x in problem.parts.items()})
    if isinstance(problem, MotorProblem):
        every = range(len(problem.keys))
        kept = [problem.keys[i] for i in every if _acts(problem.keys, i, problem.predict)]
        return replace(problem, keys=tuple(kept))
    if isinstance(problem, ImpactProblem) and isinstance(problem.predictor, LawPredictor):
        return replace(problem, predictor=without_idle(problem.predictor, problem.measured))
    return problem


def _acts(
    free: tuple[FreeParameter, ...], place: int, predict: Callable[[Array], dict[str, Array] | None]
) -> bool:
    """Return whether a number changes any prediction, or whether there is one; true where there never is."""
    predicted = False
    for point in starting_points(len(free), POINTS, seed=0):
        first: dict[str, Array] | None = None
        for number, share in enumerate(SHARES):
            point[place] = share
            forces = predict(from_cube(free, point))
            predicted = predicted or forces is not None
            if number == 0:
                first = forces
            if (forces is None) != (first is None):
                return True
            for name, values in (forces or {}).items():
                before = (first or {})[name]
                if np.abs(values - before).max() > CHANGE * np.abs(before).max():
                    return True
    return not predicted
