"""What a sweep found as one dataset, read from the folders of its runs alone."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray
import yaml

from contactlab.config.nesting import nested
from contactlab.metrics import METRICS
from contactlab.results.provenance import checkout_state, code_digest, versions
from contactlab.sweeps.cells import counts_of, dataset_of, write
from contactlab.sweeps.faults import CollectingError
from contactlab.sweeps.found import FoundRun, found_runs
from contactlab.sweeps.layout import Layout, common_settings, layout_of
from contactlab.sweeps.series import Series
from contactlab.sweeps.status import Status

COLLECTED: Final = "collected.nc"

NOT_ASKED: Final = "No run was asked for."
"""The reason of a cell of a grid that no run has."""


def collect(
    directory: str | Path, output: str | Path | None = None, series: Sequence[str] = ()
) -> xarray.Dataset:
    """Every run below a folder as one dataset, written to a file, whole or not at all.

    One run is open at a time.

    Args:
        directory: of a sweep, of several, or of any runs.
        output: the file; without, `collected.nc` in the directory.
        series: time series that go into the group `series` of the file, over the cells and `time`.

    Returns:
        The metrics of `contactlab.metrics.METRICS` over the parameters that differ between runs:
        a dimension each if the runs form a grid, else all along the dimension `run`. NaN with `status`
        and `reason` where a run did not reach its end, numbers with both where its energy ledger is open;
        `job` is the run's folder.

    Raises:
        CollectingError: there is no such folder, no run in it, no such series, or the series of the
            runs are at different times.
        OSError: the file cannot be written.
    """
    directory = Path(directory)
    if not directory.is_dir():
        raise CollectingError(
            f"'{directory}' is not there; it must be a folder of runs. "
            "`contactlab -m law=A,B hydra.sweep.dir=DIR` leaves one."
        )
    runs = list(found_runs(directory))
    if not runs:
        raise CollectingError(
            f"'{directory}' holds no run, nor does a folder below it; it must hold one at least. "
            f"A run leaves one: contactlab hydra.run.dir={directory}"
        )
    layout = layout_of(runs)
    dataset = _dataset(runs, layout)
    slabs = Series(runs, layout, series) if series else None
    path = directory / COLLECTED if output is None else Path(output)
    write(dataset, path, more=slabs and slabs.write)
    return dataset


def _dataset(runs: Sequence[FoundRun], layout: Layout) -> xarray.Dataset:
    metrics = {
        key: layout.spread([run.metrics.get(key, np.nan) for run in runs], np.nan, np.float64)
        for key in METRICS
    }
    status = layout.spread([run.status for run in runs], Status.ABSENT, np.int8)
    reason = layout.spread([run.reason for run in runs], NOT_ASKED, object)
    dataset = dataset_of(
        layout.axes,
        metrics,
        status,
        reason,
        _attributes(runs, complete=bool(np.all(status == Status.COMPLETE))),
        dims=None if layout.grid else layout.dims,
    )
    jobs = layout.spread([run.name for run in runs], "", object)
    dataset["job"] = (layout.dims, jobs, {"long_name": "folder of the run"})
    beside = {
        axis.name: (layout.dims, values, {"units": axis.units} if axis.units else {})
        for axis, values in layout.beside
    }
    return dataset.assign_coords(beside)


def _attributes(runs: Sequence[FoundRun], complete: bool) -> dict[str, Any]:
    common = common_settings(runs)
    laws = {
        str(run.job.configuration["law"].get("name"))
        for run in runs
        if isinstance(run.job.configuration.get("law"), dict)
    }
    code = versions()
    revision, dirty = checkout_state()
    return {
        "Conventions": "CF-1.11",
        "title": "Runs of a standing-wave piezoelectric motor",
        "source": f"contactlab {code['contactlab_version']}, numerical simulation",
        "law": " ".join(sorted(laws)),
        "configuration": yaml.safe_dump(nested(common), sort_keys=False, allow_unicode=True),
        **code,
        "code_digest": code_digest(),
        "git_revision": revision,
        "git_dirty": dirty,
        **counts_of(np.array([run.status for run in runs], dtype=np.int8)),
        "complete": int(complete),
    }
