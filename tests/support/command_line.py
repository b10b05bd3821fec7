"""Helpers for tests of the command."""

from collections.abc import Callable
from pathlib import Path

Command = Callable[..., tuple[int, str, str]]
"""Takes arguments; gives exit status, output and errors."""


def left_behind() -> list[Path]:
    return list(Path().rglob("*"))
