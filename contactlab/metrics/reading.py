"""Reading of a run's dataset, or of another one in the same layout, with a check of the layout."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from contactlab import variables
from contactlab.checks import check_declared
from contactlab.results.files import damage
from contactlab.results.netcdf import keep_contents
from contactlab.suggestion import excerpt
from contactlab.variables import Variable

if TYPE_CHECKING:
    import xarray

_ROOT: Final = (*variables.SERIES, variables.CONTACT_MODE)


def read_run(source: str | Path | xarray.DataTree) -> xarray.DataTree:
    """Read a run.nc, or another file or tree in the same layout; the file is closed again.

    Metrics that need variables missing from it are not applicable.

    Raises:
        ValueError: the file cannot be read, is not as its run left it, or is laid out otherwise.
    """
    return checked_run(opened(Path(source)) if isinstance(source, str | Path) else source, source)


def checked_run(tree: xarray.DataTree, source: str | Path | xarray.DataTree) -> xarray.DataTree:
    """Return a tree that has the layout of a run.

    Raises:
        ValueError: it is laid out otherwise.
    """
    for fault in _faults(tree):
        text = f"'{source}'" if isinstance(source, str | Path) else "The dataset"
        raise ValueError(
            f"{text} has {fault} The layout is that of a run.nc, which `contactlab` writes; a variable may "
            "be left out, never be misnamed."
        )
    return tree


def is_complete(tree: xarray.DataTree) -> bool:
    """Return whether the run of a dataset reached its end; True without the attribute `complete`."""
    return bool(tree.attrs.get("complete", 1))


def opened(path: Path) -> xarray.DataTree:
    """Return the tree of a netCDF-4 file, checked to be as it was left; the file is closed again.

    Raises:
        ValueError: it cannot be read, or is damaged.
    """
    # Imported here: runs are written and assessed without.
    import xarray

    if not path.is_file():
        raise ValueError(f"'{path}' is not there; it must be a netCDF-4 file in the layout of a run.nc.")
    try:
        if not (damaged := damage(path)):
            check_declared(path)
            # Seconds are numbers here, not dates.
            with xarray.open_datatree(path, engine="netcdf4", decode_times=False) as opened:
                tree = opened.load()
                keep_contents(tree)
                return tree
    except (OSError, ValueError, LookupError, RuntimeError, AttributeError, TypeError) as fault:
        raise ValueError(
            f"'{path}' cannot be read as netCDF-4 ({getattr(fault, 'strerror', None) or fault}); it must be "
            "a whole file in the layout of a run.nc."
        ) from fault
    raise ValueError(damaged)


def _faults(tree: xarray.DataTree) -> Iterator[str]:
    """Yield what the metrics would misread in a layout."""
    root, names = tree.to_dataset(inherit=False), [variable.name for variable in _ROOT]
    if "time" not in root.variables or root["time"].dims != ("time",):
        yield "no variable 'time' over a dimension 'time' at its root; it must have one, in seconds."
    yield from _misread(root, (variables.TIME, *_ROOT))
    time = root["time"].values
    if time.size < 2 or not np.all(np.diff(time) > 0.0):
        yield (
            f"{time.size} times that do not all increase; there must be at least two, strictly "
            "increasing, in seconds."
        )
    if root.variables.keys().isdisjoint(names):
        yield f"none of the time series; it must have at least one of {', '.join(names)}."
    text = tree.attrs.get("complete", 1)
    if np.size(text) != 1 or text not in (0, 1):
        yield (
            f"the attribute complete = {excerpt(repr(text))}; it must be 1 for a run that reached its "
            "end and 0 for another."
        )
    if group := tree.children.get("contacts"):
        yield from _misread(group.to_dataset(inherit=False), variables.CONTACTS)


def _misread(data: xarray.Dataset, known: Iterable[Variable]) -> Iterator[str]:
    """Yield which known variables have other dimensions or units, or are no numbers."""
    for must in (variable for variable in known if variable.name in data.variables):
        values = data[must.name]
        units = values.attrs.get("units", must.units)
        if values.dims != must.dims:
            yield f"'{must.name}' over {values.dims}; it must be over {must.dims}."
        if values.dtype.kind not in "fiu":
            yield f"'{must.name}' as {values.dtype}; it must be real numbers in {must.units}."
        if units != must.units:
            yield f"'{must.name}' in {excerpt(repr(units))}; it must be in {must.units!r}."
