"""Cross-validation of laws by measured impacts: every impact is predicted by a fit that has not seen it.

A law is fitted by the least sum of errors, since the mean error is what assesses it; an outlier therefore has
no more weight than its error.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from hashlib import sha256
from typing import Any, Final

import numpy as np
import xarray
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.inference.candidates import without_idle
from contactlab.inference.impact_problem import (
    ConstantImpulse,
    ImpactPredictor,
    ImpactProblem,
    LawPredictor,
    frictionless,
)
from contactlab.inference.least_squares import Optimum, best_fit
from contactlab.measured.floors import best_admissible_impulses, best_impulses, velocities_after
from contactlab.measured.impacts import MeasuredImpacts

FOLDS: Final = 5

STARTS: Final = 16
INTEGRATED_STARTS: Final = 8
"""Starts of a fit; those under a law that integrates every impact."""

LOOKS: Final = 2
"""Candidate points for each start. Where most lie on a plateau, more starts from fewer find more optima."""

ACCURACY: Final = 1e-5
ROUGH: Final = 1e-2
INTEGRATED_ACCURACY: Final = 1e-3
"""Relative change of the loss at which a search ends; of integrated impacts, whose error is larger, first
that of all starts and then that of the best."""

SEARCH: Final = 100
SUBSET: Final = 400
"""Impacts on which the optimum of an integrated law is searched for, and on which it is fitted then: with so
many the law loses less than a thousandth."""

RIGID: Final = "rigid"
COMPLIANT: Final = "compliant"
BASELINE: Final = "baseline"
FLOOR: Final = "floor"
"""Kinds of predictions; a floor has seen what it predicts."""


class ValidationError(ValueError):
    """Laws cannot be validated by these impacts."""


def folds_of(measurement: NDArray[np.int64], folds: int, seed: int) -> NDArray[np.int64]:
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


def least_error_fit(problem: ImpactProblem, seed: int) -> Optimum:
    """Fit a predictor by the least sum of errors.

    The optimum of an integrated law is searched for with the first `SEARCH` of the impacts.

    Raises:
        ValueError: there is a prediction at none of the starts.
    """
    free, step = problem.parameters, problem.step
    if not problem.predictor.integrated:
        return best_fit(
            problem.error_residuals, free, STARTS, seed, looks=LOOKS, step=step, accuracy=ACCURACY
        )
    few = problem.part(np.arange(min(SEARCH, len(problem.measured))))
    rough = best_fit(
        few.error_residuals, free, INTEGRATED_STARTS, seed, looks=LOOKS, step=step, accuracy=ROUGH
    )
    best = rough
    for part in (few, problem):
        best = best_fit(
            part.error_residuals, free, 1, seed,
            looks=1, step=step, accuracy=INTEGRATED_ACCURACY, begin=best.values,
        )  # fmt: skip
    return replace(best, hits=rough.hits)


def predictors_of(
    impacts: MeasuredImpacts, laws: Sequence[LawPredictor], folds: int
) -> list[ImpactPredictor]:
    """Return laws and baselines; numbers that have no effect on the impacts are fixed.

    Raises:
        ValidationError: there are too few impacts or folds, no law, or two laws of one label.
    """
    if folds < 2:
        raise ValidationError(f"folds is {folds}; it must be at least 2.")
    if not laws:
        raise ValidationError("There is no law; at least one must be chosen.")
    every: list[ImpactPredictor] = [*(without_idle(item, impacts) for item in (*laws, frictionless()))]
    every.append(ConstantImpulse.of(impacts))
    labels = [item.label for item in every]
    if twice := sorted({label for label in labels if labels.count(label) > 1}):
        raise ValidationError(f"{', '.join(twice)} occurs twice; the laws must differ.")
    most = max(every, key=lambda item: len(item.free))
    least = folds * max(len(most.free), 1)
    count = int(impacts.measurements().max(initial=-1)) + 1
    if count < least:
        kind = "impacts" if count == len(impacts) else f"different measurements among {len(impacts)} impacts"
        raise ValidationError(
            f"There are {count} {kind}; {folds} folds and the {len(most.free)} free parameters of "
            f"{most.label} need at least {least}. Measure more, fix parameters by law.NAME=VALUE, or take "
            "fewer folds."
        )
    return every


def cross_validated(
    predictor: ImpactPredictor, impacts: MeasuredImpacts, folds: int, seed: int
) -> xarray.Dataset:
    """Return what a law predicts of impacts to which it was not fitted, and its parameters by fold.

    An integrated law is fitted to `SUBSET` of the impacts of the other folds, drawn by the seed.

    Raises:
        ValueError: there is a prediction at none of the starts.
    """
    problem = ImpactProblem(impacts, predictor)
    fold = folds_of(impacts.measurements(), folds, seed)
    predicted = np.full_like(impacts.velocity_before, np.nan)
    fits, sizes, lost = list[Optimum](), list[int](), 0
    for number in range(int(fold.max()) + 1):
        fold_impacts, others = np.flatnonzero(fold == number), np.flatnonzero(fold != number)
        if predictor.integrated:
            others = np.random.default_rng([seed, number]).permutation(others)[:SUBSET]
        fits.append(least_error_fit(problem.part(others), seed))
        sizes.append(others.size)
        after = problem.part(fold_impacts).velocities_after(fits[-1].values)
        missing = np.asarray(np.isnan(after).any(axis=1))
        lost += int(missing.sum())
        predicted[fold_impacts] = np.where(missing[:, None], impacts.velocity_before[fold_impacts], after)
    free = predictor.free
    data = _predictions(
        impacts,
        predicted,
        predictor.label,
        kind_of(predictor),
        unanswered=lost,
        unmoved=", ".join(predictor.idle),
        held=", ".join(f"{name} {value:.6g}" for name, value in predictor.fixed.items()),
    )
    return data.assign(
        value=(("fold", "parameter"), np.array([fit.values for fit in fits]).reshape(len(fits), len(free))),
        range=(("parameter", "end"), np.array([(item.low, item.high) for item in free]).reshape(-1, 2)),
        units=("parameter", _texts(item.parameter.units for item in free)),
        hits=("fold", np.array([fit.hits for fit in fits])),
        fitted_on=("fold", np.array(sizes)),
        undetermined=("fold", _texts(", ".join(fit.undetermined) for fit in fits)),
        at_end=("fold", _texts(", ".join(fit.at_end) for fit in fits)),
    ).assign_coords(parameter=_texts(item.name for item in free))


def floors_of(impacts: MeasuredImpacts) -> list[xarray.Dataset]:
    """Return the errors of the best impulse of each impact, admissible or any: no law can be better."""
    best = {
        "best admissible impulse": best_admissible_impulses(impacts),
        "best impulse": best_impulses(impacts),
    }
    return [
        _predictions(impacts, velocities_after(impacts, impulse), label, FLOOR)
        for label, impulse in best.items()
    ]


def kind_of(predictor: ImpactPredictor) -> str:
    """Return "rigid", "compliant" or "baseline"."""
    if predictor.baseline:
        return BASELINE
    return COMPLIANT if predictor.integrated else RIGID


def digest_of(impacts: MeasuredImpacts) -> str:
    """Return the digest of the numbers of measured impacts, 64 hexadecimal digits."""
    digest = sha256()
    arrays = (impacts.delassus, impacts.velocity_before, impacts.velocity_after, impacts.kinetic_energy)
    for array in (*arrays, impacts.outside, impacts.covariance, impacts.number):
        digest.update(b"none" if array is None else np.ascontiguousarray(array).tobytes())
    if impacts.measurement is not None:
        digest.update(b"measurement" + impacts.measurement.astype(np.int64).tobytes())
    return digest.hexdigest()


def _predictions(
    impacts: MeasuredImpacts, predicted: Array, label: str, kind: str, **attributes: Any
) -> xarray.Dataset:
    """Return predictions with their errors."""
    return xarray.Dataset(
        {
            "error": ("impact", impacts.errors(predicted)),
            "predicted_velocity": (("impact", "direction"), predicted),
        },
        attrs={"label": label, "kind": kind, "unanswered": 0, "unmoved": "", "held": "", **attributes},
    )


def _texts(texts: Iterable[str]) -> NDArray[Any]:
    return np.array([*texts], dtype=object)
