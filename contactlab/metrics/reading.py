"""A dataset from a file or a tree, checked for its layout before anything is made of it."""

from pathlib import Path
from typing import Final

import numpy as np
import xarray

from contactlab import variables
from contactlab.results.files import damage
from contactlab.variables import Variable

_ROOT: Final = {v.name: v for v in (*variables.SERIES, variables.CONTACT_MODE)}
_CONTACTS: Final = {v.name: v for v in variables.CONTACTS}

_WAY_OUT: Final = (
    "The layout is that of a run.nc: 'time' and the series over it at the root, one row a contact in "
    "the group 'contacts'; `contactlab` writes one to look at. A variable that is not known may be "
    "left out, never be misnamed."
)


def read_run(source: str | Path | xarray.DataTree) -> xarray.DataTree:
    """Read a run as a tree in memory; the file is closed again.

    Args:
        source: a run.nc, a file of one's own in the same layout, or a tree of it.

    Returns:
        The tree. What it lacks makes the metrics that need it not applicable; what it has is of the
        layout's dimensions and units.

    Raises:
        ValueError: the file cannot be read, is not as its run left it, or is laid out otherwise: what
            is missing, what it must be, and what to do.
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
    root = tree.to_dataset(inherit=False)
    if "time" not in root.variables or root["time"].dims != ("time",):
        return (
            "no variable 'time' over a dimension 'time' at its root; it must have one, in seconds. "
            f"{_WAY_OUT}"
        )
    if fault := _fault_among(root, {"time": variables.TIME} | _ROOT):
        return fault
    time = np.asarray(root["time"].values, dtype=np.float64)
    if time.size < 2 or not np.all(np.diff(time) > 0.0):
        return (
            f"{time.size} times that do not all increase; there must be at least two, strictly "
            "increasing, in seconds. Sort them and drop repeated ones."
        )
    if not any(name in root.variables for name in _ROOT):
        return (
            f"none of the time series; it must have at least one of {', '.join(_ROOT)}. {_WAY_OUT}"
        )
    said = tree.attrs.get("complete", 1)
    if np.size(said) != 1 or np.asarray(said).dtype.kind not in "biuf" or said not in (0, 1):
        return (
            f"the attribute complete = {said!r}; it must be 1 for a run that reached its end and 0 for "
            "another. Correct it, or leave it out."
        )
    group = tree.children.get("contacts")
    return "" if group is None else _fault_among(group.to_dataset(inherit=False), _CONTACTS)


def _fault_among(found: xarray.Dataset, known: dict[str, Variable]) -> str:
    """Say which known variable has other dimensions or units, or is no number."""
    for name, variable in known.items():
        if name not in found.variables:
            continue
        given = found[name]
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
