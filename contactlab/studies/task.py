"""Tasks: the independent pieces of a study, and what each leaves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, final

from contactlab.config.faults import add_place

if TYPE_CHECKING:
    import xarray

    from contactlab.config import Setup

TASKS: Final = "tasks"
"""Folder of the finished tasks, beside the files of the result."""

Progress = Callable[[int, int], object]
"""Receives the number of finished tasks and that of all."""

Setups = Mapping[str, "Setup"]
"""The setups of a study by label: what distinguishes each, as 'law=newton'; empty for a single one."""


@final
@dataclass(frozen=True)
class Part:
    """Result of one task.

    Args:
        source: what is stored and combined, or a function that makes it when it is read first.
        details: the object of the analysis from which the data are made; it is not stored.
    """

    source: xarray.DataTree | Callable[[], xarray.DataTree]
    details: Any = None

    @cached_property
    def data(self) -> xarray.DataTree:
        """What is stored and combined."""
        return self.source() if callable(self.source) else self.source


@final
@dataclass(frozen=True)
class Task:
    """An independent piece of a study.

    Args:
        key: unique within the study.
        function: a function of a module, so that other processes can import it.
        arguments: of the function, picklable.
        resumes: whether the function takes a last argument `checkpoint`, a file by which it resumes.
    """

    key: str
    function: Callable[..., Part]
    arguments: tuple[Any, ...] = ()
    resumes: bool = False

    def __call__(self) -> Part:
        """Do it."""
        try:
            return self.function(*self.arguments)
        # A study of somebody else may fail in any way; it goes on to who can say so.
        except Exception as error:
            add_place(error, f"the task {self.key!r}")
            raise
