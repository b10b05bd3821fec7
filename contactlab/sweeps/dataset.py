"""Many runs as one dataset: parameters as coordinates, metrics as variables, a code where one is missing."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

import netCDF4
import numpy as np
import xarray
from numpy.typing import NDArray

from contactlab import variables
from contactlab.config.nesting import Value
from contactlab.metrics import METRICS
from contactlab.results.files import whole_netcdf
from contactlab.results.netcdf import cf_attributes
from contactlab.results.provenance import code_digest, versions
from contactlab.sweeps.state import Status
from contactlab.sweeps.values import short_names

DATASET: Final = "sweep.nc"
"""The file of a sweep, in its folder."""

RUN: Final = "run"
"""The dimension of runs that form no grid."""

GROUP: Final = "series"
"""Of the file: the time series."""

SERIES: Final = {variable.name: variable for variable in variables.SERIES}

TAKEN: Final = frozenset({*METRICS, *SERIES, "status", "reason", "job", "time", RUN})
"""Names of a dataset that no parameter can have."""

REASONS: Final = {
    Status.COMPLETE: "",
    Status.UNFINISHED: "The run began and has not ended: it was killed, or it is still running.",
    Status.ABSENT: "The run has not begun.",
}
"""Reasons that need no run to tell them."""


@final
@dataclass(frozen=True)
class Axis:
    """Holds a parameter that differs from run to run.

    Args:
        key: key or group of the configuration, 'contact.clearance' or 'law/normal'; from Python a name.
        values: numbers in SI, or names of options.
        units: in the words of the CF conventions; empty for names and where it is not known.
        long_name: what it means; empty where that is not known.
    """

    key: str
    values: tuple[Value, ...]
    units: str = ""
    long_name: str = ""

    @property
    def coordinate(self) -> NDArray[Any]:
        """The values as an array of numbers or texts."""
        if any(isinstance(value, str | bool) for value in self.values):
            return np.array([text_of(value) for value in self.values])
        return np.asarray(self.values, dtype=np.float64)

    @property
    def attributes(self) -> dict[str, str]:
        """What a dataset says of it."""
        said = {"key": self.key, "units": self.units, "long_name": self.long_name}
        return {name: text for name, text in said.items() if text}


def names_of(axes: Sequence[Axis]) -> list[str]:
    """Give the names of axes in a dataset."""
    named = short_names([axis.key for axis in axes], TAKEN)
    return [named[axis.key] for axis in axes]


def dataset_of(
    axes: Sequence[Axis],
    metrics: Mapping[str, NDArray[np.float64]],
    status: NDArray[np.int8],
    reason: NDArray[Any],
    attributes: Mapping[str, Any],
    *,
    grid: bool = True,
) -> xarray.Dataset:
    """Give one dataset of many runs.

    Args:
        axes: the parameters; their values are the coordinates.
        metrics: keys of `contactlab.metrics.METRICS`, each with an array; NaN where a run has none.
        status: codes of `Status`.
        reason: a sentence where a run is not complete, else empty.
        attributes: of the dataset, beside those that every sweep has.
        grid: whether each axis is a dimension, in their order; else all lie along `RUN`.
    """
    names = names_of(axes)
    dims = tuple(names) if grid else (RUN,)
    coordinates = {
        name: ((name,) if grid else dims, axis.coordinate, axis.attributes)
        for name, axis in zip(names, axes, strict=True)
    }
    found: dict[str, Any] = {key: (dims, values, _said(key)) for key, values in metrics.items()}
    flags = {
        "long_name": "what became of the run",
        "flag_values": np.array([code.value for code in Status], dtype=np.int8),
        "flag_meanings": " ".join(code.name.lower() for code in Status),
    }
    found["status"] = (dims, status.astype(np.int8), flags)
    found["reason"] = (dims, reason.astype(object), {"long_name": "why a run has no numbers"})
    every = {
        "Conventions": "CF-1.11",
        "title": f"Standing-wave piezoelectric motor over {', '.join(names) or RUN}",
        "source": f"contactlab {versions()['contactlab_version']}, numerical simulation",
        **versions(),
        "code_digest": code_digest(),
        "complete": int(bool(np.all(status == Status.COMPLETE))),
    }
    return xarray.Dataset(found, coordinates, every | counts_of(status) | dict(attributes))


def counts_of(status: NDArray[np.int8]) -> dict[str, int]:
    """Count the runs, and those of each status, as attributes."""
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


def series_group(
    file: netCDF4.Dataset, dims: Sequence[str], names: Sequence[str], time: NDArray[np.float64]
) -> netCDF4.Group:
    """Make the group of time series in a file, so that no more than one run need be in memory.

    Args:
        file: open for writing; it has the dimensions.
        dims: of the cells.
        names: of the series.
        time: of the records [s].

    Returns:
        The group; what is not written to it is NaN.
    """
    group = file.createGroup(GROUP)
    group.createDimension("time", time.size)
    axis = group.createVariable("time", "f8", ["time"])
    axis.setncatts(cf_attributes(variables.TIME))
    axis[:] = time
    for name in names:
        target = group.createVariable(
            name,
            "f8",
            [*dims, "time"],
            compression="zlib",
            complevel=1,
            shuffle=True,
            # A slab is a chunk, so that a run is read or written without its neighbours.
            chunksizes=[1] * len(dims) + [max(time.size, 1)],
            fill_value=np.nan,
        )
        target.setncatts(cf_attributes(SERIES[name]))
    return group


def summary(dataset: xarray.Dataset, path: Path, most: int = 20) -> str:
    """Say how many runs ended in which way, why those did that are not complete, and where all of it is."""
    status, reason = dataset["status"].values.ravel(), dataset["reason"].values.ravel()
    counts = {code: int((status == code).sum()) for code in Status}
    width = len(str(max(counts.values())))
    lines = [f"{count:>{width}} {code.name.lower()}" for code, count in counts.items() if count]
    names = _names(dataset)
    told = [place for place in (status != Status.COMPLETE).nonzero()[0] if names(place)]
    for place in told[:most]:
        lines.append(f"{names(place)}: {Status(status[place]).name.lower()}. {reason[place]}")
    if len(told) > most:
        lines.append(
            f"... and {len(told) - most} more: `status` and `reason` in the file tell of each."
        )
    sizes = " x ".join(f"{name} {size}" for name, size in dataset.sizes.items())
    return "\n".join([*lines, f"Collected in {path}: {sizes}."])


def _names(dataset: xarray.Dataset) -> Callable[[int], str]:
    """Give what names a run: its folder, empty where it has none, or else its parameters."""
    if "job" in dataset:
        jobs = dataset["job"].values.ravel()
        return lambda place: str(jobs[place])
    sizes = dataset.sizes

    def name(place: int) -> str:
        at = dict(zip(sizes, map(int, np.unravel_index(place, tuple(sizes.values()))), strict=True))
        cell = dataset.coords.to_dataset().isel(at)
        return ", ".join(f"{key}={text_of(value.item())}" for key, value in cell.coords.items())

    return name


def text_of(value: Any) -> str:
    """Give a value of a key as a text: true and false as a configuration has them, nothing for null."""
    if value is None:
        return ""
    return str(value).lower() if isinstance(value, bool) else str(value)


def _said(key: str) -> dict[str, str]:
    metric = METRICS[key]
    return {"units": metric.units, "symbol": metric.symbol, "long_name": metric.meaning}
