"""The files of a run's folder, and whether its dataset is the one that the run left."""

import json
from pathlib import Path
from typing import Final

from contactlab.results.files import digest_of_file

STATE: Final = "state.json"
DATASET: Final = "run.nc"
LOG: Final = "run.log"
"""The log is there for a run that raised an exception."""


def told_digest(folder: Path) -> str:
    """The digest of the dataset that the run's state tells; empty where none does."""
    try:
        found = json.loads((folder / STATE).read_text(encoding="utf-8"))["digest"]
    # Somebody else's file of that name may be anything.
    except (OSError, ValueError, TypeError, LookupError):
        return ""
    return found if isinstance(found, str) else ""


def damage(dataset: Path) -> str:
    """Why a dataset is not the one that its run left; empty where it is, and where nothing tells.

    To be asked before the dataset is opened: the libraries take damaged numbers for numbers, and may hang.

    Args:
        dataset: the file, which exists.

    Returns:
        A sentence.

    Raises:
        OSError: it cannot be read.
    """
    told = told_digest(dataset.parent) if dataset.name == DATASET else ""
    if not told or told == digest_of_file(dataset):
        return ""
    return (
        f"'{dataset}' is not as its run left it, by the digest in {STATE} beside it; it is damaged or "
        f"was replaced. Run it again, or remove {STATE} if the change is yours."
    )
