"""Run a motor until it has settled, in stretches that each continue from the state of the one before."""

from collections.abc import Callable
from itertools import count
from math import ceil
from typing import Any, Final

from contactlab.checks import ON_GRID
from contactlab.engine.simulation import simulate
from contactlab.engine.state import State
from contactlab.laws import ContactLaw
from contactlab.motor import Motor
from contactlab.motor.drive import period_of
from contactlab.settling.criterion import PRECISION, check_until_steady
from contactlab.settling.statistics import LEAST_VALUES
from contactlab.settling.verdict import SETTLED, settling_of
from contactlab.trajectory import Trajectory

GROWTH: Final = 1.25
"""Factor between the times at which convergence is checked."""


def simulate_until_steady(
    motor: Motor,
    law: ContactLaw,
    *,
    duration: float,
    record_interval: float,
    precision: float = PRECISION,
    progress: Callable[[float], None] | None = None,
    start: State | None = None,
    **others: Any,
) -> Trajectory:
    """Simulate as `contactlab.engine.simulate` does, until the motor has settled, at most for the duration.

    It has settled once the relative error of mean velocity and internal variables is within the precision,
    see `contactlab.settling.verdict.Settling.share`. The run ends on a record and is the run over all the
    duration up to there, bit for bit.

    Raises:
        ValueError: as of `contactlab.engine.simulate` and of `check_until_steady`.
    """
    check_until_steady(motor.drive, record_interval)
    period = period_of(motor.drive)
    begin = float(start["end"]) if start else 0.0
    run, check = None, (LEAST_VALUES + 2) * period
    while True:
        done = float(start["end"]) - begin if start else 0.0
        # A last stretch shorter than a step is avoided.
        last = GROWTH * check >= duration
        ahead = duration - done if last else _to_record(start, record_interval, begin + check)
        # Compilation is reported as the time zero, once.
        later = progress and (lambda time: progress(time) if time > 0.0 else None)
        piece = simulate(
            motor,
            law,
            duration=ahead,
            record_interval=min(record_interval, ahead),
            progress=progress if run is None else later,
            start=start,
            **others,
        )
        run = piece if run is None else run.followed_by(piece)
        start = piece.state
        if last or not piece.ending.reached_end:
            return run
        settling = settling_of({**run.series, "time": run.time}, run.contacts, period, run.lasting)
        if settling.verdict == SETTLED and settling.share <= precision:
            return run
        check *= GROWTH


def _to_record(start: State | None, interval: float, until: float) -> float:
    """Return the duration of a run that ends on the first record after a time, to the last bit."""
    now, origin = (float(start["end"]), float(start["origin"])) if start else (0.0, 0.0)
    if start and abs(now - (origin + round((now - origin) / interval) * interval)) > ON_GRID * interval:
        origin = now
    ends = (origin + number * interval for number in count(ceil((until - origin) / interval)))
    return next(end - now for end in ends if now + (end - now) == end)
