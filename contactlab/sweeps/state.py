"""What becomes of a run: a code in a dataset, `state.json` in its folder.

The state is written as ABSENT when a sweep is planned, as RUNNING before the run begins and with its end
after its dataset is whole, so that a run that was killed, or never began, is known by it. It holds no times:
the same run leaves the same bytes.
"""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from enum import IntEnum
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, Final, final

from pydantic import TypeAdapter

from contactlab import metrics
from contactlab.config import Setup
from contactlab.config.groups import NO_NUMBERS
from contactlab.foreign import digest_of_sources
from contactlab.laws.declaration import Declared
from contactlab.laws.registry import classes_in, classes_of, provenance
from contactlab.results.files import DATASET, STATE, digest_of_file, whole_file
from contactlab.results.provenance import code_digest, digest_of, versions
from contactlab.trajectory import Ending


class Status(IntEnum):
    """Codes what became of a run: an `Ending`, by its name, or why it has none."""

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


def status_of(ending: Ending) -> Status:
    """Give the status of a run that ended in some way."""
    return Status[ending.name]


ABSENT, RUNNING, COMPLETE, FAILED, REFUSED = "absent", "running", "complete", "failed", "refused"
INTERRUPTED, UNBALANCED = "interrupted", "unbalanced"
"""States beside the other names of `contactlab.trajectory.Ending` in small letters."""


@final
@dataclass(frozen=True)
class Job:
    """Holds what a run was asked for: its `key_of`, overrides as typed, options by group, numbers in SI.

    What is not known is empty, and so is the configuration where it is faulty.
    """

    key: str = ""
    overrides: tuple[str, ...] = ()
    choices: Mapping[str, str | None] = field(default_factory=dict)
    configuration: Mapping[str, Any] = field(default_factory=dict)


@final
@dataclass(frozen=True)
class State:
    """Holds what became of a run, with a reason where it is not complete.

    The digest of its dataset tells one that is damaged or was replaced.
    """

    state: str
    job: Job
    reason: str = ""
    digest: str = ""


_adapter: Final = TypeAdapter(State)

_WHY: Final = {
    FAILED: ("failed", "failed"),
    RUNNING: ("was cut short", "were cut short"),
    "early": ("ended early", "ended early"),
    UNBALANCED: ("has an open ledger", "have open ledgers"),
    "changed": ("is of another configuration or code", "are of another configuration or code"),
    COMPLETE: ("has lost its dataset", "have lost their datasets"),
    ABSENT: ("is new", "are new"),
}
"""Why one run, and several, that are to run are, in the order of the sentence."""


def write_state(folder: Path, state: State) -> None:
    """Write the state of a run, whole or not at all; an OSError says why it cannot be."""
    with whole_file(folder / STATE) as partial:
        text = json.dumps(asdict(state), indent=1, sort_keys=True, ensure_ascii=False)
        partial.write_text(f"{text}\n", encoding="utf-8")


def read_state(folder: Path) -> State | None:
    """Read the state of a run; None where there is none that can be read, as somebody else's file."""
    try:
        return _adapter.validate_json((folder / STATE).read_bytes())
    except (OSError, ValueError):
        return None


def key_of(setup: Setup) -> str:
    """Give the digest of what a run's numbers depend on: configuration, version, code, whose law it is."""
    numbers = {group: keys for group, keys in setup.configuration.items() if group not in NO_NUMBERS}
    parts = (json.dumps(numbers, sort_keys=True), *_code_of(*classes_of(setup.law)))
    return sha256("\0".join(parts).encode()).hexdigest()


def code_digest_of(configurations: Sequence[Mapping[str, Any]]) -> str:
    """Give the digest of the code that a sweep's numbers depend on: that of its laws, metrics and sweeps."""
    parts = [part for one in configurations for part in _code_of(*classes_in(one["law"]))]
    # Of what a single run does not depend on.
    parts += [digest_of(Path(file).parent) for file in (str(metrics.__file__), __file__)]
    return sha256("\0".join(parts).encode()).hexdigest()


def _code_of(*law: type[Declared]) -> tuple[str, ...]:
    """Return what identifies the code of a run: version, digests, and where its law and parts come from."""
    return (versions()["contactlab_version"], code_digest(), provenance(*law), _foreign_code(*law))


_foreign_code = cache(digest_of_sources)


def is_done(folder: Path, key: str) -> bool:
    """Tell whether a folder holds the complete run of a key, its dataset as the run left it."""
    return not _why(folder, key)


def resume(jobs: Sequence[tuple[Path, str]]) -> tuple[list[bool], str]:
    """Tell which jobs, each folder and key, are to run, and say in a sentence how many and why."""
    why = [_why(*job) for job in jobs]
    return [*map(bool, why)], sentence(len(jobs), Counter(filter(None, why)))


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
    """Tell why the run of a key is to run in a folder, by a key of `_WHY`; empty where it is complete."""
    state = read_state(folder)
    name = state.state if state else ABSENT
    name = {REFUSED: FAILED, INTERRUPTED: RUNNING}.get(name, name)
    if state is None or name in (ABSENT, FAILED, RUNNING):
        return name
    if state.job.key != key:
        return "changed"
    try:
        whole = name == COMPLETE and digest_of_file(folder / DATASET) == state.digest
    except OSError:
        whole = False
    return "" if whole else name if name in _WHY else "early"
