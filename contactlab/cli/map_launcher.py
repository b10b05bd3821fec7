"""Chunks of a map by one of Hydra's launchers: processes of one machine, or tasks of a cluster.

Every chunk is a job: with the launcher of a cluster all of them together are one array of tasks.
"""

import os
import platform
import sys
from collections.abc import Sequence
from pathlib import Path

from hydra._internal.callbacks import Callbacks
from hydra._internal.core_plugins.basic_launcher import BasicLauncher
from hydra._internal.hydra import Hydra
from hydra.core.plugins import Plugins
from hydra.types import HydraContext, RunMode
from omegaconf import DictConfig

from contactlab.cli.application import CONFIG_NAME
from contactlab.cli.directories import quoted
from contactlab.config.faults import ConfigurationError, one_line
from contactlab.sweeps.chunks import CHUNKS, MapFolder
from contactlab.sweeps.faults import MapError
from contactlab.sweeps.plan import code_digest_of
from contactlab.sweeps.workers import processors

BASIC = f"{BasicLauncher.__module__}.{BasicLauncher.__qualname__}"


def launcher_config(application: Hydra, lines: Sequence[str], folder: Path) -> DictConfig | None:
    """The configuration of a launcher that the arguments ask for; None where they ask for none.

    Raises:
        ConfigurationError: what they say of Hydra cannot be composed.
    """
    given = [line for line in lines if line.lstrip("+~").startswith("hydra")]
    own = [
        "hydra.mode=MULTIRUN",
        f"hydra.sweep.dir={quoted(str((folder / CHUNKS).absolute()))}",
        "hydra.sweep.subdir=log/${hydra.job.num}",
        "hydra.output_subdir=null",
    ]
    try:
        config = application.config_loader.load_configuration(
            config_name=CONFIG_NAME,
            overrides=[*given, *own],
            run_mode=RunMode.MULTIRUN,
            from_shell=True,
        )
    # Besides its own exceptions Hydra lets those of YAML and others through.
    except Exception as error:
        raise ConfigurationError([one_line(error)]) from error
    return None if config.hydra.launcher.get("_target_", BASIC) == BASIC else config


def launch(
    application: Hydra,
    config: DictConfig,
    folder: MapFolder,
    chunks: Sequence[int],
    workers: int | None,
) -> None:
    """Run chunks by a launcher; those that fail are missing afterwards, and it is told why."""
    launcher = Plugins.instance().instantiate_launcher(
        hydra_context=HydraContext(application.config_loader, Callbacks(config)),
        task_function=run_chunk,
        config=config,
    )
    where = quoted(str(folder.path.absolute()))
    jobs = [
        [f"+map.folder={where}", f"+map.chunk={chunk}", f"+map.workers={workers or 0}"]
        for chunk in chunks
    ]
    try:
        for returned in launcher.launch(jobs, initial_job_idx=0):
            # The exception of a job that failed is raised by looking at it.
            _ = returned.return_value
    # A worker that is killed, a cluster that takes no jobs: the launchers raise what they like.
    except Exception as error:
        print(
            f"The map stopped: {type(error).__name__}: {one_line(error)} What is finished stays, and "
            "the same command goes on from there.",
            file=sys.stderr,
        )


def run_chunk(settings: DictConfig) -> None:
    """The task of one job; launchers import it from here.

    Raises:
        MapError: this machine has other code than the map was begun with.
    """
    asked = settings.map
    folder = MapFolder.opened(Path(asked.folder))
    if code_digest_of(folder.plan.bases) != folder.plan.code:
        raise MapError(
            f"The map in '{folder.path}' was begun by other code than {platform.node()} has; both must be "
            "the same, laws of other packages included. Install one version everywhere."
        )
    # The processes of a launcher share a machine, unless a cluster gives each some processors.
    workers = asked.workers or int(os.environ.get("SLURM_CPUS_PER_TASK", "1"))
    with folder.pool(min(workers, processors())) as pool:
        folder.run(asked.chunk, pool)
