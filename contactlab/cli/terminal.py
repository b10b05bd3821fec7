"""The command and whoever called it: closed streams, Ctrl-C, and how far something long has come.

What was computed must not suffer from output that nobody can read. And imports and the compiler may
swallow a KeyboardInterrupt, pass it on as another error or crash: so until a run has something to lose
Ctrl-C ends the process at once, while it simulates Ctrl-C waits for the next look, and while files are
written it is the usual exception, which cleans up.
"""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from time import perf_counter
from types import FrameType
from typing import NoReturn, TextIO

from tqdm import tqdm

COMPLETE, INCOMPLETE, REFUSED, INTERRUPTED = 0, 1, 2, 130
"""Exit statuses of the command: done; not done, or not so as it should be; a fault of the user's; Ctrl-C."""

MESSAGE = "Interrupted before the end; no result was written."

BAR_AFTER = 1.5
"""Seconds before a bar appears; most runs are over by then."""

LOOK_AFTER = 5.0
"""Seconds of work from which the time that is left is estimated."""

WORTH_SAYING = 60.0
"""Seconds that must be left for a sentence."""


class RefusalError(ValueError):
    """What was asked for cannot be done; the message is a sentence.

    Args:
        message: the sentence.
        status: of the command; INCOMPLETE where nothing was wrong with what was asked for, as on a full disk.
    """

    def __init__(self, message: str, status: int = REFUSED) -> None:
        super().__init__(message)
        self.status = status


def open_closed() -> None:
    """Open what the caller has closed (`2>&-`), leading nowhere.

    Else the next file that is opened takes its number, and what any library prints goes into that file.
    """
    for number, (name, mode) in enumerate((("stdin", "r"), ("stdout", "w"), ("stderr", "w"))):
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


def silence(stream: TextIO) -> None:
    """Lead a stream nowhere, so that Python's own last flush does not complain either."""
    with suppress(OSError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def tell(text: str, stream: TextIO) -> None:
    """Print a line at once; where that cannot be done, nothing is printed from then on."""
    try:
        print(text, file=stream, flush=True)
    except OSError:
        silence(stream)


def refuse(faults: Iterable[str], status: int = REFUSED) -> int:
    """Print the faults, a line each and each once, and give the exit status."""
    print(*dict.fromkeys(faults), sep="\n", file=sys.stderr)
    return status


@contextmanager
def _handled(handler: Callable[[int, FrameType | None], None]) -> Iterator[None]:
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


def _end(_number: int, _frame: FrameType | None) -> NoReturn:
    print(MESSAGE, file=sys.stderr, flush=True)
    sys.stdout.flush()
    os._exit(INTERRUPTED)


ending_at_once = partial(_handled, _end)
"""Lets Ctrl-C end the process with its status and a sentence."""

raising = partial(_handled, signal.default_int_handler)
"""Lets Ctrl-C raise KeyboardInterrupt where it comes, as Python does by itself."""


@contextmanager
def waiting() -> Iterator[Callable[[], None]]:
    """Let Ctrl-C wait for the next look; before the first, and twice, it ends the process at once.

    Yields the look, which raises KeyboardInterrupt if Ctrl-C has come; the end of the context looks too.
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
    look()


@contextmanager
def progress(total: float, unit: str, what: str) -> Iterator[Callable[[float], None]]:
    """Show how far something has come: a bar on a terminal, elsewhere a sentence where it takes long.

    Args:
        total: all of it.
        unit: of the total.
        what: is being done, the subject of a sentence.

    Yields:
        The function to tell what is done of the total so far.
    """
    if sys.stderr.isatty():
        left = "{percentage:3.0f} %|{bar}| {n:.6g} of {total:.6g} " + unit + ", {remaining} left"
        with tqdm(total=total, delay=BAR_AFTER, leave=False, bar_format=left) as bar:

            def advance(done: float) -> None:
                bar.update(done - bar.n)

            yield advance
        return
    began, said = 0.0, False

    def estimate(done: float) -> None:
        nonlocal began, said
        # What comes before the first of it, a compiler's time, says nothing of the rest.
        began = began or perf_counter()
        spent = perf_counter() - began
        if said or spent < LOOK_AFTER or not 0.0 < done < total:
            return
        said = True
        if (seconds := spent * (total - done) / done) > WORTH_SAYING:
            share = f"{what}: {done / total:.2%} is done in {spent:.0f} s"
            tell(f"{share}, {tqdm.format_interval(seconds)} is left.", sys.stderr)

    yield estimate
