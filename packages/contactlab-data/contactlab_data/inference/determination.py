"""What determines the numbers of a fit: their intervals, and the part of the data that decides one alone.

Without the rows J_i of one part of the data a number has the variance ((J'J - J_i'J_i)^-1)_kk in place of
((J'J)^-1)_kk. Where that is more than `DECIDES` times as large the part alone determines the number, and what
the others say of it is its interval in a fit to these.
"""

from dataclasses import dataclass
from functools import partial
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.progress import part_of_progress
from contactlab_data.inference.free_parameters import FreeParameter
from contactlab_data.inference.held_out import parts_of
from contactlab_data.inference.least_squares import Optimum
from contactlab_data.inference.maximum_likelihood import (
    covariance_of,
    profile_ends,
    refit,
    scale_of,
    standardised,
)
from contactlab_data.inference.problem import Problem

DECIDES: Final = 100.0
"""Ratio of variances from which on one part of the data alone determines a number: ten times the interval."""


@final
@dataclass(frozen=True)
class Determination:
    """Interval of one number, and the part of the data that decides it.

    Args:
        number: the free number.
        ends: its 90 % interval in the unit cube, shape (2,); an end of the cube is none of the data.
        alone: label of the part of the data that alone determines it; empty without.
        of_others: interval by the other parts, shape (2,).
    """

    number: FreeParameter
    ends: Array
    alone: str = ""
    of_others: Array | None = None

    @property
    def remark(self) -> str:
        """What limits the number; empty where all of the data bound it on both sides."""
        if self.of_others is not None:
            others = bounds(self.number, self.of_others)
            return f"{self.alone} alone determines it; by the rest it is {others} (90 %)"
        if np.isnan(self.ends).any() or ((self.ends > 0.0) & (self.ends < 1.0)).all():
            return ""
        return f"it is {bounds(self.number, self.ends)} (90 %)"

    @property
    def interval(self) -> Array:
        """The 90 % interval [SI], shape (2,)."""
        return np.array([self.number.from_unit(float(end)) for end in self.ends])


def bounds(number: FreeParameter, ends: Array) -> str:
    """Return an interval in the unit cube: "at least 0.14", "0.1 to 0.2" or "not determined"."""
    low, high = (f"{number.from_unit(float(end)):.4g}" for end in ends)
    unit = number.parameter.label
    below, above = ends[0] > 0.0, ends[1] < 1.0
    if below and above:
        return f"{low} to {high}{unit}"
    if not (below or above):
        return f"not determined within {low} to {high}{unit}"
    return f"at least {low}{unit}" if below else f"at most {high}{unit}"


def determinations(problem: Problem, best: Optimum) -> list[Determination]:
    """Return the interval of each number of law and motor, and the part of the data that decides it alone."""
    residuals, (scale, quantile) = standardised(problem, best.noise), scale_of(problem, best)
    profile = partial(profile_ends, step=problem.step)
    units, count = parts_of(problem, "units"), len(best.free)
    with part_of_progress(0.0, 0.7):
        every = profile(residuals, best, scale, quantile)
    result = []
    for place, (number, ends) in enumerate(zip(best.free, every, strict=True)):
        part = decisive_part(best.jacobian, units.fold, scale, place) if len(units.labels) > 1 else None
        if part is None:
            result.append(Determination(number, ends))
            continue
        others = units.fold != part

        def of_others(values: Array, others: NDArray[np.bool_] = others) -> Array:
            return residuals(values)[others]

        with part_of_progress(0.7 + 0.3 * place / count, 0.7 + 0.3 * (place + 1) / count):
            left = refit(of_others, problem, best.values)
            (by_others,) = profile(of_others, left, scale, quantile, [place])
        result.append(Determination(number, ends, units.labels[part], by_others))
    return result


def decisive_part(jacobian: Array, unit: NDArray[np.int64], scale: float, place: int) -> int | None:
    """Return the part of the data that alone determines a number; None without."""
    whole = covariance_of(jacobian, scale)[place, place]
    # Parts that do not change the residuals with the number cannot decide it; a few change them most.
    sizes = np.bincount(unit, np.sum(jacobian[:, [place]] ** 2, axis=1))
    for part in np.argsort(-sizes, kind="stable")[:3]:
        if covariance_of(jacobian[unit != part], scale)[place, place] > DECIDES * whole:
            return int(part)
    return None
