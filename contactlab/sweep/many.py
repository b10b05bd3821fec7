"""Many runs in one go: what became of each, and the metrics that were asked for.

One run follows the other and is handed what like motors have in common; its numbers are the same to the
last bit wherever and after whatever it runs.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from time import monotonic
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.config import ConfigurationError, Setup
from contactlab.engine import simulate
from contactlab.engine.workspace import Workspace
from contactlab.laws import LawError
from contactlab.plausibility import Record, assess
from contactlab.sweep.status import Status, status_of
from contactlab.trajectory import Trajectory

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
        metrics: keys of `contactlab.plausibility.METRICS`.
        series: names of `contactlab.variables.SERIES`, kept whole.
    """

    metrics: tuple[str, ...] = USUAL
    series: tuple[str, ...] = ()

    def interval(self, setup: Setup) -> float:
        """Time between records [s]: as configured where any but the last are needed."""
        sampled = self.series or not set(self.metrics) <= set(AT_ANY_INTERVAL)
        return setup.record_interval if sampled else setup.duration


@final
@dataclass(frozen=True)
class Answers:
    """What some runs gave.

    Args:
        metrics: shape (run, metric); NaN where there is no number.
        status: codes of `Status`, shape (run,).
        reason: why a run is not complete, empty where it is.
        series: by name, shape (run, record); NaN beyond the records that a run has.
    """

    metrics: Array
    status: NDArray[np.int8]
    reason: list[str]
    series: dict[str, Array]


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
    reported, last = 0, monotonic()
    for place, cell in enumerate(cells):
        run, code, sentence = _run(setup_at, cell, wanted, workspace, metrics[place])
        status[place], reason[place] = code, sentence
        if wanted.series:
            kept.append({} if run is None else {name: run.series[name] for name in wanted.series})
        if report and (monotonic() - last > BETWEEN_REPORTS or place == len(cells) - 1):
            report(place + 1 - reported)
            reported, last = place + 1, monotonic()
    return Answers(metrics, status, reason, {name: _stacked(kept, name) for name in wanted.series})


def _run(
    setup_at: SetupAt, cell: int, wanted: Wanted, workspace: Workspace, metrics: Array
) -> tuple[Trajectory | None, Status, str]:
    """One run; its metrics go into `metrics` if it is complete.

    Returns:
        The run if it is complete, what became of it and why.
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
        if not run.complete:
            return None, status_of(run.ending), run.message
        found = assess(Record.of_trajectory(run, setup.configuration), wanted.metrics)
    except ConfigurationError as error:
        return None, Status.REFUSED, " ".join(error.faults)
    except LawError as error:
        return None, Status.FAILED, str(error)
    # The others shall not suffer from what one of ten thousand runs into.
    except Exception as error:
        return None, Status.FAILED, f"The run ended in {type(error).__name__}: {error}"
    metrics[:] = [found[key] for key in wanted.metrics]
    return run, Status.COMPLETE, ""


def _stacked(kept: list[dict[str, Array]], name: str) -> Array:
    """Series of one name, a row each, NaN where a run has none or is shorter."""
    length = max((part[name].size for part in kept if part), default=0)
    rows = np.full((len(kept), length), np.nan)
    for row, part in zip(rows, kept, strict=True):
        if part:
            row[: part[name].size] = part[name]
    return rows
