"""Exit statuses, output, Ctrl-C and the progress bar of the command.

Imports and the compiler may swallow a KeyboardInterrupt or crash on it. Therefore Ctrl-C ends the process at
once until a run has begun, waits for the next record while it is simulated, and is the usual exception, which
cleans up, while files are written.
"""

import os
import shutil
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from math import inf, isfinite
from pathlib import Path
from time import perf_counter, sleep
from types import FrameType
from typing import Final, NoReturn, TextIO, final

from tqdm import tqdm

from contactlab.progress import shown_by
from contactlab.results.files import error_text, remove_own

COMPLETE, INCOMPLETE, REFUSED, INTERRUPTED = 0, 1, 2, 130
"""Exit statuses of the command: complete, incomplete or failed, refused for a fault, ended by Ctrl-C."""

STUCK: Final = 1.0
"""Time after a second Ctrl-C in which a handler runs where the process is not stuck in compiled code [s]."""

MESSAGE: Final = "Interrupted before the end; no result was written."

BAR_AFTER, BAR_EVERY = 0.7, 0.5
"""Time after which progress is shown, and between two times [s]."""

LONGEST_LEFT: Final = 1e7
"""Estimate of the time left that is shown [s]; a longer one tells of a first step alone."""


class RefusalError(ValueError):
    """A command that cannot be carried out.

    Args:
        message: key or argument, its value and what is admitted.
        status: exit status; INCOMPLETE where the arguments have no fault, as on a full disk.
    """

    def __init__(self, message: str, status: int = REFUSED) -> None:
        super().__init__(message)
        self.status = status


def unwritable(folder: Path, error: OSError) -> RefusalError:
    """Return the failure of a folder that could not be written to the end, as on a full disk."""
    return RefusalError(f"Nothing more can be written to '{folder}': {error_text(error)}", INCOMPLETE)


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


def width_of(stream: TextIO) -> int:
    """Return the columns of a terminal; 0 of what is none."""
    return shutil.get_terminal_size().columns if stream.isatty() else 0


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

    def handle(number: int, frame: FrameType | None) -> None:
        _unhandled.clear()
        handler(number, frame)

    signal.signal(signal.SIGINT, handle)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


_unhandled: Final[list[int]] = []
"""Ctrl-C that came since a handler ran last: none runs while compiled code does not return."""


@contextmanager
def ending_stuck() -> Iterator[None]:
    """Let a second Ctrl-C end the process where compiled code does not return, as of a law without an end.

    Handlers run between two steps of the interpreter; a thread reads what the system writes of a signal.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    source, sink = os.pipe()
    os.set_blocking(sink, False)
    before = signal.set_wakeup_fd(sink, warn_on_full_buffer=False)

    def watch() -> None:
        while byte := os.read(source, 1):
            if byte[0] == signal.SIGINT:
                _unhandled.append(1)
                sleep(STUCK if len(_unhandled) > 1 else 0.0)
                if len(_unhandled) > 1:
                    _end(signal.SIGINT, None)
        os.close(source)

    _unhandled.clear()
    watching = threading.Thread(target=watch, daemon=True)
    watching.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(before)
        os.close(sink)


def _end(_number: int, _frame: FrameType | None) -> NoReturn:
    remove_own()
    # Who ends the command may have closed its output too.
    with suppress(OSError, RuntimeError):
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


@final
class _Line:
    """What is done of a total, in a line.

    Args:
        total, unit: what is to be done.
        size: of the part that tells of itself, in that unit.
    """

    def __init__(self, total: float, unit: str, size: float) -> None:
        self.done, self.total, self.unit, self.size = 0.0, total, unit, size
        self.current, self.share, self.began = "", 0.0, perf_counter()
        # What was done by an earlier start takes no time.
        self.kept: float | None = None

    def show(self, done: float, total: float | None = None) -> None:
        """Take how much is done, and another total."""
        self.done, self.total, self.current, self.share = done, total or self.total, "", 0.0
        self.kept = done if self.kept is None else self.kept

    def tell(self, what: str, share: float) -> None:
        """Take what a part of it is at."""
        self.current, self.share = what.rstrip(": "), share if isfinite(share) else 0.0

    def __str__(self) -> str:
        begun, all_of_it = self.kept or 0.0, self.total or 1.0
        done, elapsed = min(self.done + self.share * self.size, all_of_it), perf_counter() - self.began
        # Of a single task its parts tell.
        left = elapsed * (all_of_it - done) / (done - begun) if done > begun else inf
        # A narrow screen cuts off the end.
        pieces = [
            f"about {tqdm.format_interval(left)} left" if left < LONGEST_LEFT else "",
            f"{tqdm.format_interval(elapsed)} so far",
            f"{self.done:.6g} of {self.total:.6g} {self.unit}" if self.total != 1.0 else "",
            self.current,
        ]
        return f"{done / all_of_it:4.0%} | {' | '.join(filter(None, pieces))}"


@contextmanager
def progress(total: float, unit: str, size: float = 1.0) -> Iterator[Callable[..., None]]:
    """Show on a terminal what is done, the time it has taken, and the time left where that can be estimated.

    A thread draws, so that what takes long by itself is shown too. What a part of the work tells by
    `contactlab.progress` is shown beside. Arguments are those of `_Line`.

    Yields:
        Function of how much is done, and of another total where that changes.
    """
    line, ended = _Line(total, unit, size), threading.Event()
    # tqdm shows nothing on a terminal that does not tell its size.
    screen = shutil.get_terminal_size()
    bar = tqdm(total=total, leave=False, delay=inf, disable=None, nrows=screen.lines)

    def draw() -> None:
        pause = BAR_AFTER
        while not ended.wait(pause):
            bar.display(str(line)[: screen.columns - 1])
            pause = BAR_EVERY

    drawing = threading.Thread(target=draw, daemon=True)
    if not bar.disable:
        drawing.start()
    try:
        with shown_by(line.tell):
            yield line.show
    finally:
        ended.set()
        if not bar.disable:
            drawing.join()
            bar.display("")
            print("\r", end="", file=sys.stderr, flush=True)
            bar.close()
