"""What becomes of a run: a code that a dataset holds, and `state.json` in the run's folder.

The state is written as RUNNING before a run begins and with its end after its dataset is whole, so that a
run that was killed is known by it. It holds no times: the same run leaves the same bytes.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from enum import IntEnum
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, final

from contactlab.config import Setup
from contactlab.fingerprint import fingerprint, is_own
from contactlab.laws.registry import provenance
from contactlab.results.files import DATASET, STATE, digest_of_file, whole_file
from contactlab.results.provenance import code_digest, versions
from contactlab.trajectory import Ending


class Status(IntEnum):
    """Codes what became of a run; one that reached its end has numbers, a complete or an unbalanced one."""

    COMPLETE = 0
    DIVERGED = 1
    """Its state was no longer a motor's."""
    CHATTERED = 2
    """Its contact made no progress."""
    INTERRUPTED = 3
    """Somebody pressed Ctrl-C."""
    FAILED = 4
    """It raised an exception, or could not be written."""
    UNFINISHED = 5
    """It began and has not ended: killed, or still running."""
    REFUSED = 6
    """Its configuration is faulty, though each of its values alone is not."""
    ABSENT = 7
    """It has not begun."""
    UNBALANCED = 8
    """It reached its end, but its energy ledger is open."""
    STALLED = 9
    """Its law let it take no step, or too many."""
    INCONSISTENT = 10
    """Its law had no impulse for a contact that closes."""


def status_of(ending: Ending) -> Status:
    """Give the status of a run that ended in some way."""
    return Status[ending.name]


RUNNING, COMPLETE, FAILED, REFUSED = "running", "complete", "failed", "refused"
INTERRUPTED, UNBALANCED = "interrupted", "unbalanced"
"""States beside the other names of `contactlab.trajectory.Ending` in small letters."""


@final
@dataclass(frozen=True)
class Job:
    """Holds what a run was asked for.

    Args:
        key: of its configuration and the code, see `key_of`; empty where that is not known.
        overrides: of the configuration, as typed.
        choices: options by group, the value None for no option.
        configuration: nested, resolved, numbers in SI; empty where it is faulty.
    """

    key: str = ""
    overrides: tuple[str, ...] = ()
    choices: Mapping[str, str | None] = field(default_factory=dict)
    configuration: Mapping[str, Any] = field(default_factory=dict)


@final
@dataclass(frozen=True)
class State:
    """Holds what became of a run.

    Args:
        state: `RUNNING`, `COMPLETE`, ...
        job: what it was asked for.
        reason: a sentence where it is not complete.
        digest: of its dataset, so that one that is damaged or replaced is noticed; empty without.
    """

    state: str
    job: Job
    reason: str = ""
    digest: str = ""


def key_of(setup: Setup) -> str:
    """Give the digest of what a run's numbers depend on: configuration, version, code, whose law it is."""
    parts = (json.dumps(setup.configuration, sort_keys=True), *code_of(type(setup.law)))
    return sha256("\0".join(parts).encode()).hexdigest()


def code_of(law: type) -> tuple[str, ...]:
    """Give what tells the code that a run with a law depends on: version, digests, and whose law it is."""
    return (
        versions()["contactlab_version"],
        code_digest(),
        provenance(law),
        *_foreign_code(law),
    )


def write_state(folder: Path, state: State) -> None:
    """Write the state of a run, whole or not at all.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    text = json.dumps(asdict(state), indent=1, sort_keys=True, ensure_ascii=False)
    with whole_file(folder / STATE) as partial:
        partial.write_text(f"{text}\n", encoding="utf-8")


def read_state(folder: Path) -> State | None:
    """Read the state of a run; None where there is none that can be read."""
    try:
        read = json.loads((folder / STATE).read_text(encoding="utf-8"))
        job = read["job"]
        return State(
            str(read["state"]),
            job_of(job, str(job["key"])),
            str(read["reason"]),
            str(read["digest"]),
        )
    # Somebody else's file of that name may be anything.
    except (OSError, ValueError, TypeError, AttributeError, KeyError):
        return None


def job_of(read: Mapping[str, Any], key: str = "") -> Job:
    """Give a job as a file holds it, its configuration apart from others.

    Raises:
        ValueError, TypeError, LookupError: it is something else.
    """
    choices = {str(group): option and str(option) for group, option in read["choices"].items()}
    return Job(key, tuple(map(str, read["overrides"])), choices, dict(read["configuration"]))


def is_done(folder: Path, key: str) -> bool:
    """Tell whether a folder holds the complete run of a key, its dataset as the run left it."""
    state = read_state(folder)
    return (
        state is not None
        and state.state == COMPLETE
        and state.job.key == key
        and _is_sound(folder / DATASET, state.digest)
    )


def _is_sound(dataset: Path, digest: str) -> bool:
    try:
        return digest_of_file(dataset) == digest
    except OSError:
        return False


@cache
def _foreign_code(law: type) -> tuple[str, ...]:
    """Give the digests of what a law of another package is made of; `code_digest` covers our own."""
    if is_own(law):
        return ()
    found = fingerprint(law)
    return found.digest, found.sources()
