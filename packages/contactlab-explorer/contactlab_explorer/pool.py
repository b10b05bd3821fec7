"""Processes that compute pictures, so that a page never stands still, and what is no longer wanted ends."""

import asyncio
import multiprocessing
import os
import threading
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any, Final, final

import contactlab as cl

PAGES: Final = 256
"""Pages that are open at once at most."""

FAULT: Final = "fault"
"""Key of the sentence that stands for a picture."""

STOPPED: Final = "stopped"
"""Key of a picture that is no longer wanted."""

_wanted: Any = None
"""In a process of the pool: the ticket of each page that is wanted."""


def begin(wanted: Any) -> None:
    """Begin a process of the pool, which ends with the server, however that ends."""
    global _wanted
    _wanted, server = wanted, multiprocessing.parent_process()
    assert server is not None

    def follow() -> None:
        server.join()
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


def work_of(page: int, ticket: int, function: Callable[..., Any], *arguments: Any) -> Any:
    """Do the work of a ticket, unless another one is wanted by now, and say what is wrong in a sentence."""

    def stop() -> bool:
        return bool(_wanted[page] != ticket)

    try:
        return {STOPPED: True} if stop() else function(*arguments, stop)
    except cl.StoppedError:
        return {STOPPED: True}
    # What is refused, or no motion, is a sentence; a law of somebody else may fail in any way.
    except Exception as error:
        own = isinstance(error, ValueError | RuntimeError)
        return {FAULT: str(error) if own else f"{type(error).__name__}: {error}"}


@final
class Pool:
    """Processes for all pages; a page has one ticket at a time, and a new one ends earlier work.

    Args:
        workers: processes.
    """

    def __init__(self, workers: int) -> None:
        self._context, self._workers = multiprocessing.get_context("spawn"), workers
        self._wanted = self._context.Array("q", PAGES, lock=False)
        self._free = [*reversed(range(PAGES))]
        self._executor = self._made()

    def _made(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(self._workers, self._context, begin, (self._wanted,))

    def page(self) -> int:
        """Return the number of a new page.

        Raises:
            RuntimeError: too many are open.
        """
        if not self._free:
            raise RuntimeError(f"{PAGES} pages are open; there must be fewer. Close some.")
        return self._free.pop()

    def leave(self, page: int) -> None:
        """End the work of a page that is closed."""
        self.ticket(page)
        self._free.append(page)

    def ticket(self, page: int) -> int:
        """Return a new ticket of a page; the work of earlier ones ends."""
        self._wanted[page] += 1
        return int(self._wanted[page])

    async def work(self, page: int, ticket: int, function: Callable[..., Any], *arguments: Any) -> Any:
        """Return what a function of arguments and a stop returns, or `FAULT` with a sentence, or `STOPPED`.

        A process that died, as of memory, is replaced.
        """
        executor = self._executor
        try:
            future = executor.submit(work_of, page, ticket, function, *arguments)
            return await asyncio.wrap_future(future)
        except BrokenProcessPool:
            if executor is self._executor:
                self._executor = self._made()
            return {FAULT: "The process that computed this died, maybe for want of memory; change a number."}

    def close(self) -> None:
        """End all processes."""
        for page in range(PAGES):
            self._wanted[page] = -1
        self._executor.shutdown(cancel_futures=True)
