"""A run's dataset read from its file, or one of one's own, checked for its layout."""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final

import numpy as np
import xarray

from contactlab import variables
from contactlab.results.files import damage
from contactlab.variables import Variable

_ROOT: Final = (*variables.SERIES, variables.CONTACT_MODE)


def read_run(source: str | Path | xarray.DataTree) -> xarray.DataTree:
    """Read a run.nc, or a file or a tree of one's own in the same layout; the file is closed again.

    What it lacks makes the metrics that need it not applicable.

    Raises:
        ValueError: the file cannot be read, is not as its run left it, or is laid out otherwise.
    """
    tree = source if isinstance(source, xarray.DataTree) else _opened(Path(source))
    for fault in _faults(tree):
        text = "The dataset" if isinstance(source, xarray.DataTree) else f"'{source}'"
        raise ValueError(
            f"{text} has {fault} The layout is that of a run.nc, which `contactlab` writes; a variable may "
            "be left out, never be misnamed."
        )
    return tree


def is_complete(tree: xarray.DataTree) -> bool:
    """Return whether a dataset is of a run that reached its end; one of one's own need not say so."""
    return bool(tree.attrs.get("complete", 1))


def _opened(path: Path) -> xarray.DataTree:
    if not path.is_file():
        raise ValueError(
            f"'{path}' is not there; it must be a netCDF-4 file in the layout of a run.nc. Check the "
            "name, or run contactlab to make one."
        )
    try:
        if not (damaged := damage(path)):
            # Seconds are numbers here, not dates.
            with xarray.open_datatree(path, engine="netcdf4", decode_times=False) as opened:
                return opened.load()
    except (OSError, ValueError, LookupError, RuntimeError, AttributeError, TypeError) as fault:
        raise ValueError(
            f"'{path}' cannot be read as netCDF-4; it must be a file that may be read, in the layout of a "
            "run.nc. Check its permissions, and that it is whole: `ncdump -h` shows what is in it "
            f"({getattr(fault, 'strerror', None) or fault})."
        ) from fault
    raise ValueError(damaged)


def _faults(tree: xarray.DataTree) -> Iterator[str]:
    """Yield what a layout has that the metrics would misread, the first fault first."""
    root, names = tree.to_dataset(inherit=False), [variable.name for variable in _ROOT]
    if "time" not in root.variables or root["time"].dims != ("time",):
        yield "no variable 'time' over a dimension 'time' at its root; it must have one, in seconds."
    yield from _misread(root, (variables.TIME, *_ROOT))
    time = root["time"].values
    if time.size < 2 or not np.all(np.diff(time) > 0.0):
        yield (
            f"{time.size} times that do not all increase; there must be at least two, strictly "
            "increasing, in seconds. Sort them and drop repeated ones."
        )
    if root.variables.keys().isdisjoint(names):
        yield f"none of the time series; it must have at least one of {', '.join(names)}."
    text = tree.attrs.get("complete", 1)
    if np.size(text) != 1 or text not in (0, 1):
        yield (
            f"the attribute complete = {text!r}; it must be 1 for a run that reached its end and 0 for "
            "another. Correct it, or leave it out."
        )
    if group := tree.children.get("contacts"):
        yield from _misread(group.to_dataset(inherit=False), variables.CONTACTS)


def _misread(found: xarray.Dataset, known: Iterable[Variable]) -> Iterator[str]:
    """Yield which known variables have other dimensions or units, or are no numbers."""
    for must in (variable for variable in known if variable.name in found.variables):
        values = found[must.name]
        units = values.attrs.get("units", must.units)
        if values.dims != must.dims:
            yield f"'{must.name}' over {values.dims}; it must be over {must.dims}."
        if values.dtype.kind not in "fiu":
            yield f"'{must.name}' as {values.dtype}; it must be real numbers in {must.units}."
        if units != must.units:
            yield f"'{must.name}' in {units!r}; it must be in {must.units!r}. Convert the numbers too."
