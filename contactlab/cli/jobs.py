"""One run of the command: its progress, its summary and a message where it fails; and folders to write to."""

import os
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryFile
from time import perf_counter

from contactlab.cli import terminal
from contactlab.cli.terminal import tell
from contactlab.config import Setup
from contactlab.results.files import DATASET, LOG, error_text
from contactlab.results.summary import summarise
from contactlab.studies.run_folder import PICTURE, leave
from contactlab.studies.run_state import COMPLETE, INTERRUPTED, Job
from contactlab.trajectory import Trajectory


def perform(setup: Setup, directory: Path, job: Job, *, swept: bool) -> bool:
    """Run a job, leave its files in a directory, print what became of it, and return whether it is complete.

    Raises:
        KeyboardInterrupt: with a sentence, after what there was has been written.
    """
    started = perf_counter()

    def simulate(setup: Setup) -> Trajectory:
        with terminal.progress(setup.duration, "s") as show, terminal.waiting() as check:

            def report(time: float) -> None:
                nonlocal started
                # The engine reports 0 once it is compiled; the compiler's time is not the run's.
                started = perf_counter() if time == 0.0 else started
                show(time)
                check()

            trajectory = setup.run(progress=report, keep_interrupted=True)
        ended.append(perf_counter())
        return trajectory

    ended: list[float] = []
    with terminal.raising():
        state, groups = leave(setup, directory, job, simulate, with_metrics=swept)
    if state.digest:
        beside = f" and {PICTURE} beside it." if setup.configuration["record"]["picture"] else "."
        tell(f"{summarise(groups, ended[0] - started)}\nWritten to {directory / DATASET}{beside}", sys.stdout)
    if state.state == INTERRUPTED:
        raise KeyboardInterrupt(state.reason)
    if state.reason:
        tell(state.reason, sys.stderr)
    if (directory / LOG).exists():
        tell(f"The traceback is in {directory / LOG}.", sys.stderr)
    return state.state == COMPLETE


def refusals(directory: Path, key: str = "output") -> Iterator[str]:
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


def unwritable(folder: Path, error: OSError) -> terminal.RefusalError:
    """Return the failure of a folder that could not be written to the end, as on a full disk."""
    return terminal.RefusalError(
        f"Nothing more can be written to '{folder}': {error_text(error)}", terminal.INCOMPLETE
    )
