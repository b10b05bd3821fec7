"""Many runs in one go, by one process or several: what became of each, and the metrics that were asked for.

One run follows the other and is handed what like motors have in common; its numbers are the same to the
last bit wherever and after whatever it runs. Workers are processes, since a short run is half Python; they
are forked where that can be done, with the engine loaded, so that they start at once and take over whatever
makes the motors.
"""

import gc
import multiprocessing
import os
import signal
import threading
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from math import ceil
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import ConfigurationError, Setup
from contactlab.engine import prepare, simulate
from contactlab.engine.callback import is_of_a_signal
from contactlab.engine.propagator import Workspace
from contactlab.laws import LawError
from contactlab.metrics import Run, assess
from contactlab.sweeps.answers import Answers, joined, stacked
from contactlab.sweeps.plan import Outputs
from contactlab.sweeps.state import Status, status_of
from contactlab.trajectory import Trajectory

SetupAt = Callable[[int], Setup]
"""What runs in a cell; it may raise a `ConfigurationError`, which makes the cell a refused one."""

Report = Callable[[int], object]
"""Told now and then how many runs have ended."""

MOST_IN_PIECE: Final = 50
"""Runs that a worker is given at once; four pieces a worker at least, so that all end together."""

START_METHOD: Final = "fork" if "fork" in multiprocessing.get_all_start_methods() else None


class WorkerError(RuntimeError):
    """A worker process died; the message is a sentence."""


def processors() -> int:
    """Count the processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


@final
class Batch:
    """Runs cells of one sweep, by processes whose number changes no bit. A context manager.

    Args:
        setup_at: what runs in a cell.
        outputs: what is kept.
        workers: how many processes; one is this process itself. None is one a processor.
        report: hears of the progress.
    """

    def __init__(
        self,
        setup_at: SetupAt,
        outputs: Outputs,
        workers: int | None = None,
        report: Report | None = None,
    ) -> None:
        self._task = (setup_at, outputs)
        self._count = workers or processors()
        self._report = report
        self._done = 0
        self._executor: ProcessPoolExecutor | None = None
        self._others = set(multiprocessing.active_children())

    def __enter__(self) -> "Batch":
        return self

    def __exit__(self, *exception: object) -> None:
        if self._executor is None:
            return
        # Whatever they are at is not wanted any more: a run may take minutes.
        for process in set(multiprocessing.active_children()) - self._others:
            process.terminate()
        self._executor.shutdown(cancel_futures=True)

    def answers(self, cells: Sequence[int]) -> Answers:
        """Run some cells.

        Raises:
            WorkerError: a worker died.
        """
        count = min(self._count, len(cells))
        size = max(1, min(MOST_IN_PIECE, ceil(len(cells) / (4 * count))))
        pieces = [cells[at : at + size] for at in range(0, len(cells), size)]
        if count < 2:
            workspace = Workspace()
            parts = []
            for piece in pieces:
                parts.append(_answers(*self._task, piece, workspace))
                self._ended(len(piece))
            return joined(parts)
        try:
            futures = self._submitted(pieces)
            for done in as_completed(futures):
                self._ended(done.result().status.size)
        except BrokenProcessPool as error:
            raise WorkerError(
                "A worker process died, maybe for want of memory; what was finished before is kept. Start "
                "again, with fewer workers if it dies again."
            ) from error
        return joined([future.result() for future in futures])

    def _ended(self, count: int) -> None:
        self._done += count
        if self._report:
            self._report(self._done)

    def _submitted(self, pieces: Sequence[Sequence[int]]) -> list[Future[Answers]]:
        with ExitStack() as stack:
            if self._executor is None:
                self._prepare(pieces)
                self._executor = ProcessPoolExecutor(
                    self._count,
                    mp_context=multiprocessing.get_context(START_METHOD),
                    initializer=_begin,
                    initargs=self._task,
                )
                # From Python 3.12 on, of threads (those of the linear algebra) that a fork does not have:
                # the workers do not ask for them.
                stack.enter_context(warnings.catch_warnings())
                warnings.filterwarnings("ignore", "This process", DeprecationWarning)
            return [self._executor.submit(_work, piece) for piece in pieces]

    def _prepare(self, pieces: Sequence[Sequence[int]]) -> None:
        """Load the engine, so that no worker has to."""
        for cell in (cell for piece in pieces for cell in piece):
            try:
                setup = self._task[0](cell)
                prepare(setup.motor, setup.law)
            # The cell's own run tells of it.
            except Exception:
                continue
            break


_WORKER: Final[dict[str, tuple[SetupAt, Outputs, Workspace]]] = {}
"""What a worker process has for all its pieces."""


def _begin(setup_at: SetupAt, outputs: Outputs) -> None:
    """Make this process a worker."""
    # A fork has the command's handlers too: signals to the whole group are for that to answer.
    for name in ("SIGINT", "SIGUSR1", "SIGUSR2"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    # What is there stays as it is: looking it over would copy the memory that a fork shares.
    gc.freeze()
    _WORKER["task"] = (setup_at, outputs, Workspace())
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this process as soon as nobody waits for it any more: a command that is killed tells nobody."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _work(cells: Sequence[int]) -> Answers:
    setup_at, outputs, workspace = _WORKER["task"]
    return _answers(setup_at, outputs, cells, workspace)


def _answers(
    setup_at: SetupAt, outputs: Outputs, cells: Sequence[int], workspace: Workspace
) -> Answers:
    """Run some cells, one after the other."""
    metrics = np.full((len(cells), len(outputs.metrics)), np.nan)
    status = np.zeros(len(cells), dtype=np.int8)
    reason = [""] * len(cells)
    series: dict[str, list[Array]] = {name: [] for name in outputs.series}
    time = np.empty(0)
    for place, cell in enumerate(cells):
        run, status[place], reason[place] = _run(setup_at, cell, outputs, workspace, metrics[place])
        # A series alone, not the memory of all that the run has recorded.
        for name, rows in series.items():
            rows.append(np.empty(0) if run is None else run.series[name].copy())
        if run is not None and outputs.series:
            time = max(time, run.time, key=len)
    return Answers(
        metrics, status, reason, {name: stacked(rows) for name, rows in series.items()}, time
    )


def _run(
    setup_at: SetupAt, cell: int, outputs: Outputs, workspace: Workspace, metrics: Array
) -> tuple[Trajectory | None, Status, str]:
    """Run one cell; its metrics go into `metrics` if it reached its end.

    Returns:
        The run if it reached its end, what became of it and why.
    """
    try:
        setup = setup_at(cell)
        run = simulate(
            setup.motor,
            setup.law,
            duration=setup.duration,
            record_interval=outputs.interval(setup),
            contact_step=setup.contact_step,
            tolerance=setup.tolerance,
            workspace=workspace,
        )
        if not run.ending.reached_end:
            return None, status_of(run.ending), run.message
        found = assess(Run.of_trajectory(run, setup.configuration), outputs.metrics)
    except ConfigurationError as error:
        return None, Status.REFUSED, " ".join(error.faults)
    except LawError as error:
        return None, Status.FAILED, str(error)
    # The others shall not suffer from what one of ten thousand runs into.
    except Exception as error:
        # That a cluster's time is up is no result of the cell: the chunk is to be made again.
        if is_of_a_signal(error):
            raise
        return None, Status.FAILED, f"The run ended in {type(error).__name__}: {error}"
    metrics[:] = [found[key] for key in outputs.metrics]
    return run, status_of(run.ending), run.message
