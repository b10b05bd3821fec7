"""A block on a belt under friction that falls with the slip, and its motion as an ODE."""

from dataclasses import dataclass
from math import exp
from typing import final

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from contactlab.laws import Composed, Linear
from contactlab.laws.friction import Stribeck as StribeckFriction
from contactlab.motor.motor import Motor
from contactlab.testing.plants import block

Array = NDArray[np.float64]

MASS, WEIGHT, SPRING = 1e-2, 10.0, 1e5
"""Block on a belt [kg], [N], [N/m]."""


@final
@dataclass(frozen=True)
class Stribeck:
    """Numbers of N = k d, |F| <= mu(v) N with mu(v) = mu + (mu_s - mu) exp(-(|v|/v_s)^p), SI units."""

    stiffness: float = 1e7
    static_friction: float = 0.4
    kinetic_friction: float = 0.2
    stribeck_velocity: float = 1e-2
    power: float = 2.0

    @property
    def law(self) -> Composed:
        """The law of these numbers."""
        mu, ratio = self.kinetic_friction, self.static_friction / self.kinetic_friction
        friction = StribeckFriction(mu, ratio, self.stribeck_velocity, self.power)
        return Composed(Linear(self.stiffness), friction=friction)

    def bound(self, normal: float, slip: float) -> float:
        """Largest friction [N]."""
        fall = exp(-((abs(slip) / self.stribeck_velocity) ** self.power))
        mu = self.kinetic_friction + (self.static_friction - self.kinetic_friction) * fall
        return mu * max(normal, 0.0)


@final
@dataclass(frozen=True)
class Belt:
    """A block that its weight presses on a belt and a spring of 1e5 N/m pulls to way zero.

    Args:
        law: of the contact.
        depth: penetration at the start [m].
        way, velocity: along the belt at the start [m], [m/s].
        belt_velocity: [m/s].
    """

    law: Stribeck
    depth: float
    way: float = 0.0
    velocity: float = 0.05
    belt_velocity: float = 0.05

    @property
    def motor(self) -> Motor:
        """The motor of the engine."""
        return block(
            MASS,
            height=-self.depth,
            weight=WEIGHT,
            way=self.way,
            velocity=self.velocity,
            stiffness=SPRING,
            belt_velocity=self.belt_velocity,
        )

    def end(self, duration: float) -> Array:
        """Way and velocity [m], [m/s] after a time, every switch an event of an ODE at 1e-12.

        Raises:
            RuntimeError: the switches do not end.
        """
        t, y = 0.0, np.array([self.depth, 0.0, self.way, self.velocity])
        mode = int(np.sign(self.velocity - self.belt_velocity)) or self._mode_from_rest(y)
        for _ in range(200):
            solved = solve_ivp(
                self._rates,
                (t, duration),
                y,
                method="DOP853",
                rtol=1e-12,
                atol=[1e-17, 1e-13, 1e-16, 1e-13],
                events=_leaves,
                max_step=2e-5,
                args=(self, mode),
            )
            t, y = float(solved.t[-1]), solved.y[:, -1].copy()
            if solved.status == 0:
                return y[2:]
            y[3] = self.belt_velocity
            # Stick that has reached its bound must slip, whatever round-off says of it.
            mode = self._mode_from_rest(y) if mode != 0 else int(np.sign(-y[2]))
        raise RuntimeError(f"More than 200 switches before {t} s.")

    def _sinking(self, y: Array) -> float:
        return float((WEIGHT - self.law.stiffness * y[0]) / MASS)

    def bound(self, y: Array, slip: float) -> float:
        """Largest friction [N] at a slip [m/s]."""
        return self.law.bound(self.law.stiffness * y[0], slip)

    def _mode_from_rest(self, y: Array) -> int:
        pull = -SPRING * y[2]
        if abs(pull) <= self.bound(y, 0.0):
            return 0
        return 1 if pull > 0.0 else -1

    @staticmethod
    def _rates(_: float, y: Array, belt: "Belt", mode: int) -> list[float]:
        if mode == 0:
            return [y[1], belt._sinking(y), belt.belt_velocity, 0.0]
        rubbed = -mode * belt.bound(y, max(mode * (y[3] - belt.belt_velocity), 0.0))
        return [y[1], belt._sinking(y), y[3], (rubbed - SPRING * y[2]) / MASS]


def _leaves(_: float, y: Array, belt: Belt, mode: int) -> float:
    """Falls through zero where stick reaches its bound or slip its end."""
    if mode == 0:
        return belt.bound(y, 0.0) - SPRING * abs(float(y[2]))
    return float(mode * (y[3] - belt.belt_velocity))


_leaves.terminal, _leaves.direction = True, -1.0  # type: ignore[attr-defined]
