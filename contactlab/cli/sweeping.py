"""A sweep by Hydra's launchers: what is complete is skipped, and all that is there is collected.

Hydra's own sweeper composes every job twice more and hands all of them to the launcher, so that a cluster
would be asked for a node to find a run complete. Here the jobs are known and sound, see
`contactlab.cli.composition`, and the launcher is given those that are to run.
"""

import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from hydra._internal.callbacks import Callbacks
from hydra._internal.hydra import Hydra
from hydra.core.plugins import Plugins
from hydra.core.utils import JobReturn
from hydra.errors import HydraException
from hydra.types import HydraContext, RunMode, TaskFunction
from omegaconf import DictConfig, OmegaConf

from contactlab.cli import interrupts
from contactlab.cli.announcement import announce
from contactlab.cli.composition import Plan
from contactlab.cli.directories import quoted
from contactlab.cli.jobs import write_log
from contactlab.config.faults import one_line
from contactlab.results.files import LOG, told
from contactlab.sweeps.outlook import outlook
from contactlab.sweeps.roster import extend_roster

STOPPED = 1
"""Exit status of a sweep whose launcher failed."""


def sweep(
    application: Hydra, name: str, lines: Sequence[str], task: TaskFunction, plan: Plan
) -> int:
    """Run the jobs of a sweep that are not complete, and collect all of them.

    Args:
        application: Hydra's.
        name: of the primary configuration.
        lines: the overrides as typed.
        task: what runs a job; gives its exit status.
        plan: what the overrides ask for.

    Returns:
        The largest exit status of the jobs.

    Raises:
        OSError: the folder of the sweep cannot be written to.
    """
    overrides = [*lines, "hydra.mode=MULTIRUN"]
    if plan.directory:
        overrides.append(f"hydra.sweep.dir={quoted(plan.directory)}")
    config = application.compose_config(
        config_name=name,
        overrides=overrides,
        run_mode=RunMode.MULTIRUN,
        with_log_configuration=True,
    )
    directory = Path(str(config.hydra.sweep.dir))
    try:
        if plan.jobs:
            status = _status(_launched(application, config, name, task, plan, directory))
        else:
            status = _status(application.multirun(name, task, overrides))
    except HydraException:
        raise
    # A worker that is killed, a cluster that takes no jobs: the launchers raise what they like.
    except Exception as error:
        print(
            f"The sweep stopped: {type(error).__name__}: {one_line(error)} What is complete stays, "
            "and the same command goes on from there.",
            file=sys.stderr,
        )
        with suppress(OSError):
            directory.mkdir(parents=True, exist_ok=True)
            write_log(directory / LOG, error)
        status = STOPPED
    _collect(directory)
    return status


def _launched(
    application: Hydra,
    config: DictConfig,
    name: str,
    task: TaskFunction,
    plan: Plan,
    directory: Path,
) -> Iterator[Sequence[JobReturn]]:
    """What the launcher returns for each batch of jobs: `BasicSweeper.sweep` without what is done."""
    done, sentence = outlook([(job.folder, job.job.key) for job in plan.jobs])
    print(sentence, flush=True)
    directory.mkdir(parents=True, exist_ok=True)
    below = {job.folder: job.job for job in plan.jobs if directory in job.folder.parents}
    extend_roster(
        directory, {path.relative_to(directory).as_posix(): job for path, job in below.items()}
    )
    # The numbers that the launcher gives must be those that the folders are named by.
    pending = [
        job.lines for job, there in zip(plan.jobs, done, strict=True) if plan.numbered or not there
    ]
    if all(done):
        return
    announce(job.job.configuration for job, there in zip(plan.jobs, done, strict=True) if not there)
    OmegaConf.save(config, directory / "multirun.yaml")
    callbacks = Callbacks(config)
    callbacks.on_multirun_start(config=config, config_name=name)
    launcher = Plugins.instance().instantiate_launcher(
        hydra_context=HydraContext(application.config_loader, callbacks),
        task_function=task,
        config=config,
    )
    size = config.hydra.sweeper.get("max_batch_size") or len(pending)
    for first in range(0, len(pending), size):
        batch = pending[first : first + size]
        yield launcher.launch([list(lines) for lines in batch], initial_job_idx=first)
    callbacks.on_multirun_end(config=config, config_name=name)


def _collect(directory: Path) -> None:
    """Collect what is there; a failure of that is told and is none of the sweep."""
    from contactlab.cli.collect import report
    from contactlab.sweeps.collecting import COLLECTED, collect
    from contactlab.sweeps.faults import CollectingError

    try:
        with interrupts.raising():
            print(report(collect(directory), directory / COLLECTED))
    except CollectingError as error:
        print(f"The runs could not be collected: {error}", file=sys.stderr)
    except OSError as error:
        print(f"The runs could not be collected: {told(error)}", file=sys.stderr)


def _status(returned: Any) -> int:
    """The largest exit status of the jobs; a sweeper that gives back something else has none."""
    if isinstance(returned, JobReturn):
        return int(returned.return_value)
    if isinstance(returned, list | tuple | Iterator):
        return max(map(_status, returned), default=0)
    return 0
