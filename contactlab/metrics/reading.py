"""A dataset from a file or a tree, checked for its layout before anything is made of it."""

from collections.abc import Iterable
from pathlib import Path
from typing import Final

import numpy as np
import xarray

from contactlab import variables
from contactlab.results.files import damage
from contactlab.variables import Variable

_ROOT: Final = (*variables.SERIES, variables.CONTACT_MODE)

_WAY_OUT: Final = (
    "The layout is that of a run.nc: 'time' and the series over it at the root, one row a contact in "
    "the group 'contacts'; `contactlab` writes one to look at. A variable that is not known may be "
    "left out, never be misnamed."
)


def read_run(source: str | Path | xarray.DataTree) -> xarray.DataTree:
    """Read a run.nc, or a file or a tree of one's own in the same layout; the file is closed again.

    What it lacks makes the metrics that need it not applicable; what it has is of the layout's dimensions
    and units.

    Raises:
        ValueError: the file cannot be read, is not as its run left it, or is laid out otherwise.
    """
    tree = source if isinstance(source, xarray.DataTree) else _opened(Path(source))
    if fault := _fault_of(tree):
        words = "The dataset" if isinstance(source, xarray.DataTree) else f"'{source}'"
        raise ValueError(f"{words} has {fault}")
    return tree


def is_complete(tree: xarray.DataTree) -> bool:
    """Tell whether a dataset is of a run that reached its end; one of one's own need not say so."""
    return bool(tree.attrs.get("complete", 1))


def _opened(path: Path) -> xarray.DataTree:
    if not path.is_file():
        raise ValueError(
            f"'{path}' is not there; it must be a netCDF-4 file in the layout of a run.nc. Check the "
            "name, or run contactlab to make one."
        )
    try:
        damaged = damage(path)
    except OSError as fault:
        raise ValueError(
            f"'{path}' cannot be read ({fault.strerror or fault}); it must be a file that may be read. "
            "Check its permissions and the disk."
        ) from fault
    if damaged:
        raise ValueError(damaged)
    try:
        # Seconds are numbers here, not dates.
        with xarray.open_datatree(path, engine="netcdf4", decode_times=False) as opened:
            return opened.load()
    except (OSError, ValueError, LookupError, RuntimeError, AttributeError, TypeError) as fault:
        raise ValueError(
            f"'{path}' cannot be read as netCDF-4; it must be a file in the layout of a run.nc. Check "
            "that it is one, and whole: `ncdump -h` shows what is in it."
        ) from fault


def _fault_of(tree: xarray.DataTree) -> str:
    """Say what a layout has that the metrics would misread; empty where there is nothing."""
    root, group = tree.to_dataset(inherit=False), tree.children.get("contacts")
    if "time" not in root.variables or root["time"].dims != ("time",):
        return (
            "no variable 'time' over a dimension 'time' at its root; it must have one, in seconds. "
            f"{_WAY_OUT}"
        )
    if fault := _fault_among(root, (variables.TIME, *_ROOT)):
        return fault
    time = np.asarray(root["time"].values, dtype=np.float64)
    if time.size < 2 or not np.all(np.diff(time) > 0.0):
        return (
            f"{time.size} times that do not all increase; there must be at least two, strictly "
            "increasing, in seconds. Sort them and drop repeated ones."
        )
    names = [variable.name for variable in _ROOT]
    if root.variables.keys().isdisjoint(names):
        return (
            f"none of the time series; it must have at least one of {', '.join(names)}. {_WAY_OUT}"
        )
    said = tree.attrs.get("complete", 1)
    if np.size(said) != 1 or np.asarray(said).dtype.kind not in "biuf" or said not in (0, 1):
        return (
            f"the attribute complete = {said!r}; it must be 1 for a run that reached its end and 0 for "
            "another. Correct it, or leave it out."
        )
    return (
        "" if group is None else _fault_among(group.to_dataset(inherit=False), variables.CONTACTS)
    )


def _fault_among(found: xarray.Dataset, known: Iterable[Variable]) -> str:
    """Say which known variable has other dimensions or units, or is no number."""
    for variable in (variable for variable in known if variable.name in found.variables):
        name, given = variable.name, found[variable.name]
        units = given.attrs.get("units", variable.units)
        if given.dims != variable.dims:
            return f"'{name}' over {given.dims}; it must be over {variable.dims}. {_WAY_OUT}"
        if given.dtype.kind not in "fiu":
            return f"'{name}' as {given.dtype}; it must be real numbers in {variable.units}. Convert it."
        if units != variable.units:
            return (
                f"'{name}' in {units!r}; it must be in {variable.units!r}. Convert the numbers and the "
                "attribute 'units'."
            )
    return ""
