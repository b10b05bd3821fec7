"""One run from its setup to the files it leaves: run.nc, run.png and a summary on the terminal."""

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile
from time import perf_counter
from typing import TYPE_CHECKING

from contactlab.command import interrupts
from contactlab.config import Setup
from contactlab.sweep.job import DATASET

if TYPE_CHECKING:
    from contactlab.trajectory import Ending

PICTURE = "run.png"

SET_ANOTHER = (
    "Set another one with hydra.run.dir=DIR, or with hydra.sweep.dir=DIR and "
    "hydra.sweep.subdir=NAME for -m."
)

PROGRESS_AFTER = 1.5
"""Seconds before a progress bar appears; most runs are over by then."""


def execute(setup: Setup, directory: Path) -> "tuple[Ending, str]":
    """Simulate a motor, write the dataset and the picture, print a summary.

    Args:
        setup: what runs.
        directory: where run.nc and run.png go; files of these names from an earlier run are
            removed first, so that a run that is cut short leaves none that seems to be its own.

    Returns:
        How the run ended, and a sentence on it, empty for a complete one; any other is written too,
        marked as incomplete.

    Raises:
        KeyboardInterrupt: with a sentence, after what there was has been written.
        OSError: the directory is missing, not writable or full.
    """
    # Imported here: they bring the compiler and the plotting with them, which a command that only
    # has a fault to report does not need.
    from contactlab.engine import simulate
    from contactlab.output import dataset, figures
    from contactlab.output.summary import summarise
    from contactlab.trajectory import Ending

    for name in (DATASET, PICTURE):
        (directory / name).unlink(missing_ok=True)
    started = perf_counter()
    with _progress_bar(setup.duration) as show, interrupts.waiting() as look:

        def progress(time: float) -> None:
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
            progress=progress,
        )
    wall_time = perf_counter() - started
    with interrupts.raising():
        tree = dataset.write(trajectory, setup.configuration, directory / DATASET)
        beside = "."
        if setup.configuration["record"]["picture"]:
            figures.overview(tree, directory / PICTURE)
            beside = f" and {PICTURE} beside it."
    print(summarise(trajectory, wall_time))
    print(f"Written to {directory / DATASET}{beside}", flush=True)
    if trajectory.ending is Ending.INTERRUPTED:
        raise KeyboardInterrupt(trajectory.message)
    if not trajectory.complete:
        print(trajectory.message, file=sys.stderr)
    return trajectory.ending, trajectory.message


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
    except OSError as error:
        yield (
            f"The output directory is '{directory}' and cannot be written to "
            f"({error.strerror or error}); it must be a directory, or a place for one, with write "
            f"permission. {way_out}"
        )
    finally:
        for path in created:
            with suppress(OSError):
                path.rmdir()


@contextmanager
def _progress_bar(duration: float) -> Iterator[Callable[[float], None]]:
    """A bar over the simulated time [s] on a terminal, nothing elsewhere."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from tqdm import tqdm

    with tqdm(
        total=duration,
        delay=PROGRESS_AFTER,
        leave=False,
        file=sys.stderr,
        bar_format="{percentage:3.0f} %|{bar}| {n:.3g} of {total:.3g} s, {remaining} left",
    ) as bar:

        def advance(time: float) -> None:
            bar.update(time - bar.n)

        yield advance
