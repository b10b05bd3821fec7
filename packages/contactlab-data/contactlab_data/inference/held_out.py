"""Held-out data of a fit: what a law misses of a file, or of a cycle of a loop, to which it was not fitted.

A law is fitted by least squares to all folds but one, and predicts that one. Residuals are measured minus
predicted over the stated error, of impacts by the Cholesky factor of their covariance; where no error is
stated, over the size of the data. The misfit of a fold is their root mean square: of a law that is right 1,
up to sqrt(1 / (2 n)) of n residuals and to what the numbers fitted to the others are uncertain by.
"""

from collections.abc import Mapping
from typing import Any, Final, Literal, NamedTuple

import numpy as np
import xarray
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.config import ConfigurationError
from contactlab.progress import part_of_progress
from contactlab_data.inference.impact_problem import ImpactProblem
from contactlab_data.inference.joint_problem import JointProblem
from contactlab_data.inference.least_squares import best_fit
from contactlab_data.inference.motor_problem import OverTime, PointsProblem
from contactlab_data.inference.problem import Problem

HeldOut = Literal["auto", "off", "files", "cycles", "folds"]
"""What is held out in turn; auto is files, cycles of a loop, or folds of impacts, what there are two of."""

FOLDS: Final = 5

BAND: Final = 0.1
"""Part of the range of a slip on either side of its middle in which it does not begin a cycle."""


class Folds(NamedTuple):
    """Labels of the parts of the data that are held out in turn, and the part of each residual, from 0."""

    labels: list[str]
    fold: NDArray[np.int64]


def folds_of(problem: Problem, held_out: HeldOut, seed: int = 0) -> Folds | None:
    """Return the parts of a problem's data that are held out; None without any.

    Raises:
        ConfigurationError: there is one part, a file is no path, or files do not share their numbers.
    """
    own = [*problem.own] if isinstance(problem, JointProblem) else []
    chosen: HeldOut = held_out
    if held_out == "auto" and isinstance(problem, JointProblem):
        chosen = "off" if own else "files"
    elif held_out == "auto":
        # Nothing that takes runs of a motor.
        chosen = "off" if _slip(problem) is None else "cycles"
        chosen = "folds" if isinstance(problem, ImpactProblem) else chosen
    if chosen == "off":
        return None
    if chosen == "files" and own:
        raise ConfigurationError(
            f"study.own has {', '.join(own)}, which no other file determines; leave it out."
        )
    folds = parts_of(problem, chosen, seed)
    if len(folds.labels) > 1:
        return folds
    if held_out == "auto":
        return None
    kind = {"files": "file", "cycles": "cycle", "folds": "datum"}[held_out]
    raise ConfigurationError(f"study.held_out is {held_out} and there is one {kind}; there must be two.")


def _slip(problem: Problem) -> Array | None:
    """Return the slip of a path at the times of its data; None of what is no path."""
    return problem.measured.path.get("slip") if isinstance(problem, OverTime) else None


def parts_of(problem: Problem, kind: HeldOut | Literal["units"], seed: int = 0) -> Folds:
    """Return files, cycles, folds, or the smallest parts of a problem's data that are one by one.

    Those are single impacts and operating points, cycles of a loop, and else a file.

    Raises:
        ConfigurationError: cycles are wanted of what is no path.
    """
    sets = problem.parts if isinstance(problem, JointProblem) else {"": problem}
    labels, folds = list[str](), list[NDArray[np.int64]]()
    for label, part in sets.items():
        names, fold = parts_of_one(part, kind, seed, label or "data")
        folds.append(fold + len(labels))
        labels += [f"{label} {name}".strip() for name in names]
    return Folds(labels, np.concatenate(folds))


def parts_of_one(problem: Problem, kind: str, seed: int, file: str) -> tuple[list[str], NDArray[np.int64]]:
    """Return the names of the parts of one data set, and the part of each residual."""
    size = sum(item.size for item in problem.data.values())
    name, fold = "", np.zeros(size // len(problem.data), np.int64)
    if isinstance(problem, ImpactProblem) and kind in ("folds", "units"):
        number = problem.measured.number
        if kind == "units":
            return [f"impact {x}" for x in number], np.repeat(np.arange(number.size), 2)
        measurement = problem.measured.measurements()
        count = min(FOLDS, int(measurement.max()) + 1)
        name, fold = "fold", np.repeat(folds_of_measurements(measurement, count, seed), 2)
    elif kind == "folds" or (kind == "units" and isinstance(problem, PointsProblem)):
        count = fold.size if kind == "units" else min(FOLDS, fold.size)
        name, fold = "point" if kind == "units" else "fold", np.arange(fold.size) * count // fold.size
    elif (slip := _slip(problem)) is not None and kind in ("cycles", "units"):
        name, fold = "cycle", cycles(slip)
    elif kind == "cycles":
        raise ConfigurationError(f"study.held_out is cycles and {file} is no path; it must be.")
    count = int(fold.max()) + 1
    names = [f"{name} {i + 1}" for i in range(count)] if name and (count > 1 or kind != "units") else [""]
    return names, np.tile(fold, size // fold.size)


def folds_of_measurements(measurement: NDArray[np.int64], folds: int, seed: int) -> NDArray[np.int64]:
    """Return the fold, from 0, in which each impact is held out, shape (impact,).

    Measurements are shuffled by the seed, and each goes to the fold with the fewest impacts so far. Folds
    differ in size by one at most where each impact is a measurement of its own.

    Args:
        measurement: number of the measurement that each impact belongs to, from 0 without gaps.
        folds: how many.
        seed: of the shuffle.
    """
    sizes = np.bincount(measurement)
    filled, fold = np.zeros(folds, dtype=np.int64), np.empty(sizes.size, dtype=np.int64)
    for place in np.random.default_rng([seed, folds]).permutation(sizes.size):
        fold[place] = np.argmin(filled)
        filled[fold[place]] += sizes[place]
    return fold[measurement]


def cycles(slip: Array) -> NDArray[np.int64]:
    """Return the number of the cycle of each sample of a slip, from 0, shape (time,).

    A cycle begins where the slip has risen through a band about the middle of its range; less than half of
    one at the end is of the cycle before.

    >>> cycles(np.sin(np.arange(9.0) * np.pi / 2.0)).tolist()
    [0, 0, 0, 0, 0, 1, 1, 1, 1]
    """
    low, high = float(slip.min()), float(slip.max())
    middle, band = 0.5 * (low + high), BAND * (high - low)
    side = np.where(slip > middle + band, 1, np.where(slip < middle - band, -1, 0))
    known = np.flatnonzero(side)
    rises = known[1:][(side[known[1:]] == 1) & (side[known[:-1]] == -1)]
    if known.size and side[known[0]] == 1:
        rises = np.append(known[0], rises)
    if rises.size > 1 and slip.size - rises[-1] < 0.5 * np.diff(rises).mean():
        rises = rises[:-1]
    return np.searchsorted(rises[1:], np.arange(slip.size), side="right")


def residuals_of(problem: Problem, residuals: Array) -> xarray.Dataset:
    """Return residuals over the dimensions of the data, by the names of these."""
    names = {str(name): item for name, item in problem.data.items()}
    ends = np.cumsum([item.size for item in names.values()])[:-1]
    about = {"units": "1", "long_name": "measured less predicted, over the error"}
    pieces = zip(names.items(), np.split(residuals, ends), strict=True)
    variables = {n: (x.dims, piece.reshape(x.shape), about) for (n, x), piece in pieces}
    return xarray.Dataset(variables, problem.data.coords)


def held_out_misfits(problem: Problem, folds: Folds, best: Array, seed: int) -> xarray.Dataset:
    """Return misfit, number of residuals and numbers of the law without each fold.

    Args:
        problem: of all data.
        folds: of `folds_of`.
        best: optimum of all data, shape (parameter,), where each search begins.
        seed: of the fit.
    """
    misfits, values, count = list[Array](), list[Array](), len(folds.labels)
    for number in range(count):
        here = folds.fold == number

        def of_others(values: Array, here: NDArray[np.bool_] = here) -> Array:
            return problem.residuals(values)[~here]

        with part_of_progress(number / count, (number + 1) / count, f"held out: {folds.labels[number]}, "):
            fit = best_fit(of_others, problem.parameters, 1, seed, begin=best, step=problem.step)
        unseen, seen = (problem.residuals(x)[here] for x in (fit.values, best))
        misfits.append(np.sqrt([np.mean(unseen**2), np.mean(seen**2)]))
        values.append(fit.values)
    variables: Mapping[str, Any] = {
        "misfit": ("fold", np.array(misfits)[:, 0], {"units": "1", "long_name": "misfit when held out"}),
        "fitted_misfit": ("fold", np.array(misfits)[:, 1], {"units": "1", "long_name": "misfit when fitted"}),
        "count": ("fold", np.bincount(folds.fold)),
        "value": (("fold", "parameter"), np.array(values).reshape(len(misfits), len(problem.parameters))),
    }
    names = np.array([item.name for item in problem.parameters], dtype=object)
    return xarray.Dataset(variables, {"fold": np.array(folds.labels, dtype=object), "parameter": names})
