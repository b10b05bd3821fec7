"""What a sweep will do: which of its runs are complete already, and why the others run."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from contactlab.sweeps.job import (
    COMPLETE,
    FAILED,
    INTERRUPTED,
    REFUSED,
    RUNNING,
    UNBALANCED,
    is_done,
    read_state,
)

_WHY: Final = {
    "failed": ("failed", "failed"),
    "cut": ("was cut short", "were cut short"),
    "early": ("ended early", "ended early"),
    "open": ("has an open ledger", "have open ledgers"),
    "changed": ("is of another configuration or code", "are of another configuration or code"),
    "lost": ("has lost its dataset", "have lost their datasets"),
    "new": ("is new", "are new"),
}
"""Of one run and of several, in the order of the sentence."""


def outlook(jobs: Sequence[tuple[Path, str]]) -> tuple[list[bool], str]:
    """What is to be done of a sweep.

    Args:
        jobs: folder and key of every run.

    Returns:
        Whether each is complete already, and a sentence on all.
    """
    done = [is_done(folder, key) for folder, key in jobs]
    pending = [job for job, is_there in zip(jobs, done, strict=True) if not is_there]
    why = Counter(_why(folder, key) for folder, key in pending)
    runs = "1 run" if len(jobs) == 1 else f"{len(jobs)} runs"
    parts = [f"{why[name]} {words[why[name] > 1]}" for name, words in _WHY.items() if why[name]]
    if not pending:
        both = "it is complete and skipped" if len(jobs) == 1 else "all are complete and skipped"
        return done, f"{runs}: {both}."
    count = len(jobs) - len(pending)
    skipped = f"{count} {'is' if count == 1 else 'are'} complete and skipped; " if count else ""
    listed = " and ".join(filter(None, (", ".join(parts[:-1]), parts[-1])))
    return done, f"{runs}: {skipped}{listed}: {'this runs' if len(pending) == 1 else 'these run'}."


def _why(folder: Path, key: str) -> str:
    """Why a run that is not complete is not."""
    state = read_state(folder)
    if state is None:
        return "new"
    if state.state in (FAILED, REFUSED):
        return "failed"
    if state.state in (RUNNING, INTERRUPTED):
        return "cut"
    if state.job.key != key:
        return "changed"
    return {COMPLETE: "lost", UNBALANCED: "open"}.get(state.state, "early")
