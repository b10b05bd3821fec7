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
from contactlab_data.inference.joint_problem import JointProblem
from contactlab_data.inference.least_squares import best_fit
from contactlab_data.inference.path_problem import PathProblem
from contactlab_data.inference.problem import Problem

HeldOut = Literal["off", "files", "cycles"]
"""What is held out in turn."""

BAND: Final = 0.1
"""Part of the range of a slip on either side of its middle in which it does not begin a cycle."""


class Folds(NamedTuple):
    """Labels of the parts of the data that are held out in turn, and the part of each residual, from 0."""

    labels: list[str]
    fold: NDArray[np.int64]


def folds_of(problem: Problem, held_out: HeldOut) -> Folds:
    """Return the parts of a problem's data: its files, or the whole cycles of its loops.

    Raises:
        ConfigurationError: there is one part, a file is no path, or files do not share their numbers.
    """
    if isinstance(problem, JointProblem):
        parts, own = problem.parts, [*problem.own]
    else:
        parts, own = {"": problem}, []
    if held_out == "files" and own:
        raise ConfigurationError(
            f"study.own has {', '.join(own)}, which no other file determines; leave it out."
        )
    labels, folds = list[str](), list[NDArray[np.int64]]()
    for label, part in parts.items():
        count, names = 1, [label]
        fold = np.zeros(sum(item.size for item in part.data.values()), np.int64)
        if held_out == "cycles":
            if not isinstance(part, PathProblem):
                raise ConfigurationError(
                    f"study.held_out is cycles and {label or 'data'} is no path; it must be."
                )
            each = cycles(part.measured.path["slip"])
            fold, count = np.tile(each, len(part.data)), int(each.max()) + 1
            names = [f"{label} cycle {i + 1}".strip() for i in range(count)]
        folds.append(fold + len(labels))
        labels += names
    if len(labels) < 2:
        kind = "file" if held_out == "files" else "cycle"
        raise ConfigurationError(f"study.held_out is {held_out} and there is one {kind}; there must be two.")
    return Folds(labels, np.concatenate(folds))


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
    misfits, values = list[Array](), list[Array]()
    for number in range(len(folds.labels)):
        here = folds.fold == number

        def of_others(values: Array, here: NDArray[np.bool_] = here) -> Array:
            return problem.residuals(values)[~here]

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
