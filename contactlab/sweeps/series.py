"""Time series of many runs in one file, a slab a run, so that no more than one run is in memory."""

from collections.abc import Sequence
from pathlib import Path
from typing import Final, final

import netCDF4
import numpy as np

from contactlab import variables
from contactlab.metrics import read_run
from contactlab.results.files import DATASET
from contactlab.results.netcdf import cf_attributes
from contactlab.sweeps.faults import CollectingError
from contactlab.sweeps.found import FoundRun
from contactlab.sweeps.layout import Layout
from contactlab.sweeps.status import Status

GROUP: Final = "series"

_KNOWN: Final = {variable.name: variable for variable in variables.SERIES}


@final
class Series:
    """Time series of the complete runs over their cells.

    Args:
        runs: in the order of the layout.
        layout: where they stand.
        names: of the series.

    Raises:
        CollectingError: no such series, or no complete run, or runs at different times.
    """

    def __init__(self, runs: Sequence[FoundRun], layout: Layout, names: Sequence[str]) -> None:
        if unknown := [name for name in names if name not in _KNOWN]:
            raise CollectingError(
                f"{', '.join(unknown)} is no time series; it must be of {', '.join(_KNOWN)}."
            )
        self._names = list(dict.fromkeys(names))
        self._layout = layout
        self._runs = [
            (int(place), run)
            for place, run in zip(layout.place, runs, strict=True)
            if run.status is Status.COMPLETE
        ]
        if not self._runs:
            raise CollectingError(
                "There is no complete run; there must be one for time series. Leave out --series."
            )

    def write(self, path: Path) -> None:
        """Add the series to a file that has the dimensions of the layout.

        Raises:
            CollectingError: the runs are not recorded at the same times, or lack a series.
        """
        with netCDF4.Dataset(path, "a") as file:
            group, time = None, np.empty(0)
            for place, run in self._runs:
                try:
                    tree = read_run(run.folder / DATASET)
                except ValueError as error:
                    raise CollectingError(str(error)) from error
                mine = np.asarray(tree["time"].values, dtype=np.float64)
                if group is None:
                    group, time = series_group(file, self._layout.dims, self._names, mine), mine
                if not np.array_equal(mine, time):
                    raise CollectingError(
                        f"'{run.name}' is recorded at other times than '{self._runs[0][1].name}'; for "
                        "time series they must be the same. Leave out --series, or run all with one "
                        "solver.duration and one record.interval."
                    )
                cell = np.unravel_index(place, self._layout.shape)
                for name in self._names:
                    if name not in tree.variables:
                        raise CollectingError(
                            f"'{run.name}' has no {name}; leave it out of --series."
                        )
                    group[name][(*map(int, cell), slice(None))] = tree[name].values


def series_group(
    file: netCDF4.Dataset, dims: Sequence[str], names: Sequence[str], time: np.ndarray
) -> netCDF4.Group:
    """Make the group of time series in a file.

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
        said = _KNOWN[name]
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
        target.setncatts(cf_attributes(said))
    return group
