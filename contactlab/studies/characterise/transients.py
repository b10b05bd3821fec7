"""Times of start and stop when the drive is switched, and the holding torque without a drive."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.engine.state import State
from contactlab.estimate import Estimate
from contactlab.motor import ModalState, Motor
from contactlab.refinement import Refinement
from contactlab.steady_state.period_map import PeriodMap

STARTED: Final = 0.9
STOPPED: Final = 0.1
"""Velocity over that without load at which a rotor has started, and at which it has stopped."""

PIECE: Final = 50
"""Periods of the drive that are run at a time."""

LONGEST: Final = 4000
"""Periods after which the computation of a start or a stop ends."""

RESTS: Final = 1e-6
"""Vibration of a resonator over the initial one, below which it rests beside the rotor."""

DIED_DOWN: Final = 20.0
"""Times 1 / (zeta omega) of the slowest mode after which a resonator rests."""


def start_time(setup: Setup, velocity: float) -> Estimate:
    """Return the time from the motor's start to `STARTED` of a velocity [rad/s], and its error [s]."""

    def once(setup: Setup) -> float:
        clock = PeriodMap(setup)
        time, reached, _ = _until(clock, _start_of(clock), STARTED * velocity)
        return time if reached else np.inf

    return _at_two_steps(setup, once)


def stop_time(
    setup: Setup, settled: Motor, velocity: float, memory: Array | None = None, contact: State | None = None
) -> tuple[Estimate, Estimate]:
    """Return the time in which a rotor without drive falls to `STOPPED` of a velocity, and where it coasts.

    Args:
        setup: law and steps.
        settled: the free motor, whose start lies on its steady motion; its electrodes are made short there.
        velocity: without load [rad/s].
        memory, contact: of a `PeriodMap` there; None are initial internal variables, and no contact.

    Returns:
        The time [s], infinite where nothing brakes the rotor any more, and the speed at which the tip leaves
        it [rad/s], zero where the contact stops it; with their errors.
    """
    result, rotor = [], settled.rotor

    def once(setup: Setup) -> float:
        clock = PeriodMap(replace(setup, motor=_silent(settled)), contact=contact)
        time, stopped, coasts = _until(clock, _start_of(clock, memory), STOPPED * velocity)
        result.append(0.0 if stopped else abs(coasts))
        if stopped:
            return time
        decay = rotor.damping / rotor.inertia
        return time + float(np.log(coasts / (STOPPED * velocity))) / decay if decay else np.inf

    time = _at_two_steps(setup, once)
    return time, Estimate(result[1], abs(result[1] - result[0]))


def holding_torque(setup: Setup, velocity: float) -> Estimate:
    """Return the load that moves the rotor when the drive is off [N m], and its error.

    The rotor is drawn through the contact of the resting resonator at the velocity without load: with
    Coulomb friction the torque is the same at any velocity, and the rotor holds against less. Much slower,
    the tip would stick to it for longer than the resonator needs to rest.
    """
    motor = _silent(setup.motor)
    decay = motor.modes.damping[motor.modes.damping > 0.0].min(initial=np.inf)
    rest = max(int(np.ceil(DIED_DOWN / (decay * PeriodMap(setup).period))), 1)

    def once(setup: Setup) -> float:
        clock = PeriodMap(replace(setup, motor=motor), belt=velocity)
        run = clock.run(_start_of(clock), rest)
        return abs(motor.geometry.rotor_radius * float(run.series["friction_force"][-1]))

    return _at_two_steps(setup, once)


def _silent(motor: Motor) -> Motor:
    return replace(motor, drive=motor.drive.silent())


def _start_of(clock: PeriodMap, memory: Array | None = None) -> Array:
    """Return the initial state of motor and law; None takes the law's initial internal variables."""
    motor = clock.setup.motor
    rest = np.zeros_like(motor.modes.stiffness)
    return clock.state_of(motor.start or ModalState(rest, rest), motor.rotor.initial_velocity, memory)


def _until(clock: PeriodMap, z: Array, target: float) -> tuple[float, bool, float]:
    """Run a motor from a state until its mean velocity over a period passes a target, or the tip has left.

    Returns the time [s], interpolated between the middles of two periods, whether the target is passed, and
    the last velocity [rad/s].
    """
    rests = RESTS * float(np.linalg.norm(clock.vibration(z)))
    before = clock.velocity_of(z) - target
    for piece in range(LONGEST // PIECE):
        run = clock.run(z, PIECE, 1)
        distance = np.append(before, np.diff(run.series["rotor_angle"]) / clock.period - target)
        passed = np.flatnonzero(distance[1:] * distance[0] <= 0.0)
        if passed.size and before != 0.0:
            i = int(passed[0]) + 1
            part = distance[i] / (distance[i] - distance[i - 1])
            return (piece * PIECE + i - 0.5 - float(part)) * clock.period, True, target
        before = float(distance[-1])
        clock = clock.at_end_of(run, clock.phase)
        z = clock.end_of(run)
        if not run.contacts["start_time"].size or np.linalg.norm(clock.vibration(z)) < rests:
            break
    return ((piece + 1) * PIECE - 0.5) * clock.period, False, float(distance[-1] + target)


def _at_two_steps(setup: Setup, once: Callable[[Setup], float]) -> Estimate:
    """Return a number at half the step, or a tenth of the tolerance, and its error by the law's order.

    A run may last for `LONGEST` periods: there is no third step whose difference shows the order.
    """
    refinement = Refinement.of(setup, levels=2)
    return refinement.estimate([once(each) for each in refinement.setups(setup)])
