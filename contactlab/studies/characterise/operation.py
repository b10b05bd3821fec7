"""One operating point: the steady state at a prescribed or a free rotor speed, and its numbers."""

from dataclasses import dataclass, field, replace
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.estimate import Estimate
from contactlab.motor.outputs import dielectric_loss
from contactlab.settling.statistics import mean_with_error
from contactlab.steady_state import BrokenOffError, NotSettledError, converged
from contactlab.steady_state.period_map import PeriodMap
from contactlab.steady_state.state import Steady
from contactlab.trajectory import Trajectory

UNKNOWN: Final = Estimate(np.nan, np.nan)

AVERAGED: Final = 160
"""Periods over which an aperiodic motion is averaged."""

OF_ORBIT, OF_OTHERS = 512, 128
"""Records in a period of an orbit, and of another motion."""

LONGEST: Final = (480, 4000)
"""Periods of the drive after which an aperiodic motion is averaged; the second if it still drifts by then."""

GROWS: Final = 1.5
"""Ratio of successive changes above which a number is reported as divergent under step refinement (1/h gives
2)."""

ROUND_OFF: Final = 1e-12
"""Relative error of the energy balance of a motion that is no orbit."""

NOTABLE: Final = 0.1
"""Last of these changes over the number, below which it does not count as growth."""


@final
@dataclass(frozen=True)
class Point:
    """An operating point.

    Args:
        belt: prescribed rotor speed [rad/s], in the model's sense; None for a free rotor.
        kind: as of `Steady`; 'periodic at some steps', or 'none' where a run breaks off.
        numbers: every quantity of `sheet.POINT`.
        message: why there is none.
        run: whole periods of it at the finest step.
    """

    belt: float | None
    kind: str
    numbers: dict[str, Estimate] = field(default_factory=dict)
    message: str = ""
    run: Trajectory | None = None

    def __getitem__(self, name: str) -> Estimate:
        return self.numbers.get(name, UNKNOWN)

    def value(self, name: str) -> float:
        """Return the value of a quantity."""
        return self[name].value

    def turned(self, sense: float) -> "Point":
        """Return the point with velocity and torque in the other sense, if that is negative."""
        signed = {
            name: self[name]._replace(value=sense * self.value(name)) for name in ("velocity", "torque")
        }
        return replace(self, numbers=self.numbers and self.numbers | signed)


def operate(setup: Setup, belt: float | None = None) -> Point:
    """Compute the steady state at an operating point at three steps, and its numbers at the finest.

    Args:
        setup: motor and law; its contact step or tolerance is the coarsest.
        belt: prescribed rotor speed [rad/s]; None for a free rotor.
    """
    short, long = LONGEST
    try:
        try:
            result = converged(setup, belt=belt, longest=short)
        except NotSettledError:
            result = converged(setup, belt=belt, longest=long)
        recorded = [Periods.of(each) for each in result.steps]
    except (BrokenOffError, NotSettledError) as error:
        return Point(belt, "none", message=str(error))
    steps = [periods.numbers() for periods in recorded]
    kinds = {each.kind for each in result.steps}
    kind = result.best.kind if len(kinds) == 1 or "periodic" not in kinds else "periodic at some steps"

    def limit(name: str) -> Estimate:
        numbers, statistical = np.transpose([each[name] for each in steps])
        value, error = result.refinement.estimate(numbers, statistical)
        if np.isinf(value):
            return Estimate(value, np.inf)
        before, last = np.diff(np.abs(numbers))
        diverges = last > GROWS * before > 0.0
        threshold = NOTABLE * abs(value) + statistical[-1]
        return Estimate(value, np.inf if diverges and last > threshold else error)

    numbers = {name: limit(name) for name in steps[-1]}
    return Point(belt, kind, numbers, run=recorded[-1].run)


@final
@dataclass(frozen=True)
class Periods:
    """Whole periods of a settled motor, one orbit or many.

    Args:
        section: whose period it is; the rotor speed is prescribed, or free.
        run: from the section on.
        records: in each period.
        closure: distance of the run from a closed orbit [1]; None for many periods of another motion.
    """

    section: PeriodMap
    run: Trajectory
    records: int
    closure: float | None

    @classmethod
    def of(cls, state: Steady) -> "Periods":
        """Record a steady state finely: its orbit, or many periods from its end on."""
        if (orbit := state.orbit) is not None:
            return cls(orbit.map, orbit.map.run(orbit.state, 1, OF_ORBIT), OF_ORBIT, state.closure)
        section = state.once
        return cls(section, section.run(state.final, AVERAGED, OF_OTHERS), OF_OTHERS, None)

    def numbers(self) -> dict[str, Estimate]:
        """Return every quantity of `sheet.POINT`, velocity and torque in the model's sense."""
        belt, series, contacts = self.section.belt, self.run.series, self.run.contacts
        radius, viscous = self.run.motor.geometry.rotor_radius, self.section.setup.motor.rotor.damping
        drive = self._rate("drive_work")
        # Energy flows of an orbit balance: each has the error of what flows in.
        flow = (self.closure or 0.0) * abs(drive.value)
        friction, contact, damping = (
            _at_least(flow, self._rate(name)) for name in ("friction_loss", "contact_loss", "damping_loss")
        )
        speed = self._rate("rotor_angle") if belt is None else Estimate(belt, 0.0)
        pushes = -radius * series["friction_force"][1:]
        push = self._mean(pushes if self.closure is not None else self._by_period(pushes).mean(axis=1))
        # Forward and backward parts may cancel; each of them has its error.
        push = _at_least((self.closure or 0.0) * radius * float(series["normal_force"][1:].mean()), push)
        torque = Estimate(push.value - viscous * speed.value, push.error + viscous * speed.error)
        output = Estimate(torque.value * speed.value, torque.error * abs(speed.value))
        if belt is None:
            load = self.section.setup.motor.rotor.load_torque
            output = Estimate(load * speed.value, abs(load) * speed.error)
        else:
            damping = Estimate(damping.value + viscous * speed.value**2, damping.error)
        slip = np.abs(series["slip_velocity"][1:]) * (self.run.contact_mode[1:] != 0)
        ripple = float(np.ptp(series["rotor_velocity"])) if belt is None else 0.0
        coarser = float(np.ptp(series["rotor_velocity"][::2])) if ripple else 0.0
        share, stick = self._share("duration"), self._share("stick_duration")
        spent = output.value + damping.value + friction.value + contact.value + self._stored
        # The two halves of many periods show the error of the peak; one contact may last for all of them.
        peaks = contacts["peak_normal_force"] if contacts["duration"].size > 1 else series["normal_force"][1:]
        halves = [float(x.max(initial=0.0)) for x in np.array_split(peaks, 2)]
        return {
            "velocity": speed,
            "velocity_ripple": Estimate(ripple, 0.5 * abs(ripple - coarser)),
            "torque": torque,
            "output_power": output,
            "drive_power": drive,
            "damping_power": damping,
            "friction_power": friction,
            "contact_power": contact,
            "balance": Estimate(drive.value - spent, (self.closure or ROUND_OFF) * abs(drive.value)),
            **self._electrical(drive, output),
            "peak_force": Estimate(
                float(contacts["peak_normal_force"].max(initial=0.0)),
                0.0 if self.closure is not None or halves[0] == halves[1] else abs(halves[1] - halves[0]),
            ),
            "contact_share": share,
            "stick_share": ratio(stick, share),
            "friction_work_per_slip": ratio(friction, self._sampled(slip)),
            "friction_work_per_travel": ratio(
                friction, Estimate(radius * abs(speed.value), radius * speed.error)
            ),
        }

    def _by_period(self, values: Array) -> Array:
        return values.reshape(-1, self.records)

    def _mean(self, values: Array) -> Estimate:
        """Return the mean of a value for each period."""
        if self.closure is not None:
            return Estimate(float(values.mean()), self.closure * float(np.abs(values).mean()))
        return mean_with_error(values)

    def _rate(self, name: str) -> Estimate:
        """Return the mean rate at which a series grows."""
        return self._mean(np.diff(self.run.series[name][:: self.records]) / self.section.period)

    def _sampled(self, values: Array) -> Estimate:
        """Return the mean over all records; its error includes the change with half as many records."""
        every = self._by_period(values)
        value, error = self._mean(every.mean(axis=1))
        return Estimate(value, error + abs(float(every[:, 1::2].mean()) - value))

    def _share(self, name: str) -> Estimate:
        """Return the share of the time that a duration of the contacts has; a long one is spread."""
        contacts = self.run.contacts
        starts, sums = contacts["start_time"], np.cumsum(contacts[name])
        times = np.column_stack([starts, starts + contacts["duration"]]).ravel()
        reached = np.column_stack([np.append(0.0, sums[:-1])[: sums.size], sums]).ravel()
        count = (self.run.time.size - 1) // self.records
        edges = self.section.period * np.arange(count + 1)
        seconds = np.diff(np.interp(edges, times, reached)) if times.size else np.zeros(count)
        return self._mean(seconds / self.section.period)

    @property
    def _stored(self) -> float:
        """Power that resonator, free rotor, contact and preload store."""
        run, motor, before = self.run, self.run.motor, self.run.motor.start
        assert before is not None
        moved = run.final.displacement - before.displacement
        lifted = 0.0 if motor.preload is None else float(motor.preload @ moved)
        kept = [run.series[name][[0, -1]] for name in ("strain_energy", "contact_energy")]
        turns = motor.rotor.inertia * run.series["rotor_velocity"][[0, -1]] ** 2
        swings = np.array([each.velocity @ each.velocity for each in (before, run.final)])
        energy = sum(kept) + 0.5 * (swings + (turns if self.section.belt is None else 0.0))
        return float((np.diff(energy)[0] - lifted) / run.duration)

    def _electrical(self, drive: Estimate, output: Estimate) -> dict[str, Estimate]:
        """Return the electrical input, and the efficiencies where there is an output."""
        dielectric = dielectric_loss(self.run.motor)
        active = Estimate(drive.value + dielectric, drive.error)
        squares = [self._sampled(each[1:] ** 2) for each in self.run.currents]
        volts = np.sqrt(np.mean(self.run.motor.drive.voltage(self.run.time[1:]) ** 2, axis=1)).tolist()
        apparent = Estimate(*(float(np.dot(volts, part)) for part in zip(*map(_root, squares), strict=True)))
        useful = output if output.value > 0.0 else UNKNOWN
        return {
            "dielectric_power": Estimate(dielectric, 0.0),
            "active_power": active,
            "apparent_power": apparent,
            "power_factor": ratio(active, apparent),
            "rms_voltage": Estimate(float(np.sqrt(np.mean(np.square(volts)))), 0.0),
            "rms_current": _root(
                Estimate(0.5 * sum(x.value for x in squares), 0.5 * sum(x.error for x in squares))
            ),
            "mechanical_efficiency": ratio(useful, drive),
            "electrical_efficiency": ratio(useful, active),
        }


def _at_least(error: float, number: Estimate) -> Estimate:
    """Return a number with an error of at least some size; an exact zero as it is."""
    return Estimate(number.value, max(number.error, error)) if number.value else number


def ratio(above: Estimate, below: Estimate) -> Estimate:
    """Divide two numbers with their errors; NaN where the denominator is not positive."""
    if not below.value > 0.0:
        return UNKNOWN
    value = above.value / below.value
    return Estimate(value, (above.error + abs(value) * below.error) / below.value)


def _root(square: Estimate) -> Estimate:
    value = float(np.sqrt(square.value))
    return Estimate(value, 0.5 * square.error / value if value else 0.0)
