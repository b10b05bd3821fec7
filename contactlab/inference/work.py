"""Folds of models shared among processes: which of them have ended, and what is kept as each model does."""

import multiprocessing
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial

from numpy import int64
from numpy.typing import NDArray

from contactlab.inference.models import Model
from contactlab.inference.prediction import Held, held_out
from contactlab.measured.impacts import MeasuredImpacts
from contactlab.processes import START_METHOD, WorkerError, begin_worker

Done = Callable[[int, list[Held]], object]
"""Told the place of a model and its folds when all of them have ended."""

Advance = Callable[[int], object]
"""Told the place of a model of which one fold has ended."""


def perform(
    models: Sequence[Model],
    impacts: MeasuredImpacts,
    fold: NDArray[int64],
    seed: int,
    workers: int,
    done: Done,
    advance: Advance,
) -> None:
    """Fit and judge all folds of all models, the later ones first, and tell of each model as it is done.

    The results do not depend on the number of workers; one is this process itself.

    Raises:
        ValueError: a model answers nowhere in its ranges.
        WorkerError: a worker died.
    """
    folds = int(fold.max()) + 1
    tasks = [(place, number) for place in reversed(range(len(models))) for number in range(folds)]
    found: dict[int, dict[int, Held]] = {place: {} for place in range(len(models))}

    def take(task: tuple[int, int], held: Held) -> None:
        place, number = task
        found[place][number] = held
        advance(place)
        if len(found[place]) == folds:
            done(place, [found[place][number] for number in range(folds)])

    if workers == 1 or len(tasks) == 1:
        for place, number in tasks:
            take((place, number), held_out(models[place], impacts, fold, number, seed))
        return
    with _pool(workers) as submit:
        futures = {
            submit(partial(held_out, models[place], impacts, fold, number, seed)): (place, number)
            for place, number in tasks
        }
        try:
            for future in as_completed(futures):
                take(futures[future], future.result())
        except BrokenProcessPool as error:
            raise WorkerError(
                "A worker process died, maybe for want of memory; the laws that had ended are kept. Start "
                "again, with fewer workers if it dies again."
            ) from error


@contextmanager
def _pool(workers: int) -> Iterator[Callable[[Callable[[], Held]], "Future[Held]"]]:
    """Give what submits work to processes that end with the context, whatever they are at."""
    others = set(multiprocessing.active_children())
    context = multiprocessing.get_context(START_METHOD)
    executor = ProcessPoolExecutor(workers, mp_context=context, initializer=begin_worker)
    try:
        # From Python 3.12 on, of threads (those of the linear algebra) that a fork does not have:
        # the workers do not ask for them.
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "This process", DeprecationWarning)
            yield executor.submit
    finally:
        # Whatever they are at is not wanted any more.
        for process in set(multiprocessing.active_children()) - others:
            process.terminate()
        executor.shutdown(cancel_futures=True)
