"""Many runs as one dataset: parameters as coordinates, metrics as variables, a code where one is missing."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

import netCDF4
import numpy as np
import xarray
from numpy.typing import NDArray

from contactlab import variables
from contactlab.arrays import Array
from contactlab.config.nesting import Value
from contactlab.metrics import METRICS
from contactlab.results.netcdf import cf_attributes
from contactlab.results.provenance import code_attributes
from contactlab.sweeps.state import Status
from contactlab.sweeps.values import short_names
from contactlab.variables import Variable

DATASET: Final = "sweep.nc"
"""The file of a sweep, in its folder."""

RUN: Final = "run"
"""The dimension of runs that form no grid."""

GROUP: Final = "series"
"""Of the file: the time series."""

SERIES: Final = {variable.name: variable for variable in variables.SERIES}
"""Those of every run; a law that remembers has more, see `contactlab.results.internal`."""

TAKEN: Final = frozenset({*METRICS, *SERIES, "status", "reason", "job", "time", RUN})
"""Names of a dataset that no parameter can have."""

REASONS: Final = {
    Status.COMPLETE: "",
    Status.UNFINISHED: "The run began and has not ended: it was killed, or it is still running.",
    Status.ABSENT: "The run has not begun.",
}
"""Reasons that need no run to tell them."""

_ATTRIBUTES: Final[dict[str, dict[str, Any]]] = {
    **{k: {"units": m.units, "symbol": m.symbol, "long_name": m.meaning} for k, m in METRICS.items()},
    "status": {
        "long_name": "what became of the run",
        "flag_values": np.array([code.value for code in Status], dtype=np.int8),
        "flag_meanings": " ".join(code.name.lower() for code in Status),
    },
    "reason": {"long_name": "why a run has no numbers"},
    "job": {"long_name": "folder of the run"},
}
"""Of the variables that are no series, by name."""

_PACKED: Final[dict[str, Any]] = {"zlib": True, "complevel": 1, "shuffle": True}

Slab = tuple[tuple[int, ...], Array, Mapping[str, Array]]
"""The place of a run, the times of its records and its series by name."""


@final
@dataclass(frozen=True)
class Axis:
    """Holds a parameter that differs from run to run: numbers in SI, or names of options."""

    key: str
    """Of the configuration, or a group of it: 'contact.clearance', 'law/normal'; from Python any name."""
    values: tuple[Value, ...]
    units: str = ""
    """In the words of the CF conventions; empty for names and where it is not known."""
    long_name: str = ""

    @property
    def coordinate(self) -> NDArray[Any]:
        """The values as an array of numbers or texts."""
        if any(isinstance(value, str | bool) for value in self.values):
            return np.array([text_of(value) for value in self.values], dtype=object)
        return np.asarray(self.values, dtype=np.float64)


def dataset_of(
    axes: Sequence[Axis],
    columns: Mapping[str, NDArray[Any]],
    attributes: dict[str, Any] | None = None,
    *,
    samples: bool = False,
    series: Sequence[Variable] = (),
    numbers: Sequence[Variable] = (),
) -> xarray.Dataset:
    """Give one dataset of many runs.

    Args:
        axes: the parameters; each is a dimension, in this order, or all lie along `RUN`.
        columns: metrics, series over time, 'status' and 'reason', the first dimension that of the runs in C
            order over the axes.
        attributes: of the dataset, beside those that every sweep has.
        numbers: those of a study, whose columns are not metrics.
        samples: whether the n-th run has the n-th value of every axis.
        series: those that are kept, here or in the file.
    """
    taken = TAKEN.union(variable.name for variable in (*series, *numbers))
    names = list(short_names([axis.key for axis in axes], taken).values())
    told_of = _ATTRIBUTES | {f"{one.name}_series": cf_attributes(one) for one in series}
    told_of |= {variable.name: cf_attributes(variable) for variable in numbers}
    dims, shape = ([RUN], [-1]) if samples else (names, [len(axis.values) for axis in axes])

    def variable(attributes: Mapping[str, Any], values: NDArray[Any]) -> xarray.Variable:
        cells = values.astype(object) if values.dtype.kind == "U" else values
        along = [*dims, *["time"][: values.ndim - 1]]
        return xarray.Variable(along, cells.reshape(*shape, *values.shape[1:]), attributes)

    coordinates: dict[str, Any] = {}
    for name, axis in zip(names, axes, strict=True):
        said = {"key": axis.key, "units": axis.units, "long_name": axis.long_name}
        told = {name: text for name, text in said.items() if text}
        coordinates[name] = ([RUN] if samples else [name], axis.coordinate, told)
    status, time = columns["status"], columns.get("time", np.empty(0))
    if time.size:
        coordinates["time"] = ("time", time, cf_attributes(variables.TIME))
    found = {name: variable(told_of[name], values) for name, values in columns.items() if name != "time"}
    every = {
        **code_attributes(),
        "title": f"Standing-wave piezoelectric motor over {', '.join(names) or RUN}",
        "complete": int(bool(np.all(status == Status.COMPLETE))),
        "runs": int(status.size),
        **{f"runs_{code.name.lower()}": int((status == code).sum()) for code in Status},
    }
    return xarray.Dataset(found, coordinates, every | (attributes or {}))


def write(
    dataset: xarray.Dataset,
    path: Path,
    series: Sequence[Variable] = (),
    slabs: Callable[[], Iterable[Slab]] = tuple,
) -> None:
    """Write what `dataset_of` gives into a new file; the same dataset gives the same bytes.

    The `series` go into the group of that name, one of the `slabs` in memory at a time; they are NaN
    where a run has none.
    """
    encoding = {
        name: _PACKED
        for name, variable in dataset.data_vars.items()
        if variable.dtype.kind in "fi" and variable.size
    }
    dataset.to_netcdf(path, format="NETCDF4", engine="netcdf4", encoding=encoding)
    if not series:
        return
    dims: Any = dataset["status"].dims
    with netCDF4.Dataset(path, "a") as file:
        group = None
        for place, time, rows in slabs():
            if group is None:
                group = file.createGroup(GROUP)
                group.createDimension("time", time.size)
                axis = group.createVariable("time", "f8", ["time"])
                axis.setncatts(cf_attributes(variables.TIME))
                axis[:] = time
                # A slab is a chunk, so that a run is read or written without its neighbours.
                size: Any = {"fill_value": np.nan, "chunksizes": [1] * len(dims) + [time.size]}
                for one in series:
                    target = group.createVariable(one.name, "f8", [*dims, "time"], **_PACKED, **size)
                    target.setncatts(cf_attributes(one))
            for one in series:
                group[one.name][place] = rows[one.name]


def summary(dataset: xarray.Dataset, path: Path, most: int = 20) -> str:
    """Say how many runs ended in which way, why those did that are not complete, and where all of it is."""
    status = dataset["status"]
    counts = {code: int((status == code).sum()) for code in Status}
    width = len(str(max(counts.values())))
    lines = [f"{count:>{width}} {code.name.lower()}" for code, count in counts.items() if count]
    # Cells of a grid that no run was asked for have no folder.
    asked = dataset["job"] != "" if "job" in dataset else True
    told = np.argwhere(((status != Status.COMPLETE) & asked).values)
    for place in told[:most]:
        cell = dataset.isel(dict(zip(status.dims, place, strict=True)))
        point = ", ".join(f"{key}={text_of(value.item())}" for key, value in cell.coords.items())
        name = cell["job"].item() if "job" in cell else point
        lines.append(f"{name}: {Status(cell['status'].item()).name.lower()}. {cell['reason'].item()}")
    if len(told) > most:
        lines.append(f"... and {len(told) - most} more: `status` and `reason` in the file tell of each.")
    sizes = " x ".join(f"{name} {size}" for name, size in dataset.sizes.items())
    return "\n".join([*lines, f"Collected in {path}: {sizes}."])


def text_of(value: Any) -> str:
    """Give a value of a key as a text: true and false as a configuration has them, nothing for null."""
    if value is None:
        return ""
    return str(value).lower() if isinstance(value, bool) else str(value)
