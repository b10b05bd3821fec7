"""What a sweep found as one dataset, read from its folder alone, whatever it keeps of its runs.

Runs lie over their parameters as a grid where they form one, else one after the other.
"""

import os
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final, final

import numpy as np
import xarray
import yaml
from numpy.typing import NDArray
from xarray.indexes import PandasMultiIndex

from contactlab.config.faults import one_line
from contactlab.config.nesting import flat, nested
from contactlab.metrics import assess, is_complete, read_run
from contactlab.results import files
from contactlab.results.netcdf import configuration_of
from contactlab.sweeps.axes import dimensions, parameters
from contactlab.sweeps.batch import Outputs
from contactlab.sweeps.dataset import DATASET, REASONS, RUN, SERIES, Slab, dataset_of, write
from contactlab.sweeps.state import RUNNING, Job, Status, read_state, status_of
from contactlab.sweeps.store import Store, read_plan
from contactlab.sweeps.values import SweepError
from contactlab.trajectory import Ending
from contactlab.variables import INTERNAL, Variable

NOT_ASKED: Final = "No run was asked for."
"""The reason of a cell of a grid that no run has."""

_OF_STATE: Final = {status.name.lower(): status for status in Status} | {RUNNING: Status.UNFINISHED}

_WITH_NUMBERS: Final = {status_of(ending) for ending in Ending if ending.reached_end}


@final
@dataclass
class FoundRun:
    """Tells what became of a run in a folder, by its name seen from the folder that is collected.

    What it was asked for may not be known; metrics are empty where it did not reach its end.
    """

    name: str
    folder: Path
    asked: bool
    job: Job
    status: Status = Status.COMPLETE
    reason: str = ""
    metrics: Mapping[str, float] = field(default_factory=dict)


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
        its end, numbers with both where its energy ledger is open; `job` is the run's folder. The file is
        the attribute `source` of the dataset's `encoding`.

    Raises:
        ConfigurationError: there is no such metric or series.
        SweepError: there is no such folder or no run in it, or the series of the runs are at different times.
        OSError: the file cannot be written.
    """
    directory = Path(directory)
    if not directory.is_dir():
        what = "a file" if directory.exists() else "not there"
        raise SweepError(
            f"'{directory}' is {what}; it must be a folder of runs. "
            "`contactlab -m law=A,B hydra.sweep.dir=DIR` leaves one."
        )
    plan = read_plan(directory)
    if plan and plan.keep == "metrics":
        if output or series or metrics:
            raise SweepError(
                f"'{directory}' is the folder of a sweep that keeps metrics, whose dataset is its {DATASET} "
                "with the series that it keeps; another file and other series must be left out."
            )
        return Store(directory, plan).merge()
    outputs = Outputs.named(metrics or "all", series)
    if not (runs := list(discovered(directory))):
        raise SweepError(
            f"'{directory}' holds no run, nor does a folder below it; it must hold one at least. "
            f"A run leaves one: contactlab hydra.run.dir={directory}"
        )
    dataset = _dataset(runs, outputs.metrics)
    if dims := [] if plan and plan.samples else dimensions(dataset):
        texts = {name: "" for name, found in dataset.variables.items() if found.dtype.kind == "O"}
        empty = texts | {"status": np.int8(Status.ABSENT), "reason": NOT_ASKED}
        dataset = dataset.set_xindex(dims, PandasMultiIndex).unstack(RUN, fill_value=empty)
        dataset.attrs["complete"] = int(not dataset["status"].any())
    path = directory / DATASET if output is None else Path(output)
    with files.whole_netcdf(path) as partial:
        kept = _kept(runs, outputs)
        write(dataset, partial, kept, lambda: _slabs(runs, dataset, kept))
    dataset.encoding["source"] = str(path)
    return dataset


def discovered(directory: Path) -> Iterator[FoundRun]:
    """Find every run below a folder, the folder itself included; each is read when it is asked for."""
    names: list[str] = []
    for place, below, there in os.walk(directory):
        below[:] = [name for name in below if not name.startswith(".")]
        files.remove_left(Path(place))
        if not {files.DATASET, files.STATE}.isdisjoint(there):
            names.append(Path(place).relative_to(directory).as_posix())

    def in_order(name: str) -> list[tuple[int, str]]:
        """Sort 10_... after 9_..."""
        words = re.split(r"(\d+)", name)
        return [(int(word), "") if word.isdigit() else (-1, word) for word in words]

    for name in sorted(names, key=in_order):
        yield _found(name, directory / name)


def _found(name: str, folder: Path) -> FoundRun:
    """Take a run that says itself what became of it, or of which there is a dataset alone."""
    state = read_state(folder)
    run = FoundRun(name, folder, state is not None, state.job if state else Job())
    if state:
        run.status = _OF_STATE.get(state.state, Status.FAILED)
        run.reason = state.reason or REASONS.get(run.status, f"The run is {state.state}.")
    elif not (folder / files.DATASET).is_file():
        run.status = Status.FAILED
        run.reason = f"{files.STATE} cannot be read, and there is no {files.DATASET}. Run it again."
    if run.status not in _WITH_NUMBERS:
        return run
    # A file can be anything, and the other runs shall not suffer from it.
    try:
        tree = read_run(folder / files.DATASET)
        run.job = run.job if state else Job(configuration=configuration_of(tree))
        run.status, run.reason = Status.COMPLETE, ""
        if not is_complete(tree):
            status = _OF_STATE.get(str(tree.attrs.get("ending", "")), Status.FAILED)
            run.status = Status.FAILED if status is Status.COMPLETE else status
            said = str(tree.attrs.get("message", ""))
            run.reason = said or "The dataset says that it is not complete."
        run.metrics = assess(tree) if run.status in _WITH_NUMBERS else {}
    except Exception as error:
        run.status, run.reason = Status.FAILED, one_line(error)
    return run


def _dataset(runs: Sequence[FoundRun], metrics: Sequence[str]) -> xarray.Dataset:
    """Give the dataset of runs, one after the other; those whose configuration is not known share all."""
    known = [flat(run.job.configuration) for run in runs if run.job.configuration]
    common = {
        key: value
        for key, value in (known[0] if known else {}).items()
        if all(key in settings and settings[key] == value for settings in known)
    }
    columns = {
        **{key: np.array([run.metrics.get(key, np.nan) for run in runs]) for key in metrics},
        "status": np.array([run.status for run in runs], dtype=np.int8),
        "reason": np.array([run.reason for run in runs]),
        "job": np.array([run.name for run in runs]),
    }
    attributes = {
        "law": " ".join(sorted({str(one["law.name"]) for one in known if "law.name" in one})),
        "configuration": yaml.safe_dump(nested(common), sort_keys=False, allow_unicode=True),
    }
    return dataset_of(
        parameters([run.job for run in runs], all(run.asked for run in runs)),
        columns,
        attributes,
        samples=True,
    )


def _kept(runs: Sequence[FoundRun], outputs: Outputs) -> tuple[Variable, ...]:
    """Give the series as variables; an internal one is what the files say of it, and the same in all."""
    missing, found = {name for name in outputs.series if name.startswith(INTERNAL)}, dict[str, Variable]()
    for run in runs if missing else ():
        if run.status is Status.COMPLETE:
            tree = _read(run)
            for name in missing.intersection(map(str, tree.variables)):
                said = tree[name].attrs
                words = (str(said.get(word, "")) for word in ("units", "symbol", "long_name"))
                one = Variable(name, ("time",), *words, comment=str(said.get("comment", "")))
                if found.setdefault(name, one) != one:
                    raise SweepError(
                        f"'{run.name}' means something else by {name} than the runs before it; it must be "
                        "the same in all runs. Leave it out of --series."
                    )
    if lacking := sorted(missing - {*found}):
        raise SweepError(f"No complete run has {lacking[0]}; leave it out of --series.")
    return replace(outputs, internal=tuple(found.values())).kept


def _read(run: FoundRun) -> xarray.DataTree:
    try:
        return read_run(run.folder / files.DATASET)
    except ValueError as error:
        raise SweepError(str(error)) from error


def _slabs(runs: Sequence[FoundRun], dataset: xarray.Dataset, kept: Sequence[Variable]) -> Iterator[Slab]:
    """Give the time series of the complete runs; a SweepError tells of those that cannot be joined."""
    places = {job: place for place, job in np.ndenumerate(dataset["job"].values)}
    complete = [run for run in runs if run.status is Status.COMPLETE]
    if not complete:
        raise SweepError("There is no complete run; there must be one for time series. Leave out --series.")
    first: NDArray[Any] | None = None
    for run in complete:
        tree = _read(run)
        time = np.asarray(tree["time"].values, dtype=np.float64)
        first = time if first is None else first
        if not np.array_equal(time, first):
            raise SweepError(
                f"'{run.name}' is recorded at other times than '{complete[0].name}'; for time series they "
                "must be the same. Leave out --series, or run all with one solver.duration and one "
                "record.interval."
            )
        rows = {one.name: np.asarray(tree[one.name]) for one in kept if one.name in tree.variables}
        if lacking := [one.name for one in kept if one.name in SERIES and one.name not in rows]:
            raise SweepError(f"'{run.name}' has no {lacking[0]}; leave it out of --series.")
        # A law that does not remember it has none.
        none = np.full(time.size, np.nan)
        yield places[run.name], time, {one.name: rows.get(one.name, none) for one in kept}
