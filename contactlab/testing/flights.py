"""Free flights from rest in closed form, where they first touch the rotor, and flights of a wanted shape.

Every mode is the steady answer to its tones and two exponentials that cancel it at t = 0:

    q(t) = Re sum_k S_k exp(i w_k t) + A exp(r_1 t) + B exp(r_2 t),  r^2 + c r + k = 0.

Not valid for a mode that is exactly critical. The first touch-down is searched on a dense grid, without
any bound on the motion: whether a search that has one is right can be judged by it.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from contactlab.arrays import Array
from contactlab.motor import NormalModes
from contactlab.motor.drive import Drive
from contactlab.motor.motor import Motor

Phasors = NDArray[np.complex128]

POINTS_PER_RADIAN = 16
"""Grid points while the fastest exponential of a flight turns or decays by one: 100 a period."""

SUBDIVISION = 32
"""Parts into which a cell of the grid is cut where the gap may close inside it."""

OPERATIONS_PER_STEP = 16
"""Roundings of a term in one step, about: sines, products and sums of its steady and free part."""


@dataclass(frozen=True)
class Flight:
    """Hold the tip of a motor that never touches: u and th are real parts of sums of exponentials.

    Args:
        motor: modes, drive and geometry.
        exponents: shape (term,) [1/s].
        u, th: their amplitudes at the tip, shape (term,) [m], [rad].
    """

    motor: Motor
    exponents: Phasors
    u: Phasors
    th: Phasors

    @property
    def amplitudes(self) -> Phasors:
        """Of u, u rate, th and th rate, shape (term, 4)."""
        rates = self.exponents[:, None] ** np.array([0, 1])
        return np.hstack([rates * self.u[:, None], rates * self.th[:, None]])

    def at(self, time: Array | float) -> tuple[Array, Array]:
        """Give gap [m] and gap rate [m/s], shape of the time, good to their own round-off."""
        waves = np.exp(np.multiply.outer(np.asarray(time, dtype=np.float64), self.exponents))
        return self._gap_and_rate((waves @ self.amplitudes).real)

    def round_off(self, time: float, steps: int) -> float:
        """Give what float64 leaves uncertain of the gap [m] at a time [s] that was reached in so many steps.

        A phase that has grown to |exponent| t is rounded by eps |exponent| t, and with it the rate of
        its term, which moves the slowest mode by its round-off over that mode's own rate. Operations
        are rounded independently of each other, so that n of them leave sqrt(n) times as much.
        """
        rates = np.abs(self.exponents)
        slowest = np.sqrt(self.motor.modes.stiffness.min())
        sizes = np.exp(self.exponents.real * time) * (1.0 + rates * time)
        sizes *= np.maximum(rates / slowest, 1.0)
        slope = abs(float((np.exp(self.exponents * time) @ self.th).real))
        geometry = self.motor.geometry
        lever = geometry.tip_length * slope * (1.0 + geometry.tip_length / geometry.rotor_radius)
        gap = sizes @ np.abs(self.u) + lever * (sizes @ np.abs(self.th))
        spread = np.sqrt(OPERATIONS_PER_STEP * steps)
        return float(np.finfo(np.float64).eps * spread * (gap + geometry.clearance))

    def with_clearance(self, clearance: float) -> "Flight":
        """Give the same vibration under a rotor at another distance [m]."""
        geometry = replace(self.motor.geometry, clearance=clearance)
        return replace(self, motor=replace(self.motor, geometry=geometry))

    def lowered_to(self, gap: float, when: float) -> "Flight":
        """Give the same vibration with the clearance at which the gap [m] at a time [s] has this value."""
        flight = self
        for _ in range(3):
            # The gap follows the clearance but for the slope of the normal, 1e-8 and less.
            missing = gap - float(flight.at(when)[0])
            flight = flight.with_clearance(flight.motor.geometry.clearance + missing)
        return flight

    def on_grid(self, duration: float) -> tuple[Array, Array, Array]:
        """Give times [s], gaps [m] and gap rates [m/s]; at rest the rate is zero, not its round-off."""
        fastest = float(np.abs(self.exponents).max())
        side = int(np.ceil(np.sqrt(POINTS_PER_RADIAN * fastest * duration + 1.0)))
        step = duration / (side * side - 1)
        # exp(r (i side + j) step) is a product, so that a grid of n points takes 2 sqrt(n) exponentials.
        coarse = np.exp(np.multiply.outer(step * side * np.arange(side), self.exponents))
        fine = np.exp(np.multiply.outer(self.exponents, step * np.arange(side)))
        tip = [((coarse * column) @ fine).real.ravel() for column in self.amplitudes.T]
        gap, rate = self._gap_and_rate(np.stack(tip, axis=-1))
        rate[0] = 0.0
        time = step * np.arange(side * side, dtype=np.float64)
        return time, gap, rate

    def minima(self, duration: float) -> tuple[Array, Array]:
        """Give times [s] and gaps [m] of the gap's local minima in (0, duration)."""
        time, _, rate = self.on_grid(duration)
        left = np.flatnonzero((rate[:-1] < 0.0) & (rate[1:] > 0.0))
        step = time[1]
        curvature = (rate[left + 1] - rate[left]) / step
        turn = time[left] - rate[left] / curvature
        for _ in range(8):
            turn = np.clip(turn - self.at(turn)[1] / curvature, time[left], time[left + 1])
        return turn, self.at(turn)[0]

    def first_touch(self, duration: float) -> float | None:
        """Give the time at which the gap first falls to zero [s], between grid points too, or None."""
        time, gap, rate = self.on_grid(duration)
        speed = np.abs(rate)
        speed = np.maximum(speed[:-1], speed[1:])
        # A gap that closes inside a cell falls faster than at its ends and those of its neighbours
        # by a part of what these differ by.
        speed[1:] = np.maximum(speed[1:], speed[:-1])
        speed[:-1] = np.maximum(speed[:-1], speed[1:])
        near = np.minimum(gap[:-1], gap[1:]) <= 2.0 * speed * time[1]
        closed = np.flatnonzero(gap[1:] <= 0.0)
        cells = np.flatnonzero(near[: closed[0] + 1] if closed.size else near)
        parts = time[cells, None] + np.linspace(0.0, time[1], SUBDIVISION + 1)
        gaps, rates = self.at(parts)
        falls = gaps[:, 1:] <= 0.0
        turns = (rates[:, :-1] < 0.0) & (rates[:, 1:] > 0.0)
        for i, j in np.argwhere(falls | turns):
            left, right = parts[i, j], parts[i, j + 1]
            end = right if falls[i, j] else _zero(lambda t: float(self.at(t)[1]), left, right)
            if self._gap(end) <= 0.0:
                return _zero(self._gap, left, end)
        return None

    def _gap(self, time: float) -> float:
        return float(self.at(time)[0])

    def _gap_and_rate(self, tip: Array) -> tuple[Array, Array]:
        """Gap [m] and its rate [m/s] from u, u rate, th, th rate in the last axis."""
        geometry = self.motor.geometry
        u, u_rate, th, th_rate = np.moveaxis(tip, -1, 0)
        arm, radius = geometry.tip_length, geometry.rotor_radius
        sine = np.sin(th)
        across, across_rate = -arm * sine, -arm * np.cos(th) * th_rate
        rise = u - geometry.clearance - 2.0 * arm * np.sin(0.5 * th) ** 2
        rise_rate = u_rate - arm * sine * th_rate
        distance = np.hypot(across, radius - rise)
        gap = (across**2 + rise**2 - 2.0 * radius * rise) / (distance + radius)
        return gap, (across * across_rate - (radius - rise) * rise_rate) / distance


def _zero(function: Callable[[float], float], left: float, right: float) -> float:
    return float(brentq(function, left, right, xtol=1e-19, rtol=1e-15))


def flight_of(motor: Motor) -> Flight:
    """Give the closed flight of a motor from rest."""
    modes = motor.modes
    tones = 1j * motor.drive.angular_frequency
    k, c = modes.stiffness[:, None], modes.damping[:, None]
    steady = (modes.coupling @ motor.drive.phasors) / (k + c * tones + tones**2)
    root = np.sqrt((0.25 * modes.damping**2 - modes.stiffness).astype(np.complex128))
    first, second = -0.5 * modes.damping + root, -0.5 * modes.damping - root
    # A + B = -q(0) and A r1 + B r2 = -v(0) of the steady part.
    q, v = -steady.real.sum(axis=1), -(steady * tones).real.sum(axis=1)
    from_first = (v - second * q) / (first - second)
    amplitudes = [from_first, q - from_first]
    tips = []
    for row in (modes.tip_displacement, modes.tip_slope):
        tips.append(np.concatenate([row @ steady, row * amplitudes[0], row * amplitudes[1]]))
    return Flight(motor, np.concatenate([tones, first, second]), tips[0], tips[1])


def drive_through(modes: NormalModes, frequency: Array, when: float, u: Array, th: Array) -> Drive:
    """Give the weakest drive whose tip, from rest, has these derivatives at an instant.

    The motion is linear in the phasors, so that they follow from a linear system of least norm.

    Args:
        modes: the resonator.
        frequency: of the tones [Hz], shape (tone,); there are four real unknowns to each.
        when: the instant [s].
        u, th: derivatives of order 0, 1, ... [m/s^n], [rad/s^n], equally many; NaN leaves one free.
    """
    order = np.arange(u.size)
    units: Phasors = np.eye(2 * frequency.size, dtype=np.complex128)
    units = np.concatenate([units, 1j * units]).reshape(-1, 2, frequency.size)
    answers = []
    for unit in units:
        flight = flight_of(Motor(modes, Drive(frequency, unit)))
        waves = np.exp(flight.exponents * when)[:, None] * flight.exponents[:, None] ** order
        answers.append(np.concatenate([(flight.u @ waves).real, (flight.th @ waves).real]))
    # Derivatives in the time of the fastest tone, so that all are of one size.
    scale = np.tile((2.0 * np.pi * frequency.max()) ** -order.astype(np.float64), 2)
    wanted = np.concatenate([u, th])
    given = ~np.isnan(wanted)
    system = (np.array(answers).T * scale[:, None])[given]
    sizes = np.linalg.lstsq(system, (wanted * scale)[given], rcond=None)[0]
    phasors: Phasors = np.tensordot(sizes, units, axes=1)
    return Drive(frequency, phasors)


def double_well(
    modes: NormalModes, frequency: Array, when: float, half: float, barrier: float, tilt: float
) -> Flight:
    """Give a flight whose gap has two minima, `half` before and after an instant, that stand at zero.

        g(when + x) = barrier ((x/half)^2 - 1)^2 + tilt x / half

    to the fifth order, and the slope th stays zero as long. Between the minima the gap bends down;
    steps that see only its ends see nothing of it.

    Args:
        modes: the resonator.
        frequency: of the tones [Hz], three and more.
        when, half: [s], half a small part of the fastest period.
        barrier, tilt: [m]; the second minimum lies above the first by twice the tilt.
    """
    shape = np.array([0.0, tilt, -4.0 * barrier, 0.0, 24.0 * barrier, 0.0])
    u = -shape / half ** np.arange(6.0)
    u[0] = np.nan
    drive = drive_through(modes, frequency, when, u, np.zeros(6))
    return flight_of(Motor(modes, drive)).with_clearance(1e-4).lowered_to(barrier, when)
