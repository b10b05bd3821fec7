"""The runs below a folder: what each was asked for and what became of it, one dataset open at a time."""

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Final, final

from contactlab.config.faults import one_line
from contactlab.metrics import assess, configuration_of, is_complete, read_run
from contactlab.results.files import DATASET, STATE, remove_left
from contactlab.sweeps.dataset import REASONS
from contactlab.sweeps.manifest import MANIFEST, read_manifest
from contactlab.sweeps.state import RUNNING, Job, State, Status, read_state, status_of
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
        job: what it was asked for; without overrides where nothing but its dataset tells of it.
        status, reason: what became of it.
        told: whether overrides and choices are known.
        metrics: by key, empty where it did not reach its end.
    """

    name: str
    folder: Path
    job: Job
    status: Status
    reason: str
    told: bool
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
            jobs = read_manifest(Path(place))
            listed |= {Path(place) / name: job for name, job in jobs.items()}
    for folder in sorted(folders | listed.keys(), key=partial(_in_order, directory)):
        name = folder.relative_to(directory).as_posix()
        if folder not in folders:
            reason = REASONS[Status.ABSENT]
            yield FoundRun(name, folder, listed[folder], Status.ABSENT, reason, True, {})
        elif (state := read_state(folder)) is not None:
            yield _of_state(name, folder, state)
        else:
            yield _of_dataset(name, folder, listed.get(folder))


def _of_state(name: str, folder: Path, state: State) -> FoundRun:
    """Take a run that says itself what became of it."""
    status = _OF_STATE.get(state.state, Status.FAILED)
    reason = state.reason or REASONS.get(status, f"The run is {state.state}.")
    metrics: dict[str, float] = {}
    if status in _WITH_NUMBERS:
        _, status, reason, metrics = _assessed(folder)
    return FoundRun(name, folder, state.job, status, reason, True, metrics)


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


def _of_dataset(name: str, folder: Path, job: Job | None) -> FoundRun:
    """Take a run of which there is a dataset alone."""
    told = job is not None
    job = job or Job()
    if not (folder / DATASET).is_file():
        reason = f"{STATE} cannot be read, and there is no {DATASET}. Run it again."
        return FoundRun(name, folder, job, Status.FAILED, reason, told, {})
    configuration, status, reason, metrics = _assessed(folder)
    job = job if told else Job(configuration=configuration)
    return FoundRun(name, folder, job, status, reason, told, metrics)


def _in_order(directory: Path, folder: Path) -> list[tuple[int, str]]:
    """Sort 10_... after 9_..."""
    words = re.split(r"(\d+)", folder.relative_to(directory).as_posix())
    return [(int(word), "") if word.isdigit() else (-1, word) for word in words]
