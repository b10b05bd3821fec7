"""Faults of a configuration, each with key, value and bound."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from traceback import walk_tb
from typing import Final

from contactlab.foreign import is_library

RAISED: Final = "Raised in "
"""Beginning of the note of an exception on its place."""


class ConfigurationError(ValueError):
    """A configuration that cannot run, with all its faults, or one."""

    def __init__(self, faults: Iterable[str] | str) -> None:
        self.faults = [faults] if isinstance(faults, str) else [*faults]
        super().__init__("\n".join(self.faults))


def raise_faults(faults: Iterable[str]) -> None:
    """Raise a ConfigurationError of the faults, each once; nothing where there is none."""
    if every := list(dict.fromkeys(faults)):
        raise ConfigurationError(every)


@contextmanager
def faults_added(faults: list[str]) -> Iterator[None]:
    """Add the faults of a ConfigurationError to others."""
    try:
        yield
    except ConfigurationError as error:
        faults += error.faults


@contextmanager
def as_fault(before: str = "", kind: type[Exception] = ValueError, after: str = "") -> Iterator[None]:
    """Raise a ValueError, or an exception of another kind, as a fault with texts around its own."""
    try:
        yield
    except (ValueError, kind) as error:
        raise ConfigurationError(f"{before}{error}{after}") from error


def one_line(error: BaseException) -> str:
    """Return the message of an exception, its cause included, as a sentence on one line."""
    parts = [part for part in (error, error.__cause__) if part is not None]
    lines = [line.strip() for part in parts for line in str(part).splitlines()]
    inner = ("full_key:", "reference_type=", "object_type=")
    text = " ".join(line for line in lines if line and not line.startswith(inner))
    return text if text.endswith((".", "?", "!")) else f"{text}."


def failure_of(error: BaseException) -> str:
    """Return why a part of a study has no numbers, a sentence also where the exception has none."""
    text = " ".join(str(error).split())
    if is_sentence(error):
        return text
    return (
        f"It raised an unexpected {type(error).__name__} ({text or 'without a message'}) in "
        f"{place_of(error)}: a fault of contactlab or of code of yours."
    )


def is_sentence(error: BaseException) -> bool:
    """Return whether an exception says itself what must be otherwise; others are faults of some code."""
    return isinstance(error, ValueError | RuntimeError | TypeError) and str(error).endswith((".", "?", "!"))


def add_place(error: Exception, what: str) -> None:
    """Note at an exception in what it was raised, and where: another process has no frames of it."""
    if not is_sentence(error):
        error.add_note(f"{RAISED}{place_of(error)}, {what}")


def place_of(error: BaseException) -> str:
    """Return where an exception was raised: as `add_place` has noted, or file and line.

    The frame is the innermost outside contactlab and the libraries, where there is one.
    """
    notes: list[str] = getattr(error, "__notes__", [])
    if noted := [note for note in notes if note.startswith(RAISED)]:
        return noted[-1].removeprefix(RAISED)
    frames = [
        (frame.f_globals.get("__name__", ""), f"{Path(frame.f_code.co_filename).name}, line {line}")
        for frame, line in walk_tb(error.__traceback__)
    ]
    foreign = [place for module, place in frames if not is_library(module)]
    return (foreign or [place for _, place in frames] or ["an unknown place"])[-1]
