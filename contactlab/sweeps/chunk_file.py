"""The file of a finished chunk: its arrays as NumPy keeps them, and a digest of them at the end.

NumPy reads it as any .npz. One that a digest does not end or does not fit is damaged.
"""

import errno
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any, Final

import numpy as np

from contactlab.results.files import whole_file
from contactlab.sweeps.faults import ChunkGoneError, MapError
from contactlab.sweeps.many import Answers

_DIGEST: Final = sha256().digest_size
_GONE: Final = (errno.ENOENT, errno.ESTALE)
"""How a file that another machine has removed is told of."""


def write_chunk(file: Path, found: Answers) -> None:
    """Write a chunk, whole or not at all; the same answers give the same bytes.

    Raises:
        OSError: the folder is missing, not writable or full.
    """
    arrays: dict[str, Any] = {
        "metrics": found.metrics,
        "status": found.status,
        "reason": np.array(found.reason, dtype=np.str_),
        "time": found.time,
    }
    arrays |= {f"series_{name}": rows for name, rows in found.series.items()}
    stream = BytesIO()
    np.savez(stream, **arrays)
    stream.write(sha256(stream.getbuffer()).digest())
    with whole_file(file) as partial:
        partial.write_bytes(stream.getbuffer())


def read_chunk(file: Path) -> Answers:
    """The answers of a chunk.

    Raises:
        ChunkGoneError: it is not there.
        MapError: it is damaged.
    """
    try:
        kept = file.read_bytes()
        if sha256(memoryview(kept)[:-_DIGEST]).digest() != kept[-_DIGEST:]:
            raise ValueError("its digest is another")
        with np.load(BytesIO(kept), allow_pickle=False) as read:
            prefix = "series_"
            return Answers(
                metrics=read["metrics"],
                status=read["status"],
                reason=read["reason"].tolist(),
                series={
                    name.removeprefix(prefix): read[name]
                    for name in read.files
                    if name.startswith(prefix)
                },
                time=read["time"],
            )
    except (OSError, ValueError, KeyError) as error:
        if isinstance(error, OSError) and error.errno in _GONE:
            raise ChunkGoneError from error
        raise MapError(
            f"'{file}' is damaged ({error}); it must be as it was written. Remove it and give the "
            "same command again: its runs are made anew."
        ) from error
