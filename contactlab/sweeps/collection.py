"""What a sweep found as one dataset, read from its folder alone, whatever it keeps of its runs.

Runs lie over their parameters as a grid where they form one, else one after the other.
"""

import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from math import prod
from pathlib import Path
from typing import Any, Final, final

import numpy as np
import xarray
import yaml
from numpy.typing import NDArray

from contactlab.config import validate
from contactlab.config.nesting import flat, nested
from contactlab.config.schema import declared_in
from contactlab.metrics import METRICS, read_run
from contactlab.parameter import Parameter
from contactlab.results import files
from contactlab.results.provenance import checkout_state
from contactlab.sweeps.dataset import (
    DATASET,
    SERIES,
    Axis,
    Slab,
    counts_of,
    dataset_of,
    text_of,
    write,
)
from contactlab.sweeps.discovery import FoundRun, discovered
from contactlab.sweeps.state import Status, common_of, read_manifest
from contactlab.sweeps.store import Store
from contactlab.sweeps.values import SweepError

NOT_ASKED: Final = "No run was asked for."
"""The reason of a cell of a grid that no run has."""

_KEY: Final = re.compile(r"\w+(\.\w+)+")
_GROUP: Final = re.compile(r"\w+(/\w+)*")
"""What can be a key or a group; a configuration of one's own may be anything."""

MOST_EMPTY: Final = 2
"""Cells of a grid over runs; a sweep that was cut or extended still is one."""


@final
@dataclass(frozen=True)
class Layout:
    """Tells where every run stands."""

    axes: Sequence[Axis]
    """The parameters along the dimensions, or along the one dimension of the runs."""
    beside: Sequence[Axis]
    """Parameters that follow from those of the axes, a value a cell."""
    shape: tuple[int, ...]
    place: NDArray[np.intp]
    """Of every run among the cells in C order, shape (run,)."""
    grid: bool
    """Whether each axis is a dimension."""

    def spread(self, values: Sequence[Any], empty: Any) -> NDArray[Any]:
        """Give one value a run, all of the kind of `empty`, in the order of the cells."""
        kind = object if isinstance(empty, str) else np.asarray(empty).dtype
        cells = np.full(prod(self.shape), empty, dtype=kind)
        cells[self.place] = np.asarray(values, dtype=kind)
        return cells


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
    layout = _layout_of(runs, samples=keep == "samples")
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


def _layout_of(runs: Sequence[FoundRun], *, samples: bool = False) -> Layout:
    """Lay runs out: as a grid if they nearly fill one, share no cell and are no samples."""
    parameters = _parameters(runs)
    chosen: list[Axis] = []
    rest: list[Axis] = []
    for axis in parameters:
        more = _different([*chosen, axis]) > _different(chosen)
        (chosen if more else rest).append(axis)
    if samples or not _is_grid(chosen, rest, len(runs)):
        return Layout(parameters, (), (len(runs),), np.arange(len(runs)), grid=False)
    along = [np.unique(axis.coordinate, return_inverse=True) for axis in chosen]
    shape = tuple(values.size for values, _ in along)
    place = np.ravel_multi_index([steps for _, steps in along], shape)
    axes = [
        replace(axis, values=tuple(values.tolist()))
        for axis, (values, _) in zip(chosen, along, strict=True)
    ]
    grid = Layout(axes, (), shape, place, grid=True)
    beside = [
        replace(a, values=tuple(grid.spread(a.values, np.nan if a.units else ""))) for a in rest
    ]
    return replace(grid, beside=beside)


def _is_grid(chosen: Sequence[Axis], rest: Sequence[Axis], runs: int) -> bool:
    cells = prod(len(set(axis.values)) for axis in chosen)
    if not chosen or _different(chosen) < runs or cells > MOST_EMPTY * runs:
        return False
    if any(axis.units and np.isnan(axis.coordinate).any() for axis in chosen):
        return False
    # Parameters that follow from an option belong to it; numbers that follow from a number are
    # points that somebody chose.
    return not rest or any(not axis.units for axis in chosen)


def _different(axes: Sequence[Axis]) -> int:
    """Count the different values of all axes together; a NaN equals itself here."""
    return len(set(zip(*(map(repr, axis.values) for axis in axes), strict=True))) or 1


def _parameters(runs: Sequence[FoundRun]) -> list[Axis]:
    """Find what differs between runs, of what they were asked for or else of what they recorded."""
    settings = [
        {key: value for key, value in flat(run.configuration).items() if _KEY.fullmatch(key)}
        for run in runs
    ]
    keys = list(dict.fromkeys(key for setting in settings for key in setting))
    columns: dict[str, list[Any]] = {}
    jobs = [run.job for run in runs if run.job]
    if len(jobs) == len(runs):
        groups = dict.fromkeys(group for job in jobs for group in job.choices)
        given = {line.partition("=")[0].lstrip("+~") for job in jobs for line in job.overrides}
        columns = {
            group: [job.choices.get(group) or "" for job in jobs]
            for group in groups
            if _GROUP.fullmatch(group)
        }
        # Overrides set keys one by one or as a group of keys.
        given -= groups.keys()
        keys = [key for key in keys if any(f"{key}.".startswith(f"{name}.") for name in given)]
    for key in keys:
        # The choice of the law is named by its group: the key that tells it is the law's name.
        columns[key.removesuffix(".name")] = [setting.get(key) for setting in settings]
    declared = _declared(runs, {*keys})
    return [
        _axis(name, values, declared.get(name))
        for name, values in columns.items()
        if any(value != values[0] for value in values)
    ]


def _declared(runs: Sequence[FoundRun], keys: set[str]) -> dict[str, Parameter]:
    """Find what is declared of keys, from the first configurations that have them."""
    declared: dict[str, Parameter] = {}
    for run in runs:
        if missing := keys & flat(run.configuration).keys():
            # A configuration of one's own may be anything, and a law may no longer be installed.
            with suppress(Exception):
                declared |= declared_in(validate(run.configuration))
                keys = keys - missing
    return declared


def _axis(name: str, values: Sequence[Any], said: Parameter | None) -> Axis:
    if all(value is None or _is_number(value) for value in values):
        numbers = tuple(np.nan if v is None else float(v) for v in values)
        return Axis(name, numbers, said.units if said else "1", said.meaning if said else "")
    return Axis(name, tuple(text_of(value) for value in values))


def _is_number(value: Any) -> bool:
    if isinstance(value, int):
        return not isinstance(value, bool) and abs(value) < 2**sys.float_info.max_exp
    return isinstance(value, float)
