"""The period map: where the state of a motor is one period of its drive later."""

from dataclasses import dataclass, replace
from functools import cached_property
from math import log2
from typing import Final, final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.engine import Flow, simulate
from contactlab.motor import ModalState, Motor
from contactlab.motor.drive import NoPeriodError as NoPeriodError, period_of as period_of
from contactlab.trajectory import Ending, Trajectory

BELT: Final = 1e9
"""Inertia of a rotor that nothing turns [kg m2]; a second of 1 N m changes its velocity by 1 nrad/s."""


class BrokenOffError(RuntimeError):
    """A run did not reach its end; the message is its own."""


@final
@dataclass(frozen=True)
class PeriodMap:
    """Takes a state in free flight to the state some periods of the drive later.

    The state is z = (omega_j q_j, qdot_j, w_k m_k, sqrt(J) Omega). Its mechanical parts have the unit of a
    velocity in mass-orthonormal coordinates, so that half of their square is an energy; a rigid body's mode
    keeps q_j itself. m_k are the law's internal variables whose life is the run, with weights w_k that make
    them about as large as the motion. The rotor's angle changes nothing and is left out, and so is the
    velocity of a belt, which nothing changes.

    Args:
        setup: motor, law, steps and tolerance; its duration means nothing here.
        phase: of the section, in periods of the drive: z is the state at t = phase T.
        periods: how many the map takes.
        belt: velocity at which the rotor is held [rad/s]; None for one that is free.
        weights: w_k, see `weighing`; 1 in the unit of each where there are none.
    """

    setup: Setup
    phase: float = 0.0
    periods: int = 1
    belt: float | None = None
    weights: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if self.setup.changes:
            raise ValueError("The setup has solver.changes; a steady state is that of one motor.")

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
        if self.belt is not None:
            rotor = replace(motor.rotor, inertia=BELT, damping=0.0, load_torque=0.0)
            motor = replace(motor, rotor=rotor)
        return replace(motor, drive=drive.delayed(self.phase * period_of(drive)))

    @cached_property
    def _flow(self) -> Flow:
        """The motor, ready to run from many starts."""
        setup = self.setup
        return Flow(self._motor, setup.law, self.period, setup.contact_step, setup.tolerance)

    @cached_property
    def _weights(self) -> Array:
        return np.array(self.weights or [1.0] * len(self.setup.law.lasting))

    def weighing(self, run: Trajectory) -> "PeriodMap":
        """Return the map whose weights make the internal variables as large as the motion at a run's end.

        They are powers of two, so that weighing loses no digit.
        """
        if not self.setup.law.lasting:
            return self
        size = float(np.linalg.norm(self.mechanical(self.end_of(run))))
        largest = [float(np.abs(run.series[name]).max()) for name in run.lasting]
        weights = (2.0 ** round(log2(size / most)) if size and most else 1.0 for most in largest)
        return replace(self, weights=tuple(weights))

    def state_of(self, modal: ModalState, velocity: float, memory: Array | None = None) -> Array:
        """Return the state z of normal coordinates, a rotor velocity [rad/s] and the internal variables.

        Without the latter they have their initial values.
        """
        if memory is None:
            memory = np.array([each.initial for each in self.setup.law.lasting])
        parts = [self.scale * modal.displacement, modal.velocity, self._weights * memory]
        if self.belt is None:
            parts.append(np.array([np.sqrt(self.setup.motor.rotor.inertia) * velocity]))
        return np.concatenate(parts)

    def parts_of(self, z: Array) -> tuple[ModalState, float, Array]:
        """Return normal coordinates, rotor velocity [rad/s] and internal variables of a state z."""
        count = self.scale.size
        modal = ModalState(z[:count] / self.scale, z[count : 2 * count].copy())
        memory = z[2 * count : 2 * count + self._weights.size] / self._weights
        return modal, self.velocity_of(z), memory

    def mechanical(self, z: Array) -> Array:
        """Return a state z without internal variables."""
        after = 2 * self.scale.size
        return np.concatenate([z[:after], z[after + self._weights.size :]])

    def velocity_of(self, z: Array) -> float:
        """Return the rotor velocity of a state [rad/s]."""
        if self.belt is not None:
            return self.belt
        return float(z[-1] / np.sqrt(self.setup.motor.rotor.inertia))

    def run(self, z: Array, times: float = 1.0, records: int = 1) -> Trajectory:
        """Let the motor run from a state for some times the map, with some records in each of its periods.

        Raises:
            BrokenOffError: it did not reach its end.
            KeyboardInterrupt: somebody pressed Ctrl-C.
        """
        modal, velocity, memory = self.parts_of(z)
        rotor = replace(self._motor.rotor, initial_velocity=velocity)
        duration = times * self.period
        trajectory = simulate(
            replace(self._motor, start=modal, rotor=rotor),
            self.setup.law,
            duration=duration,
            record_interval=min(self.period / records, duration),
            contact_step=self.setup.contact_step,
            tolerance=self.setup.tolerance,
            memory=memory,
        )
        if trajectory.ending is Ending.INTERRUPTED:
            raise KeyboardInterrupt(trajectory.message)
        if not trajectory.ending.reached_end:
            raise BrokenOffError(trajectory.message)
        return trajectory

    def end_of(self, run: Trajectory) -> Array:
        """Return the state in which a run ended."""
        return self.state_of(run.final, float(run.series["rotor_velocity"][-1]), memory_at_end(run))

    def __call__(self, z: Array) -> Array:
        """Return the state one period of the map later.

        Raises:
            BrokenOffError: the run did not reach its end, or could not begin.
            KeyboardInterrupt: somebody pressed Ctrl-C.
        """
        ends, messages = self._sent(z[None])
        if messages[0]:
            raise BrokenOffError(messages[0])
        return np.asarray(ends[0])

    def ends(self, starts: Array) -> Array:
        """Return the states one period of the map after others, shape (start, state): many for little more.

        Where a run did not reach its end, or could not begin, the state is no number.
        """
        return self._sent(starts)[0]

    def _sent(self, starts: Array) -> tuple[Array, tuple[str, ...]]:
        """Return the states after others, and why one is no number."""
        count, weights = self.scale.size, self._weights
        q, v = starts[:, :count] / self.scale, starts[:, count : 2 * count]
        memory, rotor = np.split(starts[:, 2 * count :], [weights.size], axis=1)
        root = np.sqrt(self.setup.motor.rotor.inertia)
        belts = np.full(len(starts), self.belt, np.float64)
        ends = self._flow(q, v, rotor[:, 0] / root if self.belt is None else belts, memory / weights)
        parts = [self.scale * ends.displacement, ends.velocity, weights * ends.memory]
        if self.belt is None:
            parts.append(root * ends.rotor_velocity[:, None])
        return np.hstack(parts), ends.messages

    def at(self, phase: float) -> "PeriodMap":
        """Return the map with another section."""
        return replace(self, phase=phase % 1.0)


def memory_at_end(run: Trajectory) -> Array:
    """Return the internal variables whose life is the run as a run leaves them, shape (variable,)."""
    return np.array([float(run.series[name][-1]) for name in run.lasting])
