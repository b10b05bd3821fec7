"""Means of a steady state with their statistical errors, and its motion in records that resolve a contact."""

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.metrics import Run, assess
from contactlab.settling.statistics import mean_with_error
from contactlab.steady_state.arrival import NotSettledError
from contactlab.steady_state.search import steady
from contactlab.steady_state.state import Steady
from contactlab.trajectory import Trajectory

QUANTITIES: Final = ("rotor_velocity", "peak_force", "stick_share", "friction_share")
"""Metrics of a steady state."""

LONGEST: Final = 480
"""Run without an orbit [periods of the drive], whose second half is averaged. Statistical errors of a
thousandth are far below the differences of laws; ten times the periods would take ten times as long."""

RECORDS: Final = 300
"""Records in a period of the drive."""

APERIODIC: Final = 16
"""Periods of the drive of an aperiodic motion."""

FEWEST: Final = 16
"""Smallest number of contacts whose scatter gives a statistical error."""


@final
@dataclass(frozen=True)
class Means:
    """The numbers of a steady state.

    Args:
        kind: as of `contactlab.Steady`.
        values: by `QUANTITIES`, SI; NaN where there is none, as the stick share of a motor without contact.
        errors: statistical, half the width of a 95 % interval; zero for a periodic motion.
    """

    kind: str
    values: Array
    errors: Array


def settled(setup: Setup) -> Steady:
    """Compute the steady state that a setup reaches from its own start; errors as of `contactlab.steady`."""
    return settled_soon(setup)[0]


def settled_soon(setup: Setup) -> tuple[Steady, bool]:
    """Compute the steady state of `settled`, and return whether it was reached within `LONGEST`."""
    try:
        return steady(setup, longest=LONGEST), True
    # A light contact takes its time.
    except NotSettledError:
        return steady(setup), False


def means_of(state: Steady) -> Means:
    """Return the numbers of a steady state."""
    run = Run.of_trajectory(state.motion, state.setup.configuration)
    metrics = assess(run, QUANTITIES)
    velocity, error = state.velocity
    # The velocity as of the steady state, with its error; the others are metrics of its motion.
    values = np.array([velocity, *(metrics[key] for key in QUANTITIES[1:])])
    # Without an orbit the mean is that of the contacts and periods of the run.
    repeats = state.periods > 0 or not run.touches("duration")
    others = [0.0] * 3 if repeats else _statistical_errors(run, *values[2:])
    return Means(state.kind, values, np.array([error, *others]))


def _statistical_errors(run: Run, stick: float, friction: float) -> list[float]:
    """Return those of the largest force, between both halves of the run, and of the two ratios."""
    peaks, durations = run.rows["peak_normal_force"], run.rows["duration"]
    # The largest force of either half of the run; too few contacts show no scatter.
    middle = np.searchsorted(run.rows["start_time"], 0.5 * (run.time[0] + run.time[-1]))
    if durations.size < FEWEST or not 0 < middle < durations.size:
        return [np.nan] * 3
    work = np.diff(run.columns["drive_work"])
    # A ratio of means moves by the deviation of its numerator, over the mean of its denominator.
    deviation = run.rows["stick_duration"] - stick * durations
    lost = np.diff(run.columns["friction_loss"]) - friction * work
    pairs = ((deviation, float(durations.mean())), (lost, float(work.mean())))
    before, after = float(peaks[:middle].max()), float(peaks[middle:].max())
    halves = abs(before - after) if before != after else 0.0
    # Where impacts take no time there is no share of it.
    return [halves, *(mean_with_error(part)[1] / abs(mean) if mean else np.nan for part, mean in pairs)]


def motion_of(state: Steady) -> Trajectory:
    """Return the settled motion in `RECORDS` a period: one orbit, or some periods of another motion."""
    if state.orbit is not None:
        section, z = state.orbit.map, state.orbit.state
        # A quarter of four is what metrics of the last periods take.
        return section.run(z, 1 if state.periods == 1 else 4, RECORDS * state.periods)
    before, period = state.motion, 1.0 / float(state.setup.motor.drive.frequency[0])
    # It goes on where it ended, which may be in contact.
    return replace(state.setup, motor=before.motor).run(
        duration=APERIODIC * period, record_interval=period / RECORDS, start=before.state
    )
