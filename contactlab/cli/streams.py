"""Output that nobody can read: closed, full or broken. What was computed must not suffer from it."""

import os
import sys
from contextlib import suppress
from typing import TextIO

_OWN = (("stdin", "r"), ("stdout", "w"), ("stderr", "w"))
"""Names and modes of what a process begins with, by the numbers of their descriptors."""


def open_closed() -> None:
    """Open what the caller has closed (`2>&-`), leading nowhere.

    Else the next file that is opened takes its number, and what any library prints goes into that file.
    """
    for number, (name, mode) in enumerate(_OWN):
        if getattr(sys, name) is not None:
            continue
        nowhere = os.open(os.devnull, os.O_RDWR)
        with suppress(OSError):
            # Whatever has the number by now keeps it.
            os.fstat(number)
            number = nowhere
        if number != nowhere:
            os.dup2(nowhere, number)
            os.close(nowhere)
        setattr(sys, name, os.fdopen(number, mode))


def tell(text: str, stream: TextIO) -> None:
    """Print a line at once; where that cannot be done, nothing is printed from then on."""
    try:
        print(text, file=stream, flush=True)
    except OSError:
        silence(stream)


def silence(stream: TextIO) -> None:
    """Lead a stream nowhere, so that Python's own last flush does not complain either."""
    with suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def flushed(status: int) -> int:
    """Flush the output at the end of a command; the exit status, 1 in place of 0 where that fails."""
    try:
        sys.stdout.flush()
    except OSError:
        silence(sys.stdout)
        return status or 1
    return status
