"""Many runs in one go: what became of each, and the metrics that were asked for.

One run follows the other and is handed what like motors have in common; its numbers are the same to the
last bit wherever and after whatever it runs.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from time import monotonic
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.config import ConfigurationError, Setup
from contactlab.engine import simulate
from contactlab.engine.callback import is_of_a_signal
from contactlab.engine.propagator import Workspace
from contactlab.laws import LawError
from contactlab.metrics import METRICS, Run, assess
from contactlab.suggestion import suggestion
from contactlab.sweeps.status import Status, status_of
from contactlab.trajectory import Trajectory
from contactlab.variables import SERIES

Array = NDArray[np.float64]

AT_ANY_INTERVAL: Final = (
    "final_rotor_velocity",
    "contact_count",
    "peak_force",
    "mean_impulse",
    "total_impulse",
    "total_friction_impulse",
    "contact_time",
    "contact_duration",
    "stick_share",
    "restitution",
    "friction_share",
    "normal_loss_share",
)
"""Metrics that need no records but the last, so that none is taken where only these are asked for."""

USUAL: Final = (
    "final_rotor_velocity",
    "contact_count",
    "peak_force",
    "total_impulse",
    "total_friction_impulse",
    "contact_time",
    "stick_share",
    "friction_share",
    "normal_loss_share",
)
"""Metrics where none are named: those that cost next to nothing."""


@final
@dataclass(frozen=True)
class Wanted:
    """What is kept of every run.

    Args:
        metrics: keys of `contactlab.metrics.METRICS`.
        series: names of `contactlab.variables.SERIES`, kept whole.
    """

    metrics: tuple[str, ...] = USUAL
    series: tuple[str, ...] = ()

    @property
    def sampled(self) -> bool:
        """Whether more records than the last are needed."""
        return bool(self.series) or not set(self.metrics) <= set(AT_ANY_INTERVAL)

    def interval(self, setup: Setup) -> float:
        """Time between records [s]: as configured where any but the last are needed."""
        return setup.record_interval if self.sampled else setup.duration


def wanted_of(metrics: Iterable[str], series: Iterable[str]) -> Wanted:
    """What is kept, each once.

    Raises:
        ValueError: a name that is no metric or no series, or nothing at all.
    """
    asked = {"metric": dict.fromkeys(metrics), "series": dict.fromkeys(series)}
    known = {"metric": list(METRICS), "series": [variable.name for variable in SERIES]}
    for kind, names in asked.items():
        for name in names:
            if name not in known[kind]:
                hint = suggestion(name, known[kind], f"One is {known[kind][0]}.")
                raise ValueError(
                    f"There is no {kind} '{name}'; it must be one of {', '.join(known[kind])}. {hint}"
                )
    if not any(asked.values()):
        raise ValueError("Nothing is asked for; there must be one metric or series at least.")
    return Wanted(tuple(asked["metric"]), tuple(asked["series"]))


@final
@dataclass(frozen=True)
class Answers:
    """What some runs gave.

    Args:
        metrics: shape (run, metric); NaN where there is no number.
        status: codes of `Status`, shape (run,).
        reason: why a run is not complete, empty where it is; an unbalanced one has its numbers all the same.
        series: by name, shape (run, record); NaN where a run has none.
        time: of the records of the series [s].
    """

    metrics: Array
    status: NDArray[np.int8]
    reason: list[str]
    series: dict[str, Array]
    time: Array


SetupAt = Callable[[int], Setup]
"""What runs in a cell; it may raise a `ConfigurationError`, which makes the cell a refused one."""

Report = Callable[[int], None]
"""Told now and then how many runs have ended since the last time."""

BETWEEN_REPORTS: Final = 0.2
"""Seconds."""


def answers(
    setup_at: SetupAt,
    cells: Sequence[int],
    wanted: Wanted,
    report: Report | None = None,
) -> Answers:
    """Run some cells of a grid, one after the other.

    Args:
        setup_at: what runs in a cell.
        cells: their numbers.
        wanted: what is kept.
        report: hears of the progress.
    """
    workspace = Workspace()
    metrics = np.full((len(cells), len(wanted.metrics)), np.nan)
    status = np.zeros(len(cells), dtype=np.int8)
    reason = [""] * len(cells)
    kept: list[dict[str, Array]] = []
    time = np.empty(0)
    reported, last = 0, monotonic()
    for place, cell in enumerate(cells):
        run, code, sentence = _run(setup_at, cell, wanted, workspace, metrics[place])
        status[place], reason[place] = code, sentence
        if wanted.series:
            # A series alone, not the memory of all that the run has recorded.
            kept.append({} if run is None else {n: run.series[n].copy() for n in wanted.series})
            time = time if run is None else max(time, run.time, key=len)
        if report and (monotonic() - last > BETWEEN_REPORTS or place == len(cells) - 1):
            report(place + 1 - reported)
            reported, last = place + 1, monotonic()
    series = {name: _stacked(kept, name, time.size) for name in wanted.series}
    return Answers(metrics, status, reason, series, time)


def _run(
    setup_at: SetupAt, cell: int, wanted: Wanted, workspace: Workspace, metrics: Array
) -> tuple[Trajectory | None, Status, str]:
    """One run; its metrics go into `metrics` if it reached its end.

    Returns:
        The run if it reached its end, what became of it and why.
    """
    try:
        setup = setup_at(cell)
        run = simulate(
            setup.motor,
            setup.law,
            duration=setup.duration,
            record_interval=wanted.interval(setup),
            contact_step=setup.contact_step,
            tolerance=setup.tolerance,
            workspace=workspace,
        )
        if not run.ending.reached_end:
            return None, status_of(run.ending), run.message
        found = assess(Run.of_trajectory(run, setup.configuration), wanted.metrics)
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
    metrics[:] = [found[key] for key in wanted.metrics]
    return run, status_of(run.ending), run.message


def _stacked(kept: Sequence[dict[str, Array]], name: str, length: int) -> Array:
    """Series of one name, a row each; NaN where a run has none."""
    rows = np.full((len(kept), length), np.nan)
    for row, series in zip(rows, kept, strict=True):
        if series:
            row[: series[name].size] = series[name]
    return rows
