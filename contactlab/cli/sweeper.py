"""The sweep of a command line: every run checked before the first, what is complete skipped, all collected.

Hydra's own sweeper hands every job to the launcher, so that a cluster would be asked for a node to find a run
complete. Here the jobs are known and sound, and the launcher receives those that are to run, where runs leave
folders. A sweep that keeps numbers alone is the study `contactlab.studies.sweep.Sweep`.
"""

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
from contactlab.processes import WorkerError, processors
from contactlab.results.files import LOG, STATE, told
from contactlab.studies.sweep import Sweep as SweepStudy, begin, continued, runs_of
from contactlab.sweeps.dataset import summary
from contactlab.sweeps.outputs import Outputs
from contactlab.sweeps.plan import NOTHING, Plan, full_keys, planned, raise_faults, setups_of
from contactlab.sweeps.state import ABSENT, State, resume, write_state
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
            settings: Any = OmegaConf.to_container(self.config.sweep, resolve=True)
        # Hydra lets the errors of what it calls through.
        except Exception as error:
            raise ConfigurationError(sentences(error, lines)) from error
        arguments = Arguments(self.context, self.config, overrides, settings)
        faults = [*misplaced(lines, swept=True), *arguments.faults]
        try:
            validate({**arguments.compose({}), "sweep": arguments.settings})
        except ConfigurationError as error:
            # What else is wrong may be set right by what is swept.
            faults += [fault for fault in error.faults if fault.startswith("sweep.")]
        raise_faults(faults)
        settings = Sweep(**arguments.settings)
        section: dict[str, Any] = dict(self.config.study)
        study = section["name"]
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
        if plan.keep == "metrics":
            workers = settings.workers or (section.get("workers", 1) if study != RUN else None)
            workers = workers or processors()
            sweep = SweepStudy(plan=plan, workers=workers, scheduler=section.get("scheduler"))
            return self._metrics(sweep, folder)
        status = self._folders(plan, folder, arguments)
        collect_swept(folder, plan.outputs.series, plan.outputs.metrics if settings.metrics else ())
        if status == COMPLETE and any(axis.key == "law" for axis in plan.axes):
            tell_next("compare", [str(folder)], "sets the laws side by side")
        return status

    def _folders(self, plan: Plan, folder: Path, arguments: Arguments) -> int:
        """Run what leaves a folder each, but for what is complete; return the worst status."""
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
        begin(folder, plan)
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
        return self._launched(batch, folder)

    def _metrics(self, sweep: SweepStudy, folder: Path) -> int:
        """Do what is left of a sweep that keeps numbers alone; return the exit status."""
        plan = sweep.plan
        faults = list(refusals(folder, "Choose another one by hydra.sweep.dir=DIR."))
        if not plan.axes:
            faults.append(NOTHING)
        if "${" in str(plan.bases):
            faults.append(
                "The configuration has references in ${...}; a sweep of metrics must have their values, "
                "which may depend on what is swept. Write the values."
            )
        if (launcher := self.config.hydra.runtime.choices["hydra/launcher"]) != "basic":
            faults.append(
                f"hydra/launcher is '{launcher}', which is for runs that leave folders; with "
                "sweep.keep=metrics it must be left out. Take sweep.workers=N on one machine and "
                "study.scheduler=ADDRESS, a Dask scheduler, on several."
            )
        raise_faults(faults)
        begin(folder, plan)
        if plan.outputs.series:
            # A faulty cell is refused at its place.
            with suppress(ConfigurationError):
                first = plan.setup_at(0).configuration
                announce_series(plan.cells, len(plan.outputs.series), first)
        try:
            with terminal.raising(), terminal.progress(plan.cells, "runs", "The sweep") as show:
                dataset = continued(sweep, folder, runs_of(plan, show))
        except (WorkerError, OSError) as error:
            why = told(error) if isinstance(error, OSError) else str(error)
            tell(f"The sweep stopped: {why}", sys.stderr)
            return INCOMPLETE
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                "Interrupted. The tasks that are finished are kept: the same command goes on there."
            ) from None
        print(summary(dataset, dataset.encoding["source"]))
        # Values that cannot go together are refused alone, as the plan says; a run that fails is a failure.
        ended = dataset.attrs["runs_complete"] + dataset.attrs["runs_refused"]
        return COMPLETE if ended == dataset.attrs["runs"] else INCOMPLETE

    def _launched(self, batch: list[list[str]], folder: Path) -> int:
        """Have a launcher run jobs; return the status of the worst, and tell why they cannot be run."""
        if not batch:
            return COMPLETE
        status = COMPLETE
        try:
            # Between the jobs an exception, at which a launcher ends the processes that it has begun.
            with terminal.raising():
                launcher = Plugins.instance().instantiate_launcher(
                    hydra_context=self.context, task_function=self.task, config=self.config
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
                write_log(folder / LOG, error)
            status = INCOMPLETE
        return status
