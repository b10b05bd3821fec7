"""One job: from its setup to run.nc, run.png and a summary, a state and a sentence where it fails."""

import os
import sys
import traceback
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryFile
from time import perf_counter

from contactlab.cli import terminal
from contactlab.cli.terminal import tell
from contactlab.config import Setup
from contactlab.config.faults import one_line
from contactlab.laws import LawError
from contactlab.results import netcdf
from contactlab.results.files import DATASET, LOG, told, whole_file
from contactlab.results.summary import summarise
from contactlab.sweeps.state import COMPLETE, FAILED, INTERRUPTED, RUNNING, Job, State, write_state

PICTURE = "run.png"

SET_ANOTHER = (
    "Set another one with hydra.run.dir=DIR, or with hydra.sweep.dir=DIR and hydra.sweep.subdir=NAME for -m."
)

_MOST_CHARACTERS = 500
"""Of a reason; a compiler says more than anybody reads in a table, and the log has it all."""


def perform(setup: Setup, directory: Path, job: Job) -> bool:
    """Run a job, leave its dataset and its state in a directory, and tell whether it is complete.

    What an earlier run left there is removed first. Where it is not complete, a sentence has said why; where
    it raised an exception of whatever kind, the traceback is in `run.log`.

    Raises:
        KeyboardInterrupt: with a sentence, after what there was has been written.
    """
    try:
        # A run that is cut short leaves no file that seems to be its own.
        for name in (LOG, DATASET, PICTURE):
            (directory / name).unlink(missing_ok=True)
        write_state(directory, State(RUNNING, job))
        left, summary = _execute(setup, directory, job)
        write_state(directory, left)
    except KeyboardInterrupt as interrupt:
        reason = str(interrupt) or terminal.MESSAGE
        with suppress(OSError):
            write_state(directory, State(INTERRUPTED, job, reason))
        raise
    # A law of another package may end in any way, and the other jobs of a sweep go on.
    except (Exception, SystemExit) as error:
        reason = _reason(error)
        tell(reason, sys.stderr)
        with suppress(OSError):
            write_state(directory, State(FAILED, job, reason))
        write_log(directory / LOG, error)
        return False
    # Only now: what cannot be printed is no fault of the run.
    tell(summary, sys.stdout)
    if left.state == INTERRUPTED:
        raise KeyboardInterrupt(left.reason)
    if left.reason:
        tell(left.reason, sys.stderr)
    return left.state == COMPLETE


def _execute(setup: Setup, directory: Path, job: Job) -> tuple[State, str]:
    """Simulate and write the files; give the state of the run and its summary for the terminal."""
    started = perf_counter()
    with terminal.progress(setup.duration, "s", "The run") as show, terminal.waiting() as look:

        def report(time: float) -> None:
            nonlocal started
            # The engine reports 0 once it is compiled; a compiler's time says nothing of a run's.
            started = perf_counter() if time == 0.0 else started
            show(time)
            look()

        trajectory = setup.run(progress=report)
    wall_time = perf_counter() - started
    with terminal.raising():
        tree = netcdf.to_datatree(trajectory, setup.configuration)
        digest = netcdf.write_tree(tree, directory / DATASET)
        beside = "."
        if setup.configuration["record"]["picture"]:
            # Imported here: it brings the plotting.
            from contactlab.plot import overview

            overview.overview(tree, directory / PICTURE)
            beside = f" and {PICTURE} beside it."
    summary = f"{summarise(tree, wall_time)}\nWritten to {directory / DATASET}{beside}"
    return State(trajectory.ending.name.lower(), job, trajectory.message, digest), summary


def write_log(path: Path, error: BaseException) -> None:
    """Write a traceback to a file and say where it is; a folder that takes none goes without."""
    with suppress(OSError):
        with whole_file(path) as partial:
            partial.write_text("".join(traceback.format_exception(error)), encoding="utf-8")
        tell(f"The traceback is in {path}.", sys.stderr)


def _reason(error: BaseException) -> str:
    match error:
        case LawError():
            said = one_line(LawError(*error.args))
        case OSError():
            said = f"The run could not be written: {told(error)}"
        case _:
            said = f"The run raised {type(error).__name__}: {one_line(error)}"
    return said if len(said) <= _MOST_CHARACTERS else f"{said[:_MOST_CHARACTERS]} ..."


def refusals(directory: Path, way_out: str = SET_ANOTHER) -> Iterator[str]:
    """Say why nothing can be written into a directory, if so; everything is left as it was."""
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


def check_output(folder: Path) -> None:
    """Refuse the folder of a verb where nothing can be written into it, by a RefusalError."""
    for fault in refusals(folder, "Choose another one by --output DIR."):
        raise terminal.RefusalError(fault)


def unwritable(folder: Path, error: OSError) -> terminal.RefusalError:
    """Give the failure of a folder that took no more, as of a run whose files cannot be written."""
    words = f"Nothing more can be written to '{folder}': {told(error)}"
    return terminal.RefusalError(words, terminal.INCOMPLETE)
