"""Many runs as one dataset: parameters as coordinates, numbers as variables, and the status of each run."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
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
from contactlab.studies.run_state import Status
from contactlab.studies.sweep.values import short_names
from contactlab.variables import Variable

DATASET: Final = "sweep.nc"
"""File of a sweep, in its folder."""

DIMENSION: Final = "run"
"""Dimension of runs that form no grid."""

GROUP: Final = "series"
"""Group of the file with the time series."""

SERIES: Final = {variable.name: variable for variable in variables.SERIES}
"""Series of every run; a law with internal variables has more, see `contactlab.results.netcdf`."""

TAKEN: Final = frozenset({*METRICS, *SERIES, "status", "reason", "job", "time", DIMENSION})
"""Names of a dataset that no parameter can have."""

REASONS: Final = {
    Status.COMPLETE: "",
    Status.UNFINISHED: "The run began and has not ended: it was killed, or it is still running.",
    Status.ABSENT: "The run has not begun.",
}

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
"""Attributes of the variables that are no series, by name."""

_PACKED: Final[dict[str, Any]] = {"zlib": True, "complevel": 1, "shuffle": True}

Slab = tuple[tuple[int, ...], Array, Mapping[str, Array]]
"""Place of a run, times of its records, and its series by name."""


@final
@dataclass(frozen=True)
class Axis:
    """A parameter that differs from run to run.

    Args:
        key: of the configuration, or a group of it: 'contact.clearance', 'law/normal'; from Python any name.
        values: numbers in SI, or names of options.
        units: those of the CF conventions; empty for names and where they are not known.
        long_name: meaning.
    """

    key: str
    values: tuple[Value, ...]
    units: str = ""
    long_name: str = ""

    @property
    def coordinate(self) -> NDArray[Any]:
        """The values as an array of numbers or texts."""
        if any(isinstance(value, str | bool) for value in self.values):
            return np.array([text_of(value) for value in self.values], dtype=object)
        return np.asarray(self.values, dtype=np.float64)


@dataclass
class Outcome:
    """Status of a run, the reason where it has no numbers, its numbers and its time series."""

    status: Status = Status.FAILED
    reason: str = ""
    numbers: Mapping[str, float] = field(default_factory=dict)
    time: Any = None
    series: Mapping[str, Any] | None = None


def columns_of(runs: Sequence[Outcome], numbers: Iterable[str]) -> dict[str, NDArray[Any]]:
    """Return the columns of `dataset_of` for runs: numbers, NaN where a run has none, status and reason."""
    return {
        **{name: np.array([run.numbers.get(name, np.nan) for run in runs]) for name in numbers},
        "status": np.array([run.status for run in runs], dtype=np.int8),
        "reason": np.array([run.reason for run in runs], dtype=object),
    }


def dataset_of(
    axes: Sequence[Axis],
    columns: Mapping[str, NDArray[Any]],
    attributes: dict[str, Any],
    *,
    samples: bool,
    series: Sequence[Variable] = (),
    numbers: Sequence[Variable] = (),
) -> xarray.Dataset:
    """Return one dataset of many runs.

    Args:
        axes: the parameters; each is a dimension, in this order, or all lie along `DIMENSION`.
        columns: metrics, 'status' and 'reason' of the runs in C order over the axes.
        attributes: of the dataset, beside those that every sweep has.
        samples: whether the n-th run has the n-th value of every axis.
        series: those that are kept beside the dataset.
        numbers: those of a study, whose columns are not metrics.
    """
    taken = TAKEN.union(variable.name for variable in (*series, *numbers))
    names = list(short_names([axis.key for axis in axes], taken).values())
    described = _ATTRIBUTES | {each.name: cf_attributes(each) for each in numbers}
    dims, shape = ([DIMENSION], [-1]) if samples else (names, [len(axis.values) for axis in axes])
    coordinates: dict[str, Any] = {}
    for name, axis in zip(names, axes, strict=True):
        texts = {"key": axis.key, "units": axis.units, "long_name": axis.long_name}
        shown = {key: text for key, text in texts.items() if text}
        coordinates[name] = ([DIMENSION] if samples else [name], axis.coordinate, shown)
    status = columns["status"]
    every = {
        **code_attributes(),
        "title": f"Standing-wave piezoelectric motor over {', '.join(names) or DIMENSION}",
        "complete": int(bool(np.all(status == Status.COMPLETE))),
        "runs": int(status.size),
        **{f"runs_{code.name.lower()}": int((status == code).sum()) for code in Status},
    }
    cells = {
        name: (dims, (x.astype(object) if x.dtype.kind == "U" else x).reshape(shape), described[name])
        for name, x in columns.items()
    }
    return xarray.Dataset(cells, coordinates, every | attributes)


def with_series(dataset: xarray.Dataset, series: Sequence[Variable], slabs: Iterable[Slab]) -> xarray.Dataset:
    """Return a dataset with time series in memory, each as NAME_series; NaN where a run has none."""
    status = dataset["status"]
    arrays: dict[str, Array] = {}
    for place, time, rows in slabs:
        if not arrays:
            arrays = {each.name: np.full((*status.shape, time.size), np.nan) for each in series}
            dataset = dataset.assign_coords(time=("time", time, cf_attributes(variables.TIME)))
        for name, array in arrays.items():
            array[place] = rows[name]
    return dataset.assign(
        {
            f"{each.name}_series": ((*status.dims, "time"), arrays[each.name], cf_attributes(each))
            for each in series
            if arrays
        }
    )


def write(dataset: xarray.Dataset, path: Path, series: Sequence[Variable], slabs: Iterable[Slab]) -> None:
    """Write the dataset of `dataset_of` into a new file; the same dataset gives the same bytes.

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
        for place, time, rows in slabs:
            if group is None:
                group = file.createGroup(GROUP)
                group.createDimension("time", time.size)
                axis = group.createVariable("time", "f8", ["time"])
                axis.setncatts(cf_attributes(variables.TIME))
                axis[:] = time
                # A slab is a chunk, so that a run is read or written without its neighbours.
                size: Any = {"fill_value": np.nan, "chunksizes": [1] * len(dims) + [time.size]}
                for each in series:
                    target = group.createVariable(each.name, "f8", [*dims, "time"], **_PACKED, **size)
                    target.setncatts(cf_attributes(each))
            for each in series:
                group[each.name][place] = rows[each.name]


def summary(dataset: xarray.Dataset, path: Path, most: int = 20) -> str:
    """Return the number of runs by status, the reasons of those that are not complete, and the file."""
    status = dataset["status"]
    counts = {code: int((status == code).sum()) for code in Status}
    width = len(str(max(counts.values())))
    lines = [f"{count:>{width}} {code.name.lower()}" for code, count in counts.items() if count]
    # Cells of a grid without a run have no folder.
    exists = dataset["job"] != "" if "job" in dataset else True
    incomplete = np.argwhere(((status != Status.COMPLETE) & exists).values)
    for place in incomplete[:most]:
        cell = dataset.isel(dict(zip(status.dims, place, strict=True)))
        point = ", ".join(f"{key}={text_of(value.item())}" for key, value in cell.coords.items())
        name = cell["job"].item() if "job" in cell else point
        lines.append(f"{name}: {Status(cell['status'].item()).name.lower()}. {cell['reason'].item()}")
    if len(incomplete) > most:
        lines.append(f"... and {len(incomplete) - most} more, see `status` and `reason` in the file.")
    if others := dataset.attrs.get("runs_of_other_code", 0):
        lines.append(
            f"{others} of other code than is installed: run them again, to compare them with new ones."
        )
    sizes = " x ".join(f"{name} {size}" for name, size in dataset.sizes.items())
    return "\n".join([*lines, f"Collected in {path}: {sizes}."])


def text_of(value: Any) -> str:
    """Return a value of a key as a text: true and false as a configuration has them, nothing for null."""
    if value is None:
        return ""
    return str(value).lower() if isinstance(value, bool) else str(value)
