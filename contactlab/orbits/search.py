"""What a motor does when it has settled: a periodic motion, or one that only has means."""

from dataclasses import dataclass, replace
from math import ceil
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.laws import ContactLaw
from contactlab.motor import Motor
from contactlab.orbits.period_map import BrokenOffError, PeriodMap
from contactlab.orbits.shooting import NoOrbitError, Orbit, orbit_from
from contactlab.settling.statistics import chaos_indicator, mean_with_error, repeats_after
from contactlab.simulation import setup_of
from contactlab.trajectory import Trajectory

WARM_UP: Final = 30
"""Periods of the drive before an orbit is first looked for; what a resonator starts with has died down."""

LONGEST: Final = 4000
"""Periods after which a motion without an orbit has its means."""

RECORDS: Final = 200
"""Of a period, in which the section is chosen."""

SHORTEST_FLIGHT: Final = 0.02
"""Part of a period in free flight, below which there is no section."""

NEARER: Final = 0.8
"""Share of its distance from an orbit that a motion on its way there has left after a settling time; e^-1
where the slowest multiplier alone acts."""

REPEATS: Final = 1e-3
"""Relative difference of states at which a motion is taken for one that repeats itself."""

REGULAR: Final = 0.2
CHAOTIC: Final = 0.8
"""Values of the 0-1 test that tell them apart; between them is no telling."""


@final
@dataclass(frozen=True)
class Steady:
    """The steady state that a motor comes to.

    Args:
        setup: what moves.
        kind: 'periodic', 'quasi-periodic', 'chaotic', 'irregular' where the two cannot be told apart, or
            'without contact'.
        periods: of the drive, after which a periodic motion repeats itself; 0 for another.
        motion: one orbit, or the second half of the long run.
        orbit: the closed orbit; None where there is none.
        warm_up: periods of the drive from the start until it was found.
    """

    setup: Setup
    kind: str
    periods: int
    motion: Trajectory
    orbit: Orbit | None
    warm_up: int
    belt: float | None = None

    def mean(self, rates: Array) -> tuple[float, float]:
        """Give the mean of rates over the record intervals of the motion, and its error."""
        if self.orbit is not None:
            return float(rates.mean()), 0.0
        return mean_with_error(rates)

    @property
    def velocity(self) -> tuple[float, float]:
        """Mean rotor velocity and its statistical error [rad/s]."""
        return self.mean(np.diff(self.motion.series["rotor_angle"]) / np.diff(self.motion.time))

    @property
    def torque(self) -> tuple[float, float]:
        """Mean torque of the contact on the rotor, -R F, and its statistical error [N m]."""
        radius = self.setup.motor.geometry.rotor_radius
        return self.mean(-radius * self.motion.series["friction_force"][1:])


def steady(
    motor: Motor | Setup,
    law: ContactLaw | None = None,
    *,
    belt: float | None = None,
    contact_step: float | None = None,
    tolerance: float | None = None,
    longest: int = LONGEST,
) -> Steady:
    """Find the steady state that a motor comes to from its start.

    The motor runs for some periods; then Newton's method looks for the periodic orbit next to where it is,
    in `contactlab.orbits.shooting`. An orbit counts if it is stable and the motor is on its way to it; if
    not, the motor runs on, for three times as long as before, and so on. A motor that has come to no orbit
    after the longest run has the means of that run's second half.

    Args:
        motor: what moves, or a whole setup.
        law: what acts between tip and rotor; a setup has its own.
        belt: velocity at which the rotor is held [rad/s]; None for one that is free.
        contact_step, tolerance: as of `contactlab.simulate`.
        longest: run without an orbit [periods of the drive].

    Raises:
        NoPeriodError: the drive does not repeat itself.
        BrokenOffError: a run broke off.
        KeyboardInterrupt: as it comes.
    """
    if isinstance(motor, Setup):
        setup = motor
    else:
        given = {"contact_step": contact_step, "tolerance": tolerance, "duration": 1.0}
        setup = setup_of(motor, law, {k: v for k, v in given.items() if v is not None})
    clock = PeriodMap(setup, belt=belt)
    modes = setup.motor.modes.stiffness.size
    start = setup.motor.start
    z = np.zeros(2 * modes + (belt is None))
    if start is not None:
        z[: 2 * modes] = np.concatenate([clock.scale * start.displacement, start.velocity])
    if belt is None:
        z[-1] = np.sqrt(setup.motor.rotor.inertia) * setup.motor.rotor.initial_velocity
    done, more = 0, WARM_UP
    while done < longest:
        run = clock.run(z, more, RECORDS if more == WARM_UP else 1)
        z, done = clock.end_of(run), done + more
        last = clock.run(z, 1, RECORDS)
        if (
            not last.contacts["start_time"].size
            and run.contacts["start_time"][-1:].sum() < 0.5 * run.duration
        ):
            return Steady(setup, "without contact", 1, last, None, done, belt)
        phase = _section_of(last)
        if phase is not None:
            count = max(1, repeats_after(_strobes(run), REPEATS)) if more > WARM_UP else 1
            section = replace(clock.at(phase), periods=count)
            at_section = section.end_of(clock.run(z, phase)) if phase else z
            if (orbit := _orbit(section, at_section)) is not None:
                return Steady(setup, "periodic", count, section.run(orbit.state, 1, 1), orbit, done, belt)
        more = 3 * done
    late = clock.run(z, longest // 2, 1)
    indicator = chaos_indicator(late.series["slip_velocity"][1:])
    kind = "quasi-periodic" if indicator < REGULAR else "chaotic" if indicator > CHAOTIC else "irregular"
    return Steady(setup, kind, 0, late, None, done, belt)


def _orbit(section: PeriodMap, z: Array) -> Orbit | None:
    """Find the stable orbit near a state to which the motor is on its way."""
    try:
        orbit = orbit_from(section, z)
        if not orbit.stable:
            return None
        times = min(max(ceil(orbit.settling_time / section.period), 1), 200)
        later = section.end_of(section.run(z, times))
    except (NoOrbitError, BrokenOffError):
        return None
    before, after = (float(np.linalg.norm(state - orbit.state)) for state in (z, later))
    near = after <= max(NEARER * before, 1e-8 * float(np.linalg.norm(z)))
    return orbit if near else None


def _section_of(period: Trajectory) -> float | None:
    """Choose the middle of the longest free flight of a period, as a part of it; None where there is none."""
    free = period.contact_mode[1:] == 0
    if free.all():
        return 0.0
    count = free.size
    # The flight may last over the end.
    touched = np.flatnonzero(~free)
    gaps = np.diff(np.append(touched, touched[0] + count))
    longest = int(gaps.argmax())
    if gaps[longest] - 1 < SHORTEST_FLIGHT * count:
        return None
    return float(((touched[longest] + 1 + gaps[longest] // 2) % count) / count)


def _strobes(run: Trajectory) -> Array:
    """Give what is recorded of the state once a period, shape (period, quantity)."""
    names = ("tip_normal_displacement", "tip_slope", "slip_velocity", "rotor_velocity")
    return np.column_stack([run.series[name][1:] for name in names])
