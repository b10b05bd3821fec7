"""One job: from its setup to run.nc, run.png and a summary, its state, and a message where it fails."""

import os
import sys
import traceback
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from math import isnan
from pathlib import Path
from tempfile import TemporaryFile
from time import perf_counter
from typing import Final

from contactlab.cli import terminal
from contactlab.cli.terminal import tell
from contactlab.config import Setup
from contactlab.config.faults import one_line
from contactlab.laws import LawError
from contactlab.results import netcdf
from contactlab.results.files import DATASET, LOG, error_text, whole_file
from contactlab.results.provenance import code_digest
from contactlab.results.summary import summarise
from contactlab.studies.run_state import COMPLETE, FAILED, INTERRUPTED, RUNNING, Job, State, write_state

PICTURE: Final = "run.png"

MOST_CHARACTERS: Final = 500
"""Length of a reason in state.json; the log has all of it."""


def perform(setup: Setup, directory: Path, job: Job, *, swept: bool) -> bool:
    """Run a job, leave its dataset and its state in a directory, and return whether it is complete.

    What an earlier run left there is removed first. A run that is not complete has printed why; where it
    raised an exception of whatever kind, the traceback is in `run.log`.

    Raises:
        KeyboardInterrupt: with a sentence, after what there was has been written.
    """
    try:
        # A run that is cut short leaves no file that seems to be its own.
        for name in (LOG, DATASET, PICTURE):
            (directory / name).unlink(missing_ok=True)
        write_state(directory, State(RUNNING, job))
        left, summary = _simulated(setup, directory, job, swept)
        write_state(directory, left)
    except KeyboardInterrupt as interrupt:
        with suppress(OSError):
            write_state(directory, State(INTERRUPTED, job, str(interrupt) or terminal.MESSAGE))
        raise
    # A law of another package may end in any way, and the other jobs of a sweep go on.
    except (Exception, SystemExit) as error:
        reason = _reason(error)
        tell(reason, sys.stderr)
        with suppress(OSError):
            write_state(directory, State(FAILED, job, reason))
        write_log(directory / LOG, error)
        return False
    tell(summary, sys.stdout)
    if left.state == INTERRUPTED:
        raise KeyboardInterrupt(left.reason)
    if left.reason:
        tell(left.reason, sys.stderr)
    return left.state == COMPLETE


def _simulated(setup: Setup, directory: Path, job: Job, swept: bool) -> tuple[State, str]:
    """Simulate and write the files; return the state of the run, of a sweep with metrics, and its summary."""
    started = perf_counter()
    with terminal.progress(setup.duration, "s") as show, terminal.waiting() as check:

        def report(time: float) -> None:
            nonlocal started
            # The engine reports 0 once it is compiled; the compiler's time is not the run's.
            started = perf_counter() if time == 0.0 else started
            show(time)
            check()

        trajectory = setup.run(progress=report, keep_interrupted=True)
    wall_time = perf_counter() - started
    with terminal.raising():
        groups = netcdf.to_groups(trajectory, setup.configuration)
        digest = netcdf.write_groups(groups, directory / DATASET)
        beside = "."
        if setup.configuration["record"]["picture"]:
            # Imported here: it brings the plotting.
            from contactlab.plot import overview

            overview.overview(groups, directory / PICTURE)
            beside = f" and {PICTURE} beside it."
    summary = f"{summarise(groups, wall_time)}\nWritten to {directory / DATASET}{beside}"
    left = State(trajectory.ending.name.lower(), job, trajectory.message, digest)
    if swept and trajectory.ending.reached_end:
        # Imported here: a run by itself has none.
        from contactlab.metrics import assess

        # Runs are collected without their files being opened; why metrics cannot be computed, `collect` says.
        with suppress(Exception):
            values = assess(netcdf.to_datatree(trajectory, setup.configuration))
            numbers = {key: value for key, value in values.items() if not isnan(value)}
            left = replace(left, metrics=numbers, code=code_digest())
    return left, summary


def write_log(path: Path, error: BaseException) -> None:
    """Write a traceback to a file and print where it is; a folder that cannot be written goes without."""
    with suppress(OSError):
        with whole_file(path) as partial:
            partial.write_text("".join(traceback.format_exception(error)), encoding="utf-8")
        tell(f"The traceback is in {path}.", sys.stderr)


def _reason(error: BaseException) -> str:
    match error:
        case LawError():
            reason = one_line(LawError(*error.args))
        case OSError():
            reason = f"The run could not be written: {error_text(error)}"
        case _:
            reason = f"The run raised {type(error).__name__}: {one_line(error)}"
    return reason if len(reason) <= MOST_CHARACTERS else f"{reason[:MOST_CHARACTERS]} ..."


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
