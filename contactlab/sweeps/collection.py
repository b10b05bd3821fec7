"""What a sweep found as one dataset, read from its folder alone, whatever it keeps of its runs."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Final

import numpy as np
import xarray
import yaml

from contactlab.config.nesting import flat, nested
from contactlab.metrics import METRICS, read_run
from contactlab.results import files
from contactlab.results.provenance import checkout_state
from contactlab.sweeps.dataset import DATASET, SERIES, Slab, counts_of, dataset_of, write
from contactlab.sweeps.discovery import FoundRun, discovered
from contactlab.sweeps.layout import Layout, layout_of
from contactlab.sweeps.state import Status, common_of, read_manifest
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
    keep = read_manifest(directory).keep
    if keep == "metrics":
        if output or series or metrics:
            raise SweepError(
                f"'{directory}' is the folder of a sweep that keeps metrics, whose dataset is its {DATASET} "
                "with the series that it keeps; another file and other series must be left out."
            )
        return Store.opened(directory).merge()
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
    names = list(dict.fromkeys(series))
    write(dataset, path, names, lambda: _slabs(runs, layout, names))
    dataset.encoding["source"] = str(path)
    return dataset


def _dataset(runs: Sequence[FoundRun], layout: Layout, metrics: Sequence[str]) -> xarray.Dataset:
    # Runs whose configuration is not known do not count.
    known = [run.configuration for run in runs if run.configuration]
    sections = [configuration.get("law") for configuration in known]
    laws = {str(section.get("name")) for section in sections if isinstance(section, dict)}
    common = nested(common_of([*map(flat, known)]))
    revision, dirty = checkout_state()
    status = [run.status for run in runs]
    columns = {
        **{
            key: layout.spread([run.metrics.get(key, np.nan) for run in runs], np.nan)
            for key in metrics
        },
        "status": layout.spread(status, np.int8(Status.ABSENT)),
        "reason": layout.spread([run.reason for run in runs], NOT_ASKED),
        "job": layout.spread([run.name for run in runs], ""),
    }
    attributes = {
        "law": " ".join(sorted(laws)),
        "configuration": yaml.safe_dump(common, sort_keys=False, allow_unicode=True),
        "git_revision": revision,
        "git_dirty": dirty,
        **counts_of(np.array(status, dtype=np.int8)),
    }
    return dataset_of(
        layout.axes, columns, attributes, samples=not layout.grid, beside=layout.beside
    )


def _slabs(runs: Sequence[FoundRun], layout: Layout, names: Sequence[str]) -> Iterator[Slab]:
    """Give the time series of the complete runs.

    Raises:
        SweepError: no run is complete, or they are not recorded at the same times, or lack a series.
    """
    first: tuple[str, np.ndarray] | None = None
    for place, run in zip(layout.place, runs, strict=True):
        if run.status is not Status.COMPLETE:
            continue
        try:
            tree = read_run(run.folder / files.DATASET)
        except ValueError as error:
            raise SweepError(str(error)) from error
        time = np.asarray(tree["time"].values, dtype=np.float64)
        first = first or (run.name, time)
        if not np.array_equal(time, first[1]):
            raise SweepError(
                f"'{run.name}' is recorded at other times than '{first[0]}'; for time series they must be "
                "the same. Leave out --series, or run all with one solver.duration and one "
                "record.interval."
            )
        if lacking := [name for name in names if name not in tree.variables]:
            raise SweepError(f"'{run.name}' has no {lacking[0]}; leave it out of --series.")
        cell = tuple(map(int, np.unravel_index(place, layout.shape)))
        yield cell, time, {name: np.asarray(tree[name]) for name in names}
    if first is None:
        raise SweepError(
            "There is no complete run; there must be one for time series. Leave out --series."
        )
