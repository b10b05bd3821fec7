"""The sweep of a command line: arguments as a plan, done as the study `contactlab.studies.sweep.study.Sweep`.

A launcher of Hydra may do the runs that leave folders. Hydra's own sweeper would compose every job anew,
which takes ten times as long, and hand it on unchecked, so that a cluster allocates nodes to find runs faulty
or complete; here a launcher receives what is left.
"""

import random
import re
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, final

import pandas
import xarray
from hydra.core.config_loader import ConfigLoader
from hydra.core.hydra_config import HydraConfig
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override, QuotedString, RangeSweep, Transformer
from hydra.plugins.launcher import Launcher
from omegaconf import DictConfig, OmegaConf, open_dict, read_write
from omegaconf.errors import OmegaConfBaseException

from contactlab.checks import check_declared
from contactlab.cli import terminal
from contactlab.cli.app import announce, choices_of, idle_friction, refusals, status_of_runs
from contactlab.cli.sections import SECTIONS, sweep_in
from contactlab.cli.terminal import COMPLETE, INCOMPLETE, refuse, tell
from contactlab.cli.verbs.collect import collect_swept
from contactlab.config import ConfigurationError
from contactlab.config.composition import as_written, faults_of, resolved, written
from contactlab.config.faults import faults_added, one_line, raise_faults
from contactlab.config.nesting import Value, flat, quoted
from contactlab.processes import WorkerError, processors
from contactlab.results.files import LOG, STATE, check_file, error_text
from contactlab.studies.registry import SIMULATE
from contactlab.studies.run_state import ABSENT, Job, State, key_of, why_to_run, write_log, write_state
from contactlab.studies.runner import done_parts
from contactlab.studies.sweep.dataset import summary
from contactlab.studies.sweep.plan import NOTHING, Columns, Configuration, Outputs, Plan, full_keys, planned
from contactlab.studies.sweep.study import Sweep as SweepStudy, begin, continued, runs_of
from contactlab.studies.sweep.values import FORMS, SweepError, call_in, spread
from contactlab.suggestion import excerpt


@final
class Arguments:
    """Arguments of a sweep: which keys are swept over which values, and the configurations they compose.

    Args:
        loader, config: what Hydra hands a sweeper.
        lines: the overrides.

    Raises:
        ConfigurationError: an override cannot be read; other faults are collected in `faults`.
    """

    def __init__(self, loader: ConfigLoader, config: DictConfig, lines: Sequence[str]) -> None:
        self.options, self._loader, self._config = loader.get_group_options, loader, config
        self.columns: dict[str, list[Value]] = {}
        self.faults: list[str] = []
        self._lines: dict[str, str] = {}
        self._composed: dict[tuple[str, ...], DictConfig] = {}
        try:
            overrides = OverridesParser.create(config_loader=loader).parse_overrides(list(lines))
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

    def _values(self, override: Override) -> list[Any]:
        """Return the values of an override."""
        if override.is_delete():
            return []
        value: Any = override.value()
        values: list[Any] = [value]
        if isinstance(value, RangeSweep):
            text = f"range({value.start},{value.stop},{value.step})"
            values = spread(override.key_or_group, text) if value.shuffle else [text]
            random.shuffle(values)
            return values
        if override.is_discrete_sweep():
            values = [*override.sweep_iterator(Transformer.identity)]
        elif override.is_sweep_override():
            self.faults.append(f"{override.input_line} cannot be swept; a swept parameter must have {FORMS}.")
        return [each.text if isinstance(each, QuotedString) else each for each in values]

    @property
    def fixed(self) -> list[str]:
        """The overrides that all runs have."""
        return [line for key, line in self._lines.items() if key not in self.columns]

    def compose(self, chosen: Mapping[str, Value]) -> Configuration:
        """Return the configuration with these options of groups, and of a study its section."""
        composed = self.composed(chosen)
        study = {} if composed.study.name == SIMULATE else {"study": resolved(composed)["study"]}
        return {group: keys for group, keys in as_written(composed).items() if group not in SECTIONS} | study

    def composed(self, chosen: Mapping[str, Value]) -> DictConfig:
        """Return the configuration as Hydra composes it, once for the same options, its own part included."""
        lines = (*self.fixed, *(f"{group}={option}" for group, option in chosen.items()))
        if lines not in self._composed:
            try:
                self._composed[lines] = self._loader.load_sweep_config(self._config, [*lines])
            # Besides its own exceptions Hydra lets ValueError, TypeError and those of YAML through.
            except Exception as error:
                raise ConfigurationError(faults_of(error, lines)) from error
        return self._composed[lines]

    def jobs(self, plan: Plan) -> list[tuple[str, Job]]:
        """Return the name of the folder of every run, by `hydra.sweep.subdir`, and its configuration.

        Raises:
            ConfigurationError: runs are faulty, or have one folder.
        """
        jobs, faults = list[tuple[str, Job]](), list[str]()
        # Values as typed where they are listed.
        typed = {key: column for key, column in self.columns.items() if not any(map(call_in, column))}
        columns = {axis.key: typed.get(axis.key, axis.values) for axis in plan.axes}
        with terminal.progress(plan.cells, "runs checked") as show:
            for cell in range(plan.cells):
                places = zip(columns.items(), plan.places(cell), strict=True)
                with faults_added(faults):
                    jobs.append(self._job(plan, cell, {key: column[at] for (key, column), at in places}))
                show(cell)
        HydraConfig.instance().set_config(self._config)
        raise_faults(faults)
        raise_faults(
            f"hydra.sweep.subdir is '{name}' for {count} jobs; it must differ from job to job."
            for name, count in Counter(name for name, _ in jobs).items()
            if count > 1
        )
        return jobs

    def _job(self, plan: Plan, cell: int, values: dict[str, Value]) -> tuple[str, Job]:
        """Return folder and configuration of a run; a ConfigurationError if it is faulty."""
        setup, lines = plan.setup_at(cell), dict(self._lines)
        for key, value in values.items():
            plain = isinstance(value, str) and re.fullmatch(r"[\w.+-]+", value, re.ASCII)
            before = lines.get(key, key).partition("=")[0]
            lines[key] = f"{before}={value if plain else written(value)}"
        composed = self.composed({group: values.pop(group) for group in plan.groups})
        hydra, task = composed.hydra, {k: line for k, line in lines.items() if not re.match(r"hydra\W", k)}
        with read_write(hydra), open_dict(hydra):
            for key, value in values.items():
                OmegaConf.update(composed, key, value)
            naming = hydra.job.config.override_dirname
            named = sorted(line for key, line in task.items() if key not in naming.exclude_keys)
            hydra.job.override_dirname = naming.item_sep.join(named).replace("=", naming.kv_sep)
            hydra.job.num, hydra.job.id, hydra.overrides.task = cell, str(cell), [*task.values()]
        try:
            # For ${hydra:...} in the name.
            HydraConfig.instance().set_config(composed)
            name = str(OmegaConf.select(composed, "hydra.sweep.subdir"))
        except OmegaConfBaseException as error:
            raise ConfigurationError(f"hydra.sweep.subdir cannot be resolved: {one_line(error)}") from error
        return name, Job(key_of(setup), tuple(lines.values()), choices_of(hydra), setup.configuration)


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
            f"sweep.samples is '{path}' and cannot be read ({excerpt(reason)}); it must be a "
            "table, CSV (NAME.csv) or netCDF, whose columns are keys and whose rows are runs."
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


def sweep(
    loader: ConfigLoader, launcher: Launcher, config: DictConfig, lines: list[str], batch: int | None
) -> None:
    """Plan, check, resume and collect a sweep.

    Args:
        loader, launcher, config: what Hydra hands a sweeper.
        lines: the overrides.
        batch: jobs that a launcher receives at once; None is all.

    Raises:
        SystemExit: with the status of the worst run, or that of a refusal.
    """
    try:
        status = _swept(Arguments(loader, config, lines), launcher, config, batch)
    except ConfigurationError as error:
        status = refuse(error.faults)
    except SweepError as error:
        status = refuse([str(error)])
    if status:
        raise SystemExit(status)


def _swept(arguments: Arguments, launcher: Launcher, config: DictConfig, batch: int | None) -> int:
    faults, composed = arguments.faults, arguments.composed({})
    with faults_added(faults):
        settings = sweep_in(arguments.settings)
    raise_faults(faults)
    section, folder = config.study, Path(str(config.hydra.sweep.dir))
    study, scheduler = "" if section.name == SIMULATE else str(section.name), section.get("scheduler")
    keep = "metrics" if study else settings.keep
    if keep == "metrics" and re.search(r"\$\{[^}]*:", str(as_written(composed))):
        raise ConfigurationError(
            "${NAME:...} may depend on what is swept; write the value with sweep.keep=metrics."
        )
    columns: Columns = arguments.columns
    if settings.samples:
        keys = {key: key for key in flat(arguments.compose({}))}
        columns = full_keys(table(settings.samples), keys, arguments.options)
    plan = planned(
        arguments.compose,
        columns,
        Outputs.of_study(study)
        if study
        else Outputs.named(settings.metrics, settings.series or (), "sweep."),
        options=arguments.options,
        samples=settings.samples is not None,
        chunk=settings.chunk,
        keep=keep,
    )
    jobs = arguments.jobs(plan) if keep == "runs" else []
    swept = [*arguments.fixed, *(f"{axis.key}=" for axis in plan.axes)]
    faults += idle_friction(swept, [base["law"] for base in plan.bases])
    # Of folders that do not exist yet the longest name is tried.
    names = [name for name, _ in jobs]
    for name in {*(name for name in names if (folder / name).exists()), max(names, key=len, default="")}:
        faults += refusals(folder / name, "hydra.sweep.dir")
    if keep == "metrics" and not plan.axes:
        faults.append(NOTHING)
    kind = str(config.hydra.runtime.choices["hydra/launcher"])
    if kind != "basic" and any((keep == "metrics", settings.workers, settings.chunk, scheduler)):
        faults.append(
            f"hydra/launcher is '{kind}', for runs that leave a folder each; it must be left "
            "out with sweep.keep=metrics, sweep.workers, sweep.chunk or study.scheduler."
        )
    raise_faults(faults)
    begin(folder, plan)
    folders = _pending(config, folder, jobs) if keep == "runs" else None
    # A run that leaves a folder may need much memory: several at once must be chosen.
    usual = processors() if keep == "metrics" and not study else section.get("workers", 1)
    own = SweepStudy(
        plan=plan,
        workers=settings.workers or usual,
        scheduler=scheduler,
        folders=folders,
        log=folder.absolute(),
    )
    dataset = _done(own, folder, None if kind == "basic" else launcher, batch)
    if keep == "runs":
        collect_swept(folder, plan.outputs.series, plan.outputs.metrics if settings.metrics else ())
        return status_of_runs(folder / name for name in names)
    if dataset is None:
        return INCOMPLETE
    print(summary(dataset, dataset.encoding["source"]))
    if (folder / LOG).exists():
        tell(f"The traceback of the first failure is in {folder / LOG}.", sys.stderr)
    # Values that cannot go together are refused alone, as the plan says; a run that fails is a failure.
    ended = dataset.attrs["runs_complete"] + dataset.attrs["runs_refused"]
    return COMPLETE if ended == dataset.attrs["runs"] else INCOMPLETE


def _pending(
    config: DictConfig, folder: Path, jobs: Sequence[tuple[str, Job]]
) -> dict[int, tuple[Path, Job]]:
    """Return the runs that are not complete, by cell, and make their folders."""
    # Workers of a scheduler may have another working directory.
    every = [(folder.absolute() / name, job) for name, job in jobs]
    why = [why_to_run(place, job.key) for place, job in every]
    counts = Counter(each or "complete, skipped" for each in why)
    print(f"{len(jobs)} runs: {', '.join(f'{n} {name}' for name, n in sorted(counts.items()))}.", flush=True)
    pending = {cell: run for cell, run in enumerate(every) if why[cell]}
    for place, job in pending.values():
        place.mkdir(parents=True, exist_ok=True)
        # A run that never begins is known by its state.
        if not (place / STATE).exists():
            write_state(place, State(ABSENT, job))
    announce(job.configuration for _, job in pending.values())
    OmegaConf.save(config, folder / "multirun.yaml")
    return pending


def _done(
    study: SweepStudy, folder: Path, launcher: Launcher | None, batch: int | None
) -> xarray.Dataset | None:
    """Do what is left of a sweep; return its dataset, or none where runs leave folders or it stopped.

    Raises:
        KeyboardInterrupt: with a sentence.
    """
    cells = max(len(study.cells), 1)
    try:
        # Between the jobs an exception, at which a launcher ends the processes that it has begun.
        with terminal.raising():
            if launcher is not None:
                _launch(launcher, [*(study.folders or {}).values()], folder.absolute(), batch)
                return None
            with terminal.progress(cells, "runs", min(study.plan.chunk, cells)) as show:
                if study.folders is None:
                    return continued(study, folder, runs_of(study, show))
                done_parts(study, {}, None, runs_of(study, show))
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            "Interrupted. Finished runs are kept: the same command continues there."
        ) from None
    # A worker that is killed, a cluster that takes no jobs: launchers raise exceptions of any kind.
    except Exception as error:
        if launcher is None and not isinstance(error, WorkerError | OSError):
            raise
        text = error_text(error) if isinstance(error, OSError) else one_line(error)
        kind = "" if launcher is None else f"{type(error).__name__}: "
        tell(
            f"The sweep stopped: {kind}{text} Finished runs are kept; the same command continues.", sys.stderr
        )
        if study.folders is not None:
            write_log(folder, error)
    return None


def _launch(launcher: Launcher, jobs: Sequence[tuple[Path, Job]], folder: Path, batch: int | None) -> None:
    """Have a launcher of Hydra run jobs."""
    where = f"hydra.sweep.dir={quoted(str(folder))}"
    lines = [
        [*job.overrides, where, f"hydra.sweep.subdir={quoted(str(place.relative_to(folder)))}"]
        for place, job in jobs
    ]
    size = batch or max(len(lines), 1)
    for at in range(0, len(lines), size):
        for returned in launcher.launch(lines[at : at + size], initial_job_idx=at):
            # The exception of a job that failed is raised by reading its value.
            returned.return_value  # noqa: B018
