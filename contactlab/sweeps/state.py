"""What becomes of runs: a code in a dataset, `state.json` in a run's folder, `sweep.json` in a sweep's.

The state is written as RUNNING before a run begins and with its end after its dataset is whole, so that a
run that was killed is known by it. It holds no times: the same run leaves the same bytes. The manifest of a
sweep is written before the first job begins, so that one that never began is known when the runs are
collected. What all jobs share stands there once. A sweep that is extended keeps the jobs it had.
"""

import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from enum import IntEnum
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, Final, TypeVar, final

from pydantic import TypeAdapter

from contactlab.config import Setup
from contactlab.config.nesting import flat, nested
from contactlab.fingerprint import Fingerprint, is_own
from contactlab.laws.registry import provenance
from contactlab.results.files import DATASET, STATE, digest_of_file, whole_file
from contactlab.results.provenance import code_digest, versions
from contactlab.trajectory import Ending

MANIFEST: Final = "sweep.json"
"""Of a sweep that keeps metrics it is the plan."""

Held = TypeVar("Held")

_adapter: Final[Callable[[type], TypeAdapter[Any]]] = cache(TypeAdapter)
"""Gives what reads a class from JSON."""


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


@final
@dataclass(frozen=True)
class Manifest:
    """Lists the jobs of a sweep of folders.

    Args:
        keep: 'runs', 'samples', which form no grid, or 'metrics', of which a plan tells instead.
        common: the part of the configuration that all jobs share, by full key.
        jobs: by the names of their folders; in the file with the rest of the configuration, by full key.
    """

    keep: str = "runs"
    common: Mapping[str, Any] = field(default_factory=dict)
    jobs: Mapping[str, Job] = field(default_factory=dict)


_WHY: Final = {
    "failed": ("failed", "failed"),
    "cut": ("was cut short", "were cut short"),
    "early": ("ended early", "ended early"),
    "open": ("has an open ledger", "have open ledgers"),
    "changed": ("is of another configuration or code", "are of another configuration or code"),
    "lost": ("has lost its dataset", "have lost their datasets"),
    "new": ("is new", "are new"),
}
"""Why one run, and several, that are not complete are not, in the order of the sentence."""


def key_of(setup: Setup) -> str:
    """Give the digest of what a run's numbers depend on: configuration, version, code, whose law it is."""
    parts = (json.dumps(setup.configuration, sort_keys=True), *code_of(type(setup.law)))
    return sha256("\0".join(parts).encode()).hexdigest()


def code_of(law: type) -> tuple[str, ...]:
    """Give what tells the code that a run with a law depends on: version, digests, and whose law it is."""
    return (versions()["contactlab_version"], code_digest(), provenance(law), *_foreign_code(law))


@cache
def _foreign_code(law: type) -> tuple[str, ...]:
    """Give the digests of what a law of another package is made of; `code_digest` covers our own."""
    if is_own(law):
        return ()
    found = Fingerprint(law)
    return found.digest, found.sources()


def write_state(folder: Path, state: State) -> None:
    """Write the state of a run, whole or not at all."""
    _write(folder / STATE, asdict(state))


def read_state(folder: Path) -> State | None:
    """Read the state of a run; None where there is none that can be read."""
    return _read(State, folder / STATE)


def extend_manifest(folder: Path, jobs: Mapping[str, Job], samples: bool) -> None:
    """Add jobs, by the names of their folders, to a sweep's manifest, or put them in the place of others.

    Samples are the rows of a table, which form no grid.
    """
    merged = {**read_manifest(folder).jobs, **jobs}
    settings = {name: flat(job.configuration) for name, job in merged.items()}
    common = common_of([*settings.values()])
    jobs_listed = {
        name: replace(
            job, configuration={k: v for k, v in settings[name].items() if k not in common}
        )
        for name, job in merged.items()
    }
    manifest = Manifest("samples" if samples else "runs", common, jobs_listed)
    _write(folder / MANIFEST, asdict(manifest))


def read_manifest(folder: Path) -> Manifest:
    """Read the manifest of a sweep, jobs with their whole configurations; an empty one where it cannot be."""
    read = _read(Manifest, folder / MANIFEST) or Manifest()
    whole = {
        name: replace(job, configuration=nested({**read.common, **job.configuration}))
        for name, job in read.jobs.items()
    }
    return replace(read, jobs=whole)


def common_of(settings: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Give the keys that have one value in all settings."""
    first = settings[0] if settings else {}
    return {
        key: value
        for key, value in first.items()
        if all(key in other and other[key] == value for other in settings)
    }


def is_done(folder: Path, key: str) -> bool:
    """Tell whether a folder holds the complete run of a key, its dataset as the run left it."""
    state = read_state(folder)
    if state is None or (state.state, state.job.key) != (COMPLETE, key):
        return False
    try:
        return digest_of_file(folder / DATASET) == state.digest
    except OSError:
        return False


def resume(jobs: Sequence[tuple[Path, str]]) -> tuple[list[bool], str]:
    """Tell which jobs, each folder and key, are complete already, and say in a sentence what runs and why."""
    done = [is_done(folder, key) for folder, key in jobs]
    why = Counter(_why(*job) for job, is_there in zip(jobs, done, strict=True) if not is_there)
    return done, sentence(len(jobs), why)


def sentence(total: int, why: Mapping[str, int]) -> str:
    """Say how many of all runs are complete, and how many run for which reason."""
    runs, pending = "1 run" if total == 1 else f"{total} runs", sum(why.values())
    if not pending:
        return f"{runs}: {'it is' if total == 1 else 'all are'} complete and skipped."
    parts = [f"{why[name]} {said[why[name] > 1]}" for name, said in _WHY.items() if why.get(name)]
    count = total - pending
    skipped = f"{count} {'is' if count == 1 else 'are'} complete and skipped; " if count else ""
    listed = " and ".join(filter(None, (", ".join(parts[:-1]), parts[-1])))
    return f"{runs}: {skipped}{listed}: {'this runs' if pending == 1 else 'these run'}."


def _why(folder: Path, key: str) -> str:
    """Tell why a run that is not complete is not."""
    if (state := read_state(folder)) is None:
        return "new"
    if state.state in (FAILED, REFUSED):
        return "failed"
    if state.state in (RUNNING, INTERRUPTED):
        return "cut"
    if state.job.key != key:
        return "changed"
    return {COMPLETE: "lost", UNBALANCED: "open"}.get(state.state, "early")


def _write(file: Path, content: Mapping[str, Any]) -> None:
    """Write JSON, whole or not at all; an OSError says why it cannot be."""
    text = json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False)
    with whole_file(file) as partial:
        partial.write_text(f"{text}\n", encoding="utf-8")


def _read(kind: type[Held], file: Path) -> Held | None:
    """Read what `_write` wrote; None for somebody else's file of that name, which may be anything."""
    try:
        found: Held = _adapter(kind).validate_json(file.read_bytes())
        return found
    except (OSError, ValueError):
        return None
