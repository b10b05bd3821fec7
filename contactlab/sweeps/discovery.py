"""The runs below a folder: what each was asked for and what became of it, one dataset open at a time."""

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final

from contactlab.config.faults import one_line
from contactlab.metrics import assess, is_complete, read_run
from contactlab.results.files import DATASET, STATE, remove_left
from contactlab.results.netcdf import configuration_of
from contactlab.sweeps.dataset import REASONS
from contactlab.sweeps.state import (
    MANIFEST,
    RUNNING,
    Job,
    Status,
    read_manifest,
    read_state,
    status_of,
)
from contactlab.trajectory import Ending

_OF_STATE: Final = {status.name.lower(): status for status in Status} | {RUNNING: Status.UNFINISHED}

_WITH_NUMBERS: Final = {status_of(ending) for ending in Ending if ending.reached_end}


@final
@dataclass(frozen=True)
class FoundRun:
    """Tells what became of a run.

    Args:
        name: its folder, seen from the folder that is collected.
        folder: where it lies.
        job: what it was asked for; None where nothing but its dataset tells of it.
        status, reason: what became of it.
        configuration: nested, resolved, numbers in SI; empty where it is not known.
        metrics: by key, empty where it did not reach its end.
    """

    name: str
    folder: Path
    job: Job | None
    status: Status
    reason: str
    configuration: dict[str, Any]
    metrics: dict[str, float]


def discovered(directory: Path) -> Iterator[FoundRun]:
    """Find every run below a folder, the folder itself included; each is read when it is asked for."""
    listed: dict[Path, Job] = {}
    folders: set[Path] = set()
    for place, below, files in os.walk(directory):
        below[:] = [name for name in below if not name.startswith(".")]
        remove_left(Path(place))
        if DATASET in files or STATE in files:
            folders.add(Path(place))
        if MANIFEST in files:
            jobs = read_manifest(Path(place)).jobs
            listed |= {Path(place) / name: job for name, job in jobs.items()}
    names = {folder.relative_to(directory).as_posix(): folder for folder in {*folders, *listed}}
    for name in sorted(names, key=_in_order):
        yield _found(name, names[name], listed.get(names[name]), names[name] in folders)


def _found(name: str, folder: Path, listed: Job | None, begun: bool) -> FoundRun:
    """Take a run that says itself what became of it, or of which there is a dataset alone."""
    state = read_state(folder) if begun else None
    job = state.job if state else listed
    configuration, metrics = dict(job.configuration) if job else {}, dict[str, float]()
    status = _OF_STATE.get(state.state, Status.FAILED) if state else Status.COMPLETE
    reason = (state and state.reason) or REASONS.get(status, f"The run is {state and state.state}.")
    if not begun:
        status, reason = Status.ABSENT, REASONS[Status.ABSENT]
    elif state is None and not (folder / DATASET).is_file():
        status = Status.FAILED
        reason = f"{STATE} cannot be read, and there is no {DATASET}. Run it again."
    elif status in _WITH_NUMBERS:
        told, status, reason, metrics = _assessed(folder)
        configuration = configuration if job else told
    return FoundRun(name, folder, job, status, reason, configuration, metrics)


def _assessed(folder: Path) -> tuple[dict[str, Any], Status, str, dict[str, float]]:
    """Read what the dataset of a run tells: its configuration, its status with the reason, its metrics."""
    configuration: dict[str, Any] = {}
    try:
        tree = read_run(folder / DATASET)
        configuration = configuration_of(tree)
        if is_complete(tree):
            return configuration, Status.COMPLETE, "", assess(tree)
        status = _OF_STATE.get(str(tree.attrs.get("ending", "")), Status.FAILED)
        status = Status.FAILED if status is Status.COMPLETE else status
        reason = str(tree.attrs.get("message", "")) or "The dataset says that it is not complete."
        return configuration, status, reason, assess(tree) if status in _WITH_NUMBERS else {}
    # A file can be anything, and the other runs shall not suffer from it.
    except Exception as error:
        return configuration, Status.FAILED, one_line(error), {}


def _in_order(name: str) -> list[tuple[int, str]]:
    """Sort 10_... after 9_..."""
    words = re.split(r"(\d+)", name)
    return [(int(word), "") if word.isdigit() else (-1, word) for word in words]
