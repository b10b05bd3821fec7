"""What became of the runs of a map, for the terminal."""

from pathlib import Path
from typing import TYPE_CHECKING

from contactlab.sweeps.status import Status

if TYPE_CHECKING:
    import xarray


def summary(dataset: "xarray.Dataset", file: Path) -> str:
    """How many runs ended in which way, with the reason of one of each, and where all of them are."""
    status, reason = dataset["status"].values.ravel(), dataset["reason"].values.ravel()
    lines = []
    for code in Status:
        places = (status == code).nonzero()[0]
        if places.size:
            example = f" For example: {reason[places[0]]}" if reason[places[0]] else ""
            lines.append(f"{places.size} {code.name.lower()}.{example}")
    return "\n".join([*lines, f"Written to {file}"])
