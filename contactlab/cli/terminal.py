"""Exit statuses, output, Ctrl-C and the progress bar of the command.

Imports and the compiler may swallow a KeyboardInterrupt or crash on it. Therefore Ctrl-C ends the process at
once until a run has begun, waits for the next record while it is simulated, and is the usual exception, which
cleans up, while files are written.
"""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Final, NoReturn, TextIO

from tqdm import tqdm

COMPLETE, INCOMPLETE, REFUSED, INTERRUPTED = 0, 1, 2, 130
"""Exit statuses of the command: complete, incomplete or failed, refused for a fault, ended by Ctrl-C."""

MESSAGE: Final = "Interrupted before the end; no result was written."

BAR_AFTER: Final = 1.5
"""Time after which a progress bar appears [s]."""


class RefusalError(ValueError):
    """A command that cannot be carried out.

    Args:
        message: key or argument, its value and what is admitted.
        status: exit status; INCOMPLETE where the arguments have no fault, as on a full disk.
    """

    def __init__(self, message: str, status: int = REFUSED) -> None:
        super().__init__(message)
        self.status = status


def open_closed() -> None:
    """Open standard streams that the caller closed (`2>&-`): the next file would get their numbers."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open(mode, encoding="utf-8"))  # noqa: SIM115


def silence(stream: TextIO) -> None:
    """Redirect a stream to nowhere, so that Python's own last flush does not fail either."""
    with suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def tell(text: str, stream: TextIO) -> None:
    """Print a line at once; if that fails, nothing is printed from then on."""
    try:
        print(text, file=stream, flush=True)
    except OSError:
        silence(stream)


def refuse(faults: Iterable[str], status: int = REFUSED) -> int:
    """Print faults, a line each and each once, and return the exit status."""
    print(*dict.fromkeys(faults), sep="\n", file=sys.stderr)
    return status


@contextmanager
def _handled(handler: Callable[[int, FrameType | None], None]) -> Iterator[None]:
    """Handle Ctrl-C in this way, unless it is ignored, as in the background, or handled by a caller."""
    before = signal.getsignal(signal.SIGINT)
    main = threading.current_thread() is threading.main_thread()
    if not main or before is None or before is signal.SIG_IGN:
        yield
        return
    signal.signal(signal.SIGINT, handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _end(_number: int, _frame: FrameType | None) -> NoReturn:
    print(MESSAGE, file=sys.stderr, flush=True)
    sys.stdout.flush()
    os._exit(INTERRUPTED)


ending_at_once = partial(_handled, _end)
"""Context in which Ctrl-C ends the process with its status and a sentence."""

raising = partial(_handled, signal.default_int_handler)
"""Context in which Ctrl-C raises KeyboardInterrupt where it comes, as Python does by itself."""


@contextmanager
def waiting() -> Iterator[Callable[[], None]]:
    """Let Ctrl-C wait for the next check; before the first, and twice, it ends the process at once.

    Yields the check, which raises KeyboardInterrupt if Ctrl-C has come; the end of the context checks too.
    """
    checked = pending = False

    def handle(number: int, frame: FrameType | None) -> None:
        nonlocal pending
        if pending or not checked:
            _end(number, frame)
        pending = True

    def check() -> None:
        nonlocal checked, pending
        checked = True
        if pending:
            pending = False
            raise KeyboardInterrupt(MESSAGE)

    with _handled(handle):
        yield check
    check()


@contextmanager
def progress(total: float, unit: str) -> Iterator[Callable[[float], object]]:
    """Show a progress bar on a terminal; yields the function that receives what is done of the total."""
    left = "{percentage:3.0f} %|{bar}| {n:.6g} of {total:.6g} " + unit + ", {remaining} left"
    with tqdm(total=total, delay=BAR_AFTER, leave=False, bar_format=left, disable=None) as bar:
        yield lambda done: bar.update(done - bar.n)
