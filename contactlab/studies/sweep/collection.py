"""The runs below a folder as one dataset, read from the folder alone, whatever it keeps of its runs.

Runs lie over their parameters as a grid where they form one, else one after the other.
"""

import os
import re
from collections.abc import Hashable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from math import prod
from pathlib import Path
from types import NoneType
from typing import Any, Final, final

import numpy as np
import pandas
import xarray
from numpy.typing import NDArray
from xarray.indexes import PandasMultiIndex

from contactlab.checks import checked_arguments
from contactlab.config import validate
from contactlab.config.faults import failure_of
from contactlab.config.nesting import flat, nested
from contactlab.config.schema import declared_in
from contactlab.metrics import assess, is_complete, read_run
from contactlab.parameter import Parameter
from contactlab.progress import tell_progress
from contactlab.results import files
from contactlab.results.netcdf import configuration_of
from contactlab.results.provenance import code_digest
from contactlab.results.yaml_text import write_yaml
from contactlab.studies.run_state import RUNNING, Job, Status, is_as_left, is_of_other_code, read_state
from contactlab.studies.sweep.dataset import (
    DATASET,
    DIMENSION,
    REASONS,
    SERIES,
    Axis,
    Outcome,
    Slab,
    columns_of,
    dataset_of,
    text_of,
    write,
)
from contactlab.studies.sweep.plan import Outputs
from contactlab.studies.sweep.study import Sweep, continued, read_plan
from contactlab.studies.sweep.values import SweepError
from contactlab.trajectory import Ending
from contactlab.variables import INTERNAL, Variable

NOT_CONFIGURED: Final = "No run was configured."
"""Reason of a cell of a grid that no run has."""

MOST_EMPTY: Final = 2
"""Cells of a grid over runs; a sweep that was cut or extended still is one."""

_OF_STATE: Final = {status.name.lower(): status for status in Status} | {RUNNING: Status.UNFINISHED}

_WITH_NUMBERS: Final = {Status[ending.name] for ending in Ending if ending.reached_end}

_KEY: Final = re.compile(r"\w+(\.\w+)+")
_GROUP: Final = re.compile(r"\w+(/\w+)*")
"""Keys and groups; the configuration of a dataset may have others."""


@final
@dataclass
class Run(Outcome):
    """A run in a folder, by its name seen from the folder that is collected, its configuration if known."""

    name: str = ""
    folder: Path = Path()
    configured: bool = False
    job: Job = field(default_factory=Job)


@checked_arguments()
def collect(
    directory: str | Path,
    output: str | Path | None = None,
    series: Sequence[str] | str = (),
    metrics: Sequence[str] | str = (),
) -> xarray.Dataset:
    """Collect every run below a folder into one dataset, written to a file, whole or not at all.

    One run is open at a time. Of a sweep that keeps metrics it is what is finished so far.

        >>> import contactlab as cl
        >>> from pathlib import Path
        >>> for law in ("newton", "hertz_penalty"):
        ...     Path(law).mkdir()
        ...     cl.simulate(cl.build([f"law={law}"]), duration=5e-4).save(f"{law}/run.nc")
        ...
        >>> cl.collect(".", metrics="contact_count")["contact_count"].to_series().to_dict()
        {'hertz_penalty': 2.0, 'newton': 2.0}

    Args:
        directory: of a sweep, of several, or of any runs.
        output: the file; without, `sweep.nc` in the directory.
        series: those that go into the group `series` of the file, over the cells and `time`.
        metrics: keys of `contactlab.metrics.METRICS`; all where none is named.

    Returns:
        The metrics over the parameters that differ between runs: a dimension each if the runs form a
        grid, else all along the dimension `run`. NaN with `status` and `reason` where a run did not reach
        its end, numbers with both where its energy ledger is open; `job` is the run's folder. The attribute
        `runs_of_other_code` counts those whose law, resonator or contactlab has changed since. The file is
        the attribute `source` of the dataset's `encoding`.

    Raises:
        ConfigurationError: there is no such metric or series.
        SweepError: there is no such folder or no run in it, or the series of the runs are at different times.
        ValueError: for the series, a run of which is damaged.
        OSError: the file cannot be written.
    """
    directory = Path(directory)
    if not directory.is_dir():
        raise SweepError(f"'{directory}' must be a folder of runs, as `contactlab -m ...` leaves it.")
    plan = read_plan(directory)
    if plan and plan.keep == "metrics":
        if output or series or metrics:
            raise SweepError(f"'{directory}' keeps metrics alone; file, series and metrics must be left out.")
        return continued(Sweep(plan=plan), directory, as_it_is=True)
    outputs = Outputs.named(metrics or "all", series)
    if not (runs := list(discovered(directory))):
        raise SweepError(f"'{directory}' must have a run, itself or in a folder below it.")
    dataset = _dataset(runs, outputs.metrics)
    if dims := [] if plan and plan.samples else dimensions(dataset):
        texts = {name for name, variable in dataset.variables.items() if variable.dtype.kind == "O"}
        empty: dict[Hashable, Any] = {name: "" if name in texts else np.nan for name in dataset.variables}
        empty |= {"status": np.int8(Status.ABSENT), "reason": NOT_CONFIGURED}
        choices = {name: pandas.unique(dataset[name].values) for name in dims if name in texts}
        dataset = dataset.set_xindex(dims, PandasMultiIndex).unstack(DIMENSION, fill_value=empty)
        # Choices keep the order in which the sweep names them.
        for axis in plan.axes if plan else ():
            if {*axis.values} >= {*choices.get(axis.key, (None,))}:
                choices[axis.key] = [value for value in axis.values if value in choices[axis.key]]
        dataset = dataset.sel(choices)
        dataset.attrs["complete"] = int(not dataset["status"].any())
    path = directory / DATASET if output is None else Path(output)
    with files.whole_netcdf(path) as partial:
        kept = _kept(runs, outputs)
        write(dataset, partial, kept, _slabs(runs, dataset, kept))
    dataset.encoding["source"] = str(path)
    return dataset


def discovered(directory: Path) -> Iterator[Run]:
    """Yield every run below a folder, the folder itself included."""
    names: list[str] = []
    for place, below, there in os.walk(directory):
        below[:] = [name for name in below if not name.startswith(".")]
        files.remove_stale(Path(place))
        if not {files.DATASET, files.STATE}.isdisjoint(there):
            names.append(Path(place).relative_to(directory).as_posix())

    def in_order(name: str) -> list[tuple[int, str]]:
        """Sort 10_... after 9_..."""
        parts = re.split(r"(\d+)", name)
        return [(int(part), "") if part.isdigit() else (-1, part) for part in parts]

    for done, name in enumerate(sorted(names, key=in_order)):
        tell_progress(f"{done} of {len(names)} runs", done / len(names))
        yield _read_run(name, directory / name)


def _read_run(name: str, folder: Path) -> Run:
    """Return the run of a folder by its state, or by its dataset alone."""
    state = read_state(folder)
    run = Run(Status.COMPLETE, "", name=name, folder=folder, configured=state is not None)
    if state:
        run.job, run.status = state.job, _OF_STATE.get(state.state, Status.FAILED)
        run.reason = state.reason or REASONS.get(run.status, f"The run is {state.state}.")
    elif not (folder / files.DATASET).is_file():
        run.status = Status.FAILED
        run.reason = f"{files.STATE} cannot be read, and there is no {files.DATASET}. Run it again."
    if run.status not in _WITH_NUMBERS:
        return run
    if state and state.code == code_digest() and is_as_left(folder, state):
        run.numbers = state.metrics
        return run
    # A file can be anything, and the other runs are collected.
    try:
        tree = read_run(folder / files.DATASET)
        run.job = run.job if state else Job(configuration=configuration_of(tree.attrs))
        run.status, run.reason = Status.COMPLETE, ""
        if not is_complete(tree):
            status = _OF_STATE.get(str(tree.attrs.get("ending", "")), Status.FAILED)
            run.status = Status.FAILED if status is Status.COMPLETE else status
            run.reason = str(tree.attrs.get("message", "")) or "The dataset is not complete."
        run.numbers = assess(tree) if run.status in _WITH_NUMBERS else {}
    except Exception as error:
        run.status, run.reason = Status.FAILED, failure_of(error)
    return run


def _dataset(runs: Sequence[Run], metrics: Sequence[str]) -> xarray.Dataset:
    """Return the dataset of runs, one after the other; those of unknown configuration share all."""
    known = [flat(run.job.configuration) for run in runs if run.job.configuration]
    common = {
        key: value
        for key, value in (known[0] if known else {}).items()
        if all(key in settings and settings[key] == value for settings in known)
    }
    columns = columns_of(runs, metrics) | {"job": np.array([run.name for run in runs])}
    others = sum(
        bool(run.job.key) and run.status in _WITH_NUMBERS and is_of_other_code(run.job) for run in runs
    )
    attributes = {
        "runs_of_other_code": others,
        "law": " ".join(sorted({str(each["law.name"]) for each in known if "law.name" in each})),
        "configuration": write_yaml(nested(common)),
    }
    axes = parameters([run.job for run in runs], all(run.configured for run in runs))
    return dataset_of(axes, columns, attributes, samples=True)


def _kept(runs: Sequence[Run], outputs: Outputs) -> tuple[Variable, ...]:
    """Return the series as variables; an internal one is described by the files, alike in all."""
    wanted = {name for name in outputs.series if name.startswith(INTERNAL)}
    variables: dict[str, Variable] = {}
    for run in runs if wanted else ():
        if run.status is Status.COMPLETE:
            tree = read_run(run.folder / files.DATASET)
            for name in wanted.intersection(map(str, tree.variables)):
                attrs = tree[name].attrs
                texts = (str(attrs.get(key, "")) for key in ("units", "symbol", "long_name"))
                variable = Variable(name, ("time",), *texts, comment=str(attrs.get("comment", "")))
                if variables.setdefault(name, variable) != variable:
                    raise SweepError(f"'{run.name}' has another {name} than other runs; leave it out.")
    if lacking := sorted(wanted - {*variables}):
        raise SweepError(f"No complete run has {lacking[0]}; leave it out of series.")
    return replace(outputs, internal=tuple(variables.values())).kept


def _slabs(runs: Sequence[Run], dataset: xarray.Dataset, kept: Sequence[Variable]) -> Iterator[Slab]:
    """Yield the time series of the complete runs; a SweepError if they cannot be joined."""
    places = {job: place for place, job in np.ndenumerate(dataset["job"].values)}
    complete = [run for run in runs if run.status is Status.COMPLETE]
    if not complete:
        raise SweepError("There is no complete run; there must be one for series.")
    first: NDArray[Any] | None = None
    for run in complete:
        tree = read_run(run.folder / files.DATASET)
        time = np.asarray(tree["time"].values, dtype=np.float64)
        first = time if first is None else first
        if not np.array_equal(time, first):
            raise SweepError(
                f"'{run.name}' is recorded at other times than '{complete[0].name}'; for series all runs "
                "must have one solver.duration and one record.interval."
            )
        rows = {each.name: np.asarray(tree[each.name]) for each in kept if each.name in tree.variables}
        if lacking := [each.name for each in kept if each.name in SERIES and each.name not in rows]:
            raise SweepError(f"'{run.name}' has no {lacking[0]}; leave it out of series.")
        # A law without the internal variable has none.
        none = np.full(time.size, np.nan)
        yield places[run.name], time, {each.name: rows.get(each.name, none) for each in kept}


def dimensions(dataset: xarray.Dataset) -> list[str]:
    """Return the parameters over which runs form a grid: they nearly fill it, and share no cell."""
    table = pandas.DataFrame({name: values.values for name, values in dataset.coords.items()})
    chosen: list[str] = []
    for name in table:
        if _different(table[[*chosen, name]]) > _different(table[chosen]):
            chosen.append(name)
    cells, runs = prod(table[chosen].nunique()), dataset.sizes[DIMENSION]
    if _different(table[chosen]) < runs or cells > MOST_EMPTY * runs:
        return []
    # Parameters that follow from an option belong to it; numbers that follow from a number are points
    # that somebody chose.
    numbers = [name for name in chosen if "units" in dataset[name].attrs]
    follow = len(chosen) == len(table.columns) or len(numbers) < len(chosen)
    return chosen if follow and not table[numbers].isna().any(axis=None) else []


def _different(table: Any) -> int:
    """Return the number of different rows of a table; without columns all are alike."""
    return len(table.drop_duplicates()) if len(table.columns) else 1


def parameters(jobs: Sequence[Job], configured: bool) -> list[Axis]:
    """Return what differs between runs, in their configurations or else in what they recorded."""
    settings = [
        {key: value for key, value in flat(job.configuration).items() if _KEY.fullmatch(key)} for job in jobs
    ]
    keys = list(dict.fromkeys(key for setting in settings for key in setting))
    columns: dict[str, list[Any]] = {}
    if configured:
        groups = dict.fromkeys(group for job in jobs for group in job.choices)
        overridden = {line.partition("=")[0].lstrip("+~") for job in jobs for line in job.overrides}
        columns = {
            group: [job.choices.get(group) or "" for job in jobs]
            for group in groups
            if _GROUP.fullmatch(group)
        }
        # Overrides set keys one by one or as a group of keys.
        overridden -= groups.keys()
        keys = [key for key in keys if any(f"{key}.".startswith(f"{name}.") for name in overridden)]
    for key in keys:
        # The choice of the law is named by its group.
        columns[key.removesuffix(".name")] = [setting.get(key) for setting in settings]
    declared: dict[str, Parameter] = {}
    unknown = {*keys}
    for job, setting in zip(jobs, settings, strict=True):
        if own := unknown & setting.keys():
            # A configuration may be anything, and its law may no longer be installed.
            with suppress(Exception):
                declared |= declared_in(validate(job.configuration))
                unknown -= own
    axes: list[Axis] = []
    for name, values in columns.items():
        if any(value != values[0] for value in values):
            axis = Axis(name, tuple(text_of(value) for value in values))
            if all(type(value) in (int, float, NoneType) for value in values):
                # A whole number may have any size.
                with suppress(OverflowError):
                    numbers = tuple(np.nan if value is None else float(value) for value in values)
                    number = declared.get(name, Parameter("", "1", ""))
                    axis = Axis(name, numbers, number.units, number.meaning)
            axes.append(axis)
    return axes
