"""One job with what becomes of it: its state in its folder, and a sentence where it fails."""

import sys
import traceback
from contextlib import suppress
from pathlib import Path

from contactlab.cli import interrupts
from contactlab.cli.runner import execute
from contactlab.cli.streams import tell
from contactlab.config import Setup
from contactlab.config.faults import one_line
from contactlab.laws import LawError
from contactlab.results.files import LOG, told
from contactlab.sweeps.job import COMPLETE, FAILED, INTERRUPTED, RUNNING, Job, State, write_state

_MOST_CHARACTERS = 500
"""Of a reason; a compiler says more than anybody reads in a table, and the log has it all."""


def perform(setup: Setup, directory: Path, job: Job) -> bool:
    """Run a job and leave its dataset and its state.

    Args:
        setup: what runs.
        directory: where all of it goes; what an earlier run left there is removed first.
        job: what is asked for.

    Returns:
        Whether the run is complete. Where it is not, a sentence has said why; where it raised an
        exception of whatever kind, the traceback is in `run.log`.

    Raises:
        KeyboardInterrupt: with a sentence, after what there was has been written.
    """
    try:
        (directory / LOG).unlink(missing_ok=True)
        write_state(directory, State(RUNNING, job))
        outcome = execute(setup, directory)
        state = outcome.ending.name.lower()
        write_state(directory, State(state, job, outcome.message, outcome.digest))
    except KeyboardInterrupt as interrupt:
        reason = str(interrupt) or interrupts.MESSAGE
        with suppress(OSError):
            write_state(directory, State(INTERRUPTED, job, reason))
        raise
    # A law of another package may end in any way, and the other jobs of a sweep go on.
    except (Exception, SystemExit) as error:
        reason = _reason(error)
        tell(reason, sys.stderr)
        with suppress(OSError):
            write_state(directory, State(FAILED, job, reason))
        with suppress(OSError):
            write_log(directory / LOG, error)
        return False
    # Only now: what cannot be printed is no fault of the run.
    tell(outcome.summary, sys.stdout)
    if state == INTERRUPTED:
        raise KeyboardInterrupt(outcome.message)
    if outcome.message:
        tell(outcome.message, sys.stderr)
    return state == COMPLETE


def write_log(path: Path, error: BaseException) -> None:
    """Write a traceback to a file and say where it is.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    path.write_text("".join(traceback.format_exception(error)), encoding="utf-8")
    tell(f"The traceback is in {path}.", sys.stderr)


def _reason(error: BaseException) -> str:
    if isinstance(error, LawError):
        said = one_line(LawError(*error.args))
    elif isinstance(error, OSError):
        said = f"The run could not be written: {told(error)}"
    else:
        said = f"The run raised {type(error).__name__}: {one_line(error)}"
    return said if len(said) <= _MOST_CHARACTERS else f"{said[:_MOST_CHARACTERS]} ..."
