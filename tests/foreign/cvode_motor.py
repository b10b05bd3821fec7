"""The motor with Hertz contact as ordinary differential equations and root functions for CVODE.

State, n modes: y = (q_1..q_n, qd_1..qd_n, Omega, alpha, P_n, P_t) in SI; P are the impulses of N and F.

    qdd_j = -k_j q_j - c_j qd_j + drive_j(t) + N n_j + F t_j,   J Omegad = -R F - C_r Omega - tau
    N = K max(-g, 0)^1.5
    slip    F = -mu N sign(v)
    stick   F such that vd = 0, as long as |F| <= mu N

Friction is set-valued, so that every phase (flight, slip with either sign, stick) is a smooth
problem of its own, which a root function ends: gap zero, slip zero or the edge of the cone.
"""

from collections.abc import Callable
from math import cos, hypot, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from foreign.problem import Problem

Array = NDArray[np.float64]

FLIGHT, STICK, SLIP_FORWARD, SLIP_BACKWARD = "flight", "stick", "slip +", "slip -"
SIGN = {SLIP_FORWARD: 1, SLIP_BACKWARD: -1}


class Instant(NamedTuple):
    """Contact quantities of one state: gap [m], slip [m/s], slip rate without contact [m/s^2], rows."""

    gap: float
    slip: float
    slip_rate: float
    normal: Array
    tangent: Array


class HertzMotor:
    """Right-hand side and root functions of one motor.

    Args:
        problem: the motor.
        stiffness: K [N m^-3/2].
        friction_coefficient: mu [1].
    """

    def __init__(self, problem: Problem, stiffness: float, friction_coefficient: float) -> None:
        self.problem, self.hertz, self.mu = problem, stiffness, friction_coefficient
        self.modes = len(problem["stiffness"])
        self.k, self.c = np.array(problem["stiffness"]), np.array(problem["damping"])
        self.cosines, self.sines = np.array(problem["force_re"]), np.array(problem["force_im"])
        self.omega = np.array(problem["omega"])
        self.rows = np.array([problem["tip_displacement"], problem["tip_slope"]])

    def free_acceleration(self, t: float, y: Array) -> Array:
        """Modal accelerations without contact."""
        n = self.modes
        turn = self.omega * t
        drive = self.cosines @ np.cos(turn) - self.sines @ np.sin(turn)
        return np.asarray(drive - self.k * y[:n] - self.c * y[n : 2 * n])

    def rotor_acceleration(self, rotor_velocity: float, friction: float) -> float:
        """Omegad [rad/s^2]."""
        p = self.problem
        torque = -p["rotor_radius"] * friction - p["rotor_damping"] * rotor_velocity
        return float(torque - p["load_torque"]) / p["rotor_inertia"]

    def instant(self, y: Array, acceleration: Array) -> Instant:
        """The contact of state y with modal accelerations as they are without contact.

        d = tip - centre,  e = d/|d|,  t = e turned by +90 degrees,  a = second derivative of d
        g = |d| - R,  v = t.d' - R Omega,  v' = t.a - (e.d')(t.d')/|d| - R Omega'
        """
        p, n = self.problem, self.modes
        arm, radius = p["tip_length"], p["rotor_radius"]
        (u, th), (_, th_rate) = self.rows @ y[:n], self.rows @ y[n : 2 * n]
        s, c = sin(th), cos(th)
        rise = u - p["clearance"] - 2.0 * arm * sin(0.5 * th) ** 2
        distance = hypot(arm * s, rise - radius)
        gap = ((arm * s) ** 2 + rise * (rise - 2.0 * radius)) / (distance + radius)
        e = np.array([-arm * s, rise - radius]) / distance
        t = np.array([-e[1], e[0]])
        jacobian = np.array([[0.0, -arm * c], [1.0, -arm * s]]) @ self.rows
        speed = jacobian @ y[n : 2 * n]
        total = jacobian @ acceleration + arm * th_rate**2 * np.array([s, -c])
        rotor_velocity = float(y[2 * n])
        slip_rate = t @ total - (e @ speed) * (t @ speed) / distance
        return Instant(
            gap=gap,
            slip=float(t @ speed) - radius * rotor_velocity,
            slip_rate=float(slip_rate) - radius * self.rotor_acceleration(rotor_velocity, 0.0),
            normal=e @ jacobian,
            tangent=t @ jacobian,
        )

    def normal_force(self, now: Instant) -> float:
        """N [N]."""
        return self.hertz * max(-now.gap, 0.0) ** 1.5

    def sticking_force(self, now: Instant) -> float:
        """F [N] that leaves no slip rate."""
        p = self.problem
        mobility = now.tangent @ now.tangent + p["rotor_radius"] ** 2 / p["rotor_inertia"]
        coupled = now.slip_rate + (now.tangent @ now.normal) * self.normal_force(now)
        return float(-coupled / mobility)

    def forces(self, now: Instant, phase: str) -> tuple[float, float]:
        """N and F [N] in a phase."""
        if phase == FLIGHT:
            return 0.0, 0.0
        normal = self.normal_force(now)
        friction = self.sticking_force(now) if phase == STICK else -SIGN[phase] * self.mu * normal
        return normal, friction

    def right_hand_side(self, phase: str) -> Callable[[float, Array, Array], None]:
        """The equations of a phase."""
        n = self.modes

        def rates(t: float, y: Array, out: Array) -> None:
            acceleration = self.free_acceleration(t, y)
            now = self.instant(y, acceleration)
            normal, friction = self.forces(now, phase)
            out[:n] = y[n : 2 * n]
            out[n : 2 * n] = acceleration + normal * now.normal + friction * now.tangent
            out[2 * n] = self.rotor_acceleration(y[2 * n], friction)
            out[2 * n + 1] = y[2 * n]
            out[2 * n + 2], out[2 * n + 3] = normal, friction

        return rates


class Roots:
    """What ends a phase, as CVODE wants it: the gap first, then slip zero, or both edges of the cone.

    direction: +1 for a zero crossed upwards, -1 downwards.
    """

    def __init__(self, motor: HertzMotor, phase: str) -> None:
        self.motor, self.phase = motor, phase
        edges = 2 if phase == STICK else 1
        if phase == FLIGHT or motor.mu == 0.0:
            edges = 0
        self.direction = [-1 if phase == FLIGHT else 1] + [-1] * edges
        self.terminal = [True] * len(self.direction)

    def __call__(self, t: float, y: Array, out: Array) -> None:
        motor = self.motor
        now = motor.instant(y, motor.free_acceleration(t, y))
        out[0] = now.gap
        if self.phase == STICK:
            bound, friction = motor.mu * motor.normal_force(now), motor.sticking_force(now)
            out[1], out[2] = bound - friction, bound + friction
        elif len(self.direction) == 2:
            out[1] = SIGN[self.phase] * now.slip
