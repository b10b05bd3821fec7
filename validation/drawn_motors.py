"""Drawn motors of `experiments/law_contrasts.py` solved again by the independent solver of `oracle`.

A steady state is a fixed point z of the map P of some periods of the drive. The solver has a map of its own,

    z <- z + (1 - dP/dz)^-1 (P(z) - z),

from the engine's orbit, whose derivative only says where to: what it ends at is the solver's fixed point, and
the mean of the rotor's velocity over it is the solver's speed. Beside the modes of the resonator, which are
the input of both, nothing is shared: bearing, contact, laws, flights and impacts are written again.

Left out is `flores` with `mindlin`: the solver's slider leaves its bound mu N by the rate of an elastic force
N, and that of a damped one is not written.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import acos, exp, sqrt
from typing import Any, Final

import numpy as np
from law_contrasts import begin, law_at, settle
from motor_population import LAWS, closed_force, modes_of
from oracle.composed import Judge, JudgedRun, Parts
from oracle.flight import Flight
from oracle.friction_parts import SetValued
from oracle.motor import Law, Mechanics, OracleMotor
from oracle.normal_parts import Damping, Power, hysteretic, loss_number
from oracle.resonator import Resonator
from oracle.rigid import Impact, RigidJudge, Rough, johnson, newton, process, slip_only
from scipy.optimize import brentq

import contactlab as cl
from contactlab.steady_state import Steady

JUDGED: Final = [name for name in LAWS if name != "flores, mindlin"]
"""Laws that the solver has."""

RTOL: Final = 1e-10

CLOSED, MOST = 1e-7, 6
"""Relative distance that is left of a fixed point, and the most steps towards it."""


@dataclass(frozen=True, kw_only=True)
class DrawnMotor(OracleMotor):
    """A motor of which the modes are given: unit masses, of the resonator without the rotor."""

    modes: Any

    def resonator(self) -> Resonator:
        """Matrices of the modes."""
        m = self.modes
        return Resonator(
            np.eye(m.stiffness.size),
            np.diag(m.damping),
            np.diag(m.stiffness),
            np.asarray(m.coupling),
            np.vstack([m.tip_displacement, m.tip_slope]),
        )


class Turning(Mechanics):
    """Mechanics that have the rotor's angle in place of the normal impulse."""

    def derivative(self, t: float, y: np.ndarray, law: Law) -> np.ndarray:
        out = super().derivative(t, y, law)
        out[2 * self.shapes + 1] = y[2 * self.shapes]
        return out

    def push(self, y: np.ndarray, c: Any, p_n: float, p_t: float) -> np.ndarray:
        out = super().push(y, c, p_n, p_t)
        out[2 * self.shapes + 1] = y[2 * self.shapes + 1]
        return out


class TurningJudge(Judge):
    """A compliant law, with the rotor's angle."""

    def take(self, motor: OracleMotor) -> None:
        self.mechanics = Turning(motor)
        self.flight = Flight(self.mechanics)

    def derivative(self, t: float, y: np.ndarray, modes: tuple[int, int], speed: float) -> np.ndarray:
        out = super().derivative(t, y, modes, speed)
        out[2 * self.n + 1] = y[2 * self.n]
        return out

    def passed(self, t: float, y: np.ndarray, end: float) -> np.ndarray:
        """The state at `end` [s] from one in flight; only motion and angle of it count."""
        n, run, cut = self.n, JudgedRun(), None
        whole = np.zeros(self.third + 1)
        whole[: 2 * n + 1] = y[: 2 * n + 1]
        y = whole
        while t < end:
            if cut is None:
                begun = t
                t, y = self.fly(t, y, end)
                y[2 * n + 1] += y[2 * n] * (t - begun)
            if t < end:
                t, y, cut = self.dwell(run, t, y, end, cut)
        return y[: 2 * n + 2]


class TurningRigidJudge(RigidJudge):
    """A rigid law, with the rotor's angle."""

    def take(self, motor: OracleMotor) -> None:
        self.mechanics = Turning(motor)
        self.flight = Flight(self.mechanics)

    def passed(self, t: float, y: np.ndarray, end: float) -> np.ndarray:
        """The state at `end` [s] from one in flight; only motion and angle of it count."""
        n, lasts = self.mechanics.shapes, False
        whole = np.zeros(2 * n + 3)
        whole[: 2 * n + 1] = y[: 2 * n + 1]
        y = whole
        while t < end:
            if not lasts:
                begun = t
                t, y, down = self.flight.until(t, y, end, lambda _: 0.0)
                y[2 * n + 1] += y[2 * n] * (t - begun)
                if not down:
                    break
                y, lasts = self.meet(t, y)
            if lasts:
                t, y = self.last(t, y, end)
                lasts = t == end
        return y[: 2 * n + 2]


def spring_dashpot(law: Any, stiffness: float) -> Damping:
    """Tsuji's dashpot on Hertz's K: sqrt(5) zeta sqrt(m K) d^(1/4), zeta by the restitution at N = 0."""
    e, mass = law.damping.restitution, law.damping.effective_mass
    zeta = brentq(lambda z: exp(-2.0 * z * acos(z) / sqrt(1.0 - z * z)) - e, 0.0, 1.0 - 1e-12, xtol=1e-15)

    def damped(f: float, rate: float, speed: float) -> float:
        d = (max(f, 0.0) / stiffness) ** (2.0 / 3.0)
        return float(max(f + sqrt(5.0) * zeta * sqrt(mass * stiffness) * d**0.25 * rate, 0.0))

    return damped


def judge_of(name: str, law: Any, motor: DrawnMotor) -> TurningJudge | TurningRigidJudge:
    """The solver of a motor under a law that is written again from its numbers."""
    mu = motor.friction_coefficient
    if hasattr(law, "normal"):
        stiffness = law.normal.stiffness
        if name == "tsuji":
            damped = spring_dashpot(law, stiffness)
        else:
            damped = hysteretic(loss_number(law.damping.restitution), least=law.damping.least_speed)
        return TurningJudge(motor, Parts(Power(stiffness, 1.5), SetValued(mu), damped), RTOL)
    impact: Impact
    match name:
        case "lagrange_slip":
            impact = slip_only(mu)
        case "lagrange_stick":
            impact = newton(mu, 0.0)
        case "johnson":
            impact = johnson(mu, law.modulus, law.yield_strength, law.radius)
        case "newton":
            impact = newton(mu, law.restitution)
        case _:
            impact = process(mu, law.restitution, name == "stronge")
    return TurningRigidJudge(motor, impact, Rough(mu), RTOL)


class Drawn:
    """A motor of the population."""

    def __init__(self, number: int) -> None:
        self.drawn, self.made, self.speed = begin(number)

    def steady(self, name: str) -> Steady | None:
        """The engine's steady state under a law; None if there is none, or no such law of the motor."""
        try:
            return settle(self.made, law_at(name, self.drawn, self.made, self.speed))[1]
        except ValueError:
            return None

    @cached_property
    def motor(self) -> DrawnMotor:
        """The motor as the solver has it."""
        own, drive, geometry = self.drawn, self.made.drive, self.made.geometry
        modes = modes_of(own)
        bearing: dict[str, Any] = {}
        if own["pressed"]:
            preload = own["preload over closed force"] * closed_force(modes, drive, own["bearing mass"])
            bearing = {
                "rotor_mass": own["bearing mass"],
                "bearing_damping": own["bearing damping"],
                "preload": preload,
            }
        return DrawnMotor(
            modes=modes,
            tip_length=geometry.tip_length,
            rotor_radius=geometry.rotor_radius,
            rotor_inertia=own["inertia"],
            clearance=geometry.clearance,
            angle=geometry.angle,
            friction_coefficient=own["friction coefficient"],
            voltage_1=own["voltage 1"],
            voltage_2=own["voltage 2"],
            frequency=float(drive.frequency[0]),
            frequency_ratio=float(drive.frequency[1] / drive.frequency[0]),
            phase=own["phase"],
            **bearing,
        )

    def again(self, name: str, state: Steady) -> float:
        """The solver's speed [rad/s] of the steady state that the engine has under a law.

        Raises:
            RuntimeError: the solver comes to no fixed point.
            ValueError: the orbit's section does not lie in flight.
        """
        orbit = state.orbit
        if orbit is None or orbit.map.contact is not None:
            raise ValueError(f"{name} has no orbit with a section in flight.")
        judge = judge_of(name, law_at(name, self.drawn, self.made, self.speed), self.motor)
        section, n = orbit.map, self.made.modes.stiffness.size
        begun = section.phase * state.period
        z = orbit.state.copy()
        newton_step = np.linalg.inv(np.eye(z.size) - orbit.jacobian)
        for _ in range(MOST):
            modal, velocity, _ = section.parts_of(z)
            end = judge.passed(begun, self.state(modal, velocity), begun + section.period)
            moved = cl.ModalState(self.coordinates(end[:n]), self.coordinates(end[n : 2 * n]))
            step = newton_step @ (section.state_of(moved, float(end[2 * n])) - z)
            if np.linalg.norm(step) <= CLOSED * np.linalg.norm(z):
                return float(end[2 * n + 1]) / section.period
            z = z + step
        raise RuntimeError(f"{name} comes to no fixed point in {MOST} steps.")

    def coordinates(self, own: np.ndarray) -> np.ndarray:
        """Normal coordinates of the solver's amplitudes: that of the rotor times the root of its mass."""
        if not self.drawn["pressed"]:
            return own
        return np.append(own[:-1], sqrt(self.drawn["bearing mass"]) * own[-1])

    def state(self, modal: Any, velocity: float) -> np.ndarray:
        """The solver's state of normal coordinates, and the rotor's velocity [rad/s]."""
        root = sqrt(self.drawn["bearing mass"])
        parts = [np.asarray(x).copy() for x in (modal.displacement, modal.velocity)]
        if self.drawn["pressed"]:
            for part in parts:
                part[-1] /= root
        return np.concatenate([*parts, [velocity]])
