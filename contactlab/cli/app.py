"""The task of the Hydra application: one run or study, and the checks before it.

Hydra makes the folder of a run before it calls the task. Therefore single runs are checked by a callback,
and sweeps by our sweeper: a faulty one leaves nothing behind.
"""

import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryFile
from time import perf_counter
from typing import Any, Final, final

from hydra.conf import HydraConf
from hydra.core.hydra_config import HydraConfig
from hydra.experimental.callback import Callback
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf, read_write
from omegaconf.errors import OmegaConfBaseException

from contactlab.cli import terminal
from contactlab.cli.sections import of_command, of_run
from contactlab.cli.study import perform_study, setups_of, without_effect
from contactlab.cli.terminal import COMPLETE, INCOMPLETE, REFUSED, RefusalError, refuse, tell
from contactlab.cli.verbs.collect import collect_swept
from contactlab.config import ConfigurationError, Setup, rebuild
from contactlab.config.composition import faults_of
from contactlab.config.faults import faults_added, one_line
from contactlab.config.nesting import quoted
from contactlab.config.schema import FRICTION
from contactlab.laws.registry import takes_shared
from contactlab.results.files import DATASET, LOG, STATE
from contactlab.results.summary import summarise
from contactlab.studies import run_state
from contactlab.studies.registry import SIMULATE, study_class
from contactlab.studies.run_state import PICTURE, Job, State, is_done, key_of, leave, write_state
from contactlab.trajectory import Trajectory

RECORD_ON_DISK: Final = 85
"""Size of a record in run.nc [bytes], measured with three laws at 1 and 10 us: 83 to 104."""

LARGE: Final = 100e6
"""Size on disk from which it is announced [bytes]."""

_checked: dict[str, Setup] = {}
"""The setup of a single run, built by its check."""


def run(settings: DictConfig) -> int:
    """Perform one job and return its exit status.

    A job of a sweep that is complete already is left as it is.

    Raises:
        SystemExit: with the status, where the job is a run of its own, since Hydra returns none.
    """
    hydra_config = HydraConfig.get()
    directory = Path(hydra_config.runtime.output_dir)
    swept = hydra_config.mode == RunMode.MULTIRUN
    job = Job(overrides=tuple(typed(hydra_config.overrides.task)), choices=choices_of(hydra_config))
    try:
        setup = None if swept else _checked.pop("setup", None)
        setup = setup or rebuild(of_run(settings))
    except ConfigurationError as error:
        # Only a sweeper that chooses its values while it runs gets here.
        write_state(directory, State(run_state.REFUSED, job, " ".join(error.faults)))
        return refuse(error.faults)
    if not swept and settings.study.name != SIMULATE:
        study, sweep = of_command(settings)
        over = sweep.over or []
        setups = setups_of(job.overrides, over, study.base) if over or study.base is not None else {"": setup}
        try:
            status = perform_study(study, setups, directory)
        # Hydra would print the job's arguments before it.
        except RefusalError as refusal:
            status = refuse([str(refusal)], refusal.status)
        sys.exit(status)
    job = Job(key_of(setup), job.overrides, job.choices, setup.configuration)
    if swept and is_done(directory, job.key):
        return COMPLETE
    with terminal.ending_at_once():
        status = COMPLETE if perform(setup, directory, job, swept=swept) else INCOMPLETE
    if status and not swept:
        sys.exit(status)
    return status


def perform(setup: Setup, directory: Path, job: Job, *, swept: bool) -> bool:
    """Run a job, leave its files in a directory, print what became of it, and return whether it is complete.

    Raises:
        KeyboardInterrupt: with a sentence, after what there was has been written.
    """
    started, taken = perf_counter(), 0.0

    def simulate(setup: Setup) -> Trajectory:
        nonlocal taken
        with terminal.progress(setup.duration, "s") as show, terminal.waiting() as check:

            def report(time: float) -> None:
                nonlocal started
                # The engine reports 0 once it is compiled; the compiler's time is not the run's.
                started = perf_counter() if time == 0.0 else started
                show(time)
                check()

            trajectory = setup.run(progress=report, keep_interrupted=True)
        taken = perf_counter() - started
        return trajectory

    with terminal.raising():
        state, groups = leave(setup, directory, job, simulate, with_metrics=swept)
    if state.digest:
        beside = f" and {PICTURE} beside it." if setup.configuration["record"]["picture"] else "."
        tell(f"{summarise(groups, taken)}\nWritten to {directory / DATASET}{beside}", sys.stdout)
    if state.state == run_state.INTERRUPTED:
        raise KeyboardInterrupt(state.reason)
    if state.reason:
        tell(state.reason, sys.stderr)
    if (directory / LOG).exists():
        tell(f"The traceback is in {directory / LOG}.", sys.stderr)
    return state.state == run_state.COMPLETE


@final
class Check(Callback):
    """Checks a single run before Hydra makes its folder, and collects the runs of a sweeper of others."""

    def __init__(self) -> None:
        self._collects = False

    def on_run_start(self, config: DictConfig, **_: Any) -> None:
        """Refuse a faulty run and announce a large one.

        Raises:
            SystemExit: a fault in the arguments. Hydra makes warnings of other exceptions here.
        """
        lines = typed(config.hydra.overrides.hydra) + typed(config.hydra.overrides.task)
        faults = [*without_effect(study_class(str(config.study.name)), lines)]
        study, over = None, list[str]()
        with faults_added(faults):
            study, sweep = of_command(config)
            over = list(sweep.over or [])
            if not faults:
                faults += without_effect(study, [*lines, *over])
        try:
            setup = _checked["setup"] = rebuild(of_run(config))
            faults += idle_friction(lines, [setup.configuration["law"]])
            if study and not faults and over:
                setups_of(lines, over, study.base)
            faults = faults or list(_folder_faults(config))
        except Exception as error:
            faults += faults_of(error, lines)
        if faults:
            sys.exit(refuse(faults))
        announce([setup.configuration])

    def on_multirun_start(self, config: DictConfig, **_: Any) -> None:
        """Fix the folder of a sweep for all its jobs, which else name it by their own overrides.

        Raises:
            SystemExit: options of our sweeper, on which another does not depend.
        """
        # Our sweeper does all this itself.
        if "contactlab" in str(config.hydra.sweeper.get("_target_")):
            return
        lines = typed(config.hydra.overrides.task)
        if idle := [line for line in lines if line.lstrip("+").startswith("sweep.")]:
            name = config.hydra.runtime.choices["hydra/sweeper"]
            sys.exit(
                refuse(f"{x} has no effect with hydra/sweeper={name}; it must be left out." for x in idle)
            )
        # A reference may not have its value yet; each job then refuses it.
        with suppress(OmegaConfBaseException), read_write(config.hydra):
            folder = config.hydra.sweep.dir = str(config.hydra.sweep.dir)
            config.hydra.overrides.hydra.append(f"hydra.sweep.dir={quoted(folder)}")
        self._collects = True

    def on_multirun_end(self, config: DictConfig, **_: Any) -> None:
        """Collect what the sweeper of another package left.

        Raises:
            SystemExit: a run is not complete.
        """
        # Hydra 1.4 ends a sweep that was refused, too.
        if not self._collects:
            return
        folder = Path(str(config.hydra.sweep.dir))
        collect_swept(folder)
        if status := status_of_runs(path.parent for path in folder.rglob(STATE)):
            sys.exit(status)


def status_of_runs(folders: Iterable[Path]) -> int:
    """Return the exit status of a sweep whose runs left these folders."""
    states = {state.state if (state := run_state.read_state(folder)) else "" for folder in folders}
    if states == {run_state.COMPLETE}:
        return COMPLETE
    return REFUSED if run_state.REFUSED in states else INCOMPLETE


def typed(overrides: Any) -> list[str]:
    """Return arguments as they were typed, references in them unresolved."""
    return [str(line) for line in OmegaConf.to_container(overrides, resolve=False) or ()]


def idle_friction(lines: Iterable[str], laws: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return the fault of setting the shared friction coefficient for laws none of which has it."""
    is_set = any(line.lstrip("+").startswith(f"{FRICTION}=") for line in lines)
    if not is_set or any(map(takes_shared, laws := [*laws])):
        return []
    names = ", ".join(dict.fromkeys(str(law["name"]) for law in laws))
    return [f"{FRICTION} has no effect on law={names}; it must be left out."]


def announce(configurations: Iterable[Mapping[str, Any]]) -> None:
    """Print the size of what runs will leave, if it is large."""
    size = sum(RECORD_ON_DISK * c["solver"]["duration"] / c["record"]["interval"] for c in configurations)
    if size >= LARGE:
        tell(f"About {size / 1e6:.0f} MB will be left; a larger record.interval makes it less.", sys.stderr)


def _folder_faults(config: DictConfig) -> Iterator[str]:
    """Yield why the run cannot be written where it is to go."""
    below = Path(config.hydra.output_subdir or "")
    if below.is_absolute() or ".." in below.parts:
        yield f"hydra.output_subdir is '{below}'; it must be a folder below that of the run. Leave it out."
        return
    try:
        # For ${hydra:...} in its name.
        HydraConfig.instance().set_config(config)
        folder = str(OmegaConf.select(config, "hydra.run.dir"))
    except OmegaConfBaseException as error:
        yield f"hydra.run.dir cannot be resolved: {one_line(error)} Name a directory."
        return
    yield from refusals(Path(folder), "hydra.run.dir" if config.study.name == SIMULATE else "output")


def refusals(directory: Path, key: str) -> Iterator[str]:
    """Yield why nothing can be written into a directory, if so; everything is left as it was."""
    created: list[Path] = []
    try:
        created = [path for path in (directory, *directory.parents) if not path.exists()]
        directory.mkdir(parents=True, exist_ok=True)
        with TemporaryFile(dir=directory):
            pass
        # The netCDF library takes it for a separator, whatever the system says.
        if os.sep == "/" and "\\" in str(directory.absolute()):
            raise OSError(None, "netCDF files cannot lie in a path with a backslash")
    # A ValueError: a null character, or one that the locale cannot spell.
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        yield f"{key} is '{directory}' and cannot be written to ({reason}); it must be a writable directory."
    finally:
        for path in created:
            with suppress(OSError):
                path.rmdir()


def choices_of(hydra_config: HydraConf | DictConfig) -> dict[str, str | None]:
    """Return the options chosen from groups that are not Hydra's."""
    return {
        str(group): None if option is None else str(option)
        for group, option in sorted(hydra_config.runtime.choices.items())
        if not str(group).startswith("hydra/")
    }
