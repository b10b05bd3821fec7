"""What a motor can do in steady vibration: stall torque, velocity without load, peak force.

A belt is a rotor that keeps its velocity Omega whatever the contact does to it. The drive has a period T,
and the resonator settles into a vibration of that period as fast as its damping lets it, within some ten
periods. The contact then turns the rotor with the mean torque

    M(Omega) = -R/T int_0^T F dt - C_r Omega.

The stall torque is |M(0)|: the load that holds the rotor at rest. A free rotor is in steady state when
its velocity is the same one period later, that is when its mean torque is zero, so the velocity without
load is the root of M that is next to rest. Root and free run differ by what the velocity ripples within
a period, R/J times an impulse; the belt leaves that out, and with it the rotor's inertia.

A free run would take some hundred periods for every motor and end with an error that nobody knows: the
rotor gets up to speed with a time of its own, J over the slope of M. The root takes half a dozen runs of a
few dozen periods, each of which shows that it has settled. `contactlab.characterise` tells more of one motor,
and proves its orbits by shooting, at twice the price of a belt; this ranks thousands.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from variations import tip_phasors

import contactlab as cl
from contactlab.steady_state.period_map import BrokenOffError, PeriodMap

STEADY = 1e-5
"""Two quarters of a settled run differ in their mean torque by at most this, over R times the mean normal
force."""

DOUBLINGS = 5
"""How often a run that has not settled is made twice as long, and a belt that is too slow twice as fast."""

CLOSE = 1e-4
"""Relative error of the velocity without load; the ripple that a belt leaves out is some thousandths."""


class NoMotorError(RuntimeError):
    """The numbers do not exist: no contact, no steady vibration, no torque, or a run that broke off."""


@dataclass(frozen=True)
class OnBelt:
    """The steady vibration at one velocity of the rotor.

    Args:
        torque: mean torque of the contact on the rotor, -R F [N m].
        peak_force: largest normal force of any contact [N].
    """

    torque: float
    peak_force: float


@dataclass(frozen=True)
class Performance:
    """What a motor can do.

    Args:
        velocity: without load [rad/s], positive in either direction.
        stall_torque: [N m], positive in either direction.
        peak_force: largest normal force on the rotor at rest [N]; of a rigid law, whose impacts have no
            force, the largest impulse [N s].
        runs: that this took.
    """

    velocity: float
    stall_torque: float
    peak_force: float
    runs: int


def refuse_unfit(setup: cl.Setup) -> None:
    """Refuse a configuration in which the numbers mean something else.

    Raises:
        ConfigurationError: a load, a start in motion, or a drive without a short period.
    """
    settings = setup.configuration
    for key, unit in (("load_torque", "N m"), ("initial_velocity", "rad/s")):
        if settings["rotor"][key] != 0.0:
            raise cl.ConfigurationError(
                [f"rotor.{key} is {settings['rotor'][key]:.12g} {unit}; it must be 0."]
            )
    ratio = settings["drive"]["frequency_ratio"]
    if ratio != round(ratio):
        raise cl.ConfigurationError([f"drive.frequency_ratio is {ratio:.12g}; it must be a whole number."])


def on_belt(setup: cl.Setup, velocity: float) -> OnBelt:
    """Let the motor rub on a rotor of fixed velocity [rad/s] until its vibration has settled.

    Raises:
        NoMotorError: it does not settle, does not touch, or breaks off.
        KeyboardInterrupt: as it comes.
    """
    clock = PeriodMap(setup, belt=velocity)
    period = clock.period
    quarter = max(int(np.ceil(0.25 * setup.duration / period)), 1)
    radius, rest = setup.motor.geometry.rotor_radius, np.zeros(2 * clock.scale.size)
    for _ in range(1 + DOUBLINGS):
        try:
            run = clock.run(rest, 4 * quarter)
        except BrokenOffError as error:
            raise NoMotorError(str(error)) from error
        friction = run.series["friction_force"][1:].reshape(4, quarter)
        before, after = -radius * friction[2:].mean(axis=1)
        normal = run.series["normal_force"][-quarter:].mean()
        if abs(after - before) <= STEADY * radius * normal:
            break
        quarter *= 2
    else:
        raise NoMotorError(f"The vibration has not settled after {2 * quarter} periods.")
    if normal == 0.0:
        raise NoMotorError("The tip does not touch the rotor.")
    late = run.contacts["start_time"] + run.contacts["duration"] >= 3 * quarter * period
    peak = "normal_impulse" if isinstance(setup.law, cl.MultiplierLaw) else "peak_normal_force"
    return OnBelt(float(after), float(run.contacts[peak][late].max()))


def performance(setup: cl.Setup, watch: Callable[[float, int], None] | None = None) -> Performance:
    """Measure a motor.

    Args:
        setup: the motor, its law and its steps; `duration` is that of the shortest run [s].
        watch: called with the velocity without load as far as it is known [rad/s] and the number of
            runs, from the first run that brakes the motor on; what it raises ends the measurement.

    Raises:
        NoMotorError: there is nothing to measure.
        KeyboardInterrupt: as it comes.
    """
    fixed = on_belt(setup, 0.0)
    if fixed.torque == 0.0:
        raise NoMotorError("The contact does not turn the rotor.")
    forward = float(np.sign(fixed.torque))
    damping = setup.motor.rotor.damping
    pushes = {0.0: abs(fixed.torque)}

    def push(speed: float) -> float:
        """Mean torque in the direction of motion [N m]."""
        if speed not in pushes:
            pushes[speed] = forward * on_belt(setup, forward * speed).torque - damping * speed
            if watch is not None and min(pushes.values()) <= 0.0:
                watch(_estimate(pushes), len(pushes))
        return pushes[speed]

    # A belt that outruns the free tip is braked, or nearly so: the contact makes the tip a little faster.
    fast = tip_speed(setup) / setup.motor.geometry.rotor_radius
    while push(fast) > 0.0:
        if len(pushes) > DOUBLINGS:
            raise NoMotorError(f"The contact still pushes the rotor at {fast:.3g} rad/s.")
        fast *= 2.0
    root = brentq(push, 0.0, fast, xtol=CLOSE * fast, rtol=CLOSE)
    return Performance(float(root), abs(fixed.torque), fixed.peak_force, len(pushes))


def _estimate(pushes: dict[float, float]) -> float:
    """Where the line between the fastest belt that is pushed and the slowest that brakes is zero."""
    below = max(speed for speed, torque in pushes.items() if torque > 0.0)
    above = min(speed for speed, torque in pushes.items() if torque <= 0.0)
    share = pushes[below] / (pushes[below] - pushes[above])
    return below + share * (above - below)


def tip_speed(setup: cl.Setup) -> float:
    """Largest velocity of the tip along the rotor in steady vibration without contact [m/s], or above."""
    drive, (_, slope) = setup.motor.drive, tip_phasors(setup.motor.modes, setup.motor.drive)
    return float(setup.motor.geometry.tip_length * drive.angular_frequency @ np.abs(slope))
