"""Which jobs a sweep has: `sweep.json` in its folder, written before the first of them begins.

So a job that never began is known when the runs are collected. What all jobs share stands there once.
A sweep that is extended keeps the jobs it had.
"""

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Final

from contactlab.config.nesting import flat, nested
from contactlab.results.files import whole_file
from contactlab.sweeps.job import Job, job_of

ROSTER: Final = "sweep.json"


def extend_roster(folder: Path, jobs: Mapping[str, Job]) -> None:
    """Add jobs to a sweep's list, or put them in the place of those of the same folder.

    Args:
        folder: of the sweep.
        jobs: by the names of their folders in it.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    merged = read_roster(folder) | dict(jobs)
    settings = {name: flat(job.configuration) for name, job in merged.items()}
    common = _common(settings.values())
    listed = {
        name: {
            "overrides": job.overrides,
            "choices": job.choices,
            "configuration": {
                key: value for key, value in settings[name].items() if key not in common
            },
        }
        for name, job in merged.items()
    }
    text = json.dumps({"common": common, "jobs": listed}, indent=1, ensure_ascii=False)
    with whole_file(folder / ROSTER) as partial:
        partial.write_text(f"{text}\n", encoding="utf-8")


def read_roster(folder: Path) -> dict[str, Job]:
    """The jobs of a sweep by the names of their folders; none where no list can be read."""
    try:
        read = json.loads((folder / ROSTER).read_text(encoding="utf-8"))
        return {
            str(name): job_of(
                job | {"configuration": nested(read["common"] | job["configuration"])}
            )
            for name, job in read["jobs"].items()
        }
    # Somebody else's file of that name may be anything.
    except (OSError, ValueError, TypeError, AttributeError, KeyError):
        return {}


def _common(settings: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """The keys that have one value in all of them."""
    every = list(settings)
    first = every[0] if every else {}
    return {
        key: value
        for key, value in first.items()
        if all(key in other and other[key] == value for other in every)
    }
