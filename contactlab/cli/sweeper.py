"""The sweep of a command line: every run checked before the first, what is complete skipped, all collected.

Hydra's own sweeper hands every job to the launcher, so that a cluster would be asked for a node to find a run
complete. Here the jobs are known and sound, and the launcher is given those that are to run: a job each where
runs leave their folders, a job a chunk where they leave their metrics alone.
"""

import os
import platform
import random
import re
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import pandas
import xarray
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override, QuotedString, RangeSweep, Transformer
from hydra.core.plugins import Plugins
from hydra.plugins.sweeper import Sweeper
from hydra.types import HydraContext, TaskFunction
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from contactlab.cli import terminal
from contactlab.cli.app import choices_of
from contactlab.cli.arguments import quoted
from contactlab.cli.checking import (
    NOT_OF_A_RUN,
    announce,
    announce_series,
    misplaced,
    sentences,
    sets_friction,
)
from contactlab.cli.jobs import refusals, write_log
from contactlab.cli.terminal import COMPLETE, INCOMPLETE, refuse, tell
from contactlab.config import ConfigurationError
from contactlab.config.faults import one_line
from contactlab.config.idle import idle_friction
from contactlab.config.nesting import Value
from contactlab.config.quantity import describe
from contactlab.results.files import told
from contactlab.results.run_folder import LOG
from contactlab.sweeps.batch import WorkerError, processors
from contactlab.sweeps.collection import collect
from contactlab.sweeps.dataset import summary
from contactlab.sweeps.manifest import extend_manifest, resume
from contactlab.sweeps.plan import Configuration, Outputs, Plan, code_digest_of
from contactlab.sweeps.planning import full_keys, planned, setups_of
from contactlab.sweeps.state import Job, key_of
from contactlab.sweeps.store import CHUNKS, Store
from contactlab.sweeps.values import FORMS, SweepError, is_spaced, spread

MOST_JOBS = 100_000
"""Runs that leave a folder each, which takes a fifth of a second beside the run."""


@final
@dataclass(frozen=True)
class _Settings:
    """The section `sweep` of a configuration: how runs are made, and what is kept of them.

    Args:
        keep: 'runs', a folder each, or 'metrics', numbers alone.
        metrics, series: names, 'all' for all metrics; None for the default.
        samples: file of a table whose columns are keys and whose rows are runs.
        chunk: runs in a chunk.
        workers: processes at work.
    """

    keep: str
    metrics: Any
    series: Any
    samples: str | None
    chunk: int | None
    workers: int | None

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> "_Settings":
        """Check the section.

        Raises:
            ConfigurationError: with every fault of it.
        """
        faults = []
        if values["keep"] not in ("runs", "metrics"):
            faults.append(
                f"sweep.keep is {describe(values['keep'])}; it must be runs, which leaves a folder each, or "
                "metrics, which leaves numbers alone."
            )
        for name in ("chunk", "workers"):
            value = values[name]
            if value is None:
                continue
            if type(value) is not int or value < 1:
                faults.append(
                    f"sweep.{name} is {describe(value)}; it must be a whole number of at least 1. Leave it "
                    "out for the default."
                )
            elif values["keep"] == "runs":
                faults.append(
                    f"sweep.{name} is given and each run leaves its folder; it belongs to "
                    "sweep.keep=metrics. Leave it out; hydra/launcher=joblib runs folders side by side."
                )
        for name in ("metrics", "series"):
            listed = values[name] if isinstance(values[name], list) else [values[name]]
            if not all(isinstance(one, str) for one in listed if one is not None):
                faults.append(
                    f"sweep.{name} is {describe(values[name])}; it must be a list of names."
                )
        if faults:
            raise ConfigurationError(faults)
        return cls(**values)

    @property
    def outputs(self) -> Outputs:
        """What is kept of a run, as far as this says.

        Raises:
            ConfigurationError: there is no such metric or series.
        """
        try:
            return Outputs.named(self.metrics, self.series or ())
        except ValueError as error:
            raise ConfigurationError([str(error)]) from error


@final
class _Arguments:
    """Reads the arguments of a sweep.

    Args:
        overrides: as Hydra parses them.
        section: the section `sweep` as Hydra composes it.
    """

    def __init__(self, overrides: Iterable[Override], section: Mapping[str, Any]) -> None:
        self.columns: dict[str, list[Value]] = {}
        self.faults: list[str] = []
        self._typed: dict[str, list[str]] = {}
        self._order: dict[str, tuple[str, str]] = {}
        settings = dict(section)
        for override in overrides:
            key, line = override.key_or_group, str(override.input_line)
            values, typed = self._values(override)
            if key.startswith("sweep."):
                # A list of names is written as that of values is.
                if override.is_sweep_override():
                    settings[key.removeprefix("sweep.")] = values
                continue
            if key in self._order:
                self.faults.append(
                    f"{key} is given more than once; it must be either swept or set, and once. Leave the "
                    "others out."
                )
            swept = override.is_sweep_override() or any(map(is_spaced, values))
            self._order[key] = ("" if swept else line, line.partition("=")[0])
            if swept:
                self.columns[key], self._typed[key] = values, typed
        self.settings = _Settings.of(settings)
        if self.settings.samples is not None:
            if self.columns:
                self.faults.append(
                    f"{', '.join(self.columns)} and the table of sweep.samples are swept at once; it must be "
                    "one of them. Put all into the table, or leave it out."
                )
            self.columns = _table(self.settings.samples)

    @property
    def fixed(self) -> list[str]:
        """The overrides that all runs have."""
        return [line for line, _ in self._order.values() if line]

    def texts(self, plan: Plan) -> dict[str, list[str]]:
        """Give all values of each key as an override has them: as typed, where they were typed one by one."""
        texts = {}
        for axis in plan.axes:
            typed = self._typed.get(axis.key, ())
            as_typed = len(typed) == len(axis.values)
            texts[axis.key] = [*typed] if as_typed else [_text(value) for value in axis.values]
        return texts

    def lines(self, chosen: Mapping[str, str]) -> list[str]:
        """Give the overrides of a run from the texts of its swept values."""
        swept = dict(chosen)
        lines = [
            line or f"{prefix}={swept.pop(key)}" for key, (line, prefix) in self._order.items()
        ]
        return [*lines, *(f"{key}={text}" for key, text in swept.items())]

    def _values(self, override: Override) -> tuple[list[Any], list[str]]:
        """Give the values of an override, and how they are typed."""
        line = str(override.input_line)
        if override.is_delete():
            return [], []
        if not override.is_sweep_override():
            return [_plain(override.value())], [line.partition("=")[2]]
        if isinstance(said := override.value(), RangeSweep):
            text = f"range({said.start},{said.stop},{said.step})"
            if not said.shuffle:
                return [text], []
            try:
                values = spread(override.key_or_group, text, float)
            except SweepError as error:
                self.faults.append(str(error))
                return [], []
            random.shuffle(values)
            return values, [_text(value) for value in values]
        if not override.is_discrete_sweep():
            self.faults.append(f"{line} cannot be swept; a swept parameter must have {FORMS}.")
            return [], []
        values = [_plain(value) for value in override.sweep_iterator(Transformer.identity)]
        return values, [str(text) for text in override.sweep_string_iterator()]


@final
class _Hydra:
    """Composes configurations by Hydra, once for every combination of options; see `planning.Composer`."""

    def __init__(self, context: HydraContext, config: DictConfig, fixed: Sequence[str]) -> None:
        self._loader = context.config_loader
        self._config = config
        self._fixed = list(fixed)
        self._places: dict[tuple[Value, ...], DictConfig] = {}
        self.choices: dict[tuple[Value, ...], dict[str, str | None]] = {}

    def options(self, key: str) -> list[str]:
        """Give the options of a group; none for what is no group."""
        return self._loader.get_group_options(key)

    def compose(self, chosen: Mapping[str, Value]) -> Configuration:
        """Give the configuration with these options, all else as it is set.

        Raises:
            ConfigurationError: it cannot be composed.
        """
        lines = [*self._fixed, *(f"{group}={option}" for group, option in chosen.items())]
        try:
            composed = self._loader.load_sweep_config(self._config, lines)
        # Besides its own exceptions Hydra lets ValueError, TypeError and those of YAML through.
        except Exception as error:
            raise ConfigurationError(sentences(error, lines)) from error
        everything: dict[str, Any] = OmegaConf.to_container(composed, resolve=False)  # type: ignore[assignment]
        sweep = everything["hydra"]["sweep"]
        # The folder is told before Hydra knows the job.
        sweep["subdir"] = str(sweep["subdir"]).replace("${hydra:", "${hydra.")
        place = OmegaConf.create(everything)
        OmegaConf.copy_cache(self._config, place)
        options = tuple(chosen.values())
        self._places[options], self.choices[options] = place, choices_of(composed.hydra)
        return {key: value for key, value in everything.items() if key not in NOT_OF_A_RUN}

    def resolve(self, configuration: Configuration) -> Configuration:
        """Put values in the place of references to them.

        Raises:
            ConfigurationError: one refers to what there is not.
        """
        if "${" not in str(configuration):
            return configuration
        try:
            return OmegaConf.to_container(OmegaConf.create(dict(configuration)), resolve=True)  # type: ignore[return-value]
        except OmegaConfBaseException as error:
            raise ConfigurationError(
                [f"{one_line(error)} Correct the reference in ${{...}}."]
            ) from error

    def folder(
        self,
        chosen: tuple[Value, ...],
        lines: Sequence[str],
        values: Mapping[str, Value],
        cell: int,
    ) -> str:
        """Name the folder of a run, as Hydra does.

        Args:
            chosen: the options of the swept groups.
            lines: its overrides.
            values: its swept values, by key.
            cell: its number.

        Raises:
            ConfigurationError: the name refers to what there is not.
        """
        place = self._places[chosen]
        said = place.hydra.job.config.override_dirname
        told = sorted(line for line in lines if line.partition("=")[0] not in said.exclude_keys)
        place.hydra.job.override_dirname = said.item_sep.join(told).replace("=", said.kv_sep)
        place.hydra.job.num, place.hydra.job.id = cell, str(cell)
        try:
            for key, value in values.items():
                OmegaConf.update(place, key, value, force_add=True)
            return str(OmegaConf.select(place, "hydra.sweep.subdir"))
        except OmegaConfBaseException as error:
            raise ConfigurationError(
                [f"hydra.sweep.subdir cannot be resolved: {one_line(error)} Name a directory."]
            ) from error


@final
class ContactlabSweeper(Sweeper):
    """Plans, checks, resumes and collects a sweep.

    Args:
        max_batch_size: jobs that a launcher is given at once; None is all.
        params: what is swept beside the arguments, values by key.
    """

    def __init__(
        self, max_batch_size: int | None = None, params: Mapping[str, str] | None = None
    ) -> None:
        self._size = max_batch_size
        self._params = dict(params or {})

    def setup(
        self, *, hydra_context: HydraContext, task_function: TaskFunction, config: DictConfig
    ) -> None:
        """See `Sweeper.setup`."""
        self._context, self._task, self._config = hydra_context, task_function, config
        self._parser = OverridesParser.create(config_loader=hydra_context.config_loader)

    def sweep(self, arguments: list[str]) -> None:
        """Run a sweep, or go on with it.

        Raises:
            SystemExit: with the status of the worst run, or that of what was refused.
        """
        lines = [*(f"{key}={value}" for key, value in self._params.items()), *arguments]
        try:
            status = self._swept(lines)
        except ConfigurationError as error:
            status = refuse(dict.fromkeys(error.faults))
        except SweepError as error:
            status = refuse([str(error)])
        if status:
            raise SystemExit(status)

    def _swept(self, lines: Sequence[str]) -> int:
        try:
            overrides = self._parser.parse_overrides(list(lines))
            folder = Path(str(self._config.hydra.sweep.dir))
            section: Any = OmegaConf.to_container(self._config.sweep, resolve=True)
        # Hydra lets the errors of what it calls through.
        except Exception as error:
            raise ConfigurationError(sentences(error, lines)) from error
        arguments = _Arguments(overrides, section)
        settings = arguments.settings
        if faults := [*misplaced(lines, swept=True), *arguments.faults]:
            raise ConfigurationError(faults)
        samples = settings.samples is not None
        composer = _Hydra(self._context, self._config, arguments.fixed)
        plan = planned(
            composer,
            full_keys(arguments.columns, composer) if samples else arguments.columns,
            settings.outputs,
            samples=samples,
            chunk=settings.chunk,
            progress=terminal.progress,
        )
        if sets_friction([*arguments.fixed, *(f"{axis.key}=" for axis in plan.axes)]):
            if words := idle_friction(base["law"] for base in plan.bases):
                tell(f"contactlab: {words}", sys.stderr)
        if settings.keep == "metrics":
            return self._metrics(plan, settings, folder)
        jobs = self._jobs(plan, arguments, composer)
        return self._folders(jobs, settings, folder)

    def _folders(
        self, jobs: Sequence[tuple[str, Job, list[str]]], settings: _Settings, folder: Path
    ) -> int:
        """Run jobs that leave a folder each, but for those that are complete; give the worst status."""
        for name, count in Counter(name for name, _, _ in jobs).items():
            if count > 1:
                raise ConfigurationError(
                    [
                        f"hydra.sweep.subdir gives '{folder / name}' to {count} jobs, which would overwrite "
                        "each other; it must differ from job to job. Leave it out, and give every value "
                        "once."
                    ]
                )
        there = [folder / name for name, _, _ in jobs if (folder / name).exists()]
        longest = folder / max((name for name, _, _ in jobs), key=len)
        if faults := [fault for path in {*there, longest} for fault in refusals(path)]:
            raise ConfigurationError(faults)
        done, sentence = resume([(folder / name, job.key) for name, job, _ in jobs])
        print(sentence, flush=True)
        folder.mkdir(parents=True, exist_ok=True)
        extend_manifest(folder, {name: job for name, job, _ in jobs})
        pending = [job for job, is_there in zip(jobs, done, strict=True) if not is_there]
        status = COMPLETE
        if pending:
            announce(job.configuration for _, job, _ in pending)
            OmegaConf.save(self._config, folder / "multirun.yaml")
            where = f"hydra.sweep.dir={quoted(str(folder))}"
            batch = [
                [*lines, where, f"hydra.sweep.subdir={quoted(name)}"] for name, _, lines in pending
            ]
            status = self._launched(self._task, batch, folder)
        _collected(folder, settings)
        return status

    def _jobs(
        self, plan: Plan, arguments: _Arguments, composer: _Hydra
    ) -> list[tuple[str, Job, list[str]]]:
        """Build every run; give the name of its folder, what it is asked for, and its overrides."""
        if plan.cells > MOST_JOBS:
            raise ConfigurationError(
                [
                    f"{' x '.join(map(str, plan.shape))} = {plan.cells:.4g} runs are asked for; a sweep of "
                    f"folders must have at most {MOST_JOBS}. Take fewer values, or sweep.keep=metrics, "
                    "which keeps numbers alone."
                ]
            )
        jobs = []
        texts = arguments.texts(plan)
        resolve = composer.resolve if "${" in str(plan.bases) else None
        for cell, setup in setups_of(plan, resolve, terminal.progress):
            places = zip(texts.items(), plan.places(cell), strict=True)
            lines = arguments.lines({key: column[place] for (key, column), place in places})
            point = plan.point(cell)
            options = tuple(point[group] for group in plan.groups)
            values = {key: point[key] for key in point if key not in plan.groups}
            name = composer.folder(options, lines, values, cell)
            job = Job(key_of(setup), tuple(lines), composer.choices[options], setup.configuration)
            jobs.append((name, job, lines))
        return jobs

    def _metrics(self, plan: Plan, settings: _Settings, folder: Path) -> int:
        """Run what leaves its metrics alone, but for the chunks that are there; give the exit status."""
        if "${" in str(plan.bases):
            raise ConfigurationError(
                [
                    "The configuration has references in ${...}; a sweep of metrics must have their "
                    "values, which may depend on what is swept. Write the values."
                ]
            )
        if plan.samples:
            for _ in setups_of(plan, None, terminal.progress):
                pass
        if faults := list(refusals(folder, "Choose another one by hydra.sweep.dir=DIR.")):
            raise ConfigurationError(faults)
        store = Store(folder, plan)
        store.begin()
        print(store.sentence, flush=True)
        announce_series(plan.cells, len(plan.outputs.series), plan.bases[0])
        missing = store.missing()
        status = COMPLETE
        try:
            with terminal.raising():
                if self._config.hydra.runtime.choices["hydra/launcher"] == "basic":
                    _run_here(store, missing, settings.workers)
                elif missing:
                    status = self._launched_chunks(store, missing, settings.workers)
                dataset = store.merge()
        except WorkerError as error:
            tell(str(error), sys.stderr)
            return INCOMPLETE
        except OSError as error:
            tell(f"The sweep could not be written: {told(error)}", sys.stderr)
            return INCOMPLETE
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                "Interrupted. The chunks that are finished are kept: the same command goes on there."
            ) from None
        print(summary(dataset, store.file))
        return max(status, int(dataset.attrs["runs_absent"] > 0))

    def _launched_chunks(self, store: Store, missing: Sequence[int], workers: int | None) -> int:
        where = quoted(str(store.path.absolute()))
        own = [
            f"hydra.sweep.dir={quoted(str((store.path / CHUNKS).absolute()))}",
            "hydra.sweep.subdir=log/${hydra.job.num}",
            "hydra.output_subdir=null",
        ]
        batch = [
            [f"+chunk.folder={where}", f"+chunk.number={n}", f"+chunk.workers={workers or 0}", *own]
            for n in missing
        ]
        self._config.hydra.sweep.dir = str((store.path / CHUNKS).absolute())
        return self._launched(run_chunk, batch, store.path)

    def _launched(self, task: TaskFunction, batch: list[list[str]], folder: Path) -> int:
        """Have a launcher run jobs; give the status of the worst, and tell why they cannot be run."""
        status = COMPLETE
        try:
            # Between the jobs an exception, at which a launcher ends the processes that it has begun.
            with terminal.raising():
                launcher = Plugins.instance().instantiate_launcher(
                    hydra_context=self._context, task_function=task, config=self._config
                )
                size = self._size or len(batch)
                for first in range(0, len(batch), size):
                    jobs = batch[first : first + size]
                    for returned in launcher.launch(jobs, initial_job_idx=first):
                        # The exception of a job that failed is raised by looking at it.
                        status = max(status, int(returned.return_value or 0))
        # A worker that is killed, a cluster that takes no jobs: the launchers raise what they like.
        except Exception as error:
            tell(
                f"The sweep stopped: {type(error).__name__}: {one_line(error)} What is complete stays, "
                "and the same command goes on from there.",
                sys.stderr,
            )
            with suppress(OSError):
                write_log(folder / LOG, error)
            status = INCOMPLETE
        return status


def run_chunk(settings: DictConfig) -> int:
    """Run one chunk of a sweep that keeps metrics; launchers import it from here.

    Raises:
        SweepError: this machine has other code than the sweep was begun with.
    """
    asked = settings.chunk
    store = Store.opened(Path(asked.folder))
    if code_digest_of(store.plan.bases) != store.plan.code:
        raise SweepError(
            f"The sweep in '{store.path}' was begun by other code than {platform.node()} has; both must be "
            "the same, laws of other packages included. Install one version everywhere."
        )
    # The processes of a launcher share a machine, unless a cluster gives each some processors.
    workers = asked.workers or int(os.environ.get("SLURM_CPUS_PER_TASK", "1"))
    with store.batch(min(workers, processors())) as batch:
        store.run(asked.number, batch)
    return COMPLETE


def _run_here(store: Store, missing: Sequence[int], workers: int | None) -> None:
    """Run chunk after chunk on this machine."""
    runs = sum(len(store.plan.cells_of(chunk)) for chunk in missing)
    done = 0
    with terminal.progress(runs, "runs", "The sweep") as show:

        def report(count: int) -> None:
            nonlocal done
            done += count
            show(done)

        with store.batch(workers, report) as batch:
            for chunk in missing:
                store.run(chunk, batch)


def _collected(folder: Path, settings: _Settings) -> None:
    """Collect what is there; a failure of that is told and is none of the sweep."""
    try:
        with terminal.raising():
            outputs = settings.outputs
            metrics = () if settings.metrics is None else outputs.metrics
            dataset = collect(folder, series=outputs.series, metrics=metrics)
            print(summary(dataset, dataset.encoding["source"]))
    except SweepError as error:
        tell(f"The runs could not be collected: {error}", sys.stderr)
    except OSError as error:
        tell(f"The runs could not be collected: {told(error)}", sys.stderr)


def _table(path: str) -> dict[str, list[Value]]:
    """Read a table of samples, CSV or netCDF: its values by the names of its columns.

    Raises:
        ConfigurationError: it cannot be read, or lacks a value.
    """
    try:
        if path.endswith(".csv"):
            table = pandas.read_csv(path, skipinitialspace=True)
        else:
            with xarray.open_dataset(path, decode_times=False) as dataset:
                keys = {
                    name: str(v.attrs.get("key", name)) for name, v in dataset.variables.items()
                }
                table = dataset.to_dataframe().rename(columns=keys)
    # A file can be anything.
    except Exception as error:
        raise ConfigurationError(
            [
                f"sweep.samples is '{path}' and cannot be read ({one_line(error)}); it must be a table, CSV or "
                "netCDF, whose columns are keys and whose rows are runs."
            ]
        ) from error
    empty = [
        f"sweep.samples has no {name} in row {int(row) + 1} of '{path}'; every run must have one. Add it, or "
        "leave the row out."
        for name in table
        for row in table[name].isna().to_numpy().nonzero()[0]
    ]
    if empty:
        raise ConfigurationError(empty)
    return {str(name).strip(): table[name].tolist() for name in table}


def _plain(value: Any) -> Any:
    return value.text if isinstance(value, QuotedString) else value


def _text(value: Value) -> str:
    """Give a value as an override has it."""
    if isinstance(value, str):
        return value if re.fullmatch(r"[\w.+-]+", value, re.ASCII) else quoted(value)
    return str(value).lower() if isinstance(value, bool) else repr(value)
