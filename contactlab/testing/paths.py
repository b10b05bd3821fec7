"""Paths that a contact is taken along: gap, gap rate and slip as given functions of time."""

from collections.abc import Callable
from dataclasses import dataclass
from math import copysign, cos, pi, sin
from typing import final

import numpy as np
from scipy.optimize import brentq

from contactlab.arrays import Array

GRID = 360
"""Steps on a path; it goes in and out three times and a half, with ripples."""

RIPPLES = (((1.0, 1.0), (0.35, 2.7), (0.1, 4.3)), ((0.8, 1.7), (0.4, 3.1), (0.4, 0.9)))
"""Shares of the sines of gap and of slip, and their frequencies over that of the first of the gap."""

DEAD = 0.3
"""Share of the slip's swing that is none, so that there is stick."""

Waves = tuple[tuple[float, float, float], ...]
"""Share, angular frequency [rad/s] and phase of each."""


@final
@dataclass(frozen=True)
class Path:
    """Gap [m], gap rate and slip [m/s] of a time [s]: sums of sines; the slip stands now and then."""

    duration: float
    begin: float  # gap about which it swings [m]
    depth: float  # [m]
    speed: float  # of the slip [m/s]
    waves: Waves
    slip_waves: Waves

    def at(self, time: float) -> tuple[float, float, float]:
        """Return all three."""
        gap, rate = self.begin, 0.0
        for share, omega, phase in self.waves:
            gap -= self.depth * share * sin(omega * time + phase)
            rate -= self.depth * share * omega * cos(omega * time + phase)
        swing = self._swing(time)
        return gap, rate, copysign(self.speed * max(abs(swing) - DEAD, 0.0), swing)

    def _swing(self, time: float) -> float:
        return sum(share * sin(omega * time + phase) for share, omega, phase in self.slip_waves)

    def switches(self) -> Array:
        """Return the times at which stick begins or ends, in their order."""

        def swing(time: float) -> float:
            return abs(self._swing(time)) - DEAD

        grid = np.linspace(0.0, self.duration, GRID + 1)
        values = np.array([swing(t) for t in grid.tolist()])
        at = np.flatnonzero(values[1:] * values[:-1] < 0.0)
        return np.array([root(swing, grid[i], grid[i + 1]) for i in at.tolist()])


def drawn_path(number: int, begin: float) -> Path:
    """Draw a path about the gap at which a first contact begins: depths to 5 um, slips to 1 m/s."""
    rng = np.random.default_rng([7, number])
    depth, approach = 10.0 ** rng.uniform(-7.5, -5.3), 10.0 ** rng.uniform(-1.5, -0.3)
    turn, phase = approach / depth, rng.uniform(0.0, 2.0 * pi, (2, 3))
    # It begins clear of the contact.
    phase[0, 0] = -0.5 * pi
    waves, slip_waves = (
        tuple((share, turn * ratio, float(at)) for (share, ratio), at in zip(shares, phases, strict=True))
        for shares, phases in zip(RIPPLES, phase, strict=True)
    )
    speed = 10.0 ** rng.uniform(-3.0, 0.0)
    return Path(7.0 * pi / turn, begin, depth, speed, waves, slip_waves)


def root(function: Callable[[float], float], start: float, end: float) -> float:
    """Return where a function that has two signs at the ends is zero, or the end that is zero already."""
    if function(start) * function(end) >= 0.0:
        return end
    return float(brentq(function, start, end, xtol=1e-18, rtol=1e-13))
