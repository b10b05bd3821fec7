"""The oscillator that hits a stop, and its motions of one impact a period in closed form.

    xdd + 2 zeta omega_0 xd + omega_0^2 x = F cos(omega t),   x <= sigma,   xd+ = -e xd- where x = sigma

With omega_0 = 0 and a weight it is the ball that bounces on a table, seen from the table.

Source: Shaw and Holmes, J. Sound Vib. 90 (1983) 129; Guckenheimer and Holmes, Nonlinear Oscillations (1983),
sec. 2.4; Nordmark, J. Sound Vib. 145 (1991) 279.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

import contactlab as cl


@final
@dataclass(frozen=True)
class ImpactOscillator:
    """An oscillator of unit mass with a stop.

    Args:
        stop: sigma [m].
        restitution: e [1].
        force, frequency: F [N] and omega [rad/s].
        stiffness, damping: omega_0^2 [N/m] and 2 zeta omega_0 [N s/m].
        weight: constant force towards the stop [N].
    """

    stop: float
    restitution: float
    force: float
    frequency: float
    stiffness: float = 1.0
    damping: float = 0.0
    weight: float = 0.0

    def setup(self, displacement: float = 0.0, velocity: float = 0.0) -> cl.Setup:
        """Return it as a motor whose tip is the mass and whose rotor is the stop, without friction."""
        modes = cl.NormalModes(
            stiffness=np.array([self.stiffness]),
            damping=np.array([self.damping]),
            coupling=np.array([[1.0, 0.0]]),
            tip_displacement=np.array([1.0]),
            tip_slope=np.array([0.0]),
            shape_coupling=np.zeros((1, 2)),
        )
        motor = cl.Motor(
            modes,
            cl.Drive(np.array([self.frequency / (2.0 * np.pi)]), np.array([[self.force + 0j], [0j]])),
            cl.ContactGeometry(clearance=self.stop),
            preload=np.array([self.weight]),
            start=cl.ModalState(np.array([displacement]), np.array([velocity])),
        )
        return cl.Setup.of(motor, cl.Newton(0.0, self.restitution), self.period)

    @property
    def period(self) -> float:
        """Period of the force [s]."""
        return 2.0 * np.pi / self.frequency

    @cached_property
    def response(self) -> complex:
        """Phasor X of the motion without a stop, Re X exp(i omega t), about that under the weight [m]."""
        w = self.frequency
        return self.force / (self.stiffness - w**2 + 1j * self.damping * w)

    @property
    def grazing_stop(self) -> float:
        """The stop that the motion without impact just reaches [m]."""
        return abs(self.response) + self.weight / self.stiffness

    @cached_property
    def flow(self) -> np.ndarray:
        """What a period does to displacement and velocity without force, shape (2, 2)."""
        rates = np.array([[0.0, 1.0], [-self.stiffness, -self.damping]])
        return np.asarray(expm(rates * self.period))

    def impacts(self) -> tuple["Impact", ...]:
        """Return the motions with one impact a period, by falling speed of the impact; two, one or none.

        Between impacts the motion is the response p plus a free one h, whose period takes it from after
        the impact to before the next: h- = Phi h+, with h+- = (sigma - p, xd+- - pd) and xd+ = -e xd-. So
        (sigma - p, -pd) = xd- w, w = (Phi - 1)^-1 (1 + e Phi) (0, 1), and p^2 + (pd / omega)^2 = |X|^2 is
        a quadratic equation for xd-.
        """
        if self.stiffness == 0.0:
            return self._bounces()
        after = (np.eye(2) + self.restitution * self.flow)[:, 1]
        w = np.asarray(np.linalg.solve(self.flow - np.eye(2), after), dtype=np.float64)
        # From the place of rest under the weight.
        stop = self.stop - self.weight / self.stiffness
        a = w[0] ** 2 + (w[1] / self.frequency) ** 2
        roots = np.roots([a, -2.0 * stop * w[0], stop**2 - abs(self.response) ** 2])
        speeds = sorted((float(v.real) for v in roots if v.imag == 0.0 and v.real > 0.0), reverse=True)
        return tuple(Impact(self, v, self._angle_at(stop, v, w)) for v in speeds)

    def _angle_at(self, stop: float, speed: float, w: np.ndarray) -> float:
        """Return the angle of the drive at the stop, where p - i pd / omega = X exp(i phi)."""
        place, rate = stop - speed * w[0], -speed * w[1]
        return float(np.angle((place - 1j * rate / self.frequency) / self.response))

    def _bounces(self) -> tuple["Impact", ...]:
        """Return those of the ball, of speed g T / (1 + e), with F sin(phi) = pi g (1 - e) / (1 + e)."""
        e = self.restitution
        across = np.pi * self.weight * (1.0 - e) / (1.0 + e)
        if self.force < across:
            return ()
        speed, along = self.weight * self.period / (1.0 + e), np.sqrt(self.force**2 - across**2)
        return tuple(Impact(self, speed, float(np.arctan2(across, side))) for side in (-along, along))

    @property
    def ball_doubles_at(self) -> float:
        """The force at which the period of the ball doubles [N], where 1 + tr + det = 0.

        The map of Guckenheimer and Holmes, for bounces that are high against the way of the table, has 1 in
        place of 2 (1 + e^2) / (1 + e)^2; the fold is the same.
        """
        e, g = self.restitution, self.weight
        return float(g * np.hypot(np.pi * (1.0 - e) / (1.0 + e), 2.0 * (1.0 + e**2) / (1.0 + e) ** 2))

    @property
    def ball_begins_at(self) -> float:
        """The force at which the two motions of the ball meet in a fold [N]."""
        return float(np.pi * self.weight * (1.0 - self.restitution) / (1.0 + self.restitution))


@final
@dataclass(frozen=True)
class Impact:
    """The impact of a motion with one a period: its speed xd- [m/s] and the angle of the drive then [rad]."""

    oscillator: ImpactOscillator
    speed: float
    angle: float

    def later(self, part: float) -> tuple[float, np.ndarray]:
        """Return the phase of the drive in periods, displacement and velocity, a part of a period later."""
        it = self.oscillator
        rates = np.array([[0.0, 1.0, 0.0], [-it.stiffness, -it.damping, it.weight], [0.0, 0.0, 0.0]])
        turns = np.exp(1j * (self.angle + 2.0 * np.pi * np.array([0.0, part])))
        p = np.real(it.response * turns * np.array([[1.0], [1j * it.frequency]]))
        after = np.array([it.stop, -it.restitution * self.speed])
        free = expm(rates * part * it.period) @ np.append(after - p[:, 0], 1.0)
        return float((self.angle / (2.0 * np.pi) + part) % 1.0), free[:2] + p[:, 1]

    @property
    def jacobian(self) -> np.ndarray:
        """Derivative of the map over a period, from after an impact to after the next, shape (2, 2).

        It is S Phi, where S = [[-e, 0], [(xdd+ + e xdd-) / xd-, -e]] is what the impact does to a motion
        that hits the stop a little earlier or later.
        """
        it = self.oscillator
        e = it.restitution
        still = it.force * np.cos(self.angle) + it.weight - it.stiffness * it.stop
        before, after = still - it.damping * self.speed, still + it.damping * e * self.speed
        jump = np.array([[-e, 0.0], [(after + e * before) / self.speed, -e]])
        return np.asarray(jump @ it.flow)

    @property
    def doubling(self) -> float:
        """Zero where the period doubles: det(J + 1) = 1 + tr J + det J."""
        return float(1.0 + np.trace(self.jacobian) + np.linalg.det(self.jacobian))


def doubling_between(oscillator_at: Callable[[float], ImpactOscillator], low: float, high: float) -> float:
    """Return the parameter at which the period of the faster impact doubles, between two values."""
    return float(brentq(lambda value: oscillator_at(value).impacts()[0].doubling, low, high, xtol=1e-14))
