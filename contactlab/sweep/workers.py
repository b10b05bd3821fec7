"""The same runs on several processors: each worker process takes its share and sends its answers back.

Processes, since a short run is half Python. They are forked where that can be done, with the engine loaded,
so that they start at once and take over whatever describes the grid.
"""

import multiprocessing
import os
import signal
import warnings
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from contactlab.engine import prepare
from contactlab.sweep.many import Answers, Report, SetupAt, Wanted, answers

FORK: Final = "fork" in multiprocessing.get_all_start_methods()


Number = TypeVar("Number", np.float64, np.int8)


class WorkerError(RuntimeError):
    """A worker process died; the message is a sentence."""


def processors() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def shared_answers(
    setup_at: SetupAt,
    cells: Sequence[int],
    wanted: Wanted,
    workers: int,
    report: Report | None = None,
) -> Answers:
    """As `contactlab.sweep.many.answers`, by several processes; their number changes no bit.

    Args:
        setup_at, cells, wanted, report: see there.
        workers: how many processes; one is this process itself.

    Raises:
        WorkerError: a worker died.
    """
    count = min(workers, len(cells))
    if count < 2:
        return answers(setup_at, cells, wanted, report)
    _load(setup_at, cells)
    # Neighbours take about as long as each other: every so many-th cell makes equal shares.
    shares = [cells[first::count] for first in range(count)]
    parts = _in_processes(setup_at, shares, wanted, report)
    return _interleaved(parts, len(cells))


def _load(setup_at: SetupAt, cells: Sequence[int]) -> None:
    """Load the engine, so that no worker has to."""
    for cell in cells:
        try:
            setup = setup_at(cell)
            prepare(setup.motor, setup.law)
        # The cell's own run tells of it.
        except Exception:
            continue
        return


def _in_processes(
    setup_at: SetupAt,
    shares: Sequence[Sequence[int]],
    wanted: Wanted,
    report: Report | None,
) -> list[Answers]:
    context = multiprocessing.get_context("fork" if FORK else None)
    processes: list[BaseProcess] = []
    pending: dict[Connection, int] = {}
    parts: dict[int, Answers] = {}
    try:
        for number, share in enumerate(shares):
            ours, theirs = context.Pipe(duplex=False)
            # A fork has our ends of all pipes too; only once it closes them does it notice our death.
            inherited = [*pending, ours] if FORK else []
            worker = context.Process(
                target=_work, args=(theirs, inherited, setup_at, share, wanted), daemon=True
            )
            with warnings.catch_warnings():
                # From Python 3.12 on, of threads (those of the linear algebra) that a fork does not have:
                # the workers do not ask for them.
                warnings.filterwarnings("ignore", "This process", DeprecationWarning)
                worker.start()
            theirs.close()
            processes.append(worker)
            pending[ours] = number
        while pending:
            for connection in wait(list(pending)):
                assert isinstance(connection, Connection)
                _receive(connection, pending, processes, parts, report)
    finally:
        for process in processes:
            process.terminate()
            process.join()
    return [parts[number] for number in range(len(shares))]


def _receive(
    connection: Connection,
    pending: dict[Connection, int],
    processes: Sequence[BaseProcess],
    parts: dict[int, Answers],
    report: Report | None,
) -> None:
    try:
        message = connection.recv()
    except EOFError:
        process = processes[pending[connection]]
        process.join()
        raise WorkerError(
            f"A worker process died (exit code {process.exitcode}), maybe for want of memory; what was "
            "finished before is kept. Start again, with fewer workers if it dies again."
        ) from None
    if isinstance(message, int):
        if report:
            report(message)
    else:
        parts[pending.pop(connection)] = message
        connection.close()


def _work(
    theirs: Connection,
    inherited: Sequence[Connection],
    setup_at: SetupAt,
    cells: Sequence[int],
    wanted: Wanted,
) -> None:
    """What a worker does; it ends as soon as nobody listens any more."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for connection in inherited:
        connection.close()
    with suppress(BrokenPipeError):
        theirs.send(answers(setup_at, cells, wanted, theirs.send))


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
