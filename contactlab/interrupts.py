"""What ends a computation from outside: signals to a process that runs compiled code, and stops."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from traceback import walk_tb
from types import FrameType
from typing import Final, Protocol

_ASKING: Final = [
    number
    for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGALRM", "SIGXCPU", "SIGUSR1", "SIGUSR2", "SIGBREAK")
    if (number := getattr(signal, name, None)) is not None
]
"""Signals that ask a program to end, where a system has them."""


@contextmanager
def signals_wait() -> Iterator[None]:
    """Let a signal that asks the program to end wait for the end of the context; a second one acts at once.

    While compiled code takes its arguments over, the interpreter may run a handler, and what it raises is
    lost there.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handlers: dict[int, Callable[[int, FrameType | None], object]] = {}
    came: list[tuple[int, FrameType | None]] = []

    def wait(number: int, frame: FrameType | None) -> None:
        if any(number == earlier for earlier, _ in came):
            handlers[number](number, frame)
        came.append((number, frame))

    for number in _ASKING:
        if callable(handler := signal.getsignal(number)):
            handlers[number] = handler
            signal.signal(number, wait)
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for number, frame in came:
            handlers[number](number, frame)


def is_of_a_signal(error: BaseException) -> bool:
    """Return whether a signal's handler raised it: that time is up on a cluster is no fault of a law's."""
    handlers = [signal.getsignal(number) for number in signal.valid_signals()]
    codes = [getattr(getattr(h, "__func__", h), "__code__", None) for h in handlers]
    return any(frame.f_code in codes for frame, _ in walk_tb(error.__traceback__))


class StoppedError(RuntimeError):
    """A computation was stopped from outside; the message is a sentence."""


class Event(Protocol):
    """Whether something has happened, as of `threading.Event` and of that of `multiprocessing`."""

    def is_set(self) -> bool:
        """Return whether it has."""


Stop = Callable[[], object] | Event
"""Says whether a computation is to end: by what it returns, or as an event."""

_stops: Final[ContextVar[tuple[Callable[[], object], ...]]] = ContextVar("stops", default=())


@contextmanager
def stopped_by(stop: Stop | None) -> Iterator[None]:
    """Let `raise_if_stopped` end the body once it is to stop; None never does.

    Raises:
        TypeError: it is neither a function nor an event.
    """
    if stop is None:
        yield
        return
    is_set = getattr(stop, "is_set", stop)
    if not callable(is_set):
        raise TypeError(f"stop is {stop!r}; it must be a function without arguments, or an event.")
    token = _stops.set((*_stops.get(), is_set))
    try:
        yield
    finally:
        _stops.reset(token)


def is_stopped() -> bool:
    """Return whether the computation of this context is to end."""
    return any(is_set() for is_set in _stops.get())


def raise_if_stopped(*_: object) -> None:
    """Raise a StoppedError if the computation is to end; arguments, as of progress, are ignored."""
    if is_stopped():
        raise StoppedError("The computation was stopped before its end.")
