"""Tables of measurements as netCDF: a variable a column, with its unit as the attribute `units`."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray

from contactlab.measured.columns import IMPACT, WORDS
from contactlab.measured.faults import MeasurementError
from contactlab.measured.table import Table

_COMPRESSED = {"zlib": True, "complevel": 1, "shuffle": True, "_FillValue": None}


def read_netcdf(path: Path) -> Table:
    """Read a table from a netCDF file.

    Raises:
        MeasurementError: it cannot be read, or a variable has more dimensions than one, or another one.
    """
    try:
        with xarray.open_dataset(path, engine="netcdf4", decode_times=False) as dataset:
            dataset.load()
    except (OSError, ValueError, RuntimeError) as error:
        raise MeasurementError(f"it cannot be read as netCDF: {error}.") from error
    along = {str(dimension) for variable in dataset.variables.values() for dimension in variable.dims}
    _refuse_tables(dataset)
    values, units = {}, {}
    for key, variable in dataset.variables.items():
        name = str(key)
        # What numbers the dimension numbers the impacts, whatever it is called.
        name = IMPACT.form if name in along else name
        values[name] = np.asarray(variable.values)
        units[name] = None if "units" not in variable.attrs else str(variable.attrs["units"])
    count = dataset.sizes[along.pop()] if along else 1
    return Table(
        values,
        units,
        tuple(f"impact {at} of {count} in the file" for at in range(1, count + 1)),
        _words(dataset),
        "the attribute units = '{unit}' at the variable {name}",
    )


def dataset_of(
    columns: Mapping[str, np.ndarray], units: Mapping[str, str], words: Mapping[str, str]
) -> xarray.Dataset:
    """Return columns, shape (row,) or (), with their units as a dataset."""
    variables = {
        name: xarray.Variable((IMPACT.form,) if values.ndim else (), values, {"units": units[name]})
        for name, values in columns.items()
    }
    for variable in variables.values():
        variable.encoding = _COMPRESSED if variable.ndim else {"_FillValue": None}
    return xarray.Dataset(variables, attrs=dict(words))


def _refuse_tables(dataset: xarray.Dataset) -> None:
    """Refuse variables that are neither a number nor along the one dimension of all."""
    several = {str(name): variable.dims for name, variable in dataset.variables.items() if variable.ndim}
    name = max(several, key=lambda each: len(several[each]), default="")
    if name and len(several[name]) > 1:
        raise MeasurementError(
            f"{name} has the dimensions ({', '.join(map(str, several[name]))}); every variable must be a "
            "number, or one number an impact. Write a variable for each coordinate: before_x, before_y."
        )
    along = {str(dims[0]): name for name, dims in several.items()}
    if len(along) > 1:
        told = ", ".join(f"{variable} lies along {dimension}" for dimension, variable in along.items())
        raise MeasurementError(f"{told}; all variables must lie along one dimension. Give it one name.")


def _words(dataset: xarray.Dataset) -> dict[str, str]:
    """Give the words among the attributes; what else the tools of others have put there is theirs."""
    found = {}
    for key, value in dataset.attrs.items():
        name = str(key).lower().replace("license", "licence")
        if name in WORDS:
            found[name] = str(value)
    return found
