"""What a run's folder says of the run: `state.json`, which tells a complete run from one to be done again.

Written as RUNNING before a run begins and with its end after its dataset is whole, so that a run that
was killed is known by its state. It holds no times: the same run leaves the same bytes.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, final

from contactlab.config import Setup
from contactlab.laws.registry import provenance
from contactlab.results.files import DATASET, STATE, digest_of_file, whole_file
from contactlab.results.provenance import code_digest, versions

RUNNING, COMPLETE, FAILED, REFUSED = "running", "complete", "failed", "refused"
INTERRUPTED, UNBALANCED = "interrupted", "unbalanced"
"""States beside the other names of `contactlab.trajectory.Ending` in small letters."""


@final
@dataclass(frozen=True)
class Job:
    """What a run was asked for.

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
    """What became of a run.

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
    """Digest of all that a run's numbers depend on: configuration, version, code, and whose law it is.

    Returns:
        64 hexadecimal digits.
    """
    parts = (json.dumps(setup.configuration, sort_keys=True), *code_of(type(setup.law)))
    return sha256("\0".join(parts).encode()).hexdigest()


def code_of(law: type) -> tuple[str, ...]:
    """What tells the code that a run with a law depends on: version, digests, and whose law it is."""
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
    """The state of a run; None where there is none that can be read."""
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
    """A job as a file holds it, its configuration apart from others.

    Raises:
        ValueError, TypeError, LookupError: it is something else.
    """
    choices = {str(group): option and str(option) for group, option in read["choices"].items()}
    return Job(key, tuple(map(str, read["overrides"])), choices, dict(read["configuration"]))


def is_done(folder: Path, key: str) -> bool:
    """Whether a folder holds the complete run of a key, its dataset as the run left it."""
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
    """Digests of all that a law of another package is made of; `code_digest` covers one of this package."""
    # Imported here: it brings the libraries of numbers, which --help does not need.
    from contactlab.fingerprint import fingerprint, is_own

    if is_own(law):
        return ()
    found = fingerprint(law)
    return found.digest, found.sources()
