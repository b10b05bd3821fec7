"""What runs will cost in time, from a trial of the first periods of some of them, told before they start."""

import sys
from collections.abc import Sequence
from contextlib import suppress
from time import perf_counter
from typing import Final

from tqdm import tqdm

from contactlab.cli.terminal import tell
from contactlab.config import Setup
from contactlab.engine import simulate
from contactlab.laws.declaration import LawError
from contactlab.trajectory import Ending

LONG: Final = 60.0
"""Wall time that one wants to know of beforehand [s]."""

TRIAL_PERIODS, TRIAL = 30, 0.5
"""Periods of the first tone that a trial takes, and wall time after which it ends [s]."""

TRIALS: Final = 3
"""Runs of a sweep that are tried."""


def announce_time(setups: Sequence[Setup], runs: int = 1, workers: int = 1) -> None:
    """Say how long runs will take, if that is long, from a trial of some of them."""
    if not setups:
        return
    seconds = runs * sum(map(wall_time_of, setups)) / len(setups)
    alike = min(workers, runs)
    if seconds / alike < LONG:
        return
    what = "The run" if runs == 1 else f"The {runs} runs"
    said = f"{what} will take about {_spelled(seconds / alike)} or more"
    if alike > 1:
        said += f" on {alike} processors"
    tell(
        f"{said}, by a trial of {TRIAL_PERIODS} periods or {TRIAL:g} s. A shorter solver.duration takes "
        "less, and so do a longer solver.contact_step and slower tones and modes.",
        sys.stderr,
    )


def wall_time_of(setup: Setup) -> float:
    """Estimate the wall time of a run [s] from its first periods; zero where they tell of nothing."""
    began, spent, came = perf_counter(), 0.0, 0.0

    def watch(time: float) -> None:
        nonlocal began, spent, came
        if time == 0.0:
            # Before, there was the compiler.
            began = perf_counter()
        spent, came = perf_counter() - began, time
        if spent > TRIAL:
            raise KeyboardInterrupt

    tones = setup.motor.drive.frequency
    duration = min(setup.duration, TRIAL_PERIODS / tones[0]) if tones.size else setup.duration
    # What is wrong with a run, it says itself.
    with suppress(ValueError, LawError):
        trial = simulate(
            setup.motor,
            setup.law,
            duration=duration,
            record_interval=duration,
            contact_step=setup.contact_step,
            tolerance=setup.tolerance,
            progress=watch,
        )
        if trial.ending is Ending.INTERRUPTED and spent <= TRIAL:
            raise KeyboardInterrupt(trial.message)
    return spent * setup.duration / came if came > 0.0 else 0.0


def _spelled(seconds: float) -> str:
    return (
        f"{seconds / 86400.0:.2g} days" if seconds > 2.0 * 86400.0 else tqdm.format_interval(round(seconds))
    )
