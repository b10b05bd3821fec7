"""One run from its setup to the files it leaves: run.nc, run.png and a summary on the terminal."""

import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile
from time import perf_counter
from typing import TYPE_CHECKING, final

from contactlab.cli import interrupts
from contactlab.cli.progress import progress
from contactlab.config import Setup
from contactlab.results.files import DATASET

if TYPE_CHECKING:
    from contactlab.trajectory import Ending

PICTURE = "run.png"

SET_ANOTHER = (
    "Set another one with hydra.run.dir=DIR, or with hydra.sweep.dir=DIR and "
    "hydra.sweep.subdir=NAME for -m."
)


@final
@dataclass(frozen=True)
class Outcome:
    """What a run left.

    Args:
        ending: how it ended.
        message: a sentence on that, empty for a complete one.
        digest: of its dataset.
        summary: for the terminal.
    """

    ending: "Ending"
    message: str
    digest: str
    summary: str


def execute(setup: Setup, directory: Path) -> Outcome:
    """Simulate a motor, write the dataset and the picture.

    Args:
        setup: what runs.
        directory: where run.nc and run.png go; files of these names from an earlier run are
            removed first, so that a run that is cut short leaves none that seems to be its own.

    Returns:
        How the run ended; one that is not complete is written too, and marked so.

    Raises:
        OSError: the directory is missing, not writable or full.
    """
    # Imported here: they bring the compiler with them, which a command that only has a fault to
    # report does not need.
    from contactlab.engine import simulate
    from contactlab.results import netcdf
    from contactlab.results.summary import summarise

    for name in (DATASET, PICTURE):
        (directory / name).unlink(missing_ok=True)
    started = perf_counter()
    with progress(setup.duration, "s", "The run") as show, interrupts.waiting() as look:

        def report(time: float) -> None:
            nonlocal started
            # The engine reports 0 once it is compiled; a compiler's time says nothing of a run's.
            started = perf_counter() if time == 0.0 else started
            show(time)
            look()

        trajectory = simulate(
            setup.motor,
            setup.law,
            duration=setup.duration,
            record_interval=setup.record_interval,
            contact_step=setup.contact_step,
            tolerance=setup.tolerance,
            progress=report,
        )
    wall_time = perf_counter() - started
    with interrupts.raising():
        tree = netcdf.to_datatree(trajectory, setup.configuration)
        digest = netcdf.write_tree(tree, directory / DATASET)
        beside = "."
        if setup.configuration["record"]["picture"]:
            # It brings the plotting.
            from contactlab.plot import overview

            overview.overview(tree, directory / PICTURE)
            beside = f" and {PICTURE} beside it."
    summary = f"{summarise(tree, wall_time)}\nWritten to {directory / DATASET}{beside}"
    return Outcome(trajectory.ending, trajectory.message, digest, summary)


def refusals(directory: Path, way_out: str = SET_ANOTHER) -> Iterator[str]:
    """Why a run cannot be written into a directory, if so; everything is left as it was."""
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
        yield (
            f"The output directory is '{directory}' and cannot be written to "
            f"({getattr(error, 'strerror', None) or error}); it must be a directory, or a place for one, "
            f"with write permission. {way_out}"
        )
    finally:
        for path in created:
            with suppress(OSError):
                path.rmdir()
