"""Free numbers of a law without influence on the data, such as a stiffness under a prescribed load."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from contactlab.arrays import Array
from contactlab_data.inference.free_parameters import FreeParameter, from_cube
from contactlab_data.inference.impact_problem import ROUGH_TOLERANCE, ImpactProblem, LawPredictor
from contactlab_data.inference.joint_problem import JointProblem
from contactlab_data.inference.least_squares import starting_points
from contactlab_data.inference.motor_problem import MotorProblem
from contactlab_data.inference.problem import Problem
from contactlab_data.measured.impacts import MeasuredImpacts

POINTS: Final = 16
IMPACT_POINTS: Final = 8
"""Latin-hypercube samples of the other numbers, also for impacts, which all stick under large friction."""

IMPACTS: Final = 12
"""Impacts on which a number is tried."""

SHARES: Final = (0.1, 0.5, 0.9)
"""Places in the range of a number."""

CHANGE: Final = 1e-7
"""Change of a quantity over its largest value from which on a number has influence; integration errs less."""

EXACT: Final = 1e-9
"""Relative change of a velocity under a rigid law above round-off."""


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


def without_idle(predictor: LawPredictor, impacts: MeasuredImpacts) -> LawPredictor:
    """Fix the numbers of a law that have no effect on impacts at their values.

    Each runs through its range, with several samples of the others, on a dozen of the impacts.
    """
    some = impacts.part(np.unique(np.linspace(0, len(impacts) - 1, IMPACTS).astype(np.int64)))
    acts = [_moves(predictor, place, some) for place in range(len(predictor.free))]
    idle = tuple(item.name for item, act in zip(predictor.free, acts, strict=True) if not act)
    free = tuple(item for item, act in zip(predictor.free, acts, strict=True) if act)
    return replace(predictor, free=free, idle=idle)


def _moves(predictor: LawPredictor, place: int, impacts: MeasuredImpacts) -> bool:
    """Return whether a number changes any velocity."""
    threshold = 10.0 * ROUGH_TOLERANCE if predictor.integrated else EXACT
    size = np.abs(impacts.velocity_before).max()
    for point in starting_points(len(predictor.free), IMPACT_POINTS, seed=0):
        after = []
        for share in SHARES:
            point[place] = share
            after.append(predictor.velocities_after(from_cube(predictor.free, point), impacts))
        for other in after[1:]:
            changed = np.nanmax(np.abs(other - after[0]), initial=0.0) > threshold * size
            if changed or np.isnan(other).sum() != np.isnan(after[0]).sum():
                return True
    return False
