"""What a sweep found as one dataset, read from its folder alone, whatever it keeps of its runs."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import netCDF4
import numpy as np
import xarray
import yaml

from contactlab.config.nesting import nested
from contactlab.metrics import METRICS, read_run
from contactlab.results import files
from contactlab.results.provenance import checkout_state
from contactlab.sweeps.dataset import DATASET, SERIES, counts_of, dataset_of, series_group, write
from contactlab.sweeps.discovery import FoundRun, discovered
from contactlab.sweeps.layout import Layout, common_settings, layout_of
from contactlab.sweeps.manifest import kept
from contactlab.sweeps.state import Status
from contactlab.sweeps.store import Store
from contactlab.sweeps.values import SweepError

NOT_ASKED: Final = "No run was asked for."
"""The reason of a cell of a grid that no run has."""


def collect(
    directory: str | Path,
    output: str | Path | None = None,
    series: Sequence[str] = (),
    metrics: Sequence[str] = (),
) -> xarray.Dataset:
    """Collect every run below a folder into one dataset, written to a file, whole or not at all.

    One run is open at a time. Of a sweep that keeps metrics it is what is finished so far.

    Args:
        directory: of a sweep, of several, or of any runs.
        output: the file; without, `sweep.nc` in the directory.
        series: time series that go into the group `series` of the file, over the cells and `time`.
        metrics: those of `contactlab.metrics.METRICS` that are wanted; all where none is named.

    Returns:
        The metrics over the parameters that differ between runs: a dimension each if the runs form a
        grid, else all along the dimension `run`. NaN with `status` and `reason` where a run did not reach
        its end, numbers with both where its energy ledger is open; `job` is the run's folder. The file is
        the attribute `source` of the dataset's `encoding`.

    Raises:
        SweepError: there is no such folder, no run in it, no such series, or the series of the runs are
            at different times.
        OSError: the file cannot be written.
    """
    directory = Path(directory)
    if not directory.is_dir():
        raise SweepError(
            f"'{directory}' is not there; it must be a folder of runs. "
            "`contactlab -m law=A,B hydra.sweep.dir=DIR` leaves one."
        )
    if (keep := kept(directory)) == "metrics":
        return _of_store(directory, bool(output or series or metrics))
    if unknown := [name for name in series if name not in SERIES]:
        raise SweepError(
            f"{', '.join(unknown)} is no time series; it must be of {', '.join(SERIES)}."
        )
    runs = list(discovered(directory))
    if not runs:
        raise SweepError(
            f"'{directory}' holds no run, nor does a folder below it; it must hold one at least. "
            f"A run leaves one: contactlab hydra.run.dir={directory}"
        )
    layout = layout_of(runs, samples=keep == "samples")
    dataset = _dataset(runs, layout, metrics or tuple(METRICS))
    path = directory / DATASET if output is None else Path(output)

    def add_series(partial: Path) -> None:
        _add_series(partial, runs, layout, list(dict.fromkeys(series)))

    write(dataset, path, add_series if series else None)
    dataset.encoding["source"] = str(path)
    return dataset


def _of_store(directory: Path, otherwise: bool) -> xarray.Dataset:
    """Collect what is finished of a sweep that keeps metrics."""
    if otherwise:
        raise SweepError(
            f"'{directory}' is the folder of a sweep that keeps metrics, whose dataset is its {DATASET} with "
            "the series that it keeps; another file and other series must be left out."
        )
    store = Store.opened(directory)
    dataset = store.merge()
    dataset.encoding["source"] = str(store.file)
    return dataset


def _dataset(runs: Sequence[FoundRun], layout: Layout, metrics: Sequence[str]) -> xarray.Dataset:
    common = common_settings(runs)
    sections = [run.job.configuration.get("law") for run in runs]
    laws = {str(section.get("name")) for section in sections if isinstance(section, dict)}
    revision, dirty = checkout_state()
    status = layout.spread([run.status for run in runs], Status.ABSENT, np.int8)
    dataset = dataset_of(
        layout.axes,
        {
            key: layout.spread([run.metrics.get(key, np.nan) for run in runs], np.nan, np.float64)
            for key in metrics
        },
        status,
        layout.spread([run.reason for run in runs], NOT_ASKED, object),
        {
            "law": " ".join(sorted(laws)),
            "configuration": yaml.safe_dump(nested(common), sort_keys=False, allow_unicode=True),
            "git_revision": revision,
            "git_dirty": dirty,
            **counts_of(np.array([run.status for run in runs], dtype=np.int8)),
        },
        grid=layout.grid,
    )
    jobs = layout.spread([run.name for run in runs], "", object)
    dataset["job"] = (layout.dims, jobs, {"long_name": "folder of the run"})
    names = layout.names_beside
    return dataset.assign_coords(
        {
            name: (layout.dims, values, axis.attributes)
            for name, (axis, values) in zip(names, layout.beside, strict=True)
        }
    )


def _add_series(path: Path, runs: Sequence[FoundRun], layout: Layout, names: Sequence[str]) -> None:
    """Add the time series of the complete runs to a file that has the dimensions of the layout.

    Raises:
        SweepError: no run is complete, or they are not recorded at the same times, or lack a series.
    """
    complete = [
        (int(place), run)
        for place, run in zip(layout.place, runs, strict=True)
        if run.status is Status.COMPLETE
    ]
    if not complete:
        raise SweepError(
            "There is no complete run; there must be one for time series. Leave out --series."
        )
    with netCDF4.Dataset(path, "a") as file:
        group, time = None, np.empty(0)
        for place, run in complete:
            try:
                tree = read_run(run.folder / files.DATASET)
            except ValueError as error:
                raise SweepError(str(error)) from error
            mine = np.asarray(tree["time"].values, dtype=np.float64)
            if group is None:
                group, time = series_group(file, layout.dims, names, mine), mine
            if not np.array_equal(mine, time):
                raise SweepError(
                    f"'{run.name}' is recorded at other times than '{complete[0][1].name}'; for time "
                    "series they must be the same. Leave out --series, or run all with one "
                    "solver.duration and one record.interval."
                )
            cell: Any = (*map(int, np.unravel_index(place, layout.shape)), slice(None))
            for name in names:
                if name not in tree.variables:
                    raise SweepError(f"'{run.name}' has no {name}; leave it out of --series.")
                group[name][cell] = tree[name].values
