"""The period map: where the state of a motor is one period of its drive later."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import log2
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.engine import Flow, Simulator, simulator_of
from contactlab.engine.initial_state import memory_mark
from contactlab.engine.state import TOUCHING, State
from contactlab.interrupts import raise_if_stopped
from contactlab.laws.base import SET_VALUED, STICK, ContactLaw, MultiplierLaw
from contactlab.laws.memory import InternalVariable
from contactlab.motor import ModalState, Motor
from contactlab.motor.drive import NoPeriodError as NoPeriodError, period_of as period_of
from contactlab.trajectory import Ending, Trajectory
from contactlab.variables import INTERNAL

BELT: Final = 1e9
"""Inertia of a rotor whose velocity is prescribed [kg m2] at a radius of up to a metre; a second of 1 N m
changes it by 1 nrad/s."""

HEAVIEST: Final = 1e3
"""Mass of the rotor on its rim, over that of the tip, with which it counts at most in a state [1]."""

PROJECTIONS: Final = 2
"""Newton steps onto a closed gap; each squares the distance, over the radius."""


class BrokenOffError(RuntimeError):
    """A run did not reach its end; the message is its own."""


@final
@dataclass(frozen=True)
class PeriodMap:
    """Takes a state at a phase of the drive to the state some periods later, in flight or in contact.

    The state is z = (omega_j q_j, qdot_j, w_k m_k, sqrt(J') Omega). Its mechanical parts have the unit of a
    velocity in mass-orthonormal coordinates, so that half of their square is an energy; a rigid body's mode
    has omega_j of the drive's period. J' is the rotor's inertia, at most that of `HEAVIEST` times the tip's
    mass on its rim: beside a heavier one no step and no norm would see the resonator. m_k are the law's
    internal variables with weights w_k that make them about as large as the motion: in flight those whose
    life is the run, in contact all that are not discrete.

    What no force depends on is no part of the state: the rotor's angle, the displacement of a coordinate that
    slides freely, and the velocity of a belt. Nor is what the clock says: prescribed modes.

    In contact the section is the manifold that the contact holds: the gap and its rate are zero under a rigid
    law, and the slip is where it sticks. Every state is projected onto it first, along the masses, so that a
    derivative of the map is that along the manifold, and zero across it.

    Args:
        setup: motor, law, steps and tolerance; its duration means nothing here.
        phase: of the section, in periods of the drive: z is the state at t = phase T.
        periods: how many the map takes.
        belt: velocity at which the rotor is held [rad/s]; None for one that is free. That of a motor whose
            rotor is a belt is its own.
        weights: w_k, see `weighing`; 1 in the unit of each where there are none.
        contact: state of a run that is in contact at the section, or over the residual indentation of the
            last contact: friction mode and impact speed are its. None in flight.
    """

    setup: Setup
    phase: float = 0.0
    periods: int = 1
    belt: float | None = None
    weights: tuple[float, ...] = ()
    contact: State | None = None

    def __post_init__(self) -> None:
        if self.setup.changes:
            raise ValueError("The setup has solver.changes; a steady state is that of one motor.")
        if (start := self.setup.motor.start) and start.touching:
            raise ValueError("The motor's start is touching; a steady state has no start of its own.")
        if self.belt is None:
            object.__setattr__(self, "belt", self.setup.motor.belt_velocity)

    @cached_property
    def period(self) -> float:
        """Time that the map takes [s]."""
        return self.periods * period_of(self.setup.motor.drive)

    @cached_property
    def scale(self) -> Array:
        """omega_j, or that of the drive's period for a rigid body [rad/s], shape (mode,)."""
        # A displacement in units of a velocity, omega q; a rigid body has the drive's omega.
        rates = np.sqrt(self.setup.motor.modes.stiffness)
        return np.where(rates > 0.0, rates, 2.0 * np.pi / period_of(self.setup.motor.drive))

    @cached_property
    def _led(self) -> NDArray[np.bool_]:
        """Which modes the voltages prescribe, shape (mode,)."""
        return self.setup.motor.modes.is_prescribed

    @cached_property
    def _kept(self) -> NDArray[np.bool_]:
        """Which displacements are part of the state, shape (mode,)."""
        return ~self.setup.motor.slides_freely & ~self._led

    @cached_property
    def _modes_size(self) -> int:
        """How many displacements and rates of modes are part of the state."""
        return int(self._kept.sum() + (~self._led).sum())

    @cached_property
    def rotor_scale(self) -> float:
        """Root of J', the rotor's velocity in the state over Omega [kg^1/2 m]."""
        motor = self.setup.motor
        # The tip's mass along the rotor is 1 / sum t_j^2; J' <= J and J' <= 1000 of these masses times R^2.
        mobility = float(np.sum(motor.rows_at_rest[1][~self._led] ** 2))
        most = motor.geometry.rotor_radius * np.sqrt(HEAVIEST / mobility) if mobility > 0.0 else np.inf
        return float(min(np.sqrt(motor.rotor.inertia), most))

    @cached_property
    def variables(self) -> tuple[InternalVariable, ...]:
        """The internal variables that are part of the state."""
        return variables_in(self.setup.law, self.contact)

    @cached_property
    def _continuous(self) -> NDArray[np.bool_]:
        """Which internal variables of the law are not discrete, shape (variable,)."""
        return np.array([not each.discrete for each in self.setup.law.internal_variables], dtype=bool)

    @property
    def touches(self) -> bool:
        """Whether tip and rotor are in contact at the section."""
        return self.contact is not None and bool(self.contact["phase"] == TOUCHING)

    @cached_property
    def _motor(self) -> Motor:
        """The motor whose clock starts at the section."""
        motor, drive = self.setup.motor, self.setup.motor.drive
        if self.belt is not None and motor.belt_velocity is None:
            # A belt is a rotor so heavy that no contact changes its velocity.
            inertia = BELT * max(motor.geometry.rotor_radius, 1.0) ** 2
            motor = replace(motor, rotor=replace(motor.rotor, inertia=inertia, damping=0.0, load_torque=0.0))
        # The clock of a run is zero at the section, where the drive has its phase.
        return replace(motor, drive=drive.delayed(self.phase * period_of(drive)))

    @cached_property
    def _flow(self) -> Flow:
        """The motor, ready to run from many starts."""
        return Flow(self._simulator(self._motor, self.period), self.contact)

    def _simulator(self, motor: Motor, duration: float) -> Simulator:
        """Return a motor under the law that is made ready to run for a duration [s]."""
        return simulator_of(motor, self.setup.law, duration, self.setup.contact_step, self.setup.tolerance)

    @cached_property
    def _weights(self) -> Array:
        return np.array(self.weights or [1.0] * len(self.variables))

    def weighing(self, run: Trajectory) -> "PeriodMap":
        """Return the map whose weights make the internal variables as large as the motion at a run's end.

        They are powers of two, so that weighing loses no digit.
        """
        if not self.variables:
            return replace(self, weights=())
        # w_k of (7.1), the power of two next to |z| / |m_k|.
        size = float(np.linalg.norm(self.mechanical(self.end_of(run))))
        largest = [float(np.abs(run.series[INTERNAL + each.name]).max()) for each in self.variables]
        weights = (2.0 ** round(log2(size / most)) if size and most else 1.0 for most in largest)
        return replace(self, weights=tuple(weights))

    def at_end_of(self, run: Trajectory, phase: float) -> "PeriodMap":
        """Return the map whose section lies where a run ended, at a phase of the drive."""
        return replace(self, phase=phase % 1.0, weights=(), contact=contact_at_end(run))

    def state_of(self, modal: ModalState, velocity: float, memory: Array | None = None) -> Array:
        """Return the state z of normal coordinates, a rotor velocity [rad/s] and its `variables`.

        Without the latter they have their initial values.
        """
        if memory is None:
            memory = np.array([each.initial for each in self.variables])
        # z of (7.1): omega_j q_j, the rates of the modes, w_k m_k, sqrt(J') Omega.
        placed = (self.scale * modal.displacement)[self._kept]
        parts = [placed, modal.velocity[~self._led], self._weights * memory]
        if self.belt is None:
            parts.append(np.array([self.rotor_scale * velocity]))
        return np.concatenate(parts)

    def parts_of(self, z: Array) -> tuple[ModalState, float, Array]:
        """Return normal coordinates, rotor velocity [rad/s] and internal variables of a state z.

        In contact the latter are all of the law's, those that are discrete as at the section.
        """
        (q,), (v,), (velocity,), (memory,) = self._parts_of(z[None])
        return ModalState(q, v), float(velocity), memory

    def _parts_of(self, starts: Array) -> tuple[Array, Array, Array, Array]:
        """Return those of many states, shape (start, state), projected onto the section, q and v apart."""
        # (7.1) backwards. Displacements that are no part of z are zero.
        count, placed, weights = self._modes_size, int(self._kept.sum()), self._weights
        q, v = np.zeros((2, len(starts), self.scale.size))
        q[:, self._kept] = starts[:, :placed] / self.scale[self._kept]
        v[:, ~self._led] = starts[:, placed:count]
        if self._led.any():
            # Prescribed modes are where the clock says.
            for values, first in zip((q, v), self._motor.first_motion, strict=True):
                values[:, self._led] = first[self._led]
        memory = starts[:, count : count + weights.size] / weights
        velocities = np.full(len(starts), self.belt or 0.0)
        if self.belt is None:
            velocities = starts[:, -1] / self.rotor_scale
        if self.touches:
            # In contact a state counts by its projection onto what the contact holds.
            rows = [self._projected(*row) for row in zip(q, v, velocities.tolist(), strict=True)]
            q, v, turned = map(np.array, zip(*rows, strict=True))
            velocities = velocities if self.belt is not None else turned
        if self.contact is not None:
            # Discrete internal variables are those at the section.
            every = np.repeat(self.contact["memory"][None, : self._continuous.size], len(starts), axis=0)
            every[:, self._continuous] = memory
            memory = every
        return q, v, velocities, memory

    def _projected(self, q: Array, v: Array, velocity: float) -> tuple[Array, Array, float]:
        """Project a motion in contact onto what its contact holds."""
        law, modes, geometry, rotor = (
            self.setup.law,
            self._motor.modes,
            self._motor.geometry,
            self._motor.rotor,
        )
        rigid = isinstance(law, MultiplierLaw)
        sticks = self.contact is not None and self.contact["mode"] == STICK
        sticks = sticks and (rigid or getattr(law, "friction_kind", None) == SET_VALUED)
        if not (rigid or sticks):
            return q, v, velocity
        # The displacement onto g = 0 along the masses: q <- q - n g / (n n), n the row of the gap.
        for _ in range(PROJECTIONS if rigid else 1):
            gap, n_u, n_th, t_u, t_th = geometry.frame(float(modes.approach @ q), float(modes.tip_slope @ q))
            normal = n_u * modes.approach + n_th * modes.tip_slope
            moved = np.where(self._led, 0.0, normal)
            if rigid:
                q = q - moved * (gap / (moved @ moved))
        # The rows G of what is held, in sqrt(mass) coordinates: the gap rate under a rigid law, and the slip,
        # of which the rotor's part is -R Omega, in stick.
        turning = -geometry.rotor_radius / np.sqrt(rotor.inertia)
        rows = [np.append(normal, 0.0), np.append(t_u * modes.approach + t_th * modes.tip_slope, turning)]
        constraints = np.array(rows[0 if rigid else 1 : 2 if sticks else 1])
        # The rates onto G qdot = 0 along the masses: qdot <- qdot - G^T (G G^T)^-1 G qdot. Prescribed modes
        # are not moved, but count in G qdot.
        rates = np.append(v, np.sqrt(rotor.inertia) * velocity)
        moving = np.where(np.append(self._led, False), 0.0, constraints)
        rates = rates - moving.T @ np.linalg.solve(moving @ moving.T, constraints @ rates)
        return q, rates[:-1], float(rates[-1] / np.sqrt(rotor.inertia))

    def mechanical(self, z: Array) -> Array:
        """Return a state z without internal variables."""
        modes = self.vibration(z)
        return np.concatenate([modes, z[modes.size + self._weights.size :]])

    def vibration(self, z: Array) -> Array:
        """Return the part of a state z that is the modes' motion."""
        return z[: self._modes_size]

    def velocity_of(self, z: Array) -> float:
        """Return the rotor velocity of a state [rad/s]."""
        if self.belt is not None:
            return self.belt
        return float(z[-1] / self.rotor_scale)

    def run(self, z: Array, times: float = 1.0, records: int = 1) -> Trajectory:
        """Let the motor run from a state for some times the map, with some records in each of its periods.

        Raises:
            BrokenOffError: it did not reach its end.
            KeyboardInterrupt: somebody pressed Ctrl-C.
        """
        modal, velocity, memory = self.parts_of(z)
        rotor = replace(self._motor.rotor, initial_velocity=velocity)
        duration = times * self.period
        motor = replace(self._motor, start=modal, rotor=rotor)
        trajectory = self._simulator(motor, duration).run(
            record_interval=min(self.period / records, duration),
            progress=raise_if_stopped,
            memory=memory,
            contact=self.contact,
        )
        if trajectory.ending is Ending.INTERRUPTED:
            raise KeyboardInterrupt(trajectory.message)
        if not trajectory.ending.reached_end:
            raise BrokenOffError(trajectory.message)
        return trajectory

    def end_of(self, run: Trajectory) -> Array:
        """Return the state in which a run ended."""
        memory = memory_at_end(run, self.variables)
        return self.state_of(run.final, float(run.series["rotor_velocity"][-1]), memory)

    def ends_at(self, run: Trajectory) -> bool:
        """Return whether a run has ended in the contact that there is at the section, or in flight as it."""
        end = contact_at_end(run)
        if end is None or self.contact is None:
            return end is self.contact
        # The contact is that of the section if phase, mode and discrete variables are.
        count = np.flatnonzero(~self._continuous)
        same = all(end[name] == self.contact[name] for name in ("phase", "mode"))
        return same and np.array_equal(end["memory"][count], self.contact["memory"][count])

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

    def ends(self, starts: Array, times: int = 1) -> Array:
        """Return the states some periods of the map after others, shape (start, state): many for little more.

        Where a run did not reach its end, or could not begin, the state is no number.
        """
        return self._sent(starts, times)[0]

    def _sent(self, starts: Array, times: int = 1) -> tuple[Array, tuple[str, ...]]:
        """Return the states after others, and why one is no number."""
        raise_if_stopped()
        # All starts in one call of the compiled loop, and z of (7.1) at their ends.
        ends = self._flow(*self._parts_of(starts), times)
        placed = (self.scale * ends.displacement)[:, self._kept]
        memory = ends.memory if self.contact is None else ends.memory[:, self._continuous]
        parts = [placed, ends.velocity[:, ~self._led], self._weights * memory]
        if self.belt is None:
            parts.append(self.rotor_scale * ends.rotor_velocity[:, None])
        return np.hstack(parts), ends.messages


def variables_in(law: ContactLaw, contact: State | None) -> tuple[InternalVariable, ...]:
    """Return the internal variables of a state: in flight those of the run, in contact all not discrete."""
    if contact is None:
        return law.lasting
    return tuple(each for each in law.internal_variables if not each.discrete)


def memory_at_end(run: Trajectory, variables: Sequence[InternalVariable] | None = None) -> Array:
    """Return internal variables as a run leaves them, by default those whose life is the run."""
    each = run.law.lasting if variables is None else variables
    return np.array([float(run.series[INTERNAL + variable.name][-1]) for variable in each])


def contact_at_end(run: Trajectory) -> State | None:
    """Return the contact in which a run ended, or whose indentation is still there; None in free flight."""
    state = run.state
    # A residual indentation under the tip is part of a contact, though the tip is off it.
    dented = state["limits.remembered"] and state["limits.release_gap"] == np.inf
    return state if state["phase"] == TOUCHING or dented else None


def continues(contact: State | None, law: ContactLaw) -> State | None:
    """Return a contact that goes on under a law, or None where it is another law's."""
    if contact is None:
        return None
    # What the contact's state was of: kind of law, kind of friction, internal variables.
    kind = not isinstance(law, MultiplierLaw), getattr(law, "friction_kind", SET_VALUED), memory_mark(law)
    names = "law.compliant", "law.friction_kind", "law.variables_mark"
    return contact if kind == tuple(contact[name] for name in names) else None
