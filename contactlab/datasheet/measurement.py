"""What is measured of whole periods of a settled motor: powers, forces, currents, each with its error."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.datasheet.electrodes import currents, dielectric_loss
from contactlab.settling.statistics import mean_with_error
from contactlab.steady_state.period_map import PeriodMap
from contactlab.steady_state.state import Steady
from contactlab.trajectory import Trajectory

Number = tuple[float, float]
"""A value and its error, half the width of a 95 % interval where it is statistical."""

UNKNOWN: Final = (np.nan, np.nan)

MEASURED: Final = 160
"""Periods over which the means of a motion without an orbit are taken."""

RECORDS: Final = {True: 512, False: 128}
"""Of a period of an orbit, and of another motion."""


@final
@dataclass(frozen=True)
class Measurement:
    """Whole periods of a settled motor, one orbit or many.

    Args:
        section: whose period it is; the rotor is on its belt, or free.
        run: from the section on.
        records: in each period.
        closure: distance of the run from a closed orbit [1]; None for many periods of another motion.
    """

    section: PeriodMap
    run: Trajectory
    records: int
    closure: float | None

    @classmethod
    def of(cls, found: Steady) -> "Measurement":
        """Record a steady state finely: its orbit, or many periods from where it is."""
        if (orbit := found.orbit) is not None:
            records = RECORDS[True]
            return cls(orbit.map, orbit.map.run(orbit.state, 1, records), records, found.closure)
        phase, modal, velocity, memory = found.end
        section, records = PeriodMap(found.setup, phase, belt=found.belt), RECORDS[False]
        run = section.run(section.state_of(modal, velocity, memory), MEASURED, records)
        return cls(section, run, records, None)

    def numbers(self) -> dict[str, Number]:
        """Return every quantity of `quantities.POINT`, velocity and torque in the model's sense."""
        speed, torque, output = self._shaft()
        drive, friction, contact = map(self._rate, ("drive_work", "friction_loss", "contact_loss"))
        damping = self._rate("damping_loss")
        if self.section.belt is not None:
            damping = damping[0] + self._rotor_damping * speed[0] ** 2, damping[1]
        slip = np.abs(self.run.series["slip_velocity"][1:]) * (self.run.contact_mode[1:] != 0)
        velocities = self.run.series["rotor_velocity"]
        ripple = float(np.ptp(velocities)) if self.section.belt is None else 0.0
        share, stick = (self._mean(self._summed(n) / self._period) for n in ("duration", "stick_duration"))
        spent = output[0] + damping[0] + friction[0] + contact[0] + self._stored
        radius = self.run.motor.geometry.rotor_radius
        return {
            "velocity": speed,
            "velocity_ripple": (
                ripple,
                0.5 * abs(ripple - float(np.ptp(velocities[::2])) if ripple else 0.0),
            ),
            "torque": torque,
            "output_power": output,
            "drive_power": drive,
            "damping_power": damping,
            "friction_power": friction,
            "contact_power": contact,
            "balance": (drive[0] - spent, 0.0),
            **self._electrical(drive, output),
            "peak_force": self._peak,
            "contact_share": share,
            "stick_share": ratio(stick, share),
            "friction_work_per_slip": ratio(friction, self._sampled(slip)),
            "friction_work_per_travel": ratio(friction, (radius * abs(speed[0]), radius * speed[1])),
        }

    @property
    def _period(self) -> float:
        return self.section.period

    @property
    def _rotor_damping(self) -> float:
        return self.section.setup.motor.rotor.damping

    @cached_property
    def _count(self) -> int:
        return (self.run.time.size - 1) // self.records

    def _mean(self, values: Array) -> Number:
        """Return the mean of a value a period."""
        if self.closure is not None:
            return float(values.mean()), self.closure * float(np.abs(values).mean())
        return mean_with_error(values)

    def _rate(self, name: str) -> Number:
        """Return the mean rate at which a series grows."""
        return self._mean(np.diff(self.run.series[name][:: self.records]) / self._period)

    def _sampled(self, values: Array) -> Number:
        """Return the mean of a value a record; its error shows what half as many records make of it."""
        every = values.reshape(self._count, self.records)
        value, error = self._mean(every.mean(axis=1))
        return value, error + abs(float(every[:, 1::2].mean()) - value)

    def _summed(self, name: str) -> Array:
        """Sum a column of the contacts over every period, shape (period,)."""
        contacts, count = self.run.contacts, self._count
        when = (contacts["start_time"] / self._period).astype(int)
        return np.bincount(np.minimum(when, count - 1), contacts[name], count).astype(float)

    def _shaft(self) -> tuple[Number, Number, Number]:
        """Return velocity, torque less that of the rotor's damping, and power to the load."""
        belt = self.section.belt
        speed, error = (belt, 0.0) if belt is not None else self._rate("rotor_angle")
        friction = self.run.series["friction_force"][1:]
        pushes = -self.run.motor.geometry.rotor_radius * friction
        push, push_error = self._mean(
            pushes if self.closure is not None else pushes.reshape(self._count, -1).mean(axis=1)
        )
        torque = push - self._rotor_damping * speed, push_error + self._rotor_damping * error
        output = torque[0] * speed, torque[1] * abs(speed)
        return (speed, error), torque, self._rate("load_work") if belt is None else output

    @property
    def _stored(self) -> float:
        """Power that resonator, free rotor and contact store; a mechanical state z holds |z|^2 / 2."""
        section, run = self.section, self.run
        assert run.motor.start is not None
        start = section.state_of(run.motor.start, run.motor.rotor.initial_velocity)
        start, end = section.mechanical(start), section.mechanical(section.end_of(run))
        contact = run.series["contact_energy"]
        stored = 0.5 * (end @ end - start @ start) + contact[-1] - contact[0]
        return float(stored / run.duration)

    def _electrical(self, drive: Number, output: Number) -> dict[str, Number]:
        """Return what the electrodes take, and the efficiencies where there is an output."""
        dielectric = dielectric_loss(self.run.motor)
        active = drive[0] + dielectric, drive[1]
        squares = [self._sampled(each[1:] ** 2) for each in currents(self.run)]
        volts = np.sqrt(np.mean(self.run.motor.drive.voltage(self.run.time[1:]) ** 2, axis=1)).tolist()
        amperes = [_root(square) for square in squares]
        apparent = [float(np.dot(volts, part)) for part in zip(*amperes, strict=True)]
        useful = output if output[0] > 0.0 else UNKNOWN
        return {
            "dielectric_power": (dielectric, 0.0),
            "active_power": active,
            "apparent_power": (apparent[0], apparent[1]),
            "power_factor": ratio(active, (apparent[0], apparent[1])),
            "rms_voltage": (float(np.sqrt(np.mean(np.square(volts)))), 0.0),
            "rms_current": _root((0.5 * sum(s for s, _ in squares), 0.5 * sum(e for _, e in squares))),
            "mechanical_efficiency": ratio(useful, drive),
            "electrical_efficiency": ratio(useful, active),
        }

    @property
    def _peak(self) -> Number:
        """Largest normal force; the two halves of many periods tell its error."""
        peaks = self.run.contacts["peak_normal_force"]
        halves = [float(half.max(initial=0.0)) for half in np.array_split(peaks, 2)]
        return max(halves), 0.0 if self.closure is not None else abs(halves[1] - halves[0])


def ratio(above: Number, below: Number) -> Number:
    """Divide two numbers with their errors; not a number where nothing is below."""
    if not below[0] > 0.0:
        return UNKNOWN
    value = above[0] / below[0]
    return value, (above[1] + abs(value) * below[1]) / below[0]


def _root(square: Number) -> Number:
    value = float(np.sqrt(square[0]))
    return value, 0.5 * square[1] / value if value else 0.0
