"""The sweep of a command line: every run checked before the first, what is complete skipped, all collected.

Hydra's own sweeper hands every job to the launcher, so that a cluster would be asked for a node to find a run
complete. Here the jobs are known and sound, and the launcher is given those that are to run: a job each where
runs leave their folders, a job a chunk where they leave their metrics alone.
"""

import os
import platform
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.plugins import Plugins
from hydra.types import HydraContext, TaskFunction
from omegaconf import DictConfig, OmegaConf

from contactlab.cli import terminal
from contactlab.cli.arguments import quoted
from contactlab.cli.checking import announce, announce_series, misplaced, sets_friction
from contactlab.cli.collect import collect_swept
from contactlab.cli.jobs import refusals, write_log
from contactlab.cli.next_step import tell_next
from contactlab.cli.sweep_arguments import Arguments, table
from contactlab.cli.terminal import COMPLETE, INCOMPLETE, refuse, tell
from contactlab.config import ConfigurationError, validate
from contactlab.config.composition import sentences
from contactlab.config.faults import one_line
from contactlab.config.groups import Sweep
from contactlab.config.schema import idle_friction
from contactlab.config.studies import RUN
from contactlab.processes import processors
from contactlab.results.files import LOG, STATE, told
from contactlab.sweeps.batch import Outputs, WorkerError
from contactlab.sweeps.dataset import summary
from contactlab.sweeps.plan import NOTHING, full_keys, planned, raise_faults, setups_of
from contactlab.sweeps.state import ABSENT, State, code_digest_of, resume, sentence, write_state
from contactlab.sweeps.store import CHUNKS, Store
from contactlab.sweeps.values import SweepError


@final
@dataclass(frozen=True)
class Sweeping:
    """Plans, checks, resumes and collects a sweep, by what Hydra gives a sweeper and its options."""

    context: HydraContext
    task: TaskFunction
    config: DictConfig
    max_batch_size: int | None = None
    params: Mapping[str, str] | None = None

    def sweep(self, arguments: list[str]) -> None:
        """Run a sweep, or go on with it.

        Raises:
            SystemExit: with the status of the worst run, or that of what was refused.
        """
        try:
            given = (f"{key}={value}" for key, value in (self.params or {}).items())
            status = self._swept([*given, *arguments])
        except ConfigurationError as error:
            status = refuse(dict.fromkeys(error.faults))
        except SweepError as error:
            status = refuse([str(error)])
        if status:
            raise SystemExit(status)

    def _swept(self, lines: Sequence[str]) -> int:
        try:
            parser = OverridesParser.create(config_loader=self.context.config_loader)
            overrides = parser.parse_overrides(list(lines))
            folder = Path(str(self.config.hydra.sweep.dir))
            section: Any = OmegaConf.to_container(self.config.sweep, resolve=True)
        # Hydra lets the errors of what it calls through.
        except Exception as error:
            raise ConfigurationError(sentences(error, lines)) from error
        arguments = Arguments(self.context, self.config, overrides, section)
        faults = [*misplaced(lines, swept=True), *arguments.faults]
        try:
            validate({**arguments.compose({}), "sweep": arguments.settings})
        except ConfigurationError as error:
            # What else is wrong may be set right by what is swept.
            faults += [fault for fault in error.faults if fault.startswith("sweep.")]
        raise_faults(faults)
        settings = Sweep(**arguments.settings)
        study = str(self.config.study.name)
        samples = settings.samples
        plan = planned(
            arguments,
            full_keys(table(samples), arguments) if samples else arguments.columns,
            Outputs.of_study(study)
            if study != RUN
            else Outputs.named(settings.metrics, settings.series or ()),
            samples=samples is not None,
            # A cell of a study takes seconds: every one is kept as it ends.
            chunk=settings.chunk or (1 if study != RUN else None),
            keep="metrics" if study != RUN else settings.keep,
        )
        set_keys = [*arguments.fixed, *(f"{axis.key}=" for axis in plan.axes)]
        if sets_friction(set_keys) and (words := idle_friction(b["law"] for b in plan.bases)):
            tell(f"contactlab: {words}", sys.stderr)
        store = Store(folder, plan)
        if plan.keep == "metrics":
            return self._metrics(store, settings.workers)
        status = self._folders(store, arguments)
        collect_swept(folder, plan.outputs.series, plan.outputs.metrics if settings.metrics else ())
        if status == COMPLETE and any(axis.key == "law" for axis in plan.axes):
            tell_next("compare", [str(folder)], "sets the laws side by side")
        return status

    def _folders(self, store: Store, arguments: Arguments) -> int:
        """Run what leaves a folder each, but for what is complete; give the worst status."""
        plan, folder = store.plan, store.path
        jobs = []
        with terminal.progress(plan.cells, "runs", "Checking the sweep") as show:
            for cell, setup in enumerate(setups_of(plan, arguments)):
                jobs.append(arguments.job(plan, cell, setup))
                show(cell)
        names = Counter(name for name, _ in jobs)
        faults = [
            f"hydra.sweep.subdir gives '{folder / name}' to {count} jobs, which would overwrite each other; "
            "it must differ from job to job. Leave it out, and give every value once."
            for name, count in names.items()
            if count > 1
        ]
        # Of folders that are not there yet the longest name tells.
        tried = {*(folder / name for name in names if (folder / name).exists())}
        faults += [f for path in {*tried, folder / max(names, key=len)} for f in refusals(path)]
        raise_faults(faults)
        store.begin()
        runs, said = resume([(folder / name, job.key) for name, job in jobs])
        print(said, flush=True)
        pending = [job for job, is_to_run in zip(jobs, runs, strict=True) if is_to_run]
        for place, job in ((folder / name, job) for name, job in pending):
            # So that it is known what one was that never begins.
            place.mkdir(parents=True, exist_ok=True)
            if not (place / STATE).exists():
                write_state(place, State(ABSENT, job))
        announce(job.configuration for _, job in pending)
        if pending:
            OmegaConf.save(self.config, folder / "multirun.yaml")
        where = f"hydra.sweep.dir={quoted(str(folder))}"
        batch = [[*job.overrides, where, f"hydra.sweep.subdir={quoted(name)}"] for name, job in pending]
        return self._launched(self.task, batch, store)

    def _metrics(self, store: Store, workers: int | None) -> int:
        """Run what leaves its metrics alone, but for the chunks that are there; give the exit status."""
        plan = store.plan
        faults = list(refusals(store.path, "Choose another one by hydra.sweep.dir=DIR."))
        if not plan.axes:
            faults.append(NOTHING)
        if "${" in str(plan.bases):
            faults.append(
                "The configuration has references in ${...}; a sweep of metrics must have their values, "
                "which may depend on what is swept. Write the values."
            )
        raise_faults(faults)
        store.begin()
        print(sentence(plan.cells, {ABSENT: store.missing_runs()}), flush=True)
        if plan.outputs.series:
            # A run that is refused is told of at its place.
            with suppress(ConfigurationError):
                first = plan.setup_at(0).configuration
                announce_series(plan.cells, len(plan.outputs.series), first)
        try:
            with terminal.raising():
                status = self._chunks(store, workers)
                dataset = store.merge()
        except (WorkerError, OSError) as error:
            why = told(error) if isinstance(error, OSError) else str(error)
            tell(f"The sweep stopped: {why}", sys.stderr)
            return INCOMPLETE
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                "Interrupted. The chunks that are finished are kept: the same command goes on there."
            ) from None
        print(summary(dataset, dataset.encoding["source"]))
        # Values that cannot go together are refused alone, as the plan says; a run that fails is a failure.
        ended = dataset.attrs["runs_complete"] + dataset.attrs["runs_refused"]
        return max(status, COMPLETE if ended == dataset.attrs["runs"] else INCOMPLETE)

    def _chunks(self, store: Store, workers: int | None) -> int:
        """Run the chunks that are missing, here or by a launcher."""
        missing = store.missing()
        if missing and self.config.hydra.runtime.choices["hydra/launcher"] == "basic":
            with terminal.progress(store.missing_runs(), "runs", "The sweep") as show:
                store.run_missing(workers, show)
            return COMPLETE
        below = self.config.hydra.sweep.dir = str((store.path / CHUNKS).absolute())
        own = [
            f"+chunk.folder={quoted(str(store.path.absolute()))}",
            f"+chunk.workers={workers or 0}",
            f"hydra.sweep.dir={quoted(below)}",
            "hydra.sweep.subdir=log/${hydra.job.num}",
            "hydra.output_subdir=null",
        ]
        return self._launched(run_chunk, [[f"+chunk.number={n}", *own] for n in missing], store)

    def _launched(self, task: TaskFunction, batch: list[list[str]], store: Store) -> int:
        """Have a launcher run jobs; give the status of the worst, and tell why they cannot be run."""
        if not batch:
            return COMPLETE
        status = COMPLETE
        try:
            # Between the jobs an exception, at which a launcher ends the processes that it has begun.
            with terminal.raising():
                launcher = Plugins.instance().instantiate_launcher(
                    hydra_context=self.context, task_function=task, config=self.config
                )
                size = self.max_batch_size or len(batch)
                for at in range(0, len(batch), size):
                    for returned in launcher.launch(batch[at : at + size], initial_job_idx=at):
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
                write_log(store.path / LOG, error)
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
    with store.plan.batch(min(workers, processors())) as batch:
        store.run(asked.number, batch)
    return COMPLETE
