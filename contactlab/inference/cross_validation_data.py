"""The dataset of a study: what every law predicts of impacts it has not seen, its parameters, who beats whom.

| variable | dims | |
|---|---|---|
| error | law, impact | ||v+ - v+_predicted|| / ||v-|| in the norm of the kinetic energy |
| predicted_velocity | law, impact, direction | gap rate and slip [m/s] |
| prediction_error, prediction_error_interval | law (, end) | mean of the errors, 95 % interval |
| kind, group, unanswered, fitted_on, held, unmoved, cannot_tell, at_end | law | |
| value, range, units | law, fold_number, parameter | of the fit without that fold; NaN for no such number |
| difference, difference_interval | law, other (, end) | of the mean errors, law less other, by pairs |
| velocity_before, velocity_after, fold, noise_bound, unexplained | impact | as measured; see `unexplained` |

Laws are in the order of their errors, those of the kinds rigid and compliant first; then baselines, floors.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray
from numpy.typing import NDArray

from contactlab.inference.bootstrap import LEVEL, RESAMPLES, Resampled, resampled
from contactlab.inference.outcome import BASELINE, COMPLIANT, END, FLOOR, RIGID, digest_of
from contactlab.inference.ranking import groups_of, sentences
from contactlab.inference.unexplained import noise_of, unexplained
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.measured.repeats import copies_warning
from contactlab.results.provenance import checkout_state, code_digest, versions

JUDGED = (RIGID, COMPLIANT)
_TEXTS = ("cannot_tell", "at_end")


def assembled(
    outcomes: Sequence[xarray.Dataset],
    floors: Sequence[xarray.Dataset],
    impacts: MeasuredImpacts,
    fold: NDArray[np.int64],
    seed: int,
) -> xarray.Dataset:
    """Put the outcomes of models and the floors together, weighed against each other."""
    ordered = sorted(outcomes, key=lambda one: (one.attrs["kind"] == BASELINE, float(one["error"].mean())))
    every = [*ordered, *sorted(floors, key=lambda one: -float(one["error"].mean()))]
    labels = [one.attrs["label"] for one in every]
    table = resampled(np.column_stack([one["error"].values for one in every]), seed)
    data = xarray.Dataset(coords={"law": labels, "end": [*END], "direction": ["normal", "tangential"]})
    data["error"] = (
        ("law", "impact"),
        table.values.T,
        {"units": "1", "long_name": "held-out prediction error"},
    )
    predicted = np.stack([one["predicted_velocity"].values for one in every])
    data["predicted_velocity"] = ("law", "impact", "direction"), predicted, {"units": "m s-1"}
    data["prediction_error"] = "law", table.mean(), {"units": "1", "long_name": "mean held-out error"}
    intervals = [table.interval(at) for at in range(len(every))]
    data["prediction_error_interval"] = ("law", "end"), np.array(intervals), {"units": "1"}
    for name in ("kind", "held", "unmoved", "unanswered"):
        data[name] = "law", [one.attrs[name] for one in every]
    data["fitted_on"] = "law", [int(one["fitted_on"].min()) if "fitted_on" in one else 0 for one in every]
    for name in _TEXTS:
        data[name] = "law", [_united(one[name].values) if name in one else "" for one in every]
    _add_parameters(data, every)
    _add_differences(data, table)
    judged = sum(one.attrs["kind"] in JUDGED for one in every)
    among = Resampled(table.values[:, :judged], table.means[:, :judged])
    groups = groups_of(among, labels[:judged])
    group = {at: number for number, members in enumerate(groups, 1) for at in members}
    data["group"] = "law", [group.get(at, 0) for at in range(len(every))]
    _add_impacts(data, impacts, fold, judged)
    data.attrs |= _attributes(impacts, int(fold.max()) + 1, seed)
    data.attrs["order"] = "\n".join(sentences(among, labels[:judged]))
    return data


def laws_in(data: xarray.Dataset) -> xarray.Dataset:
    """Give the part of a dataset that is of laws, without baselines and floors."""
    return data.isel(law=np.isin(data["kind"].values, JUDGED))


def floors_in(data: xarray.Dataset) -> xarray.Dataset:
    """Give the part of a dataset that is of floors."""
    return data.isel(law=data["kind"].values == FLOOR)


def _united(texts: NDArray[Any]) -> str:
    """Give the names that any fold has, in their order."""
    return ", ".join(dict.fromkeys(name for text in texts for name in str(text).split(", ") if name))


def _add_parameters(data: xarray.Dataset, every: Sequence[xarray.Dataset]) -> None:
    """Add what was fitted, of all laws over the names that any of them has."""
    names = [*dict.fromkeys(str(name) for one in every if "value" in one for name in one["parameter"].values)]
    folds = max(one.sizes.get("fold", 0) for one in every)
    values = np.full((len(every), folds, len(names)), np.nan)
    ranges = np.full((len(every), len(names), 2), np.nan)
    units = np.full((len(every), len(names)), "", dtype=object)
    for at, one in enumerate(every):
        if "value" in one and one.sizes["parameter"]:
            places = [names.index(str(name)) for name in one["parameter"].values]
            values[at][:, places] = one["value"].values
            ranges[at, places], units[at, places] = one["range"].values, one["units"].values
    data.coords["parameter"] = np.array(names, dtype=object)
    data["value"] = ("law", "fold_number", "parameter"), values
    data["range"] = ("law", "parameter", "end"), ranges
    data["units"] = ("law", "parameter"), units


def _add_differences(data: xarray.Dataset, table: Resampled) -> None:
    count = table.values.shape[1]
    found = np.array([[table.difference(i, j) for j in range(count)] for i in range(count)])
    data.coords["other"] = data["law"].values
    data["difference"] = ("law", "other"), found[..., 0], {"units": "1"}
    data["difference_interval"] = ("law", "other", "end"), found[..., 1:], {"units": "1"}


def _add_impacts(
    data: xarray.Dataset, impacts: MeasuredImpacts, fold: NDArray[np.int64], judged: int
) -> None:
    """Add what is of the impacts, whatever the law."""
    data.coords["impact"] = "impact", impacts.number, {"long_name": "number in the file"}
    for name in ("velocity_before", "velocity_after"):
        data[name] = ("impact", "direction"), getattr(impacts, name), {"units": "m s-1"}
    data["fold"] = "impact", fold
    noise = noise_of(impacts)
    data["noise_bound"] = "impact", noise.bound, {"units": "1", "long_name": "error that noise may make"}
    errors = data["error"].values[:judged]
    data["unexplained"] = "impact", unexplained(errors, noise).astype(np.int8)
    data.attrs["noise"] = noise.words


def _attributes(impacts: MeasuredImpacts, folds: int, seed: int) -> dict[str, object]:
    revision, dirty = checkout_state()
    return {
        "title": f"Contact laws against: {impacts.title}",
        "source": impacts.source,
        "licence": impacts.licence,
        "data_digest": digest_of(impacts),
        "data_notes": "\n".join(impacts.notes),
        "left_out": impacts.left_out,
        "copies": copies_warning(impacts),
        "folds": folds,
        "seed": seed,
        "resamples": RESAMPLES,
        "interval_level": LEVEL,
        **versions(),
        "code_digest": code_digest(),
        "git_revision": revision,
        "git_dirty": dirty,
    }
