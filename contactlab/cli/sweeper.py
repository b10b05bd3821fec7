"""The sweep of a command line: every run checked before the first, what is complete skipped, all collected.

Hydra's own sweeper hands every job to the launcher, so that a cluster would allocate a node to find a run
complete. Here the launcher receives the jobs that are to run, where runs leave folders. A sweep that keeps
numbers alone is the study `contactlab.studies.sweep.study.Sweep`.
"""

import random
import re
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import pandas
import xarray
from hydra.core.hydra_config import HydraConfig
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override, QuotedString, RangeSweep, Transformer
from hydra.core.plugins import Plugins
from hydra.core.utils import JobReturn, run_job
from hydra.types import HydraContext, TaskFunction
from omegaconf import DictConfig, OmegaConf, open_dict, read_write
from omegaconf.errors import OmegaConfBaseException

from contactlab.checks import check_declared
from contactlab.cli import terminal
from contactlab.cli.app import announce, choices_of, idle_friction
from contactlab.cli.collect import collect_swept
from contactlab.cli.jobs import refusals, write_log
from contactlab.cli.settings import of_run, sweep_in
from contactlab.cli.terminal import COMPLETE, INCOMPLETE, refuse, tell
from contactlab.config import ConfigurationError, rebuild
from contactlab.config.composition import faults_of, resolved
from contactlab.config.faults import one_line
from contactlab.config.nesting import Value, quoted
from contactlab.processes import WorkerError, processors
from contactlab.results.files import LOG, STATE, check_file, error_text
from contactlab.studies.registry import RUN
from contactlab.studies.run_state import ABSENT, Job, State, key_of, resume, write_state
from contactlab.studies.sweep.dataset import summary
from contactlab.studies.sweep.plan import (
    NOTHING,
    Configuration,
    Outputs,
    Plan,
    full_keys,
    planned,
    raise_faults,
)
from contactlab.studies.sweep.study import Sweep as SweepStudy, begin, continued, runs_of
from contactlab.studies.sweep.values import FORMS, SweepError, call_in, spread
from contactlab.suggestion import excerpt


@final
class Arguments:
    """Arguments of a sweep: which keys are swept over which values, and the configurations they compose.

    Args:
        context, config: what Hydra hands a sweeper.
        lines: the overrides.
    """

    def __init__(self, context: HydraContext, config: DictConfig, lines: Sequence[str]) -> None:
        self._loader, self._config = context.config_loader, config
        self.options = self._loader.get_group_options
        self.columns: dict[str, list[Value]] = {}
        self.faults: list[str] = []
        self._lines: dict[str, str] = {}
        self._shared: dict[tuple[str, ...], DictConfig] = {}
        self._parser = OverridesParser.create(config_loader=self._loader)
        try:
            overrides = self._parser.parse_overrides(list(lines))
            self.settings: dict[str, Any] = dict(OmegaConf.to_container(config.sweep, resolve=True))  # type: ignore[arg-type]
        # Hydra lets the errors of what it calls through.
        except Exception as error:
            raise ConfigurationError(faults_of(error, lines)) from error
        for override in overrides:
            key, values = override.key_or_group, self._values(override)
            if key.startswith("sweep."):
                # A list of names is written as that of values is.
                if override.is_sweep_override():
                    self.settings[key.removeprefix("sweep.")] = values
                continue
            if key in self._lines:
                self.faults.append(f"{key} occurs more than once; it must be either swept or set, and once.")
            self._lines[key] = str(override.input_line)
            if override.is_sweep_override() or any(map(call_in, values)):
                self.columns[key] = values
        if self.columns and self.settings["samples"] is not None:
            keys = ", ".join(self.columns)
            self.faults.append(f"{keys} and sweep.samples are swept at once; it must be one of them.")

    @property
    def fixed(self) -> list[str]:
        """The overrides that all runs have."""
        return [line for key, line in self._lines.items() if key not in self.columns]

    def compose(self, chosen: Mapping[str, Value]) -> Configuration:
        """Return the configuration with these options of groups, and of a study its section."""
        composed = self.composed(chosen)
        study = {} if composed.study.name == RUN else {"study": resolved(composed)["study"]}
        return {**of_run(composed), **study}

    def composed(self, chosen: Mapping[str, Value]) -> DictConfig:
        """Return the configuration as Hydra composes it, its own part and references included."""
        return self._loaded([*self.fixed, *(f"{group}={option}" for group, option in chosen.items())])

    def _loaded(self, lines: list[str]) -> DictConfig:
        try:
            return self._loader.load_sweep_config(self._config, lines)
        # Besides its own exceptions Hydra lets ValueError, TypeError and those of YAML through.
        except Exception as error:
            raise ConfigurationError(faults_of(error, lines)) from error

    def job(self, plan: Plan, cell: int) -> tuple[str, Job]:
        """Return the name of a run's folder, as Hydra makes it, and its configuration.

        Raises:
            ConfigurationError: the run is faulty.
        """
        lines = dict(self._lines)
        for axis, place in zip(plan.axes, plan.places(cell), strict=True):
            column = self.columns.get(axis.key, axis.values)
            # Values as typed where they are listed.
            values = axis.values if any(map(call_in, column)) else column
            before = lines.get(axis.key, axis.key).partition("=")[0]
            lines[axis.key] = f"{before}={_text(values[place])}"
        composed = self.of_job([*lines.values()], cell)
        try:
            # For ${hydra:...} in the name.
            HydraConfig.instance().set_config(composed)
            name = str(OmegaConf.select(composed, "hydra.sweep.subdir"))
        except OmegaConfBaseException as error:
            raise ConfigurationError([f"hydra.sweep.subdir cannot be resolved: {one_line(error)}"]) from error
        setup = rebuild(of_run(composed))
        job = Job(key_of(setup), tuple(lines.values()), choices_of(composed.hydra), setup.configuration)
        return name, job

    def of_job(self, lines: Sequence[str], number: int) -> DictConfig:
        """Return the configuration of a job, which the next call changes.

        Jobs with the same options share one that Hydra has composed, in which the values are replaced.
        """
        overrides = self._parser.parse_overrides([*lines])
        values = [each for each in overrides if self._is_value(each)]
        options = tuple(line for line, each in zip(lines, overrides, strict=True) if not self._is_value(each))
        if options not in self._shared:
            self._shared[options] = self._loaded([*lines])
        composed = self._shared[options]
        hydra = composed.hydra
        with read_write(hydra), open_dict(hydra):
            for each in values:
                OmegaConf.update(composed, each.key_or_group, each.value(), merge=True)
            task = [each for each in overrides if not each.is_hydra_override()]
            hydra.overrides.task = [each.input_line for each in task]
            naming = hydra.job.config.override_dirname
            named = sorted(str(e.input_line) for e in task if e.key_or_group not in naming.exclude_keys)
            hydra.job.override_dirname = naming.item_sep.join(named).replace("=", naming.kv_sep)
            hydra.job.num, hydra.job.id = number, str(number)
        return composed

    def _is_value(self, override: Override) -> bool:
        """Return whether an override sets a swept number, text or truth value of a run, and no option."""
        key = override.key_or_group
        swept = key not in self._lines or key in self.columns
        return swept and not key.startswith("hydra.") and not self.options(key)

    def _values(self, override: Override) -> list[Any]:
        """Return the values of an override."""
        if override.is_delete():
            return []
        value = override.value()
        if not override.is_sweep_override():
            return [_plain(value)]
        if isinstance(value, RangeSweep):
            values: list[Any] = [f"range({value.start},{value.stop},{value.step})"]
            if value.shuffle:
                values = spread(override.key_or_group, values[0])
                random.shuffle(values)
            return values
        if not override.is_discrete_sweep():
            self.faults.append(f"{override.input_line} cannot be swept; a swept parameter must have {FORMS}.")
            return []
        return [_plain(each) for each in override.sweep_iterator(Transformer.identity)]


def table(path: str) -> dict[str, list[Value]]:
    """Read a table of samples, CSV or netCDF: its values by the names of its columns.

    Raises:
        ConfigurationError: it cannot be read, or lacks a value.
    """
    try:
        check_file(Path(path))
        if path.endswith(".csv"):
            # Without header: pandas would rename a column that is there twice, and shift too long a row.
            cells = pandas.read_csv(path, header=None, skipinitialspace=True, dtype=str, encoding="utf-8-sig")
            names = [str(name).strip() for name in cells.iloc[0]]
            if len({*names}) < len(names):
                raise ValueError("two columns have one name")
            rows = pandas.read_csv(path, skipinitialspace=True, index_col=False, names=names, header=0)
        else:
            check_declared(Path(path))
            with xarray.open_dataset(path, engine="netcdf4", decode_times=False) as dataset:
                # The dataset of a sweep says which of its variables are keys.
                keys = {name: v.attrs["key"] for name, v in dataset.variables.items() if "key" in v.attrs}
                rows = dataset.to_dataframe()
                rows = rows.reset_index()[[*keys]].rename(columns=keys) if keys else rows
    # A file can be anything.
    except Exception as error:
        reason = one_line(error).removeprefix("Error tokenizing data. C error: ")
        raise ConfigurationError(
            [
                f"sweep.samples is '{path}' and cannot be read ({excerpt(reason)}); it must be a "
                "table, CSV (NAME.csv) or netCDF, whose columns are keys and whose rows are runs."
            ]
        ) from error
    raise_faults(
        f"sweep.samples has the column '{excerpt(name)}'; its name must be a key."
        for name in rows
        if excerpt(name) != str(name)
    )
    raise_faults(
        f"sweep.samples has {'no' if str(value) == 'nan' else 'a reference as'} {name} in row {row} of "
        f"'{path}'; a cell must be a number or the name of an option."
        for name in rows
        for row, value in enumerate(rows[name], 1)
        if str(value) == "nan" or "${" in str(value)
    )
    return {str(name): rows[name].tolist() for name in rows}


def _plain(value: Any) -> Any:
    return value.text if isinstance(value, QuotedString) else value


def _text(value: Value) -> str:
    """Return a value as an override has it."""
    if isinstance(value, str):
        return value if re.fullmatch(r"[\w.+-]+", value, re.ASCII) else quoted(value)
    return str(value).lower() if isinstance(value, bool) else repr(value)


@final
@dataclass(frozen=True)
class Sweeping:
    """Plans, checks, resumes and collects a sweep, by what Hydra hands a sweeper and its options."""

    context: HydraContext
    task: TaskFunction
    config: DictConfig
    max_batch_size: int | None = None
    params: Mapping[str, str] | None = None

    def sweep(self, lines: list[str]) -> None:
        """Run a sweep, or continue it.

        Raises:
            SystemExit: with the status of the worst run, or that of a refusal.
        """
        try:
            status = self._swept([*(f"{k}={v}" for k, v in (self.params or {}).items()), *lines])
        except ConfigurationError as error:
            status = refuse(error.faults)
        except SweepError as error:
            status = refuse([str(error)])
        if status:
            raise SystemExit(status)

    def _swept(self, lines: Sequence[str]) -> int:
        arguments = Arguments(self.context, self.config, lines)
        faults, composed = arguments.faults, arguments.composed({})
        try:
            settings = sweep_in(arguments.settings)
        except ConfigurationError as error:
            faults += error.faults
        raise_faults(faults)
        study = str(self.config.study.name)
        samples, is_run = settings.samples, study == RUN
        keep = settings.keep if is_run else "metrics"
        mine: Any = OmegaConf.to_container(composed, resolve=False)
        if keep == "metrics" and "${" in str({key: mine[key] for key in mine if key != "hydra"}):
            raise ConfigurationError(
                ["A reference ${...} may depend on what is swept; write the value with sweep.keep=metrics."]
            )
        plan = planned(
            arguments,
            full_keys(table(samples), arguments) if samples else arguments.columns,
            Outputs.named(settings.metrics, settings.series or (), "sweep.")
            if is_run
            else Outputs.of_study(study),
            samples=samples is not None,
            # A cell of a study takes seconds: every one is kept as it ends.
            chunk=settings.chunk or (None if is_run else 1),
            keep=keep,
        )
        set_keys = [*arguments.fixed, *(f"{axis.key}=" for axis in plan.axes)]
        raise_faults(idle_friction(set_keys, [base["law"] for base in plan.bases]))
        folder = Path(str(self.config.hydra.sweep.dir))
        if keep == "metrics":
            section = self.config.study
            workers = settings.workers or (None if is_run else section.get("workers", 1)) or processors()
            return self._numbers(
                SweepStudy(plan=plan, workers=workers, scheduler=section.get("scheduler")), folder
            )
        status = self._folders(plan, folder, arguments)
        collect_swept(folder, plan.outputs.series, plan.outputs.metrics if settings.metrics else ())
        return status

    def _folders(self, plan: Plan, folder: Path, arguments: Arguments) -> int:
        """Run what leaves a folder each, but for what is complete; return the worst status."""
        jobs: list[tuple[str, Job]] = []
        faults: list[str] = []
        with terminal.progress(plan.cells, "runs checked") as show:
            for cell in range(plan.cells):
                try:
                    jobs.append(arguments.job(plan, cell))
                except ConfigurationError as error:
                    faults += error.faults
                show(cell)
        HydraConfig.instance().set_config(self.config)
        raise_faults(faults)
        counts = Counter(name for name, _ in jobs)
        faults = [
            f"hydra.sweep.subdir is '{name}' for {count} jobs; it must differ from job to job."
            for name, count in counts.items()
            if count > 1
        ]
        # Of folders that do not exist yet the longest name is tried.
        tried = {*(folder / name for name in counts if (folder / name).exists())}
        for path in {*tried, folder / max(counts, key=len)}:
            faults += refusals(path, "hydra.sweep.dir")
        raise_faults(faults)
        begin(folder, plan)
        is_pending, sentence = resume([(folder / name, job.key) for name, job in jobs])
        print(sentence, flush=True)
        pending = [job for job, is_to_run in zip(jobs, is_pending, strict=True) if is_to_run]
        for name, job in pending:
            (folder / name).mkdir(parents=True, exist_ok=True)
            # A run that never begins is known by its state.
            if not (folder / name / STATE).exists():
                write_state(folder / name, State(ABSENT, job))
        announce(job.configuration for _, job in pending)
        if pending:
            OmegaConf.save(self.config, folder / "multirun.yaml")
        return self._launched(pending, folder, arguments)

    def _launched(self, jobs: Sequence[tuple[str, Job]], folder: Path, arguments: Arguments) -> int:
        """Run jobs, or have a launcher do it; return the worst status, and print why they cannot be run."""
        status = COMPLETE
        launch = self._launch_here if self._launcher == "basic" else self._launch
        try:
            # Between the jobs an exception, at which a launcher ends the processes that it has begun.
            with terminal.raising():
                for returned in launch(jobs, folder, arguments) if jobs else ():
                    # The exception of a job that failed is raised by reading its value.
                    status = max(status, int(returned.return_value or 0))
        # A worker that is killed, a cluster that takes no jobs: launchers raise exceptions of any kind.
        except Exception as error:
            tell(
                f"The sweep stopped: {type(error).__name__}: {one_line(error)} Complete runs are kept; the "
                "same command continues.",
                sys.stderr,
            )
            write_log(folder / LOG, error)
            status = INCOMPLETE
        return status

    def _launch(
        self, jobs: Sequence[tuple[str, Job]], folder: Path, arguments: Arguments
    ) -> Iterator[JobReturn]:
        """Have the launcher run jobs."""
        del arguments
        where = f"hydra.sweep.dir={quoted(str(folder))}"
        batch = [[*job.overrides, where, f"hydra.sweep.subdir={quoted(name)}"] for name, job in jobs]
        launcher = Plugins.instance().instantiate_launcher(
            hydra_context=self.context, task_function=self.task, config=self.config
        )
        size = self.max_batch_size or len(batch)
        for at in range(0, len(batch), size):
            yield from launcher.launch(batch[at : at + size], initial_job_idx=at)

    def _launch_here(
        self, jobs: Sequence[tuple[str, Job]], folder: Path, arguments: Arguments
    ) -> Iterator[JobReturn]:
        """Run jobs in this process, one after the other; Hydra's launcher would compose each once more."""
        print(f"Running {len(jobs)} jobs.", flush=True)
        for number, (name, job) in enumerate(jobs):
            print(f"#{number}: {' '.join(job.overrides)}", flush=True)
            composed = arguments.of_job(job.overrides, number)
            with read_write(composed.hydra):
                composed.hydra.sweep.dir, composed.hydra.sweep.subdir = str(folder), name
            yield run_job(self.task, composed, "hydra.sweep.dir", "hydra.sweep.subdir", self.context)

    @property
    def _launcher(self) -> str:
        return str(self.config.hydra.runtime.choices["hydra/launcher"])

    def _numbers(self, sweep: SweepStudy, folder: Path) -> int:
        """Do what is left of a sweep that keeps numbers alone; return the exit status."""
        faults = list(refusals(folder, "hydra.sweep.dir"))
        if not sweep.plan.axes:
            faults.append(NOTHING)
        if self._launcher != "basic":
            faults.append(
                f"hydra/launcher is '{self._launcher}', for runs that leave folders; with sweep.keep=metrics "
                "it must be left out. Take sweep.workers=N, or study.scheduler=ADDRESS of a Dask scheduler."
            )
        raise_faults(faults)
        begin(folder, sweep.plan)
        try:
            cells, chunk = sweep.plan.cells, sweep.plan.chunk
            with terminal.raising(), terminal.progress(cells, "runs", min(chunk, cells)) as show:
                dataset = continued(sweep, folder, runs_of(sweep.plan, show))
        except (WorkerError, OSError) as error:
            tell(
                f"The sweep stopped: {error_text(error) if isinstance(error, OSError) else str(error)}",
                sys.stderr,
            )
            return INCOMPLETE
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                "Interrupted. Finished tasks are kept: the same command continues there."
            ) from None
        print(summary(dataset, dataset.encoding["source"]))
        # Values that cannot go together are refused alone, as the plan says; a run that fails is a failure.
        ended = dataset.attrs["runs_complete"] + dataset.attrs["runs_refused"]
        return COMPLETE if ended == dataset.attrs["runs"] else INCOMPLETE
