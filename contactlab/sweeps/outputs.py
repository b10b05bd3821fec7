"""Many runs in one go, by one process or several: what became of each, and the metrics that were asked for.

The numbers of a run are the same to the last bit wherever and after whatever it runs. Workers are processes,
since a short run is half Python; they are forked where that can be done, with the engine loaded, so that they
start at once and take over whatever makes the motors.
"""

import multiprocessing
import warnings
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from math import ceil
from typing import TYPE_CHECKING, Any, Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.config import ConfigurationError, Setup
from contactlab.config.studies import study_class
from contactlab.engine import prepare
from contactlab.engine.callback import is_of_a_signal
from contactlab.laws import ContactLaw, LawError
from contactlab.metrics import METRICS, Run, assess
from contactlab.processes import START_METHOD, begin_worker, processors
from contactlab.results.internal import internal_series
from contactlab.settling.until import STEADY
from contactlab.suggestion import suggestion
from contactlab.sweeps.dataset import SERIES
from contactlab.sweeps.state import Status, status_of
from contactlab.sweeps.values import listed
from contactlab.variables import INTERNAL, Variable

if TYPE_CHECKING:
    from contactlab.studies.study import Study

Answers = dict[str, NDArray[Any]]
"""What runs gave, a row each: metrics, NAME_series, `status` and `reason`; and the `time` of all series."""

SetupAt = Callable[[int], Setup]
"""What runs in a cell; it may raise a `ConfigurationError`, which makes the cell a refused one."""

StudyAt = Callable[[int], "Study"]
"""The study of a cell, where its numbers are kept."""

Report = Callable[[int], object]
"""Told now and then how many runs have ended."""

MOST_IN_PIECE: Final = 50
"""Runs that a worker is given at once; four pieces a worker at least, so that all end together."""


class WorkerError(RuntimeError):
    """A worker process died; the message is a sentence."""


@final
@dataclass(frozen=True)
class Outputs:
    """Names what is kept of every run: metrics of `contactlab.metrics.METRICS`, and series kept whole.

    Among the series may be internal variables; which they are hangs on the laws.
    """

    metrics: tuple[str, ...] = tuple(key for key, metric in METRICS.items() if metric.usual)
    series: tuple[str, ...] = ()
    internal: tuple[Variable, ...] = ()
    study: str = ""
    """Name of the study whose numbers are kept, each with its error, in place of metrics of a run."""

    @classmethod
    def of_study(cls, name: str) -> "Outputs":
        """Keep the numbers of a study."""
        return cls(tuple(variable.name for variable in numbers_of(name)), study=name)

    @classmethod
    def named(cls, metrics: Iterable[str] | str | None, series: Iterable[str] | str) -> "Outputs":
        """Take names, each once; None stands for the usual metrics and 'all' for all of them.

        Raises:
            ConfigurationError: a name that is no metric or no series, or nothing at all.
        """
        chosen = cls.metrics if metrics is None else METRICS if metrics == "all" else metrics
        asked, faults = [], []
        for kind, names, known in (("metric", chosen, [*METRICS]), ("series", series, [*SERIES])):
            asked.append(tuple(dict.fromkeys(listed(names) if isinstance(names, str) else names)))
            remembered = {name for name in asked[-1] if kind == "series" and name.startswith(INTERNAL)}
            for name in sorted({*asked[-1]} - {*known} - remembered):
                hint = suggestion(name, known, f"One is {known[0]}.")
                there = ", ".join(known)
                faults.append(f"There is no {kind} '{name}'; it must be one of {there}. {hint}")
        if not any(asked):
            faults.append("Nothing is asked for; there must be one metric or series at least.")
        if faults:
            raise ConfigurationError(faults)
        return cls(asked[0], asked[1])

    def of_laws(self, laws: Iterable[ContactLaw]) -> "Outputs":
        """Find out which the internal variables among the series are.

        Raises:
            ConfigurationError: one that no law has, or that is not the same in all that have it.
        """
        asked = {name: set[Variable]() for name in self.series if name not in SERIES}
        there: set[str] = set()
        for law in laws if asked else ():
            for one in internal_series(law):
                there.add(one.name)
                asked.get(one.name, set()).add(one)
        faults = []
        for name, found in asked.items():
            if not found:
                words = ", ".join(sorted(there)) or "nothing under these laws"
                hint = suggestion(name, there)
                faults.append(f"There is no series '{name}'; what is remembered is {words}. {hint}".rstrip())
            elif len(found) > 1:
                said = " and ".join(sorted(f"{one.long_name} [{one.units}]" for one in found))
                faults.append(
                    f"The series '{name}' is {said}; it must be the same under all laws. Leave it out."
                )
        if faults:
            raise ConfigurationError(faults)
        return replace(self, internal=tuple(one for found in asked.values() for one in found))

    @property
    def kept(self) -> tuple[Variable, ...]:
        """The series as variables, once the laws are known."""
        known = SERIES | {one.name: one for one in self.internal}
        return tuple(known[name] for name in self.series)

    @property
    def numbers(self) -> tuple[Variable, ...]:
        """The numbers of a study as variables; none for metrics of a run."""
        return numbers_of(self.study) if self.study else ()

    @property
    def sampled(self) -> bool:
        """Whether more records than the last are needed."""
        return bool(self.series) or any(METRICS[key].needs_records for key in self.metrics if key in METRICS)


def numbers_of(study: str) -> tuple[Variable, ...]:
    """Return the quantities of a study and their errors as variables of a sweep."""
    every = study_class(study).quantities
    errors = (
        replace(
            q, name=f"{q.name}_error", symbol=f"error of {q.symbol}", long_name=f"error of the {q.long_name}"
        )
        for q in every
    )
    return (*every, *errors)


@final
class Batch:
    """Runs cells of one sweep, by processes whose number changes no bit. A context manager.

    One worker is this process itself; None is one a processor.
    """

    def __init__(
        self,
        setup_at: SetupAt,
        outputs: Outputs,
        workers: int | None = None,
        report: Report | None = None,
        study_at: StudyAt | None = None,
    ) -> None:
        self._task = (setup_at, outputs, study_at)
        self._count = workers or processors()
        self._report = report
        self._done = 0
        self._executor: ProcessPoolExecutor | None = None
        self._others = set(multiprocessing.active_children())

    def __enter__(self) -> "Batch":
        return self

    def __exit__(self, *exception: object) -> None:
        if self._executor is not None:
            # Whatever they are at is not wanted any more: a run may take minutes.
            for process in set(multiprocessing.active_children()) - self._others:
                process.terminate()
            self._executor.shutdown(cancel_futures=True)

    def answers(self, cells: Sequence[int]) -> Answers:
        """Run some cells; a WorkerError tells that a worker died."""
        count = min(self._count, len(cells))
        size = max(1, min(MOST_IN_PIECE, ceil(len(cells) / (4 * count))))
        pieces = [cells[at : at + size] for at in range(0, len(cells), size)]
        parts = []
        try:
            for part in self._ended(pieces, count):
                parts.append(part)
                self._done += part["status"].size
                if self._report:
                    self._report(self._done)
        except BrokenProcessPool as error:
            raise WorkerError(
                "A worker process died, maybe for want of memory; what was finished before is kept. Start "
                "again, with fewer workers if it dies again."
            ) from error
        return joined(parts)

    def _ended(self, pieces: Sequence[Sequence[int]], count: int) -> Iterable[Answers]:
        """Give the answers of pieces one by one, from workers where there is to be more than one."""
        if count < 2:
            return map(partial(_answers, *self._task), pieces)
        if self._executor is None:
            # With the engine loaded here none has to load it; a cell's own run tells what is wrong.
            for cell in pieces[0]:
                with suppress(Exception):
                    setup = self._task[0](cell)
                    prepare(setup.motor, setup.law)
                    break
            context = multiprocessing.get_context(START_METHOD)
            self._executor = ProcessPoolExecutor(
                self._count, mp_context=context, initializer=_begin, initargs=self._task
            )
        # From Python 3.12 on, of threads (those of the linear algebra) that a fork does not have:
        # the workers do not ask for them.
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "This process", DeprecationWarning)
            return self._executor.map(_work, pieces)


_WORKER: Final[list[Callable[[Sequence[int]], Answers]]] = []
"""What a worker process does with all its pieces."""


def _begin(setup_at: SetupAt, outputs: Outputs, study_at: StudyAt | None) -> None:
    """Make this process a worker."""
    begin_worker()
    _WORKER[:] = [partial(_answers, setup_at, outputs, study_at)]


def _work(cells: Sequence[int]) -> Answers:
    return _WORKER[0](cells)


def _answers(setup_at: SetupAt, outputs: Outputs, study_at: StudyAt | None, cells: Sequence[int]) -> Answers:
    return joined([_run(setup_at, outputs, study_at, cell) for cell in cells])


def joined(parts: Sequence[Answers]) -> Answers:
    """Give the answers of all parts, one after the other; NaN where a part has no records."""
    time = max((part["time"] for part in parts), key=len)

    def rows(values: NDArray[Any]) -> NDArray[Any]:
        # Only series may have no size.
        return values if values.size else np.full((len(values), time.size), np.nan)

    names = [name for name in parts[0] if name != "time"]
    found = {name: np.concatenate([rows(part[name]) for part in parts]) for name in names}
    return {**found, "time": time}


def _run(setup_at: SetupAt, outputs: Outputs, study_at: StudyAt | None, cell: int) -> Answers:
    """Run one cell: what became of it and why, with its numbers where it reached its end."""
    metrics, status = dict.fromkeys(outputs.metrics, np.nan), Status.FAILED
    series, time = dict.fromkeys(outputs.series, np.empty(0)), np.empty(0)
    try:
        setup = setup_at(cell)
        if study_at is not None:
            return _put(study_at(cell), setup, outputs)
        sampled = outputs.sampled or setup.until == STEADY
        run = setup.run(record_interval=setup.record_interval if sampled else setup.duration)
        status, reason = status_of(run.ending), run.message
        if run.ending.reached_end:
            metrics = assess(Run.of_trajectory(run, setup.configuration), outputs.metrics)
            if outputs.series:
                # A series alone, not the memory of all that the run has recorded.
                there, time = {*SERIES, *(one.name for one in internal_series(run.law))}, run.time
                none = np.full(time.size, np.nan)
                series = {n: run.series[n].copy() if n in there else none for n in outputs.series}
    except ConfigurationError as error:
        status, reason = Status.REFUSED, " ".join(error.faults)
    except LawError as error:
        reason = str(error)
    # The others shall not suffer from what one of ten thousand runs into.
    except Exception as error:
        # That a cluster's time is up is no result of the cell: the chunk is to be made again.
        if is_of_a_signal(error):
            raise
        status, reason = Status.FAILED, f"The run ended in {type(error).__name__}: {error}"
    return {
        **{key: np.array([metrics[key]]) for key in outputs.metrics},
        "status": np.array([status], dtype=np.int8),
        "reason": np.array([reason]),
        **{f"{name}_series": rows[np.newaxis] for name, rows in series.items()},
        "time": time,
    }


def _put(study: "Study", setup: Setup, outputs: Outputs) -> Answers:
    """Put a study to a setup and return its numbers with their errors."""
    numbers = study.result(setup).numbers
    return {
        **{q: np.array([numbers[q].value]) for q in outputs.metrics if q in numbers},
        **{f"{q}_error": np.array([numbers[q].error]) for q in numbers if f"{q}_error" in outputs.metrics},
        "status": np.array([Status.COMPLETE], dtype=np.int8),
        "reason": np.array([""]),
        "time": np.empty(0),
    }
