"""A run in a folder of its own: run.nc, run.png, state.json and, where it raised an exception, run.log."""

import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from math import isnan
from pathlib import Path
from typing import Final

from contactlab.config import Setup
from contactlab.config.faults import failure_of
from contactlab.progress import tell_progress
from contactlab.results.files import DATASET, LOG, error_text, whole_file
from contactlab.results.netcdf import Groups, to_groups, write_groups
from contactlab.results.provenance import code_digest
from contactlab.studies.run_state import FAILED, INTERRUPTED, RUNNING, Job, State, write_state
from contactlab.trajectory import Trajectory

PICTURE: Final = "run.png"

MOST_CHARACTERS: Final = 500
"""Length of a reason in state.json; the log has all of it."""


def simulated(setup: Setup) -> Trajectory:
    """Simulate a setup and report its progress."""
    return setup.run(progress=lambda time: tell_progress("", time / setup.duration), keep_interrupted=True)


def leave(
    setup: Setup,
    folder: Path,
    job: Job,
    simulate: Callable[[Setup], Trajectory] = simulated,
    *,
    with_metrics: bool = True,
) -> tuple[State, Groups]:
    """Run a setup, write its files into a folder, and return its state and the groups of its dataset.

    What an earlier run left there is removed first. A run that raises an exception of whatever kind has
    failed, and its traceback is in `run.log`.

    Args:
        setup: what runs.
        folder: where the files go; it exists.
        job: what the run is to do, for its state.
        simulate: runs the setup, and keeps what there is at an interrupt.
        with_metrics: whether the state has the metrics, by which runs are collected without their files.

    Raises:
        KeyboardInterrupt: after the state has been written.
    """
    groups: Groups = {}
    try:
        # A run that is cut short leaves no file that seems to be its own.
        for name in (LOG, DATASET, PICTURE):
            (folder / name).unlink(missing_ok=True)
        write_state(folder, State(RUNNING, job))
        trajectory = simulate(setup)
        groups = to_groups(trajectory, setup.configuration)
        digest = write_groups(groups, folder / DATASET)
        if setup.configuration["record"]["picture"]:
            # Imported here: it brings the plotting.
            from contactlab.plot import overview

            overview.overview(groups, folder / PICTURE)
        state = State(trajectory.ending.name.lower(), job, trajectory.message, digest)
        if with_metrics and trajectory.ending.reached_end:
            state = replace(state, metrics=_metrics_of(trajectory, setup), code=code_digest())
        write_state(folder, state)
    except KeyboardInterrupt as interrupt:
        reason = str(interrupt) or "Interrupted before the end; no result was written."
        state = State(INTERRUPTED, job, reason)
        with suppress(OSError):
            write_state(folder, state)
        raise
    # A law of another package may end in any way, and the other runs of a sweep go on.
    except (Exception, SystemExit) as error:
        text = f"The run could not be written: {error_text(error)}" if isinstance(error, OSError) else ""
        state = State(FAILED, job, (text or failure_of(error))[:MOST_CHARACTERS])
        with suppress(OSError):
            write_state(folder, state)
        write_log(folder, error)
    return state, groups


def _metrics_of(trajectory: Trajectory, setup: Setup) -> dict[str, float]:
    """Return the metrics that are applicable; none where they cannot be computed, `collect` says why."""
    # Imported here: a run by itself has none.
    from contactlab.metrics import Run, assess

    with suppress(Exception):
        values = assess(Run.of_trajectory(trajectory, setup.configuration))
        return {key: value for key, value in values.items() if not isnan(value)}
    return {}


def write_log(folder: Path, error: BaseException) -> None:
    """Write the traceback of an exception to `run.log`; a folder that cannot be written goes without."""
    with suppress(OSError), whole_file(folder / LOG) as partial:
        partial.write_text("".join(traceback.format_exception(error)), encoding="utf-8")
