"""Assessment of laws from cross-validation: errors with intervals, differences, groups, unexplained impacts.

| variable | dims | |
|---|---|---|
| error | law, impact | ||v+ - v+_predicted|| / ||v-|| in the norm of the kinetic energy |
| predicted_velocity | law, impact, direction | gap rate and slip [m/s] |
| prediction_error, prediction_error_interval | law (, end) | mean of the errors, 95 % interval |
| kind, group, unanswered, fitted_on, held, unmoved, undetermined, at_end | law | |
| value, range, units | law, fold_number, parameter | of the fit without that fold; NaN for no such number |
| difference, difference_interval | law, other (, end) | of the mean errors, law less other, by pairs |
| velocity_before, velocity_after, fold, noise_bound, unexplained | impact | as measured; see `noise_of` |

Laws are in the order of their errors, those of the kinds rigid and compliant first; then baselines, floors.
"""

from collections.abc import Sequence
from itertools import pairwise
from math import log
from typing import Final, NamedTuple

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.inference.bootstrap import LEVEL, RESAMPLES, mean_intervals, paired_differences
from contactlab.inference.cross_validation import (
    BASELINE,
    COMPLIANT,
    FLOOR,
    RIGID,
    digest_of,
    floors_of,
    folds_of,
)
from contactlab.measured.impacts import MeasuredImpacts, noise_from_outside

ASSESSED: Final = (RIGID, COMPLIANT)
"""Kinds of laws, in contrast to baselines and floors."""

PLUS_MINUS: Final = "+-"

SAME: Final = 1e-6
"""Difference of two errors within the accuracy of the fits."""

SHOWN: Final = 1e-4
"""Difference below which four decimals show nothing."""

RARE: Final = 0.01
"""Share of the impacts whose error exceeds the bound by noise alone."""

CHI_SQUARE: Final = -2.0 * log(RARE)
"""Quantile of a chi-square distribution of two degrees of freedom that is exceeded so rarely."""

PLANAR: Final = 3
"""Coordinates of a body in the plane."""

BINS: Final = 8
FEWEST: Final = 10
"""Impacts in a bin, if there are several bins."""


def assessed(
    outcomes: Sequence[xarray.Dataset], impacts: MeasuredImpacts, folds: int, seed: int
) -> xarray.Dataset:
    """Combine the cross-validation of several laws and baselines with the floors."""
    ordered = sorted(outcomes, key=lambda item: (item.attrs["kind"] == BASELINE, float(item["error"].mean())))
    every = [*ordered, *sorted(floors_of(impacts), key=lambda item: -float(item["error"].mean()))]
    labels = [item.attrs["label"] for item in every]
    errors = np.column_stack([item["error"].values for item in every])
    means = mean_intervals(errors, seed)
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
    for name in ("undetermined", "at_end"):
        texts = [", ".join(item[name].values if name in item else []).split(", ") for item in every]
        data[name] = "law", [", ".join(dict.fromkeys(filter(None, names))) for names in texts]
    _add_parameters(data, every)
    apart, intervals = paired_differences(errors, seed)
    data.coords["other"] = data["law"].values
    data["difference"] = ("law", "other"), apart, {"units": "1"}
    data["difference_interval"] = ("law", "other", "end"), intervals, {"units": "1"}
    data["group"] = "law", _groups(data)
    data.coords["impact"] = "impact", impacts.number, {"long_name": "number in the file"}
    for name in ("velocity_before", "velocity_after"):
        data[name] = ("impact", "direction"), getattr(impacts, name), {"units": "m s-1"}
    data["fold"] = "impact", folds_of(impacts.measurements(), folds, seed)
    noise = noise_of(impacts)
    data["noise_bound"] = "impact", noise.bound, {"units": "1", "long_name": "error that noise may cause"}
    smallest = laws_in(data)["error"].values.min(axis=0)
    data["unexplained"] = "impact", (smallest > noise.bound).astype(np.int8)
    data.attrs |= {
        "noise": noise.source,
        "title": f"Contact laws against: {impacts.title}",
        "source": impacts.source,
        "licence": impacts.licence,
        "data_digest": digest_of(impacts),
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
    """Return whether the interval of the difference of two errors excludes zero, and more than round-off."""
    return float(data["difference_interval"].sel(law=worse, other=better, end="low")) > SAME


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


def comparisons(data: xarray.Dataset) -> list[str]:
    """Return a sentence for each law and the next in the order of their errors, and for the baselines."""
    laws = [str(label) for label in laws_in(data)["law"].values]
    baselines = [str(label) for label in data["law"].values[data["kind"].values == BASELINE]]
    return [
        *(comparison(data, better, worse) for better, worse in pairwise(laws)),
        *(comparison(data, laws[0], baseline, "the baseline ") for baseline in baselines),
    ]


def comparison(data: xarray.Dataset, better: str, worse: str, kind: str = "") -> str:
    """Return a sentence on which of two laws predicts better and by how much."""
    apart = float(data["difference"].sel(law=worse, other=better))
    ends = data["difference_interval"].sel(law=worse, other=better).values
    largest = float(np.abs(ends).max())
    if largest < SAME:
        return f"{better} and {kind}{worse} predict the same."
    by = f"{apart:.4f} {PLUS_MINUS} {0.5 * float(ends[1] - ends[0]):.4f}"
    by = by if largest >= SHOWN else f"less than {SHOWN}"
    if not distinct(data, better, worse):
        return f"{better} and {kind}{worse} are not distinguishable: {by} apart."
    return f"{better} predicts better than {kind}{worse} by {by}."


def _add_parameters(data: xarray.Dataset, every: Sequence[xarray.Dataset]) -> None:
    """Add the fitted values of all laws, over the names that any of them has."""
    fitted = {at: item for at, item in enumerate(every) if item.sizes.get("parameter")}
    names = [*dict.fromkeys(str(name) for item in fitted.values() for name in item["parameter"].values)]
    folds = max(item.sizes.get("fold", 0) for item in every)
    values = np.full((len(every), folds, len(names)), np.nan)
    ranges = np.full((len(every), len(names), 2), np.nan)
    units = np.full((len(every), len(names)), "", dtype=object)
    for at, item in fitted.items():
        places = [names.index(str(name)) for name in item["parameter"].values]
        values[at][:, places] = item["value"].values
        ranges[at, places], units[at, places] = item["range"].values, item["units"].values
    data.coords["parameter"] = np.array(names, dtype=object)
    data["value"] = ("law", "fold_number", "parameter"), values
    data["range"] = ("law", "parameter", "end"), ranges
    data["units"] = ("law", "parameter"), units


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
    `contactlab.measured.noise`, of one body in the plane.
    """
    covariance, origin = impacts.covariance, "the stated covariance"
    if covariance is None:
        if not np.median(impacts.outside) > 0.0:
            unknown = "not known: the data state no covariance, and impulses reach all of the jumps"
            return Noise(np.full(len(impacts), np.nan), unknown)
        covariance = noise_from_outside(impacts, PLANAR)
        origin = "a covariance estimated from what no impulse reaches"
    variances = np.linalg.eigvals(np.linalg.solve(impacts.delassus, covariance)).real
    square = (2.0 * impacts.outside + CHI_SQUARE * variances.max(axis=1)) / (2.0 * impacts.kinetic_energy)
    bound = np.asarray(np.sqrt(square))
    return Noise(
        bound, f"{np.median(bound):.3f} (median), which {origin} exceeds in {RARE:.0%} of the impacts"
    )


class Binned(NamedTuple):
    """Medians and quartiles in bins of equal numbers, at the medians of the abscissa."""

    at: Array
    median: Array
    low: Array
    high: Array


def abscissas(data: xarray.Dataset) -> dict[str, Array]:
    """Return quantities of the impacts before, shape (impact,), by the label of an axis."""
    rate, slip = data["velocity_before"].values.T
    return {
        "incidence (°)": np.degrees(np.arctan2(np.abs(slip), -rate)),
        "approach velocity (m/s)": -rate,
        "slip velocity (m/s)": np.abs(slip),
    }


def residuals_of(data: xarray.Dataset, law: str) -> dict[str, Array]:
    """Return error and residuals (measured less predicted), shape (impact,), by the label of an axis.

    The residual of the slip velocity is positive along the slip before the impact.
    """
    missed = data["velocity_after"].values - data["predicted_velocity"].sel(law=law).values
    along = np.sign(data["velocity_before"].values[:, 1])
    return {
        "error": data["error"].sel(law=law).values,
        "gap rate residual (m/s)": missed[:, 0],
        "slip residual (m/s)": missed[:, 1] * along,
    }


def binned(x: Array, y: Array) -> Binned:
    """Bin one quantity by another."""
    count = int(np.clip(x.size // FEWEST, 1, BINS))
    parts = np.array_split(np.argsort(x, kind="stable"), count)
    low, median, high = np.array([np.quantile(y[part], [0.25, 0.5, 0.75]) for part in parts]).T
    return Binned(np.array([np.median(x[part]) for part in parts]), median, low, high)
