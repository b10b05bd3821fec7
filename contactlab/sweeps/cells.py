"""Many runs as one dataset: parameters as coordinates, metrics as variables, a code where one is missing."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

import numpy as np
import xarray
from numpy.typing import NDArray

from contactlab.config.nesting import Value
from contactlab.metrics import METRICS
from contactlab.results.files import whole_netcdf
from contactlab.sweeps.status import Status

Array = NDArray[np.float64]

STATUS: Final = "status"
REASON: Final = "reason"

REASONS: Final = {
    Status.COMPLETE: "",
    Status.UNFINISHED: "The run began and has not ended: it was killed, or it is still running.",
    Status.ABSENT: "The run has not begun.",
}
"""Reasons that need no run to tell them."""


@final
@dataclass(frozen=True)
class Axis:
    """A parameter that differs from run to run.

    Args:
        name: key or group of the configuration, 'contact.clearance' or 'law'.
        values: numbers in SI, or names of options.
        units: in the words of the CF conventions; empty for names and where it is not known.
    """

    name: str
    values: tuple[Value, ...]
    units: str = ""

    @property
    def coordinate(self) -> NDArray[Any]:
        """The values as an array of numbers or texts."""
        if any(isinstance(value, str | bool) for value in self.values):
            return np.array([_text(value) for value in self.values])
        return np.asarray(self.values, dtype=np.float64)


def dataset_of(
    axes: Sequence[Axis],
    metrics: Mapping[str, Array],
    status: NDArray[np.int8],
    reason: NDArray[Any],
    attributes: Mapping[str, Any],
    dims: Sequence[str] | None = None,
) -> xarray.Dataset:
    """One dataset of many runs.

    Args:
        axes: the parameters; their values are the coordinates.
        metrics: keys of `contactlab.metrics.METRICS`, each with an array; NaN where a run has none.
        status: codes of `Status`.
        reason: a sentence where a run is not complete, else empty.
        attributes: of the dataset.
        dims: dimensions of all arrays; without, one for each axis, in their order.

    Returns:
        The dataset. Where `dims` is one dimension, every axis is a coordinate along it.
    """
    along = tuple(axis.name for axis in axes) if dims is None else tuple(dims)
    coordinates = {
        axis.name: (
            (axis.name,) if dims is None else along,
            axis.coordinate,
            {"units": axis.units} if axis.units else {},
        )
        for axis in axes
    }
    variables: dict[str, Any] = {
        key: (along, values, _said(key)) for key, values in metrics.items()
    }
    flags = {
        "long_name": "what became of the run",
        "flag_values": np.array([code.value for code in Status], dtype=np.int8),
        "flag_meanings": " ".join(code.name.lower() for code in Status),
    }
    variables[STATUS] = (along, status.astype(np.int8), flags)
    variables[REASON] = (along, reason.astype(object), {"long_name": "why a run has no numbers"})
    return xarray.Dataset(variables, coordinates, dict(attributes))


def counts_of(status: NDArray[np.int8]) -> dict[str, int]:
    """Attributes that tell how many runs there are, and how many of each status."""
    counted = {f"runs_{code.name.lower()}": int((status == code).sum()) for code in Status}
    return {"runs": int(status.size), **counted}


def write(dataset: xarray.Dataset, path: Path, more: Callable[[Path], None] | None = None) -> None:
    """Write a dataset of many runs, whole or not at all; the same dataset gives the same bytes.

    Args:
        dataset: as `dataset_of` gives it.
        path: the file, in a folder that exists.
        more: adds to the file before it takes its name.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    packed = {"zlib": True, "complevel": 1, "shuffle": True}
    encoding = {
        name: packed
        for name, variable in dataset.data_vars.items()
        if variable.dtype.kind in "fi" and variable.size
    }
    with whole_netcdf(path) as partial:
        dataset.to_netcdf(partial, format="NETCDF4", engine="netcdf4", encoding=encoding)
        if more is not None:
            more(partial)


def _text(value: Value) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _said(key: str) -> dict[str, str]:
    metric = METRICS[key]
    return {"units": metric.units, "symbol": metric.symbol, "long_name": metric.meaning}
