"""Fitted on one part of the impacts, judged on another: what a model predicts of impacts it has not seen."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypedDict, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.inference.least_squares import Fit, best_fit
from contactlab.inference.models import Model
from contactlab.measured.impacts import MeasuredImpacts

SMOOTH: Final = 0.01
"""Error [1] below which the loss is a parabola and above which it is the error itself: less than any camera
sees, so that what is fitted is what is judged."""

STARTS: Final = 16
COSTLY_STARTS: Final = 8
"""Starts of a fit; those of a law that integrates every impact."""

LOOKED: Final = 2
"""Points that are looked at for each of them. Where most are on a plateau, as of contacts that all stick, the
best of many are there too, and more starts from fewer points find more valleys."""

ACCURACY: Final = 1e-5
ROUGH: Final = 1e-2
COSTLY_ACCURACY: Final = 1e-3
"""Relative change of the loss at which a start has ended: of a law that is integrated, whose error is larger,
first of all starts and then of the best alone."""

SEARCH: Final = 100
SUBSET: Final = 400
"""Impacts among which the optimum of a costly law is searched for, and those on which it is fitted then: with
so many its parameters are known well enough that a law loses less than a thousandth by it."""


class _Settings(TypedDict):
    looks: int
    step: float | None
    accuracy: float


@final
@dataclass(frozen=True, eq=False)
class Held:
    """What a model, fitted without a fold, predicts of that fold.

    Args:
        places: of the impacts of the fold among all, shape (held,).
        predicted: gap rate and slip after them [m/s], shape (held, 2); where the model has no answer, those
            before them.
        unanswered: for how many it has none.
        fit: of the parameters, on the other folds.
        fitted_on: how many impacts.
    """

    places: NDArray[np.int64]
    predicted: Array
    unanswered: int
    fit: Fit
    fitted_on: int


def held_out(model: Model, impacts: MeasuredImpacts, fold: NDArray[np.int64], number: int, seed: int) -> Held:
    """Fit a model on all folds but one and predict that one.

    A costly model is fitted on `SUBSET` of the impacts of the other folds, drawn by the seed.

    Raises:
        ValueError: the model has an answer at none of the starts; a sentence.
    """
    places, others = np.flatnonzero(fold == number), np.flatnonzero(fold != number)
    if model.costly:
        others = np.random.default_rng([seed, number]).permutation(others)[:SUBSET]
    fit = fitted(model, impacts.part(others), seed)
    here = impacts.part(places)
    predicted = model.after(fit.values, here)
    lost = np.asarray(np.isnan(predicted).any(axis=1))
    predicted = np.where(lost[:, None], here.velocity_before, predicted)
    return Held(places, predicted, int(lost.sum()), fit, others.size)


def fitted(model: Model, impacts: MeasuredImpacts, seed: int) -> Fit:
    """Fit a model to impacts: the least sum of their errors.

    The mean of the errors is what judges, so it is what is fitted, not that of their squares; it also gives
    an outlier no more weight than its error. Its kink at zero is smoothed, see `residuals`. The optimum of a
    costly model is searched for with the first `SEARCH` of the impacts.
    """
    if not model.costly:
        plain = _Settings(looks=LOOKED, step=model.step, accuracy=ACCURACY)
        return best_fit(_residuals_of(model, impacts), model.free, STARTS, seed, **plain)
    rough = _Settings(looks=LOOKED, step=model.step, accuracy=ROUGH)
    few = impacts.part(np.arange(min(SEARCH, len(impacts))))
    found = best_fit(_residuals_of(model, few), model.free, COSTLY_STARTS, seed, **rough)
    best = found
    for part in (few, impacts):
        fine = _Settings(looks=1, step=model.step, accuracy=COSTLY_ACCURACY)
        best = best_fit(_residuals_of(model, part), model.free, 1, seed, begin=best.values, **fine)
    return replace(best, hits=found.hits)


def _residuals_of(model: Model, impacts: MeasuredImpacts) -> Callable[[Array], Array]:
    return lambda values: residuals(impacts, model.after(values, impacts))


def residuals(impacts: MeasuredImpacts, predicted: Array) -> Array:
    """Give residuals whose squares add up to the sum of the errors, shape (3 impacts,).

        f = w/(w'w + c^2)^(1/4),  f'f = e^2/sqrt(e^2 + c^2)

    of the error e of `MeasuredImpacts.errors`, with w'w = e^2 and c = `SMOOTH`. The third part of w is that
    which no impulse reaches. A prediction that is NaN counts as no motion changed.
    """
    predicted = np.where(np.isfinite(predicted), predicted, impacts.velocity_before)
    root = np.linalg.cholesky(impacts.delassus)
    missed = np.linalg.solve(root, (impacts.velocity_after - predicted)[..., None])[..., 0]
    whole = np.column_stack([missed, np.sqrt(2.0 * impacts.outside)])
    whole /= np.sqrt(2.0 * impacts.kinetic_energy)[:, None]
    square = np.einsum("ni,ni->n", whole, whole)
    return np.asarray((whole / (square + SMOOTH**2)[:, None] ** 0.25).ravel())


def errors_of(held: Sequence[Held], impacts: MeasuredImpacts) -> tuple[Array, Array]:
    """Put the folds together: predicted velocities, shape (impact, 2), and errors, shape (impact,)."""
    predicted = np.full_like(impacts.velocity_before, np.nan)
    for one in held:
        predicted[one.places] = one.predicted
    return predicted, impacts.errors(predicted)
