"""What became of one model: its predictions of impacts it has not seen, and its parameters, as a dataset."""

from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path
from typing import Final

import numpy as np
import xarray

from contactlab.arrays import Array
from contactlab.inference.models import LawModel, Model
from contactlab.inference.prediction import Held, errors_of
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.results.files import whole_netcdf
from contactlab.results.provenance import code_digest

RIGID: Final = "rigid"
COMPLIANT: Final = "compliant"
BASELINE: Final = "baseline"
FLOOR: Final = "floor"
"""Kinds of what predicts; the last has seen what it is judged by."""

END: Final = ("low", "high")


def digest_of(impacts: MeasuredImpacts) -> str:
    """Give the digest of the numbers of measured impacts, 64 hexadecimal digits."""
    said = sha256()
    arrays = (impacts.delassus, impacts.velocity_before, impacts.velocity_after, impacts.kinetic_energy)
    for array in (*arrays, impacts.outside, impacts.covariance, impacts.number):
        said.update(b"none" if array is None else np.ascontiguousarray(array).tobytes())
    if impacts.measurement is not None:
        said.update(b"measurement" + impacts.measurement.astype(np.int64).tobytes())
    return said.hexdigest()


def key_of(model: Model, impacts: MeasuredImpacts, folds: int, seed: int) -> str:
    """Give the digest of all that an outcome depends on, 16 hexadecimal digits."""
    settings = (folds, seed, digest_of(impacts), code_digest())
    return sha256(repr((model, settings)).encode()).hexdigest()[:16]


def kind_of(model: Model) -> str:
    """Give the kind of a model; the frictionless law is none of those that are judged."""
    if not isinstance(model, LawModel) or model.baseline:
        return BASELINE
    return COMPLIANT if model.costly else RIGID


def outcome_of(
    model: Model, impacts: MeasuredImpacts, held: Sequence[Held], unmoved: Sequence[str]
) -> xarray.Dataset:
    """Put the folds of one model together.

    Args:
        model: that was fitted.
        impacts: all of them.
        held: of each fold.
        unmoved: names of numbers that change nothing and are therefore not free.
    """
    predicted, error = errors_of(held, impacts)
    names = [one.name for one in model.free]
    units = [one.parameter.units for one in model.free]
    fits = [one.fit for one in held]
    values = np.array([fit.values for fit in fits]).reshape(len(fits), len(names))
    doubts = [", ".join(fit.cannot_tell) for fit in fits]
    data = xarray.Dataset(
        {
            "error": ("impact", error),
            "predicted_velocity": (("impact", "direction"), predicted),
            "value": (("fold", "parameter"), values),
            "range": (
                ("parameter", "end"),
                np.array([(one.low, one.high) for one in model.free]).reshape(-1, 2),
            ),
            "units": ("parameter", np.array(units, dtype=object)),
            "hits": ("fold", np.array([fit.hits for fit in fits])),
            "fitted_on": ("fold", np.array([one.fitted_on for one in held])),
            "cannot_tell": ("fold", np.array(doubts, dtype=object)),
            "at_end": ("fold", np.array([", ".join(fit.at_end) for fit in fits], dtype=object)),
        },
        coords={"parameter": np.array(names, dtype=object)},
    )
    data.attrs = {
        "label": model.label,
        "kind": kind_of(model),
        "unanswered": sum(one.unanswered for one in held),
        "unmoved": ", ".join(unmoved),
        "held": ", ".join(f"{name} {value:.6g}" for name, value in model.held().items()),
    }
    return data


def floor(label: str, impacts: MeasuredImpacts, predicted: Array) -> xarray.Dataset:
    """Give the outcome of an impulse that is the best for each impact, with what is measured known."""
    data = {
        "error": ("impact", impacts.errors(predicted)),
        "predicted_velocity": (("impact", "direction"), predicted),
    }
    attributes = {"label": label, "kind": FLOOR, "unanswered": 0, "unmoved": "", "held": ""}
    return xarray.Dataset(data, attrs=attributes)


def write(outcome: xarray.Dataset, path: Path) -> None:
    """Write an outcome, whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_netcdf(path) as partial:
        outcome.to_netcdf(partial, engine="netcdf4")


def read(path: Path) -> xarray.Dataset | None:
    """Read an outcome, or give None where there is none."""
    if not path.is_file():
        return None
    with xarray.open_dataset(path) as data:
        return data.load()
