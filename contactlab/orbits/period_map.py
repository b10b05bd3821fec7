"""The period map: where the state of a motor is one period of its drive later."""

from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.engine import Flow, simulate
from contactlab.motor import Drive, ModalState, Motor
from contactlab.trajectory import Ending, Trajectory

MOST_PERIODS: Final = 100
"""Periods of the first tone after which a drive must repeat itself."""

SAME: Final = 1e-9
"""Relative distance from a ratio of whole numbers that counts as none."""

BELT: Final = 1e9
"""Inertia of a rotor that nothing turns [kg m2]; a second of 1 N m changes its velocity by 1 nrad/s."""


class NoPeriodError(ValueError):
    """The drive does not repeat itself; the message is a sentence."""


class BrokenOffError(RuntimeError):
    """A run did not reach its end; the message is its own."""


def period_of(drive: Drive) -> float:
    """Give the time after which all tones of a drive repeat themselves [s].

    Raises:
        NoPeriodError: there is no tone, or no such time within `MOST_PERIODS` of the first.
    """
    if not drive.frequency.size:
        raise NoPeriodError("The drive has no tone; a steady state needs a period. Give it a frequency.")
    ratios = drive.frequency / drive.frequency[0]
    count = 1
    for ratio in ratios.tolist():
        near = Fraction(ratio).limit_denominator(MOST_PERIODS)
        if abs(ratio - near) <= SAME * ratio:
            count = int(np.lcm(count, near.denominator))
        else:
            count = MOST_PERIODS + 1
    if count > MOST_PERIODS:
        raise NoPeriodError(
            f"The tones at {', '.join(f'{f:.9g}' for f in drive.frequency)} Hz do not repeat themselves "
            f"within {MOST_PERIODS} periods of the first; a steady state needs a drive that does. Choose a "
            "frequency_ratio of small whole numbers; the paper takes 2."
        )
    return count / float(drive.frequency[0])


@final
@dataclass(frozen=True)
class PeriodMap:
    """Takes a state in free flight to the state some periods of the drive later.

    The state is z = (omega_j q_j, qdot_j, sqrt(J) Omega), whose parts have the unit of a velocity in
    mass-orthonormal coordinates, so that |z|^2 / 2 is an energy; a rigid body's mode keeps q_j itself. The
    rotor's angle changes nothing and is left out, and so is the velocity of a belt, which nothing changes.

    Args:
        setup: motor, law, steps and tolerance; its duration means nothing here.
        phase: of the section, in periods of the drive: z is the state at t = phase T.
        periods: how many the map takes.
        belt: velocity at which the rotor is held [rad/s]; None for one that is free.
    """

    setup: Setup
    phase: float = 0.0
    periods: int = 1
    belt: float | None = None

    @cached_property
    def period(self) -> float:
        """Time that the map takes [s]."""
        return self.periods * period_of(self.setup.motor.drive)

    @cached_property
    def scale(self) -> Array:
        """omega_j, or 1 for a rigid body [rad/s], shape (mode,)."""
        rates = np.sqrt(self.setup.motor.modes.stiffness)
        return np.where(rates > 0.0, rates, 1.0)

    @cached_property
    def _motor(self) -> Motor:
        """The motor whose clock starts at the section."""
        motor, drive = self.setup.motor, self.setup.motor.drive
        turned = np.exp(1j * drive.angular_frequency * self.phase * period_of(drive))
        if self.belt is not None:
            rotor = replace(motor.rotor, inertia=BELT, damping=0.0, load_torque=0.0)
            motor = replace(motor, rotor=rotor)
        return replace(motor, drive=Drive(drive.frequency, drive.phasors * turned))

    @cached_property
    def _flow(self) -> Flow:
        """The motor, ready to run from many starts."""
        setup = self.setup
        return Flow(self._motor, setup.law, self.period, setup.contact_step, setup.tolerance)

    def state_of(self, modal: ModalState, velocity: float) -> Array:
        """Give the state z of normal coordinates and a rotor velocity [rad/s]."""
        parts = [self.scale * modal.displacement, modal.velocity]
        if self.belt is None:
            parts.append(np.array([np.sqrt(self.setup.motor.rotor.inertia) * velocity]))
        return np.concatenate(parts)

    def velocity_of(self, z: Array) -> float:
        """Give the rotor velocity of a state [rad/s]."""
        if self.belt is not None:
            return self.belt
        return float(z[-1] / np.sqrt(self.setup.motor.rotor.inertia))

    def run(self, z: Array, times: float = 1.0, records: int = 1) -> Trajectory:
        """Let the motor run from a state for some times the map, with some records in each of its periods.

        Raises:
            BrokenOffError: it did not reach its end.
            KeyboardInterrupt: somebody pressed Ctrl-C.
        """
        count = self.scale.size
        modal = ModalState(z[:count] / self.scale, z[count : 2 * count].copy())
        rotor = replace(self._motor.rotor, initial_velocity=self.velocity_of(z))
        duration = times * self.period
        trajectory = simulate(
            replace(self._motor, start=modal, rotor=rotor),
            self.setup.law,
            duration=duration,
            record_interval=min(self.period / records, duration),
            contact_step=self.setup.contact_step,
            tolerance=self.setup.tolerance,
        )
        if trajectory.ending is Ending.INTERRUPTED:
            raise KeyboardInterrupt(trajectory.message)
        if not trajectory.ending.reached_end:
            raise BrokenOffError(trajectory.message)
        return trajectory

    def end_of(self, run: Trajectory) -> Array:
        """Give the state in which a run ended."""
        return self.state_of(run.final, float(run.series["rotor_velocity"][-1]))

    def __call__(self, z: Array) -> Array:
        """Give the state one period of the map later.

        Raises:
            BrokenOffError: the run did not reach its end, or could not begin.
            KeyboardInterrupt: somebody pressed Ctrl-C.
        """
        ends, messages = self._sent(z[None])
        if messages[0]:
            raise BrokenOffError(messages[0])
        return np.asarray(ends[0])

    def ends(self, starts: Array) -> Array:
        """Give the states one period of the map after others, shape (start, state): many for little more.

        Where a run did not reach its end, or could not begin, the state is no number.
        """
        return self._sent(starts)[0]

    def _sent(self, starts: Array) -> tuple[Array, tuple[str, ...]]:
        """Give the states after others, and why one is no number."""
        count = self.scale.size
        q, v, rotor = starts[:, :count] / self.scale, starts[:, count : 2 * count], starts[:, 2 * count :]
        root = np.sqrt(self.setup.motor.rotor.inertia)
        held = np.full(len(starts), self.belt, np.float64)
        ends = self._flow(q, v, rotor[:, 0] / root if self.belt is None else held)
        parts = [self.scale * ends.displacement, ends.velocity]
        if self.belt is None:
            parts.append(root * ends.rotor_velocity[:, None])
        return np.hstack(parts), ends.messages

    def at(self, phase: float) -> "PeriodMap":
        """Give the map with another section."""
        return replace(self, phase=phase % 1.0)
