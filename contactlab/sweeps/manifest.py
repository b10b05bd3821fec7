"""Which jobs a sweep of folders has, and what is left to do of them.

The list is `sweep.json` in the sweep's folder, written before the first job begins, so that one that never
began is known when the runs are collected. What all jobs share stands there once. A sweep that is extended
keeps the jobs it had.
"""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from contactlab.config.nesting import flat, nested
from contactlab.results.files import whole_file
from contactlab.sweeps.state import (
    COMPLETE,
    FAILED,
    INTERRUPTED,
    REFUSED,
    RUNNING,
    UNBALANCED,
    Job,
    is_done,
    job_of,
    read_state,
)

MANIFEST: Final = "sweep.json"
"""Of a sweep that keeps metrics it is the plan."""

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


def extend_manifest(folder: Path, jobs: Mapping[str, Job], samples: bool) -> None:
    """Add jobs to a sweep's list, or put them in the place of those of the same folder.

    Args:
        folder: of the sweep.
        jobs: by the names of their folders in it.
        samples: whether they are the rows of a table, which form no grid.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    merged = read_manifest(folder) | dict(jobs)
    settings = {name: flat(job.configuration) for name, job in merged.items()}
    common = common_of(list(settings.values()))
    jobs_listed = {
        name: {
            "overrides": job.overrides,
            "choices": job.choices,
            "configuration": {k: v for k, v in settings[name].items() if k not in common},
        }
        for name, job in merged.items()
    }
    manifest = {"keep": "samples" if samples else "runs", "common": common, "jobs": jobs_listed}
    with whole_file(folder / MANIFEST) as partial:
        partial.write_text(f"{json.dumps(manifest, indent=1, ensure_ascii=False)}\n", "utf-8")


def read_manifest(folder: Path) -> dict[str, Job]:
    """Read the jobs of a sweep by the names of their folders; none where no list can be read."""
    try:
        read = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
        return {
            str(name): job_of(
                job | {"configuration": nested(read["common"] | job["configuration"])}
            )
            for name, job in read["jobs"].items()
        }
    # Somebody else's file of that name may be anything.
    except (OSError, ValueError, TypeError, AttributeError, KeyError):
        return {}


def kept(folder: Path) -> str:
    """Tell what the sweep of a folder keeps: 'runs', 'samples', which form no grid, or 'metrics'."""
    try:
        return str(json.loads((folder / MANIFEST).read_text(encoding="utf-8"))["keep"])
    except (OSError, ValueError, TypeError, KeyError):
        return "runs"


def common_of(settings: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Give the keys that have one value in all settings."""
    first = settings[0] if settings else {}
    return {
        key: value
        for key, value in first.items()
        if all(key in other and other[key] == value for other in settings)
    }


def resume(jobs: Sequence[tuple[Path, str]]) -> tuple[list[bool], str]:
    """Tell what is to be done of a sweep.

    Args:
        jobs: folder and key of every run.

    Returns:
        Whether each is complete already, and a sentence on all.
    """
    done = [is_done(folder, key) for folder, key in jobs]
    why = Counter(_why(*job) for job, is_there in zip(jobs, done, strict=True) if not is_there)
    return done, sentence(len(jobs), why)


def sentence(total: int, why: Mapping[str, int]) -> str:
    """Say how many runs are complete, and why the others run.

    Args:
        total: all of them.
        why: how many run for which reason.
    """
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
