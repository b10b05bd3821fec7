"""What a long computation is at: told where the work is done, shown by whoever waits, or by nobody."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

Report = Callable[[str, float], object]
"""Receives what is being done, and the share that is done [1], NaN where that is not known."""

_receivers: Final[list[Report]] = []


def tell_progress(what: str, share: float = float("nan")) -> None:
    """Report what is being done, and the share of it that is done [1], to whoever shows it."""
    if _receivers:
        _receivers[-1](what, share)


def is_shown() -> bool:
    """Return whether somebody shows progress, who would be drawn over by another bar."""
    return bool(_receivers)


@contextmanager
def shown_by(report: Report) -> Iterator[None]:
    """Let a function show the progress of the body."""
    _receivers.append(report)
    try:
        yield
    finally:
        _receivers.pop()


@contextmanager
def part_of_progress(begin: float, end: float, before: str = "") -> Iterator[None]:
    """Report the progress of the body as that from one share of the whole to another, with a text before."""

    def report(what: str, share: float) -> None:
        outer(f"{before}{what}", begin + (end - begin) * share)

    if not _receivers:
        yield
        return
    outer = _receivers[-1]
    with shown_by(report):
        yield


@contextmanager
def untold_progress() -> Iterator[None]:
    """Keep what the body tells, as one of many evaluations, from whoever shows the whole."""
    with shown_by(lambda *_: None):
        yield
