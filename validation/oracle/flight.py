"""Free flight as the flow of one linear system, and where the gap falls to a level.

Shape amplitudes, their rates and sine and cosine of both tones together are a linear system with constant
coefficients, whose matrix exponential is taken; the rotor has its own. No normal modes and no steady state.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos, exp, pi, sin

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq, minimize_scalar

from oracle.motor import Mechanics

STEP, BLOCK = 5e-7, 200
"""Distance at which the gap is looked at [s], and how many places at once."""

Level = Callable[[float], float]
"""Gap [m] at which a contact begins, a time [s] after the start of the flight."""


class Flight:
    """The flow of one motor without contact."""

    def __init__(self, mechanics: Mechanics) -> None:
        """Set up the matrix of amplitudes, rates, tones and preload, in units in which it is balanced."""
        self.mechanics, m, n = mechanics, mechanics.motor, mechanics.shapes
        w = 2.0 * pi * mechanics.frequency
        self.tones = w, m.frequency_ratio * w
        a = np.zeros((2 * n + 5, 2 * n + 5))
        a[:n, n : 2 * n] = np.eye(n)
        a[n : 2 * n, : 2 * n] = mechanics.free_map
        both, opposite = mechanics.drive_map @ [1.0, 1.0], mechanics.drive_map @ [1.0, -1.0]
        a[n : 2 * n, 2 * n] = m.voltage_1 * both
        a[n : 2 * n, 2 * n + 2] = m.voltage_2 * opposite
        a[n : 2 * n, 2 * n + 4] = mechanics.pressed
        for k, tone in enumerate(self.tones):
            i = 2 * n + 2 * k
            a[i, i + 1], a[i + 1, i] = tone, -tone
        scale = np.ones(2 * n + 5)
        scale[:n], scale[n : 2 * n] = 1e6, 1e6 / w
        self.matrix, self.scale = scale[:, None] * a / scale, scale
        each = expm(self.matrix * STEP)
        powers = [np.eye(2 * n + 5)]
        for _ in range(BLOCK):
            powers.append(each @ powers[-1])
        self.powers = np.array(powers)

    def start(self, t: float, y: np.ndarray) -> np.ndarray:
        """The scaled state of the linear system at (t, y)."""
        n, (first, second) = self.mechanics.shapes, self.tones
        phase = first * t + self.mechanics.motor.phase
        tones = np.sin(phase), np.cos(phase), np.sin(second * t), np.cos(second * t)
        return self.scale * np.concatenate([y[: 2 * n], tones, [1.0]])

    def after(self, x: np.ndarray, s: float) -> np.ndarray:
        """The scaled state a time s later, of less than a step or so."""
        return np.asarray(expm(self.matrix * s) @ x)

    def gap(self, x: np.ndarray) -> np.ndarray:
        """Gap [m] of scaled states, shape (..., state)."""
        m, n = self.mechanics.motor, self.mechanics.shapes
        r = x[..., :n] / self.scale[:n]
        u, slope = r @ self.mechanics.resonator.tip[0], r @ self.mechanics.resonator.tip[1]
        px, py = -m.tip_length * np.sin(slope), u - 2.0 * m.tip_length * np.sin(0.5 * slope) ** 2
        away = m.rotor_radius + m.clearance
        cx, cy = away * sin(m.angle), away * cos(m.angle)
        square = px * px + py * py - 2.0 * (px * cx + py * cy) + m.clearance * (m.rotor_radius + away)
        return square / (np.hypot(px - cx, py - cy) + m.rotor_radius)

    def state(self, y: np.ndarray, x: np.ndarray, s: float) -> np.ndarray:
        """The motor's state y a time s later, from the linear system's."""
        m, n = self.mechanics.motor, self.mechanics.shapes
        out = y.copy()
        out[: 2 * n] = x[: 2 * n] / self.scale[: 2 * n]
        omega, torque = y[2 * n], m.load_torque / m.rotor_inertia
        rate = m.rotor_damping / m.rotor_inertia
        # (1 - exp(-rate s))/rate
        spent = -np.expm1(-rate * s) / rate if rate > 0.0 else s
        out[2 * n] = omega * exp(-rate * s) - torque * spent
        return out

    def until(
        self, t: float, y: np.ndarray, end: float, level: Level, upwards: bool = False
    ) -> tuple[float, np.ndarray, bool]:
        """Fly from (t, y) until the gap falls to the level (rises to it: upwards) or to `end` [s]."""
        sign, x, begun = -1.0 if upwards else 1.0, self.start(t, y), 0.0
        while t + begun < end:
            states = self.powers @ x
            times = begun + STEP * np.arange(BLOCK + 1)
            room = sign * (self.gap(states) - np.array([level(s) for s in times]))
            k = self._crossing(states, times, room, sign, level, first=begun == 0.0)
            if k is not None:
                i, s = k
                if t + times[i] + s > end:
                    break
                x = self.after(states[i], s)
                return t + times[i] + s, self.state(y, x, times[i] + s), True
            if t + times[-1] > end:
                break
            x, begun = states[-1], float(times[-1])
        left = end - t - begun
        whole = int(left / STEP)
        x = self.after(self.powers[whole] @ x, left - whole * STEP)
        return end, self.state(y, x, end - t), False

    def _crossing(
        self, states: np.ndarray, times: np.ndarray, room: np.ndarray, sign: float, level: Level, first: bool
    ) -> tuple[int, float] | None:
        """Index of the place before the first crossing, and the time from there [s]."""

        def at(i: int, s: float) -> float:
            return sign * (float(self.gap(self.after(states[i], s))) - level(float(times[i]) + s))

        def root(i: int, low: float, high: float) -> tuple[int, float]:
            return i, float(brentq(lambda s: at(i, s), low, high, xtol=1e-19, rtol=1e-15))

        for i in range(1, len(room)):
            begins = first and i == 1
            if room[i] < 0.0:
                low = 0.0
                if (begins and room[0] <= 0.0) or begins:
                    # It starts on the level: look for where it is off it.
                    shares = [s for s in STEP * 0.5 ** np.arange(1, 30) if at(0, s) > 0.0]
                    if not shares and room[0] <= 0.0:
                        return 0, 0.0
                    low = shares[0] if shares else 0.0
                return root(i - 1, low, STEP)
            if i + 1 < len(room) and room[i] < room[i - 1] and room[i] <= room[i + 1]:
                dip = (room[i - 1] - room[i]) + (room[i + 1] - room[i])
                if room[i] < dip:
                    low = minimize_scalar(
                        lambda s, i=i: at(i - 1, s),
                        bounds=(0.0, 2.0 * STEP),
                        method="bounded",
                        options={"xatol": 1e-6 * STEP},
                    )
                    if low.fun < 0.0:
                        return root(i - 1, 0.0 if not begins else 1e-3 * STEP, float(low.x))
        return None
