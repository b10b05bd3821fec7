"""Ctrl-C, kept away from code that does not stand an exception at any place.

Imports and the compiler may swallow a KeyboardInterrupt, pass it on as another error or crash. So
until a run has something to lose Ctrl-C ends the process at once, while it simulates Ctrl-C waits
for the next look, and while files are written it is the usual exception, which cleans up.
"""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

STATUS = 130
"""Exit status of an interrupted command."""

MESSAGE = "Interrupted before the run was written."

_Handler = Callable[[int, FrameType | None], None]


@contextmanager
def ending_at_once() -> Iterator[None]:
    """Let Ctrl-C end the process with `STATUS` and a sentence."""
    with _handled(_end):
        yield


@contextmanager
def waiting() -> Iterator[Callable[[], None]]:
    """Let Ctrl-C wait for the next look; before the first, and twice, it ends the process at once.

    Yields:
        The look, which raises KeyboardInterrupt if Ctrl-C has come.

    Raises:
        KeyboardInterrupt: at the end, if Ctrl-C has come after the last look.
    """
    looked = pending = False

    def handle(number: int, frame: FrameType | None) -> None:
        nonlocal pending
        if pending or not looked:
            _end(number, frame)
        pending = True

    def look() -> None:
        nonlocal looked, pending
        looked = True
        if pending:
            pending = False
            raise KeyboardInterrupt(MESSAGE)

    with _handled(handle):
        yield look
    if pending:
        raise KeyboardInterrupt(MESSAGE)


@contextmanager
def raising() -> Iterator[None]:
    """Let Ctrl-C raise KeyboardInterrupt where it comes, as Python does by itself."""
    with _handled(signal.default_int_handler):
        yield


def _end(_number: int, _frame: FrameType | None) -> NoReturn:
    print(MESSAGE, file=sys.stderr, flush=True)
    sys.stdout.flush()
    os._exit(STATUS)


@contextmanager
def _handled(handler: _Handler) -> Iterator[None]:
    """Handle Ctrl-C in this way, unless it is ignored, as in the background, or is not ours."""
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
