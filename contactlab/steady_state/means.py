"""What a law does once its motor has settled: the motion that is judged and drawn, and its means."""

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.metrics import Run, assess
from contactlab.settling.statistics import mean_with_error
from contactlab.steady_state import NotSettledError, Steady, steady

QUANTITIES: Final = ("rotor_velocity", "peak_force", "stick_share", "friction_share")
"""Metrics whose differences between settled motors are weighed."""

LONGEST: Final = 480
"""Periods of the drive after which a motion without an orbit has its means. Statistical errors of a
thousandth stand far below what laws differ by, and ten times the periods would take ten times as long."""

RECORDS: Final = 300  # of a period that is judged and drawn
DRAWN: Final = 16  # periods of a motion that does not repeat itself
FEWEST: Final = 16  # contacts whose scatter tells a statistical error


@final
@dataclass(frozen=True)
class Means:
    """The numbers of a steady state.

    Args:
        kind: as of `contactlab.Steady`.
        values: by `QUANTITIES`, SI; NaN where there is none, as the stick share of a motor without contact.
        errors: statistical ones, half the width of a 95 % interval; zero of a periodic motion.
    """

    kind: str
    values: Array
    errors: Array


def settled(setup: Setup) -> Steady:
    """Find the steady state that a setup comes to from its own start; errors as of `contactlab.steady`."""
    try:
        return steady(setup, longest=LONGEST)
    # A light contact takes its time.
    except NotSettledError:
        return steady(setup)


def means_of(state: Steady) -> Means:
    """Give the numbers of a steady state."""
    run = Run.of_trajectory(state.motion, state.setup.configuration)
    found = assess(run, QUANTITIES)
    velocity, error = state.velocity
    values = np.array([velocity, *(found[key] for key in QUANTITIES[1:])])
    # Without an orbit the mean is what it is of the contacts and periods that were seen.
    repeats = state.periods > 0 or not run.touches("duration")
    others = [0.0] * 3 if repeats else _statistical_errors(run, *values[2:])
    return Means(state.kind, values, np.array([error, *others]))


def _statistical_errors(run: Run, stick: float, friction: float) -> list[float]:
    """Give those of the largest force, between both halves of the run, and of the two ratios."""
    peaks, held = run.rows["peak_normal_force"], run.rows["duration"]
    middle = np.searchsorted(run.rows["start_time"], 0.5 * (run.time[0] + run.time[-1]))
    if held.size < FEWEST or not 0 < middle < held.size:
        return [np.nan] * 3
    work = np.diff(run.columns["drive_work"])
    # A ratio of means moves by what its numerator is off it, over the mean of its denominator.
    off = run.rows["stick_duration"] - stick * held
    lost = np.diff(run.columns["friction_loss"]) - friction * work
    pairs = ((off, held), (lost, work))
    halves = abs(float(peaks[:middle].max() - peaks[middle:].max()))
    return [halves, *(mean_with_error(part)[1] / abs(float(whole.mean())) for part, whole in pairs)]


def motion_of(state: Steady) -> Run:
    """Give the settled motion with records that a contact can be seen in: one orbit, or some periods."""
    if state.orbit is not None:
        section, z = state.orbit.map, state.orbit.state
        # A quarter of four is what metrics of the last periods take.
        trajectory = section.run(z, 1 if state.periods == 1 else 4, RECORDS * state.periods)
    else:
        before, period = state.motion, 1.0 / float(state.setup.motor.drive.frequency[0])
        # It goes on where it ended, which may be in contact.
        trajectory = replace(state.setup, motor=before.motor).run(
            duration=DRAWN * period, record_interval=period / RECORDS, start=before.state
        )
    return Run.of_trajectory(trajectory, state.setup.configuration)
