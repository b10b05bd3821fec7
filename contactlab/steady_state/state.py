"""A steady state and what it does on average: velocity, torque, forces, work, each with its error."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, final

import numpy as np
import pandas
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.engine.state import State
from contactlab.estimate import Estimate
from contactlab.motor import ModalState
from contactlab.motor.motor import lever_of
from contactlab.results.netcdf import REFERENCES
from contactlab.results.provenance import code_attributes
from contactlab.results.yaml_text import write_yaml
from contactlab.settling.statistics import mean_with_error
from contactlab.steady_state.period_map import (
    PeriodMap,
    contact_at_end,
    memory_at_end,
    period_of,
    variables_in,
)
from contactlab.steady_state.shooting import Orbit
from contactlab.trajectory import Trajectory

CUMULATIVE: Final = (
    "rotor_angle",
    "drive_work",
    "damping_loss",
    "friction_loss",
    "contact_loss",
    "load_work",
)
"""Series that add up, whose rate has a mean."""

OF_INTERVALS: Final = ("normal_force", "friction_force")
"""Series that are means of their record intervals."""


@final
@dataclass(frozen=True)
class Steady:
    """The steady state that a motor comes to.

        >>> import contactlab as cl
        >>> found = cl.steady(cl.build()).details
        >>> found
        <Steady: periodic, -2.19111 rad/s under hertz_penalty>
        >>> value, error = found.velocity
        >>> found.kind, round(value, 6), error < 1e-6
        ('periodic', -2.191106, True)
        >>> round(found.peak_force.value, 2), round(found.contact_share.value, 3)
        (8.71, 0.199)

    Args:
        setup: what moves, its load included.
        kind: 'periodic', 'quasi-periodic', 'chaotic', 'aperiodic' where the two are not told apart,
            'without contact', or 'standing' where a brake holds the rotor.
        periods: of the drive, after which a periodic motion repeats itself; 0 for another.
        motion: one orbit, or a long run recorded once a period.
        orbit: the closed orbit with its multipliers; None where there is none.
        warm_up: periods of the drive from the start until it was found.
        belt: velocity at which the rotor was held [rad/s]; None for one that is free.
        brake: torque of a load against whatever motion there is [N m]; None for another load.
        phase: of the drive where the motion begins [periods].
        reason: why there is no orbit, a sentence, where that is known.
    """

    setup: Setup
    kind: str
    periods: int
    motion: Trajectory
    orbit: Orbit | None
    warm_up: int
    belt: float | None = None
    brake: float | None = None
    phase: float = 0.0
    reason: str = ""

    def __repr__(self) -> str:
        return f"<Steady: {self.kind}, {self.velocity.text(digits=6)} rad/s under {self.setup.law.title}>"

    @property
    def period(self) -> float:
        """Period of the drive [s]."""
        return period_of(self.setup.motor.drive)

    @cached_property
    def closure(self) -> float:
        """Distance of what was found from a closed orbit, see `Orbit.closure` [1]."""
        return 0.0 if self.orbit is None else self.orbit.closure(self.orbit.map.end_of(self.motion))

    def mean(self, rates: Array) -> Estimate:
        """Return the mean of rates over the record intervals of the motion, and its error.

        That of an orbit is what its closure leaves; a motion that was run until it repeated itself has the
        range of its rates, another one its statistical error. What steps and tolerance do comes on top, see
        `contactlab.steady_state.converged`.
        """
        if self.orbit is not None or rates.size == 1:
            # An orbit closes: its mean has no other error than what is left of the closing.
            mean = float(rates.mean())
            return Estimate(mean, self.closure * abs(mean))
        if self.periods:
            # Whole repetitions, the last one for its value and all for the error.
            cycles = rates[rates.size % self.periods :].reshape(-1, self.periods).mean(axis=1)
            return Estimate(float(cycles[-1]), float(np.ptp(cycles)))
        return mean_with_error(rates)

    def average(self, name: str) -> Estimate:
        """Return the mean of a series over time, and its error.

        Args:
            name: a force, 'normal_force' [N]; or what adds up, whose rate is meant: 'rotor_angle' [rad/s],
                'drive_work', 'damping_loss', 'friction_loss', 'contact_loss', 'load_work' [W].

        Raises:
            ValueError: the series has values at its records alone, which say nothing of its mean.
        """
        if name in CUMULATIVE:
            mean, error = self.mean(self._rates(name))
            if self.orbit is not None and name != "rotor_angle" and mean != 0.0:
                # Energy flows of an orbit balance: each has the error of what flows in, if it flows.
                error = max(error, self.closure * abs(float(self._rates("drive_work").mean())))
            return Estimate(mean, error)
        if name in OF_INTERVALS:
            mean, error = self.mean(self.motion.series[name][1:])
            if name == "friction_force":
                # Forward and backward parts may cancel; each of them has its error.
                error = max(error, self.closure * self.average("normal_force").value)
            return Estimate(mean, error)
        raise ValueError(
            f"{name} has no mean here; it must be one of {', '.join((*OF_INTERVALS, *CUMULATIVE))}. Take the "
            "mean of another from `curves`."
        )

    def _rates(self, name: str) -> Array:
        """Return the rates of what adds up over the record intervals."""
        return np.diff(self.motion.series[name]) / np.diff(self.motion.time)

    @property
    def velocity(self) -> Estimate:
        """Mean rotor velocity and its error at this step [rad/s]; `contactlab.converged` adds the step's."""
        if self.belt is not None:
            return Estimate(self.belt, 0.0)
        mean = self.average("rotor_angle")
        return mean if self.orbit is None else self.orbit.velocity(mean.value, self.closure)

    @property
    def torque(self) -> Estimate:
        """Mean torque of the contact on the rotor, -R F, and its error [N m]; NaN of a flat contact."""
        radius, force = lever_of(self.setup.motor.geometry.rotor_radius), self.average("friction_force")
        return Estimate(-radius * force.value, radius * force.error)

    @property
    def impulse(self) -> Estimate:
        """Normal impulse of a period of the drive, and its error [N s]."""
        mean, error = self.average("normal_force")
        return Estimate(mean * self.period, error * self.period)

    @property
    def peak_force(self) -> Estimate:
        """Largest normal force of the motion and its error [N], infinite with impacts.

        No error is known of the largest force of a motion that does not repeat itself.
        """
        rows = self.motion.contacts_within
        peaks = rows["peak_normal_force"]
        largest = float(peaks.max(initial=0.0))
        if np.isinf(largest):
            return Estimate(largest, 0.0)
        if self.orbit is not None or not peaks.size:
            return Estimate(largest, self.closure * largest)
        if not self.periods:
            return Estimate(largest, np.nan)
        # The largest force of each repetition; their range is its error.
        passed = (rows["start_time"] - self.motion.time[0]) / (self.periods * self.period)
        cycles = pandas.Series(peaks).groupby(np.floor(passed)).max()
        return Estimate(largest, float(np.ptp(cycles)))

    @property
    def contact_share(self) -> Estimate:
        """Share of the time in which tip and rotor touch, and its error [1]."""
        rows = self.motion.contacts_within
        touched, lasted = rows["start_time"], rows["duration"]
        if not touched.size:
            return Estimate(0.0, 0.0)
        # The time in contact until an instant grows by one a second in contact, and rests in flight.
        edges = np.column_stack([touched, touched + lasted]).ravel()
        until = np.column_stack([np.cumsum(lasted) - lasted, np.cumsum(lasted)]).ravel()
        return self.mean(np.diff(np.interp(self.motion.time, edges, until)) / np.diff(self.motion.time))

    @property
    def end(self) -> tuple[float, ModalState, float, Array, State | None]:
        """Where another motion may go on, as `contactlab.steady_state.arrival.Start`."""
        # Periods since the section, without the round-off of the clock.
        passed = (self.motion.time[-1] - self.motion.time[0]) / self.period
        velocity, contact = float(self.motion.series["rotor_velocity"][-1]), contact_at_end(self.motion)
        memory = memory_at_end(self.motion, variables_in(self.motion.law, contact))
        return (self.phase + round(passed, 9)) % 1.0, self.motion.final, velocity, memory, contact

    @cached_property
    def once(self) -> PeriodMap:
        """The map of one period of the drive, whose section lies at the end of the motion."""
        phase, _, _, _, contact = self.end
        return PeriodMap(self.setup, phase, 1, self.belt, contact=contact)

    @property
    def final(self) -> Array:
        """The state of `once` at the end of the motion."""
        return self.once.state_of(*self.end[1:4])

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet multipliers, the largest first [1]; none where there is no orbit."""
        return np.empty(0, np.complex128) if self.orbit is None else self.orbit.multipliers

    @cached_property
    def energy(self) -> dict[str, float]:
        """Mean power that flows in, `drive_work`, and out, by name [W]; they balance in an orbit."""
        return {name: self.average(name).value for name in CUMULATIVE[1:]}

    @cached_property
    def impacts(self) -> dict[str, Array]:
        """The contacts within one orbit, or one period of the drive, a row each, as arrays by name.

        `phase` is that of the drive at their start [periods], as in `series`; `approach_velocity` [m/s],
        `normal_impulse`, `friction_impulse` [N s] and `duration` [s] are those of a run's contacts. A rigid
        impact has an impulse and no force.
        """
        run = self.curves(1)
        rows = run.contacts_within
        names = "approach_velocity", "normal_impulse", "friction_impulse", "duration"
        phase = self.phase + (rows["start_time"] - run.time[0]) / self.period
        return {"phase": phase} | {name: rows[name] for name in names}

    def series(self, records: int = 1000) -> dict[str, Array]:
        """Return the quantities of a run over one orbit, or one period of the drive, as arrays by name.

        `phase` is that of the drive [periods], ascending from `phase` of the state; `time` and the others
        have the units of a run. There are as many records as asked for, and the start.
        """
        run = self.curves(records)
        phase = self.phase + (run.time - run.time[0]) / self.period
        return {"phase": phase, "time": run.time, **run.series}

    def curves(self, records: int = 1000) -> Trajectory:
        """Return one orbit, or one period of the drive, finely recorded; its clock begins at `phase`."""
        if self.orbit is not None:
            return self.orbit.map.run(self.orbit.state, 1.0, records)
        return replace(self.once, periods=max(self.periods, 1)).run(self.final, 1.0, records)


def attributes_of(setup: Setup) -> dict[str, object]:
    """Return the global attributes of a dataset about a setup: law, configuration and code."""
    return {
        "references": f"{REFERENCES} Contact law: {setup.law.source}.",
        "law": setup.law.name,
        "configuration": write_yaml(setup.configuration),
        **code_attributes(),
    }


def flags(meaning: str, names: Sequence[str], first: int = 0) -> dict[str, object]:
    """Return the CF attributes of an enumerated quantity whose values begin with `first`."""
    values = np.arange(first, first + len(names), dtype=np.int8)
    return {"long_name": meaning, "flag_values": values, "flag_meanings": " ".join(names)}
