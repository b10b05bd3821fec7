"""What some runs gave, in memory and as the file of a finished chunk.

NumPy reads the file as any .npz. One that a digest does not end or does not fit is damaged.
"""

import errno
from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.results.files import whole_file
from contactlab.sweeps.values import SweepError

_GONE: Final = (errno.ENOENT, errno.ESTALE)
"""How a file that another machine has removed is told of."""


class ChunkGoneError(Exception):
    """A chunk that was there is there no more: another process has merged it, or somebody removed it."""


@final
@dataclass(frozen=True)
class Answers:
    """Holds what some runs gave.

    Args:
        metrics: shape (run, metric); NaN where there is no number.
        status: codes of `Status`, shape (run,).
        reason: why a run is not complete, empty where it is; an unbalanced one has its numbers all the same.
        series: by name, shape (run, record); NaN where a run has none.
        time: of the records of the series [s].
    """

    metrics: Array
    status: NDArray[np.int8]
    reason: list[str]
    series: dict[str, Array]
    time: Array


def joined(parts: Sequence[Answers]) -> Answers:
    """Give the answers of all pieces, one after the other."""
    return Answers(
        metrics=np.concatenate([part.metrics for part in parts]),
        status=np.concatenate([part.status for part in parts]),
        reason=[reason for part in parts for reason in part.reason],
        series={
            name: stacked([row for part in parts for row in part.series[name]])
            for name in parts[0].series
        },
        time=max((part.time for part in parts), key=len),
    )


def stacked(rows: Sequence[Array]) -> Array:
    """Give series as the rows of one array; those that are shorter end in NaN."""
    stacked = np.full((len(rows), max(map(len, rows))), np.nan)
    for place, row in zip(stacked, rows, strict=True):
        place[: row.size] = row
    return stacked


def write_chunk(file: Path, answers: Answers) -> None:
    """Write a chunk, whole or not at all; the same answers give the same bytes.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    arrays: dict[str, Any] = {
        "metrics": answers.metrics,
        "status": answers.status,
        "reason": np.array(answers.reason, dtype=np.str_),
        "time": answers.time,
        **{f"series_{name}": rows for name, rows in answers.series.items()},
    }
    stream = BytesIO()
    np.savez(stream, **arrays)
    stream.write(sha256(stream.getbuffer()).digest())
    with whole_file(file) as partial:
        partial.write_bytes(stream.getbuffer())


def read_chunk(file: Path) -> Answers:
    """Read the answers of a chunk.

    Raises:
        ChunkGoneError: it is not there.
        SweepError: it is damaged.
    """
    try:
        kept, size = file.read_bytes(), sha256().digest_size
        if sha256(memoryview(kept)[:-size]).digest() != kept[-size:]:
            raise ValueError("its digest is another")
        with np.load(BytesIO(kept), allow_pickle=False) as read:
            series = [name for name in read.files if name.startswith("series_")]
            return Answers(
                metrics=read["metrics"],
                status=read["status"],
                reason=read["reason"].tolist(),
                series={name.removeprefix("series_"): read[name] for name in series},
                time=read["time"],
            )
    except (OSError, ValueError, KeyError) as error:
        if isinstance(error, OSError) and error.errno in _GONE:
            raise ChunkGoneError from error
        raise SweepError(
            f"'{file}' is damaged ({error}); it must be as it was written. Remove it and give the "
            "same command again: its runs are made anew."
        ) from error
