"""A terminal of a test's own, and what long computations tell of themselves."""

import os
import pty
import sys
from collections.abc import Callable
from contextlib import suppress
from time import sleep

from contactlab.progress import shown_by

LONG = 1.6
"""Time that an injected task takes [s]."""

BEGUN, ENDED = "<it begins>", "<it ends>"


def on_terminal(work: Callable[[], object]) -> str:
    """Return what a forked process writes to a terminal of its own."""
    written = []
    process, terminal_end = pty.fork()
    if process == 0:
        # pytest has replaced them.
        for number, name in enumerate(("stdin", "stdout", "stderr")):
            setattr(sys, name, os.fdopen(number, "w" if number else "r"))
        try:
            work()
        finally:
            sys.stderr.flush()
            os._exit(0)
    # Reading fails where the terminal has no other end any more.
    with suppress(OSError):
        while data := os.read(terminal_end, 65536):
            written.append(data)
    os.waitpid(process, 0)
    os.close(terminal_end)
    return b"".join(written).decode(errors="replace")


def slow(*_: object, **__: object) -> None:
    """Take long, and end what is done with it."""
    print(BEGUN, file=sys.stderr, flush=True)
    sleep(LONG)
    print(ENDED, file=sys.stderr, flush=True)
    raise ValueError("It ends here.")


def assert_terminal_is_written_to(work: Callable[[], object]) -> None:
    """A terminal is written to while `slow` takes the place of what works."""
    before, begun, during = on_terminal(work).partition(BEGUN)
    assert begun, before
    assert "so far" in during.partition(ENDED)[0]


def reports_of(work: Callable[[], object]) -> list[tuple[str, float]]:
    reports: list[tuple[str, float]] = []
    with shown_by(lambda what, share: reports.append((what, share))):
        work()
    return reports
