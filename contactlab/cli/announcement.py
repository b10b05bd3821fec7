"""What large datasets are said of before they are made."""

import sys
from collections.abc import Iterable, Mapping
from typing import Any

from contactlab.config.rules import BYTES_A_RECORD

IN_FILE = 60
"""Bytes of a record in run.nc, compressed; runs of all laws and intervals took 52 to 80."""

WORTH_SAYING = 100e6
"""Bytes on disk that one wants to know of beforehand."""


def announce(configurations: Iterable[Mapping[str, Any]]) -> None:
    """Say how much runs will leave, if it is much.

    Args:
        configurations: what runs, resolved.
    """
    records = [c["solver"]["duration"] / c["record"]["interval"] for c in configurations]
    size = IN_FILE * sum(records)
    if size < WORTH_SAYING:
        return
    runs = "The run leaves" if len(records) == 1 else f"The {len(records)} runs leave"
    print(
        f"{runs} about {_spelled(size)}: {sum(records):.3g} records of {IN_FILE} bytes. The "
        f"longest takes {_spelled(BYTES_A_RECORD * max(records))} of memory meanwhile. A larger "
        "record.interval makes both smaller and does not change the motion.",
        file=sys.stderr,
        flush=True,
    )


def announce_series(runs: int, names: int, configuration: Mapping[str, Any]) -> None:
    """Say how much the series of a map will take, if it is much.

    Args:
        runs: of the map.
        names: how many series are kept.
        configuration: of one run, resolved.
    """
    records = configuration["solver"]["duration"] / configuration["record"]["interval"]
    size = 8.0 * runs * names * records
    if size >= WORTH_SAYING:
        print(
            f"The series take up to {_spelled(size)}: {runs} runs of {records:.3g} records. A larger "
            "record.interval or fewer names for --series make it less.",
            file=sys.stderr,
            flush=True,
        )


def _spelled(size: float) -> str:
    return f"{size / 1e9:.2g} GB" if size >= 1e9 else f"{size / 1e6:.0f} MB"
