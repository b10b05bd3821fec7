"""The same runs on several processors: each worker process takes its share and sends its answers back.

Processes, since a short run is half Python. They are forked where that can be done, with the engine loaded,
so that they start at once and take over whatever describes the grid.
"""

import gc
import multiprocessing
import os
import signal
import warnings
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Final, TypeVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.engine import prepare
from contactlab.sweeps.many import Answers, Report, SetupAt, Wanted, answers

FORK: Final = "fork" in multiprocessing.get_all_start_methods()


Number = TypeVar("Number", np.float64, np.int8)


class WorkerError(RuntimeError):
    """A worker process died; the message is a sentence."""


def processors() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@final
class Pool:
    """Processes that run cells of one grid; their number changes no bit. A context manager.

    Args:
        setup_at: what runs in a cell.
        wanted: what is kept.
        workers: how many processes; one is this process itself.
    """

    def __init__(self, setup_at: SetupAt, wanted: Wanted, workers: int) -> None:
        self._setup_at = setup_at
        self._wanted = wanted
        self._count = workers
        self._workers: list[tuple[BaseProcess, Connection]] = []

    def __enter__(self) -> "Pool":
        return self

    def __exit__(self, *exception: object) -> None:
        for process, own in self._workers:
            process.terminate()
            own.close()
        for process, _ in self._workers:
            process.join()
        self._workers = []

    def answers(self, cells: Sequence[int], report: Report | None = None) -> Answers:
        """As `contactlab.sweeps.many.answers`.

        Raises:
            WorkerError: a worker died.
        """
        count = min(self._count, len(cells))
        if count < 2:
            return answers(self._setup_at, cells, self._wanted, report)
        if not self._workers:
            self._start(cells)
        # Neighbours take about as long as each other: every so many-th cell makes equal shares.
        pending: dict[Connection, int] = {}
        for number, (_, connection) in enumerate(self._workers[:count]):
            with suppress(BrokenPipeError):
                connection.send(cells[number::count])
            pending[connection] = number
        parts: dict[int, Answers] = {}
        while pending:
            for ready in wait(list(pending)):
                assert isinstance(ready, Connection)
                message = self._received(ready, pending[ready])
                if isinstance(message, Answers):
                    parts[pending.pop(ready)] = message
                elif report:
                    report(message)
        return _interleaved([parts[number] for number in range(count)], len(cells))

    def _start(self, cells: Sequence[int]) -> None:
        """Load the engine, so that no worker has to, and start the workers."""
        for cell in cells:
            try:
                setup = self._setup_at(cell)
                prepare(setup.motor, setup.law)
            # The cell's own run tells of it.
            except Exception:
                continue
            break
        context = multiprocessing.get_context("fork" if FORK else None)
        for _ in range(self._count):
            ours, theirs = context.Pipe()
            # A fork has our ends of all pipes too; only once it closes them does it notice our death.
            inherited = [connection for _, connection in self._workers] + [ours] if FORK else []
            worker = context.Process(
                target=_work,
                args=(theirs, inherited, self._setup_at, self._wanted),
                daemon=True,
            )
            with warnings.catch_warnings():
                # From Python 3.12 on, of threads (those of the linear algebra) that a fork does not have:
                # the workers do not ask for them.
                warnings.filterwarnings("ignore", "This process", DeprecationWarning)
                worker.start()
            theirs.close()
            self._workers.append((worker, ours))

    def _received(self, connection: Connection, number: int) -> Answers | int:
        """The answers of a worker, or how many runs it has ended since it last said so."""
        try:
            message: Answers | int = connection.recv()
        except (EOFError, ConnectionResetError):
            process, _ = self._workers[number]
            process.join()
            raise WorkerError(
                f"A worker process died (exit code {process.exitcode}), maybe for want of memory; what "
                "was finished before is kept. Start again, with fewer workers if it dies again."
            ) from None
        return message


def _work(
    theirs: Connection, inherited: Sequence[Connection], setup_at: SetupAt, wanted: Wanted
) -> None:
    """What a worker does; it ends as soon as nobody listens any more."""
    # A fork has our handlers too: signals to the whole group are for us to answer, and to end is to end.
    for name in ("SIGINT", "SIGUSR1", "SIGUSR2"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    # What is there stays as it is: looking it over would copy the memory that a fork shares.
    gc.freeze()
    for connection in inherited:
        connection.close()
    with suppress(EOFError, BrokenPipeError, ConnectionResetError):
        while True:
            theirs.send(answers(setup_at, theirs.recv(), wanted, theirs.send))


def _interleaved(parts: Sequence[Answers], count: int) -> Answers:
    """The answers of all shares, back in the order of the cells."""
    reason = [""] * count
    for number, part in enumerate(parts):
        reason[number :: len(parts)] = part.reason
    return Answers(
        metrics=_woven([part.metrics for part in parts], count),
        status=_woven([part.status for part in parts], count),
        reason=reason,
        series={
            name: _woven([part.series[name] for part in parts], count) for name in parts[0].series
        },
        time=max((part.time for part in parts), key=len),
    )


def _woven(parts: Sequence[NDArray[Number]], count: int) -> NDArray[Number]:
    """Every part's rows as every so many-th row; rows that are shorter end in NaN."""
    widths: list[int] = [
        max(sizes) for sizes in zip(*(part.shape[1:] for part in parts), strict=True)
    ]
    found = np.empty((count, *widths), dtype=parts[0].dtype)
    for number, part in enumerate(parts):
        rows = found[number :: len(parts)]
        if widths and part.shape[1] < widths[0]:
            rows[:] = np.nan
        rows[tuple(slice(size) for size in part.shape)] = part
    return found
