"""Cross-validation of laws by measured impacts: every impact is predicted by a fit that has not seen it.

A law is fitted by the least sum of errors, since the mean error is what assesses it; an outlier therefore has
no more weight than its error. The assessment of several laws has these variables:

| variable | dims | |
|---|---|---|
| error | law, impact | ||v+ - v+_predicted|| / ||v-|| in the norm of the kinetic energy |
| predicted_velocity | law, impact, direction | gap rate and slip [m/s] |
| prediction_error, prediction_error_interval | law (, end) | mean of the errors, 95 % interval |
| kind, group, unanswered, fitted_on, held, unmoved, at_end | law | |
| value, range, units | law, fold_number, parameter | of the fit without that fold; NaN for no such number |
| interval, remark | law, parameter (, end) | by all impacts, 90 %, and what limits it: `determination` |
| difference, difference_interval | law, other (, end) | of the mean errors, law less other, by pairs |
| p_value | law, other | of equal errors, corrected for the number of pairs by Holm's procedure |
| velocity_before, velocity_after, fold, noise_bound, unexplained | impact | as measured; see `noise_of` |

Laws are in the order of their errors, those of the kinds rigid and compliant first; then baselines, floors.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from math import log
from typing import Any, Final, NamedTuple

import numpy as np
import xarray
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from contactlab.arrays import Array
from contactlab.progress import part_of_progress
from contactlab.studies.compare.bootstrap import LEVEL, RESAMPLES, mean_intervals, paired_differences
from contactlab.studies.compare.multiple import holm
from contactlab_data.inference.determination import Determination, determinations
from contactlab_data.inference.free_parameters import FreeParameter
from contactlab_data.inference.held_out import FOLDS as FOLDS, folds_of_measurements
from contactlab_data.inference.impact_problem import (
    ConstantImpulse,
    ImpactPredictor,
    ImpactProblem,
    LawPredictor,
    frictionless,
)
from contactlab_data.inference.influence import without_idle
from contactlab_data.inference.least_squares import Optimum, best_fit
from contactlab_data.inference.maximum_likelihood import maximum_likelihood
from contactlab_data.measured.floors import best_admissible_impulses, best_impulses, velocities_after
from contactlab_data.measured.impacts import MeasuredImpacts, noise_from_outside

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

ASSESSED: Final = (RIGID, COMPLIANT)
"""Kinds of laws, in contrast to baselines and floors."""

SAME: Final = 1e-6
"""Difference of two errors within the accuracy of the fits."""

RARE: Final = 0.01
"""Share of the impacts whose error exceeds the bound by noise alone."""

CHI_SQUARE: Final = -2.0 * log(RARE)
"""Quantile of a chi-square distribution of two degrees of freedom that is exceeded so rarely."""

PLANAR: Final = 3
"""Coordinates of a body in the plane, which impacts without coordinates are taken for."""


class ValidationError(ValueError):
    """Laws cannot be validated by these impacts."""


def least_error_fit(problem: ImpactProblem, seed: int) -> Optimum:
    """Fit a predictor by the least sum of errors.

    The optimum of an integrated law is searched for with the first `SEARCH` of the impacts.

    Raises:
        ValueError: there is a prediction at none of the starts.
    """
    search = partial(best_fit, free=problem.parameters, seed=seed, step=problem.step)
    if not problem.predictor.integrated:
        return search(problem.error_residuals, starts=STARTS, looks=LOOKS, accuracy=ACCURACY)
    few = problem.part(np.arange(min(SEARCH, len(problem.measured))))
    best = rough = search(few.error_residuals, starts=INTEGRATED_STARTS, looks=LOOKS, accuracy=ROUGH)
    for part in (few, problem):
        accuracy, begin = INTEGRATED_ACCURACY, best.values
        best = search(part.error_residuals, starts=1, looks=1, accuracy=accuracy, begin=begin)
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
    every: list[ImpactPredictor] = [without_idle(item, impacts) for item in (*laws, frictionless())]
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
    predictor: ImpactPredictor,
    impacts: MeasuredImpacts,
    folds: int,
    seed: int,
    corrections: tuple[FreeParameter, ...] = (),
) -> xarray.Dataset:
    """Return what a law predicts of impacts to which it was not fitted, and its parameters by fold.

    An integrated law is fitted to `SUBSET` of the impacts of the other folds, drawn by the seed. Free numbers
    of the data are fitted with those of the law.

    Raises:
        ValueError: there is a prediction at none of the starts.
    """
    problem = ImpactProblem(impacts, predictor, corrections=corrections)
    fold = folds_of_measurements(impacts.measurements(), folds, seed)
    predicted, outside = np.full_like(impacts.velocity_before, np.nan), np.zeros(len(impacts))
    fits, sizes, lost = list[Optimum](), list[int](), 0
    count = int(fold.max()) + 1
    for number in range(count):
        fold_impacts, others = np.flatnonzero(fold == number), np.flatnonzero(fold != number)
        if predictor.integrated:
            others = np.random.default_rng([seed, number]).permutation(others)[:SUBSET]
        text = f"{predictor.label}, fold {number + 1} of {count}: "
        with part_of_progress(0.9 * number / count, 0.9 * (number + 1) / count, text):
            fits.append(least_error_fit(problem.part(others), seed))
        sizes.append(others.size)
        after, outside[fold_impacts] = problem.part(fold_impacts).prediction(fits[-1].values)
        missing = np.asarray(np.isnan(after).any(axis=1))
        lost += int(missing.sum())
        predicted[fold_impacts] = np.where(missing[:, None], impacts.velocity_before[fold_impacts], after)
    free, kind = problem.parameters, COMPLIANT if predictor.integrated else RIGID
    with part_of_progress(0.9, 1.0, f"{predictor.label}, all impacts: "):
        every = determined_by_all(problem, [fit.values for fit in fits], seed)
    data = _predictions(
        impacts,
        predicted,
        outside,
        label=predictor.label,
        kind=BASELINE if predictor.baseline else kind,
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
        interval=(("parameter", "end"), np.array([item.interval for item in every]).reshape(-1, 2)),
        remark=("parameter", _texts(item.remark for item in every)),
        at_end=("fold", _texts(", ".join(fit.at_end) for fit in fits)),
    ).assign_coords(parameter=_texts(item.name for item in free))


def determined_by_all(problem: ImpactProblem, begins: Sequence[Array], seed: int) -> list[Determination]:
    """Return what all impacts say of the numbers of a law, as a fit does, from the best of some values.

    Those of an integrated law are of `SUBSET` of the impacts, drawn by the seed.
    """
    if problem.predictor.integrated:
        drawn = np.random.default_rng(seed).permutation(len(problem.measured))[:SUBSET]
        problem = problem.part(np.sort(drawn))
    problem = replace(problem, discrepancy=problem.measured.covariance is None)
    costs = [float(np.sum(problem.residuals(values) ** 2)) for values in begins]
    if problem.predictor.baseline or not np.isfinite(costs).any():
        return [Determination(item, np.full(2, np.nan)) for item in problem.parameters]
    best = maximum_likelihood(problem, 1, seed, begins[int(np.nanargmin(costs))])
    return determinations(problem, best)


def _predictions(
    impacts: MeasuredImpacts, predicted: Array, outside: Array | None = None, **attributes: Any
) -> xarray.Dataset:
    """Return predictions with their errors."""
    errors, directions = impacts.errors(predicted, outside), ("impact", "direction")
    data = xarray.Dataset({"error": ("impact", errors), "predicted_velocity": (directions, predicted)})
    return data.assign_attrs({"unanswered": 0, "unmoved": "", "held": "", **attributes})


def _texts(texts: Iterable[str]) -> NDArray[Any]:
    return np.array([*texts], dtype=object)


def assessed(
    outcomes: Sequence[xarray.Dataset], impacts: MeasuredImpacts, folds: int, seed: int, block: int = 1
) -> xarray.Dataset:
    """Combine the cross-validation of several laws and baselines with the floors.

    Rows that are resampled together are impacts of one measurement, or `block` impacts in a row.
    """
    ordered = sorted(outcomes, key=lambda item: (item.attrs["kind"] == BASELINE, float(item["error"].mean())))
    # The best impulse of each impact, admissible or any: no law can be better.
    best = {"admissible impulse": best_admissible_impulses(impacts), "impulse": best_impulses(impacts)}
    floors = [
        _predictions(impacts, velocities_after(impacts, impulses), label=f"best {name}", kind=FLOOR)
        for name, impulses in best.items()
    ]
    every = [*ordered, *sorted(floors, key=lambda item: -float(item["error"].mean()))]
    labels = [item.attrs["label"] for item in every]
    errors = np.column_stack([item["error"].values for item in every])
    blocks = impacts.measurements() if block == 1 else np.arange(len(impacts)) // block
    means = mean_intervals(errors, seed, blocks=blocks)
    data = xarray.Dataset(
        coords={"law": labels, "end": ["low", "high"], "direction": ["normal", "tangential"]}
    )
    data["error"] = ("law", "impact"), errors.T, {"units": "1", "long_name": "held-out prediction error"}
    predicted = np.stack([item["predicted_velocity"].values for item in every])
    data["predicted_velocity"] = ("law", "impact", "direction"), predicted, {"units": "m s-1"}
    data["prediction_error"] = "law", means.mean, {"units": "1", "long_name": "mean held-out error"}
    data["prediction_error_interval"] = ("law", "end"), means.interval, {"units": "1"}
    for name in ("kind", "held", "unmoved", "unanswered"):
        data[name] = "law", [item.attrs[name] for item in every]
    data["fitted_on"] = "law", [int(item["fitted_on"].min()) if "fitted_on" in item else 0 for item in every]
    texts = [", ".join(item["at_end"].values if "at_end" in item else []).split(", ") for item in every]
    data["at_end"] = "law", [", ".join(dict.fromkeys(filter(None, names))) for names in texts]
    _add_parameters(data, every)
    apart, intervals = paired_differences(errors, seed, blocks)
    data.coords["other"] = data["law"].values
    data["difference"] = ("law", "other"), apart, {"units": "1"}
    data["difference_interval"] = ("law", "other", "end"), intervals, {"units": "1"}
    p_values = pair_p_values(apart, intervals, data["kind"].values != FLOOR)
    data["p_value"] = ("law", "other"), p_values, {"units": "1", "long_name": "of equal errors, after Holm"}
    data["group"] = "law", _groups(data)
    data.coords["impact"] = "impact", impacts.number, {"long_name": "number in the file"}
    for name in ("velocity_before", "velocity_after"):
        data[name] = ("impact", "direction"), getattr(impacts, name), {"units": "m s-1"}
    data["fold"] = "impact", folds_of_measurements(impacts.measurements(), folds, seed)
    noise = noise_of(impacts)
    data["noise_bound"] = "impact", noise.bound, {"units": "1", "long_name": "error that noise may cause"}
    smallest = laws_in(data)["error"].values.min(axis=0)
    data["unexplained"] = "impact", (smallest > noise.bound).astype(np.int8)
    data.attrs = {
        "unexplained_by_noise": RARE * len(impacts),
        "block": block,
        "noise": noise.source,
        "title": f"Contact laws against: {impacts.title}",
        "source": impacts.source,
        "licence": impacts.licence,
        "data_digest": impacts.content_digest,
        "data_notes": "\n".join(impacts.notes),
        "left_out": impacts.left_out,
        "copies": impacts.copies_warning(),
        "folds": int(data["fold"].max()) + 1,
        "seed": seed,
        "resamples": RESAMPLES,
        "interval_level": LEVEL,
    }
    return data


def laws_in(data: xarray.Dataset) -> xarray.Dataset:
    """Return the part of a dataset that is of laws, without baselines and floors."""
    return data.isel(law=np.isin(data["kind"].values, ASSESSED))


def floors_in(data: xarray.Dataset) -> xarray.Dataset:
    """Return the part of a dataset that is of floors."""
    return data.isel(law=data["kind"].values == FLOOR)


def distinct(data: xarray.Dataset, better: str, worse: str) -> bool:
    """Return whether one law predicts better than another, corrected for the number of pairs."""
    pair = data[["difference", "p_value"]].sel(law=worse, other=better)
    return bool(pair["difference"] > SAME and pair["p_value"] <= 1.0 - LEVEL)


def pair_p_values(apart: Array, intervals: Array, tested: NDArray[np.bool_]) -> Array:
    """Return p-values of equal means for all pairs, corrected by Holm's procedure; shape (column, column).

    The standard error is that of a normal distribution with the half-width of the interval.

    Args:
        apart, intervals: of `paired_differences`.
        tested: columns whose pairs are a family of tests; others have NaN.
    """
    half = 0.5 * (intervals[..., 1] - intervals[..., 0])
    size = np.abs(apart) * -ndtri(0.5 * (1.0 - LEVEL))
    z = np.divide(size, half, out=np.where(size > 0.0, np.inf, 0.0), where=half > 0.0)
    upper = np.triu(np.outer(tested, tested), 1)
    adjusted = holm(np.where(upper, 2.0 * ndtr(-z), np.nan))
    return np.where(upper.T, adjusted.T, adjusted)


def _groups(data: xarray.Dataset) -> list[int]:
    """Return the group of each law, from 1: laws that are not distinct from the first of it; 0 for others."""
    groups, first = list[int](), ""
    for label, kind in zip(map(str, data["law"].values), data["kind"].values, strict=True):
        if kind not in ASSESSED:
            groups.append(0)
        elif not first or distinct(data, first, label):
            first = label
            groups.append(max(groups, default=0) + 1)
        else:
            groups.append(groups[-1])
    return groups


def _add_parameters(data: xarray.Dataset, every: Sequence[xarray.Dataset]) -> None:
    """Add the fitted values of all laws, over the names that any of them has."""
    fitted = {at: item for at, item in enumerate(every) if item.sizes.get("parameter")}
    names = [*dict.fromkeys(str(name) for item in fitted.values() for name in item["parameter"].values)]
    folds = max(item.sizes.get("fold", 0) for item in every)
    values = np.full((len(every), folds, len(names)), np.nan)
    ranges, intervals = np.full((2, len(every), len(names), 2), np.nan)
    units, remarks = np.full((2, len(every), len(names)), "", dtype=object)
    for at, item in fitted.items():
        places = [names.index(str(name)) for name in item["parameter"].values]
        values[at][:, places] = item["value"].values
        ranges[at, places], units[at, places] = item["range"].values, item["units"].values
        intervals[at, places], remarks[at, places] = item["interval"].values, item["remark"].values
    data.coords["parameter"] = np.array(names, dtype=object)
    data["value"] = ("law", "fold_number", "parameter"), values
    data["range"] = ("law", "parameter", "end"), ranges
    data["interval"] = ("law", "parameter", "end"), intervals
    data["units"] = ("law", "parameter"), units
    data["remark"] = ("law", "parameter"), remarks


class Noise(NamedTuple):
    """Bound on the error under the true law, shape (impact,), NaN where unknown, and where it comes from."""

    bound: Array
    source: str


def noise_of(impacts: MeasuredImpacts) -> Noise:
    """Return the error that noise alone exceeds in one of a hundred impacts.

    With the covariance C of the velocity after, the square of the error that impulses reach,
    r' D^-1 r/(2 K), is a sum of squares of normal variables whose variances are the eigenvalues of
    D^-1 C/(2 K): the larger one bounds it, as a chi-square of two. The part of the jump that no impulse
    reaches is in the bound. Without a stated covariance it is estimated from that part of all impacts, see
    `contactlab_data.measured.impacts.noise_from_outside`.
    """
    covariance, origin = impacts.covariance, "the stated covariance"
    if covariance is None:
        if not np.median(impacts.outside) > 0.0:
            unknown = "not known: the data state no covariance, and impulses reach all of the jumps"
            return Noise(np.full(len(impacts), np.nan), unknown)
        coordinates = PLANAR if impacts.bodies is None else impacts.bodies.mass.shape[1]
        covariance = noise_from_outside(impacts, coordinates)
        origin = "a covariance estimated from what no impulse reaches"
    variances = np.linalg.eigvals(np.linalg.solve(impacts.delassus, covariance)).real
    square = (2.0 * impacts.outside + CHI_SQUARE * variances.max(axis=1)) / (2.0 * impacts.kinetic_energy)
    bound = np.asarray(np.sqrt(square))
    source = f"{np.median(bound):.3f} (median), which {origin} exceeds in {RARE:.0%} of the impacts"
    return Noise(bound, source)
