"""A run in a folder: run.nc, run.png, state.json and, where it raised an exception, run.log.

The state is ABSENT when a sweep is planned, RUNNING before the run begins and its ending after its dataset is
whole, so that a run that was killed, or never began, is recognised. It has no times: the same run leaves the
same bytes. In a dataset it is a code.
"""

import json
import traceback
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from enum import IntEnum
from functools import cache
from hashlib import sha256
from math import isnan
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, final

from contactlab.checks import read_json
from contactlab.config import Setup
from contactlab.config.faults import failure_of
from contactlab.config.groups import resonator_class
from contactlab.foreign import digest_of_sources
from contactlab.laws.declaration import Declared
from contactlab.laws.registry import classes_in, classes_of, provenance
from contactlab.metrics import METRICS, Run, assess
from contactlab.progress import tell_progress
from contactlab.results.files import DATASET, LOG, STATE, digest_of_file, error_text, whole_file
from contactlab.results.netcdf import Groups, to_groups, write_groups
from contactlab.results.provenance import code_digest, digest_of, versions
from contactlab.trajectory import Trajectory


class Status(IntEnum):
    """Status of a run: a `contactlab.trajectory.Ending`, by its name, or why it has none."""

    COMPLETE = 0
    DIVERGED = 1
    CHATTERED = 2
    INTERRUPTED = 3
    FAILED = 4
    """It raised an exception, or could not be written."""
    UNFINISHED = 5
    """It began and has not ended: killed, or still running."""
    REFUSED = 6
    """Its configuration is faulty, though each of its values alone is not."""
    ABSENT = 7
    """It has not begun."""
    UNBALANCED = 8
    STALLED = 9
    INCONSISTENT = 10


ABSENT, RUNNING, COMPLETE, FAILED, REFUSED = "absent", "running", "complete", "failed", "refused"
INTERRUPTED = "interrupted"
"""States beside the other names of `contactlab.trajectory.Ending` in small letters."""

CHANGED, LOST = "of another configuration or code", "without its dataset"
"""Why a run that was complete runs again."""


@final
@dataclass(frozen=True)
class Job:
    """What a run is to do: its `key_of`, overrides as typed, options by group, numbers in SI.

    What is not known is empty, and so is the configuration where it is faulty.
    """

    key: str = ""
    overrides: tuple[str, ...] = ()
    choices: Mapping[str, str | None] = field(default_factory=dict)
    configuration: Mapping[str, Any] = field(default_factory=dict)


@final
@dataclass(frozen=True)
class State:
    """State of a run, the reason where it is not complete, and the digest of its dataset.

    The metrics are those of the dataset, by the code of a digest; one that is not applicable is left out.
    """

    state: str
    job: Job
    reason: str = ""
    digest: str = ""
    metrics: Mapping[str, float] = field(default_factory=dict)
    code: str = ""


def write_state(folder: Path, state: State) -> None:
    """Write the state of a run, whole or not at all; an OSError if it cannot be written."""
    with whole_file(folder / STATE) as partial:
        text = json.dumps(asdict(state), indent=1, sort_keys=True, ensure_ascii=False)
        partial.write_text(f"{text}\n", encoding="utf-8")


def read_state(folder: Path) -> State | None:
    """Return the state of a run; None where no file can be read as one."""
    try:
        return read_json((folder / STATE).read_bytes(), State)
    # Somebody else's file of that name may be anything.
    except (OSError, ValueError, RecursionError):
        return None


def key_of(setup: Setup) -> str:
    """Return the digest of all that a run's numbers depend on: configuration, version and code."""
    return _key(setup.configuration, code_of(*classes_of(setup.law), configuration=setup.configuration))


def is_of_other_code(job: Job) -> bool:
    """Return whether a run was made by other code than is installed, or by some that is not."""
    try:
        return _key(job.configuration, code_in(job.configuration)) != job.key
    # A configuration may be anything, and so may a law of another package.
    except Exception:
        return True


def _key(configuration: Mapping[str, Any], code: Sequence[str]) -> str:
    return sha256("\0".join((json.dumps(configuration, sort_keys=True), *code)).encode()).hexdigest()


def code_digest_of(configurations: Sequence[Mapping[str, Any]]) -> str:
    """Return the digest of the code that a sweep depends on: that of its laws, metrics and studies."""
    parts = [part for each in configurations for part in code_in(each)]
    package = Path(__file__).parents[1]
    parts += [digest_of(package / folder) for folder in ("metrics", "studies")]
    parts.append(_foreign_code(*(metric.measure for metric in METRICS.values())))
    return sha256("\0".join(parts).encode()).hexdigest()


def code_in(configuration: Mapping[str, Any]) -> tuple[str, ...]:
    """Return `code_of` the law and the resonator that a configuration chooses."""
    return code_of(*classes_in(configuration["law"]), configuration=configuration)


def code_of(*law: type[Declared], configuration: Mapping[str, Any] = MappingProxyType({})) -> tuple[str, ...]:
    """Return what identifies the code of a run: version, digests, and where its law and parts come from.

    The class of the resonator is that of the configuration; a motor made in Python has none there.
    """
    basis = configuration.get("resonator", {}).get("basis")
    resonator = () if basis is None else (resonator_class(basis),)
    foreign = _foreign_code(*law, *resonator)
    return (versions()["contactlab_version"], code_digest(), provenance(*law), foreign)


_foreign_code = cache(digest_of_sources)


def is_done(folder: Path, key: str) -> bool:
    """Return whether a folder has the complete run of a key, its dataset as the run left it."""
    return not why_to_run(folder, key)


def why_to_run(folder: Path, key: str) -> str:
    """Return why the run of a key is to run in a folder; empty where it is complete."""
    state = read_state(folder)
    if state is None or state.state in (ABSENT, FAILED, REFUSED, RUNNING, INTERRUPTED):
        return state.state if state else ABSENT
    if state.job.key != key:
        return CHANGED
    if state.state != COMPLETE:
        return state.state
    return "" if is_as_left(folder, state) else LOST


def is_as_left(folder: Path, state: State) -> bool:
    """Return whether the dataset of a run is the one of its state."""
    try:
        return digest_of_file(folder / DATASET) == state.digest
    except OSError:
        return False


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
            state = replace(state, code=code_digest())
            # Where metrics cannot be computed, `collect` says why.
            with suppress(Exception):
                values = assess(Run.of_trajectory(trajectory, setup.configuration))
                state = replace(state, metrics={key: x for key, x in values.items() if not isnan(x)})
        write_state(folder, state)
    except KeyboardInterrupt as interrupt:
        reason = str(interrupt) or "Interrupted before the end; no result was written."
        with suppress(OSError):
            write_state(folder, State(INTERRUPTED, job, reason))
        raise
    # A law of another package may end in any way, and the other runs of a sweep go on.
    except (Exception, SystemExit) as error:
        if isinstance(error, OSError):
            reason = f"The run could not be written: {error_text(error)}"
        else:
            reason = failure_of(error)
        state = State(FAILED, job, reason[:MOST_CHARACTERS])
        with suppress(OSError):
            write_state(folder, state)
        write_log(folder, error)
    return state, groups


def write_log(folder: Path, error: BaseException) -> None:
    """Write the traceback of an exception to `run.log`; a folder that cannot be written goes without."""
    with suppress(OSError), whole_file(folder / LOG) as partial:
        partial.write_text("".join(traceback.format_exception(error)), encoding="utf-8")
