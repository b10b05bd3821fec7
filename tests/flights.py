"""Free flights from rest in closed form, and where they first touch the rotor.

Every mode is the steady answer to its tones and two exponentials that cancel it at t = 0:

    q(t) = Re sum_k S_k exp(i w_k t) + A exp(r_1 t) + B exp(r_2 t),  r^2 + c r + k = 0.

Not valid for a mode that is exactly critical.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from contactlab.motor import Motor

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Flight:
    """The tip of a motor that never touches: u and th are real parts of sums of exponentials.

    Args:
        motor: modes, drive and geometry.
        exponents: shape (term,) [1/s].
        u, th: their amplitudes at the tip, shape (term,) [m], [rad].
    """

    motor: Motor
    exponents: NDArray[np.complex128]
    u: NDArray[np.complex128]
    th: NDArray[np.complex128]

    def at(self, time: Array | float) -> tuple[Array, Array]:
        """Gap [m] and gap rate [m/s], good to their own round-off."""
        geometry = self.motor.geometry
        waves = np.exp(np.multiply.outer(np.asarray(time, dtype=np.float64), self.exponents))
        u, u_rate = (waves @ self.u).real, (waves @ (self.exponents * self.u)).real
        th, th_rate = (waves @ self.th).real, (waves @ (self.exponents * self.th)).real
        arm, radius = geometry.tip_length, geometry.rotor_radius
        across, across_rate = -arm * np.sin(th), -arm * np.cos(th) * th_rate
        rise = u - geometry.clearance - 2.0 * arm * np.sin(0.5 * th) ** 2
        rise_rate = u_rate - arm * np.sin(th) * th_rate
        distance = np.hypot(across, radius - rise)
        gap = (across**2 + rise**2 - 2.0 * radius * rise) / (distance + radius)
        return gap, (across * across_rate - (radius - rise) * rise_rate) / distance

    def with_clearance(self, clearance: float) -> "Flight":
        """The same vibration under a rotor at another distance."""
        geometry = replace(self.motor.geometry, clearance=clearance)
        return replace(self, motor=replace(self.motor, geometry=geometry))

    def lowered_to(self, gap: float, when: float) -> "Flight":
        """The same vibration with the clearance at which the gap at a time has this value."""
        flight = self
        for _ in range(3):
            # The gap follows the clearance but for the slope of the normal, 1e-8 and less.
            missing = gap - float(flight.at(when)[0])
            flight = flight.with_clearance(flight.motor.geometry.clearance + missing)
        return flight

    def on_grid(self, duration: float, points: int) -> tuple[Array, Array, Array]:
        """Times [s], gaps [m] and gap rates [m/s]; at rest the rate is zero, not its round-off."""
        time = np.linspace(0.0, duration, points)
        gap, rate = self.at(time)
        rate[0] = 0.0
        return time, gap, rate

    def minima(self, duration: float, points: int) -> Array:
        """Times of the gap's local minima in (0, duration), found on a grid and refined [s]."""
        time, _, rate = self.on_grid(duration, points)
        turns = np.flatnonzero((rate[:-1] < 0.0) & (rate[1:] > 0.0))
        return np.array([self._turn(time[i], time[i + 1]) for i in turns])

    def first_touch(self, duration: float, points: int) -> float | None:
        """Time at which the gap first falls to zero [s], between grid points as well."""
        time, gap, rate = self.on_grid(duration, points)
        closed = gap[1:] <= 0.0
        low = np.minimum(gap[:-1], gap[1:])
        # A turning point between two grid points lies below both by less than this.
        reach = np.maximum(np.abs(rate[:-1]), np.abs(rate[1:])) * (time[1] - time[0])
        turns = (rate[:-1] < 0.0) & (rate[1:] > 0.0) & (low < reach)
        for i in np.flatnonzero(closed | turns):
            end = time[i + 1] if closed[i] else self._turn(time[i], time[i + 1])
            if self._gap(end) <= 0.0:
                return float(brentq(self._gap, time[i], end, xtol=1e-19, rtol=1e-15))
        return None

    def _gap(self, time: float) -> float:
        return float(self.at(time)[0])

    def _turn(self, left: float, right: float) -> float:
        return float(brentq(lambda t: float(self.at(t)[1]), left, right, xtol=1e-19, rtol=1e-15))


def flight_of(motor: Motor) -> Flight:
    """The closed flight of a motor from rest."""
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
