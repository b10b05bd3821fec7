"""The study `sweep`: many runs, or another study many times, whose numbers lie in one dataset.

One task is some cells of a plan. A cell leaves its numbers, or a folder (`contactlab.studies.run_state`), by
whose state it is skipped where it is complete. Of numbers alone there are

    DIR/sweep.json        the plan of the runs, and the digest of the code
    DIR/tasks/*.nc        finished tasks, see `contactlab.studies.runner`
    DIR/sweep.nc          the dataset; the tasks are removed once it is on the disk
    DIR/sweep.nc.sha256   its digest, in the format of `sha256sum -c`
    DIR/unfinished.nc     the finished runs of an unfinished sweep, where `collect` was called

Every file appears whole or not at all, and the numbers of a task do not depend on when or where it runs.
Several processes may therefore work on one sweep: they write the same bytes.
"""

import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, Final, TypeAlias

import numpy as np
import pandas
import xarray

from contactlab.checks import check_kind, checked_arguments
from contactlab.config import ConfigurationError, Setup, rebuild
from contactlab.config.composition import compose, overridden, parsed
from contactlab.config.faults import failure_of, is_sentence
from contactlab.config.made_in_python import variable_numbers, with_number
from contactlab.config.nesting import Value, flat
from contactlab.estimate import Estimate
from contactlab.interrupts import is_of_a_signal
from contactlab.laws import LawError
from contactlab.metrics import Run, assess
from contactlab.processes import processors
from contactlab.progress import part_of_progress, tell_progress
from contactlab.results.files import LOG, digest_of_file, whole_file, whole_netcdf
from contactlab.results.yaml_text import write_yaml
from contactlab.settling.criterion import STEADY
from contactlab.studies.run_state import (
    INTERRUPTED,
    REFUSED,
    Job,
    State,
    Status,
    leave,
    write_log,
    write_state,
)
from contactlab.studies.runner import TASKS, Store, done_parts
from contactlab.studies.study import Part, Progress, Setups, Study, Task
from contactlab.studies.sweep.dataset import (
    DATASET,
    REASONS,
    Axis,
    Outcome,
    Slab,
    columns_of,
    dataset_of,
    with_series,
    write,
)
from contactlab.studies.sweep.plan import (
    NOTHING,
    ONE_PROCESS,
    Columns,
    Compose,
    Configuration,
    Outputs,
    Plan,
    full_keys,
    planned,
    size_of_tasks,
)
from contactlab.studies.sweep.values import SweepError, in_si, listed, spread

Over: TypeAlias = Mapping[str, Any] | pandas.DataFrame | Sequence[Mapping[str, Any]]

Base: TypeAlias = Sequence[str] | Configuration | Setup | Callable[..., Setup]

Maker: TypeAlias = Callable[[Plan, int], Setup]
"""Makes the setup of a cell; a `ConfigurationError` makes the cell a refused one."""

MANIFEST: Final = "sweep.json"
DIGEST: Final = f"{DATASET}.sha256"
UNFINISHED: Final = "unfinished.nc"


@dataclass(frozen=True, kw_only=True)
class Sweep(Study):
    """What becomes of every combination of values, or of every row of a table?

    Args:
        plan: of the runs.
        make: makes the setup of a cell from the plan.
        question: the study that is put to each setup, where the configuration does not name it.
        folders: folder and job of the cells that leave one and are not complete; None leaves none.
        log: folder of the traceback of the first cell that failed by a fault of some code; None without.
    """

    name: ClassVar[str] = "sweep"
    plan: Plan
    make: Maker = Plan.setup_at
    question: Study | None = None
    folders: Mapping[int, tuple[Path, Job]] | None = None
    log: Path | None = None

    @property
    def delay(self) -> float:  # type: ignore[override]
        """Processor time after which other processes are started [s]; at once where runs leave folders."""
        return 2.0 if self.folders is None else 0.0

    @property
    def options(self) -> dict[str, Any]:
        """The plan, on which alone the numbers depend."""
        return {"plan": self.plan.text()}

    def tasks(self, setups: Setups) -> Iterable[Task]:
        """Return tasks of as many cells as the plan has in a chunk, whatever the number of workers."""
        del setups
        cells = self.cells
        for start in range(0, len(cells), self.plan.chunk):
            own = cells[start : start + self.plan.chunk]
            # A task brings the values of its own cells alone.
            rows, folders = self.plan.rows(own), [self.folders[cell] for cell in own] if self.folders else []
            yield Task(str(own[0]), _done, (own[0], rows, self.make, self.question, folders, self.log))

    @property
    def cells(self) -> Sequence[int]:
        """The cells of the plan that are done."""
        return range(self.plan.cells) if self.folders is None else [*self.folders]

    def combine(self, setups: Setups, parts: Mapping[str, xarray.DataTree]) -> xarray.DataTree:
        """Return the dataset of all runs, their time series included."""
        del setups
        series = _slabs(self.plan, parts)
        return xarray.DataTree(with_series(combined(self.plan, parts), self.plan.outputs.kept, series))

    def numbers(self, data: xarray.DataTree) -> dict[str, Estimate]:
        """Return none: the numbers of a sweep are variables of its dataset."""
        del data
        return {}


def _done(
    first: int,
    plan: Plan,
    make: Maker,
    question: Study | None,
    folders: Sequence[tuple[Path, Job]],
    log: Path | None,
) -> Part:
    """Run cells and return their numbers along `run`; series are a group, NaN where a run has none.

    Args:
        first: number of the first one in the whole sweep.
        plan, make, question, folders, log: see `Sweep`.
    """
    outputs, runs = plan.outputs, list[Outcome]()
    for cell in range(plan.cells):
        with part_of_progress(cell / plan.cells, (cell + 1) / plan.cells, f"run {first + cell + 1}: "):
            tell_progress("", 0.0)
            runs.append(_left(*folders[cell]) if folders else _outcome(plan, cell, make, question, log))
    root = {name: ("run", column) for name, column in columns_of(runs, outputs.metrics).items()}
    groups = {"/": xarray.Dataset(root)}
    time = next((each.time for each in runs if each.time is not None), None)
    if time is not None:
        none = np.full(time.size, np.nan)
        rows = {
            name: (("run", "time"), np.stack([each.series[name] if each.series else none for each in runs]))
            for name in outputs.series
        }
        groups["/series"] = xarray.Dataset({**rows, "times": ("time", time)})
    return Part(xarray.DataTree.from_dict(groups))


def _left(folder: Path, job: Job) -> Outcome:
    """Run one cell in its folder; its numbers are in its state, from which they are collected."""
    try:
        setup = rebuild(job.configuration)
    # A file of the configuration may be gone since the plan was made.
    except ConfigurationError as error:
        write_state(folder, State(REFUSED, job, reason := " ".join(error.faults)))
        return Outcome(Status.REFUSED, reason)
    state, _ = leave(setup, folder, job)
    if state.state == INTERRUPTED:
        raise KeyboardInterrupt(state.reason)
    return Outcome(Status[state.state.upper()], state.reason)


def _outcome(plan: Plan, cell: int, make: Maker, question: Study | None, log: Path | None) -> Outcome:
    """Run one cell."""
    outputs = plan.outputs
    try:
        setup = make(plan, cell)
        if outputs.study:
            study = question or plan.study_at(cell)
            every = study.evaluate(setup)
            values = {q.name: every[q.name].value for q in study.quantities}
            errors = {f"{q.name}_error": every[q.name].error for q in study.quantities}
            return Outcome(Status.COMPLETE, numbers=values | errors)
        sampled = outputs.sampled or setup.until == STEADY
        trajectory = setup.run(record_interval=setup.record_interval if sampled else setup.duration)
        outcome = Outcome(Status[trajectory.ending.name], trajectory.message)
        if trajectory.ending.reached_end:
            outcome.numbers = assess(Run.of_trajectory(trajectory, setup.configuration), outputs.metrics)
            if outputs.series:
                none = np.full(trajectory.time.size, np.nan)
                outcome.time = trajectory.time
                # A copy: a view would keep all that the run has recorded in memory.
                outcome.series = {name: trajectory.series.get(name, none).copy() for name in outputs.series}
    except ConfigurationError as error:
        return Outcome(Status.REFUSED, " ".join(error.faults))
    except LawError as error:
        return Outcome(reason=str(error))
    # One of ten thousand runs does not end the others.
    except Exception as error:
        # The end of a cluster's time is no result of the cell: the task is to be done again.
        if is_of_a_signal(error):
            raise
        if log and not is_sentence(error) and not (log / LOG).exists():
            write_log(log, error)
        return Outcome(reason=failure_of(error))
    return outcome


def combined(plan: Plan, parts: Mapping[str, xarray.DataTree]) -> xarray.Dataset:
    """Return the dataset of a plan from the tasks that are finished, one in memory at a time."""
    outputs = plan.outputs
    absent = columns_of([Outcome(Status.ABSENT, REASONS[Status.ABSENT])], outputs.metrics)
    columns = {name: np.repeat(column, plan.cells) for name, column in absent.items()}
    for start, part in parts.items():
        for name, column in columns.items():
            column[int(start) : int(start) + part.sizes["run"]] = part[name].values
    attributes: dict[str, Any] = {}
    if plan.bases != ({},):
        shown = plan.bases[0] if len(plan.bases) == 1 else list(plan.bases)
        attributes["configuration"] = write_yaml(shown)
    return dataset_of(
        plan.axes, columns, attributes, samples=plan.samples, series=outputs.kept, numbers=outputs.numbers
    )


def _slabs(plan: Plan, parts: Mapping[str, xarray.DataTree]) -> Iterator[Slab]:
    """Yield the time series of every run, one task in memory at a time."""
    for start, part in parts.items():
        if "series" in part.children:
            group = part["series"].to_dataset()
            time = group["times"].values
            rows = {name: group[name].values for name in plan.outputs.series}
            for row in range(part.sizes["run"]):
                place = tuple(map(int, np.unravel_index(int(start) + row, plan.shape)))
                yield place, time, {name: values[row] for name, values in rows.items()}


def begin(folder: Path, plan: Plan) -> None:
    """Write the plan of a sweep; a sweep of folders may be extended.

    Raises:
        SweepError: the folder contains another sweep, or one by other code.
        OSError: the folder cannot be written to.
    """
    folder.mkdir(parents=True, exist_ok=True)
    file, there = folder / MANIFEST, read_plan(folder)
    extends = plan.keep == "runs" and (there is None or there.keep == "runs")
    # Of several processes that begin at once one writes the file.
    if extends or not file.exists():
        with suppress(FileExistsError), whole_file(file, fresh=not extends) as partly:
            partly.write_text(plan.text(), encoding="utf-8")
    if not extends and file.read_bytes() != plan.text().encode():
        raise SweepError(
            f"'{folder}' contains another sweep, or one by other code; it must be another folder."
        )


def read_plan(folder: Path) -> Plan | None:
    """Return the plan of the sweep in a folder; None where there is none that can be read."""
    try:
        return Plan.of_text((folder / MANIFEST).read_bytes())
    except (OSError, ValueError, RecursionError):
        return None


def continued(
    study: Sweep, folder: Path, progress: Progress | None = None, *, as_it_is: bool = False
) -> xarray.Dataset:
    """Do what is left of a sweep in its folder, write sweep.nc, remove the tasks and return the dataset.

    Series are in the file only, which is the attribute `source` of its `encoding`. A sweep that is left as it
    is has a file of its finished runs beside its tasks where it is not finished.

    Raises:
        SweepError: sweep.nc is damaged.
        WorkerError: a worker process died.
        OSError: the folder cannot be written to.
    """
    plan, file = study.plan, folder / DATASET
    while not file.exists():
        try:
            if as_it_is:
                parts = Store(folder / TASKS, study, {}).kept([*study.tasks({})])
            else:
                parts, _ = done_parts(study, {}, folder, progress)
            dataset, kept = combined(plan, parts), plan.outputs.kept
            path = folder / UNFINISHED if parts.missing else file
            with whole_netcdf(path) as partly:
                write(dataset, partly, kept, _slabs(plan, parts))
                if path == file:
                    # Before the sweep has its name: killed in between, the tasks make the same again.
                    with whole_file(folder / DIGEST) as digest:
                        digest.write_text(_digest_line(partly), encoding="utf-8")
            if parts.missing:
                dataset.encoding["source"] = str(path)
                return dataset
        except OSError:
            # Another process may finish the sweep, and remove its tasks, meanwhile.
            if not file.exists():
                raise
    digest = folder / DIGEST
    if digest.exists() and digest.read_text(encoding="utf-8") != _digest_line(file):
        raise SweepError(
            f"'{file}' was damaged or changed, by its digest in {DIGEST}; move it away to run it anew, or "
            f"remove {DIGEST} if the change is yours."
        )
    with xarray.open_dataset(file, engine="netcdf4", decode_times=False) as opened:
        dataset = opened.load()
    dataset.encoding["source"] = str(file)
    shutil.rmtree(folder / TASKS, ignore_errors=True)
    (folder / UNFINISHED).unlink(missing_ok=True)
    return dataset


def _digest_line(file: Path) -> str:
    return f"{digest_of_file(file)}  {DATASET}\n"


def runs_of(study: Sweep, progress: Progress) -> Progress:
    """Return what converts finished tasks to finished runs."""
    chunk, total = study.plan.chunk, len(study.cells)
    return lambda done, _: progress(min(done * chunk, total), total)


@checked_arguments()
def sweep(
    over: Over,
    base: Base = (),
    *,
    study: Study | None = None,
    metrics: Sequence[str] | str | None = None,
    series: Sequence[str] = (),
    output: str | Path | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> xarray.Dataset:
    """Run every combination of values, or every row of a table, and return the numbers of each.

        >>> values = {"law": ["newton", "hertz_penalty"], "clearance": "linspace(0, 2 um, 3)"}
        >>> dict(sweep(values, ["solver.duration=1 ms"], workers=1).sizes)
        {'law': 2, 'clearance': 3}

    A motor and a law made in Python vary in the numbers of contact, rotor and law, and in drive.frequency:

        >>> import contactlab as cl
        >>> setup = cl.Setup.of(cl.ball(1e-3, height=1e-4), cl.Newton(restitution=0.5), duration=0.02)
        >>> swept = sweep({"law.restitution": [0.4, 0.6]}, setup, workers=1)
        >>> swept["law_restitution"].values
        array([0.4, 0.6])

    With a function that returns the setup anything may vary:

        sweep({"gap": gaps}, lambda gap: cl.Setup.of(Motor(..., ContactGeometry(clearance=gap)), law, 5e-3))

    Any study can be swept:

        sweep({"drive.phase": "linspace(-3, 3, 100)"}, ["law=newton"], study=cl.Steady())

    Every number is that of the run alone to the last bit, whatever the number of workers.

    Args:
        over: values by name: a key of the configuration ('contact.clearance' or 'clearance'), a group
            ('law'), or an argument of the function. Values are a list, an array (a DataArray brings
            its unit), or a text as on the command line. A table (DataFrame, list of mappings) has a run in
            each row.
        base: what all runs have: overrides, a configuration or a setup; or a function of the values that
            returns the setup, whose exception makes the run a failed one.
        study: the study that is put to every setup; without one it is run.
        metrics: keys of `contactlab.metrics.METRICS`, or 'all'; None is those that cost next to nothing.
        series: names of `contactlab.variables.SERIES` that are kept whole, each as NAME_series; and
            internal_NAME of internal variables, NaN under laws without them.
        output: folder of the dataset, in which finished tasks are kept until then, so that the same sweep
            continues; for sweeps over keys of the configuration alone, since functions and motors made in
            Python cannot be identified.
        workers: processes at work; None is one a processor. They start after two seconds of work.
        progress: receives the number of finished runs and that of all.

    Returns:
        The numbers over the parameters, or over `run` for a table, with `status` (see `Status`) and
        `reason` of every run; one that did not reach its end has NaN.

    Raises:
        ConfigurationError: values, with every fault.
        TypeError, ValueError: arguments that do not fit together.
        SweepError: the folder contains another sweep.
        WorkerError: a worker process died.
    """
    samples = not isinstance(over, Mapping)
    table: Any = pandas.DataFrame(over) if samples else over
    columns = {str(name): _values(table[name]) for name in table}
    if not columns:
        raise ValueError(NOTHING)
    if study is not None and (metrics is not None or series):
        raise ValueError("A study has numbers of its own; metrics and series are those of runs.")
    outputs = Outputs.named(metrics, series) if study is None else Outputs.of_study(study.name)
    in_python = callable(base) or (isinstance(base, Setup) and base.made_in_python)
    if in_python and output is not None:
        raise ValueError("output is for sweeps over a configuration; a motor made in Python has no identity.")
    if callable(base):
        units = {name: str(getattr(table[name], "attrs", {}).get("units", "")) for name in columns}
        axes = [Axis(name, tuple(columns[name]), units[name]) for name in columns]
        swept = _in_python(partial(_returned, base), axes, samples, outputs)
    elif isinstance(base, Setup) and in_python:
        swept = _in_python(partial(_with_numbers, base), _axes(base, columns, samples), samples, outputs)
        for cell in range(swept.plan.cells):
            swept.make(swept.plan, cell)
    else:
        composed = composing(base, study)
        full = full_keys(columns, {key: key for key in flat(composed({}))})
        swept = Sweep(plan=planned(composed, full, outputs, samples=samples))
    swept = replace(
        swept,
        question=study if in_python else None,
        workers=workers or processors(),
        scheduler=study.scheduler if study else None,
    )
    report = runs_of(swept, progress) if progress else None
    if output is None:
        return swept.combine({}, done_parts(swept, {}, None, report)[0]).to_dataset()
    folder = Path(output)
    begin(folder, swept.plan)
    return continued(replace(swept, log=folder.absolute()), folder, report)


def _in_python(make: Maker, axes: Iterable[Axis], samples: bool, outputs: Outputs) -> Sweep:
    """Return a sweep whose setups are made in Python; a ValueError if a parameter has no values."""
    plan, laws = Plan(axes=tuple(axes), samples=samples, outputs=outputs), []
    if empty := [axis.key for axis in plan.axes if not axis.values]:
        raise ValueError(f"{', '.join(empty)} has no values; every parameter must have one at least.")
    # What a function raises at both ends, its runs raise too.
    for cell in (0, plan.cells - 1):
        with suppress(Exception):
            laws.append(make(plan, cell).law)
    chunk = size_of_tasks(plan.cells, study=outputs.study)
    return Sweep(plan=replace(plan, outputs=outputs.of_laws(laws), chunk=chunk), make=make)


def _returned(function: Callable[..., Setup], plan: Plan, cell: int) -> Setup:
    """Return the setup of a cell by a function of its values."""
    setup = function(**plan.point(cell))
    check_kind("What the function returns", setup, Setup)
    return setup


def _with_numbers(setup: Setup, plan: Plan, cell: int) -> Setup:
    """Return the setup of a cell of a sweep over numbers of a motor made in Python."""
    for key, value in plan.point(cell).items():
        setup = with_number(setup, key, value)
    return setup


def _axes(setup: Setup, columns: Columns, samples: bool) -> Iterator[Axis]:
    """Yield the axes of a sweep over numbers of a motor made in Python."""
    numbers = variable_numbers(setup)
    # The friction coefficient that laws share has a key of the contact beside that of its law.
    known = {key: path for key, (path, _) in numbers.items()}
    for key, column in full_keys(columns, known, lambda _: ()).items():
        declared = numbers[key][1].parameter if key in numbers else None
        units, meaning = (declared.units, declared.meaning) if declared else ("", "")
        values = column if samples else [x for value in column for x in spread(key, value, units)]
        yield Axis(key, tuple(in_si(value, units) for value in values), units, meaning)


def _values(values: Any) -> list[Value]:
    """Return the values of one parameter."""
    if isinstance(values, str):
        return [*listed(values)]
    if np.ndim(values) > 1:
        raise ValueError("The values of a parameter are a table; they must be a list.")
    return list(np.atleast_1d(values).tolist())


def composing(base: Sequence[str] | Configuration | Setup, study: Study | None = None) -> Compose:
    """Return what composes configurations over a base, and the section of a study that is put to them."""
    base = base.source if isinstance(base, Setup) else base
    below = base if isinstance(base, Mapping) else compose(base)
    section = {"study": {"name": study.name, **study.options, **ONE_PROCESS}} if study else {}
    return lambda chosen: (
        overridden(below, *parsed([f"{key}={option}" for key, option in chosen.items()])) | section
    )
