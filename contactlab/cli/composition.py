"""What a command line asks for, checked before anything runs: every job of it, and every fault."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

from hydra.core.config_loader import ConfigLoader
from hydra.core.override_parser.types import Override
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from contactlab.cli.composer import BASIC_SWEEPER, Composer, parted, sweeper_of
from contactlab.cli.directories import (
    depends_on_number,
    resolved_directory,
    shared,
    sweep_directory,
    to_be_tried,
)
from contactlab.cli.progress import progress
from contactlab.cli.runner import refusals
from contactlab.config import build
from contactlab.config.faults import ConfigurationError, one_line
from contactlab.config.rules import FRICTION, idle_friction
from contactlab.sweeps.job import Job, key_of


@final
@dataclass(frozen=True)
class PlannedJob:
    """A job of a command line.

    Args:
        lines: its overrides, those left out that the command line gives to Hydra itself.
        folder: where it writes to.
        job: what it is asked for.
    """

    lines: tuple[str, ...]
    folder: Path
    job: Job


@final
@dataclass(frozen=True)
class Plan:
    """What a sound command line asks for.

    Args:
        mode: a run or a sweep.
        jobs: all of them; none for a sweeper that chooses its values itself.
        directory: of a sweep, where its name depends on all overrides, else empty.
        numbered: whether the folder of a job depends on its number in the sweep.
    """

    mode: RunMode
    jobs: tuple[PlannedJob, ...]
    directory: str
    numbered: bool


def check(loader: ConfigLoader, config_name: str, lines: Sequence[str], multirun: bool) -> Plan:
    """Compose and build every job of a command line and try its output directory.

    Args:
        loader: Hydra's.
        config_name: of the primary configuration.
        lines: the overrides as typed.
        multirun: whether a sweep is asked for; the configuration may ask for one as well.

    Returns:
        What the command line asks for.

    Raises:
        ConfigurationError: with every fault of every job. Nothing has been written.
    """
    composer = Composer(loader, config_name)
    overrides = composer.parse(lines)
    whole = None if multirun or composer.faults else composer.compose_whole(lines)
    base = whole or composer.compose([o for o in overrides if not o.is_sweep_override()])
    multirun = multirun or (base is not None and base.hydra.mode == RunMode.MULTIRUN)
    checker = _Checker(composer.faults, lines)
    if multirun:
        checker.name_sweep(base, overrides)
        planned = []
        asked = composer.jobs(overrides, base)
        with progress(len(asked), "runs", "Checking the sweep") as show:
            for number, job in enumerate(asked):
                planned.append(checker.check(composer.compose_job(job), job, number, multirun=True))
                show(number + 1)
    else:
        job = composer.refuse_sweeps(overrides)
        planned = [checker.check(parted(whole) if whole else composer.compose_job(job), job, 0)]
    jobs = [job for job in planned if job is not None]
    folders = [job.folder for job in jobs]
    faults = composer.faults
    faults = faults or [*shared(folders), *(f for p in to_be_tried(folders) for f in refusals(p))]
    if faults or base is None:
        raise ConfigurationError(list(dict.fromkeys(faults)))
    if words := idle_friction(checker.rubbing):
        print(f"contactlab: {words}", file=sys.stderr)
    return Plan(
        RunMode.MULTIRUN if multirun else RunMode.RUN,
        tuple(jobs) if not multirun or sweeper_of(base) == BASIC_SWEEPER else (),
        checker.directory,
        depends_on_number(base),
    )


def check_composition(loader: ConfigLoader, config_name: str, lines: Sequence[str]) -> None:
    """Check that a command line composes, whatever its values are.

    Raises:
        ConfigurationError: with every fault, those of the values included, if it does not.
    """
    if Composer(loader, config_name).compose_whole(lines) is None:
        check(loader, config_name, lines, multirun=False)


def choices_of(choices: Mapping[str, Any]) -> dict[str, str | None]:
    """The options that were chosen, by group; Hydra's own groups left out."""
    return {
        str(group): None if option is None else str(option)
        for group, option in sorted(choices.items())
        if not str(group).startswith("hydra/")
    }


@final
class _Checker:
    """Builds jobs and finds their folders.

    Args:
        faults: where sentences on what is wrong go.
        lines: the overrides as typed.
    """

    def __init__(self, faults: list[str], lines: Sequence[str]) -> None:
        self.directory = ""
        self.rubbing: list[Mapping[str, Any]] = []
        """The laws of the jobs for which the friction coefficient is set."""
        self._faults = faults
        self._typed = set(lines)
        self._first: DictConfig | None = None

    def name_sweep(self, base: DictConfig | None, overrides: list[Override]) -> None:
        """Find the folder of a sweep where its name depends on all overrides."""
        try:
            self.directory = "" if base is None else sweep_directory(base, _tasks(overrides))
        except OmegaConfBaseException as error:
            self._faults.append(f"hydra.sweep.dir cannot be resolved: {one_line(error)} Name one.")

    def check(
        self,
        composed: tuple[DictConfig, DictConfig] | None,
        job: list[Override],
        number: int,
        multirun: bool = False,
    ) -> PlannedJob | None:
        """Build what a job would run; None where something is faulty."""
        if composed is None:
            return None
        task, hydra = composed
        try:
            setup = build(OmegaConf.to_container(task, resolve=True))  # type: ignore[arg-type]
        except ConfigurationError as error:
            self._faults += error.faults
            setup = None
        except OmegaConfBaseException as error:
            self._faults.append(f"{one_line(error)} Correct the reference in ${{...}}.")
            setup = None
        folder = self._folder(task, hydra, _tasks(job), number, multirun)
        if setup is None or folder is None:
            return None
        if any(override.key_or_group == FRICTION for override in job):
            self.rubbing.append(setup.configuration["law"])
        tasks = tuple(str(override.input_line) for override in _tasks(job))
        asked = Job(key_of(setup), tasks, choices_of(hydra.runtime.choices), setup.configuration)
        lines = [
            str(override.input_line)
            for override in job
            if not (override.is_hydra_override() and override.input_line in self._typed)
        ]
        return PlannedJob(tuple(lines), folder, asked)

    def _folder(
        self,
        task: DictConfig,
        hydra: DictConfig,
        tasks: list[Override],
        number: int,
        multirun: bool,
    ) -> Path | None:
        """Output directory of a job."""
        # ${now:...} is one moment for all jobs, as it is for Hydra.
        OmegaConf.copy_cache(self._first or task, task)
        self._first = self._first or task
        keys = "hydra.sweep.dir or hydra.sweep.subdir" if multirun else "hydra.run.dir"
        try:
            folder = resolved_directory(task, hydra, tasks, number, multirun, self.directory)
        except OmegaConfBaseException as error:
            self._faults.append(f"{keys} cannot be resolved: {one_line(error)} Name a directory.")
            return None
        below = Path(hydra.output_subdir or "")
        if below.is_absolute() or ".." in below.parts:
            self._faults.append(
                f"hydra.output_subdir is '{below}'; it must be a folder below that of the run. Leave it out."
            )
        return folder


def _tasks(overrides: list[Override]) -> list[Override]:
    """The overrides that do not concern Hydra itself."""
    return [override for override in overrides if not override.is_hydra_override()]
