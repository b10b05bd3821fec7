"""The motor of the oracle: its inputs, and its equations of motion seen from the one contact point.

State vector, n shapes (SI units):

    y = (r_1..r_n, r'_1..r'_n, Omega, P_n, P_t)

Signs: the gap g is positive when open; N >= 0 and F act on the tip along n (rotor centre to tip)
and t (n turned by +90 degrees: at rest n = (0, -1), t = (1, 0)); slip = v_T - R Omega;
J Omega' = -R F - C_r Omega - tau.  P_n and P_t are the impulses of N and F [N s].

A rotor on a bearing has its displacement w away from the tip for a last amplitude,

    m w'' + c w' + k w = N_u - P,   N_u = -(N n + F t) . y

so that with the row (psi(L/2), -1) in place of psi(L/2) the tip's u is that relative to the rotor: the gap
and its rates have it, and the contact's force acts on both.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, hypot, pi, sin
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from oracle.resonator import Resonator, Section, build_resonator, natural_frequencies


@dataclass(frozen=True, kw_only=True)
class OracleMotor:
    """All inputs of one run, SI units; by default placement 2 of Table 1, identified inputs.

    frequency None means the first natural frequency; the second tone has frequency_ratio times it. A
    rotor_mass of zero is a fixed axle; else the rotor begins at rest at the displacement rotor_start.
    """

    length: float = 57e-3
    width: float = 16e-3
    beam_thickness: float = 1e-3
    piezo_thickness: float = 1e-3
    patch_start: float = 0.914e-3
    patch_end: float = 10.146e-3
    tip_mass: float = 1.181e-3
    tip_inertia: float = 1.321e-7
    tip_length: float = 19e-3
    rotor_radius: float = 25e-3
    rotor_inertia: float = 4.8e-5
    rotor_damping: float = 0.0
    load_torque: float = 0.0
    initial_velocity: float = 0.0
    rotor_mass: float = 0.0
    bearing_stiffness: float = 0.0
    bearing_damping: float = 0.0
    preload: float = 0.0
    rotor_start: float = 0.0
    clearance: float = 1e-6
    angle: float = 0.0
    friction_coefficient: float = 0.3
    voltage_1: float = 100.0
    voltage_2: float = 100.0
    frequency: float | None = None
    frequency_ratio: float = 2.0
    phase: float = -pi / 5.0
    shapes: int = 4
    mass_damping: float = 7.5
    stiffness_damping: float = 2e-5
    steel_modulus: float = 210e9
    steel_poisson: float = 0.3
    steel_density: float = 7850.0
    piezo_bending_modulus: float = 94.295e9
    piezo_bending_coupling: float = 9.196
    piezo_density: float = 7700.0

    def resonator(self) -> Resonator:
        """Matrices of this motor's resonator."""
        section = Section(*(getattr(self, name) for name in Section._fields))
        return build_resonator(
            section, self.shapes, self.tip_mass, self.tip_inertia, self.mass_damping, self.stiffness_damping
        )

    def with_bearing(self) -> Resonator:
        """Matrices of the resonator, and of the rotor on its bearing where it has one."""
        res = self.resonator()
        if not self.rotor_mass:
            return res
        return Resonator(
            block_diag(res.mass, [[self.rotor_mass]]),
            block_diag(res.damping, [[self.bearing_damping]]),
            block_diag(res.stiffness, [[self.bearing_stiffness]]),
            np.vstack([res.coupling, np.zeros((1, 2))]),
            np.hstack([res.tip, [[-1.0], [0.0]]]),
        )


class Contact(NamedTuple):
    """The motor at one instant, reduced to its contact point."""

    gap: float  # g, m
    gap_rate: float  # m/s
    slip: float  # v_T - R Omega, m/s
    normal_bias: float  # second derivative of the gap if N = F = 0, m/s^2
    slip_bias: float  # derivative of the slip if N = F = 0, m/s^2
    dnn: float  # Delassus matrix of (gap, slip), 1/kg
    dnt: float
    dtt: float
    n_row: tuple[float, float]  # gap rate per (u rate, slope rate)
    t_row: tuple[float, float]  # v_T per (u rate, slope rate)


Law = Callable[[Contact], tuple[float, float]]
"""Gives (N, F) [N] from the instant."""


class Mechanics:
    """Right-hand side, contact kinematics and energies of one motor."""

    def __init__(self, motor: OracleMotor) -> None:
        """Assemble the matrices of the motor."""
        self.motor = motor
        self.resonator = res = motor.with_bearing()
        self.shapes = n = len(res.mass)
        inverse = np.linalg.inv(res.mass)
        self.free_map = -inverse @ np.hstack([res.stiffness, res.damping])
        self.drive_map = inverse @ res.coupling
        self.tip_response = inverse @ res.tip.T
        (self.w_uu, self.w_us), (_, self.w_ss) = (res.tip @ self.tip_response).tolist()
        # One product gives u, slope and their rates.
        self.tip_map = np.zeros((4, 2 * n))
        self.tip_map[:2, :n] = self.tip_map[2:, n:] = res.tip
        values = motor.frequency
        self.frequency = float(natural_frequencies(motor.resonator())[0] if values is None else values)
        self.pressed = np.zeros(n)
        if motor.rotor_mass:
            self.pressed[-1] = -motor.preload / motor.rotor_mass

    def initial_state(self) -> np.ndarray:
        """At rest, undeformed, the rotor at its initial velocity."""
        y = np.zeros(2 * self.shapes + 3)
        if self.motor.rotor_mass:
            y[self.shapes - 1] = self.motor.rotor_start
        y[2 * self.shapes] = self.motor.initial_velocity
        return y

    def voltages(self, t: float) -> np.ndarray:
        """(U_A, U_B) = U1 sin(w1 t + phi) +- U2 sin(w2 t) [V] (eqs. 1-2)."""
        m = self.motor
        w1 = 2.0 * pi * self.frequency
        first = m.voltage_1 * sin(w1 * t + m.phase)
        second = m.voltage_2 * sin(m.frequency_ratio * w1 * t)
        return np.array([first + second, first - second])

    def free_acceleration(self, t: float, y: np.ndarray) -> np.ndarray:
        """r'' without contact [m/s^2]."""
        free = self.free_map @ y[: 2 * self.shapes] + self.drive_map @ self.voltages(t)
        return np.asarray(free + self.pressed)

    def contact_under(self, y: np.ndarray, acceleration: np.ndarray) -> Contact:
        """Gap, rates, biases and Delassus matrix (eqs. 35-46 with the true tangent).

        gap'' = n.J r'' + n.(J' r') + v_T^2/d,   d = |tip - centre|
        v_T'  = t.J r'' + t.(J' r') - v_T gap'/d

        `acceleration` is r'' without contact [m/s^2].
        """
        m = self.motor
        arm, radius = m.tip_length, m.rotor_radius
        u, slope, u_rate, slope_rate = (self.tip_map @ y[: 2 * self.shapes]).tolist()
        u_acc, slope_acc = (self.resonator.tip @ acceleration).tolist()
        sn, cs = sin(slope), cos(slope)
        # The tip's way p from rest and the centre's place c: |p - c|^2 - R^2 = p.p - 2 p.c + g_0 (2 R + g_0).
        away = radius + m.clearance
        px, py = -arm * sn, u - 2.0 * arm * sin(0.5 * slope) ** 2
        cx, cy = away * sin(m.angle), away * cos(m.angle)
        dx, dy = px - cx, py - cy
        distance = hypot(dx, dy)
        square = px * px + py * py - 2.0 * (px * cx + py * cy) + m.clearance * (radius + away)
        gap = square / (distance + radius)
        nx, ny = dx / distance, dy / distance
        tx, ty = -ny, nx
        nu, ns = ny, -arm * (nx * cs + ny * sn)
        tu, ts = ty, -arm * (tx * cs + ty * sn)
        gap_rate = nu * u_rate + ns * slope_rate
        tip_speed = tu * u_rate + ts * slope_rate
        swing = arm * slope_rate * slope_rate
        b_n = swing * (nx * sn - ny * cs) + tip_speed * tip_speed / distance
        b_t = swing * (tx * sn - ty * cs) - tip_speed * gap_rate / distance
        omega = float(y[2 * self.shapes])
        rotor_acc = -(m.rotor_damping * omega + m.load_torque) / m.rotor_inertia
        wnu, wns = self.w_uu * nu + self.w_us * ns, self.w_us * nu + self.w_ss * ns
        dtt = tu * (self.w_uu * tu + self.w_us * ts) + ts * (self.w_us * tu + self.w_ss * ts)
        return Contact(
            gap,
            gap_rate,
            tip_speed - radius * omega,
            nu * u_acc + ns * slope_acc + b_n,
            tu * u_acc + ts * slope_acc + b_t - radius * rotor_acc,
            nu * wnu + ns * wns,
            tu * wnu + ts * wns,
            dtt + radius * radius / m.rotor_inertia,
            (nu, ns),
            (tu, ts),
        )

    def contact(self, t: float, y: np.ndarray) -> Contact:
        """The instant (t, y) seen from the contact point."""
        return self.contact_under(y, self.free_acceleration(t, y))

    def derivative(self, t: float, y: np.ndarray, law: Law) -> np.ndarray:
        """Time derivative of y with the contact forces of `law`."""
        m, n = self.motor, self.shapes
        acceleration = self.free_acceleration(t, y)
        c = self.contact_under(y, acceleration)
        normal, friction = law(c)
        load = [normal * c.n_row[i] + friction * c.t_row[i] for i in (0, 1)]
        out = np.empty_like(y)
        out[:n] = y[n : 2 * n]
        out[n : 2 * n] = acceleration + self.tip_response @ load
        torque = -m.rotor_radius * friction - m.rotor_damping * y[2 * n] - m.load_torque
        out[2 * n :] = torque / m.rotor_inertia, normal, friction
        return out

    def push(self, y: np.ndarray, c: Contact, p_n: float, p_t: float) -> np.ndarray:
        """State after the impulses p_n, p_t [N s], which are booked in P_n and P_t too."""
        n, out = self.shapes, y.copy()
        on_tip = [p_n * c.n_row[i] + p_t * c.t_row[i] for i in (0, 1)]
        out[n : 2 * n] += self.tip_response @ on_tip
        out[2 * n] -= self.motor.rotor_radius * p_t / self.motor.rotor_inertia
        out[2 * n + 1] += p_n
        out[2 * n + 2] += p_t
        return out

    def tip_state(self, y: np.ndarray) -> tuple[float, float, float, float]:
        """Displacement u [m], of a rotor on a bearing that relative to it, slope [rad] and their rates."""
        u, slope, u_rate, slope_rate = (self.tip_map @ y[: 2 * self.shapes]).tolist()
        return u, slope, u_rate, slope_rate

    def tolerances(self, rtol: float) -> np.ndarray:
        """Absolute tolerance of every state of y, and of a work: rtol times a tenth of the static size."""
        m, res = self.motor, self.motor.resonator()
        peak = abs(m.voltage_1) + abs(m.voltage_2)
        r = np.linalg.solve(res.stiffness, np.abs(res.coupling) @ [peak, peak])
        size = max(float(np.abs(r).max()), 1e-9)
        speed = 2.0 * pi * self.frequency * size
        omega = speed * (1.0 + m.tip_length * float(np.abs(res.tip[1]).max())) / m.rotor_radius
        energy = 0.5 * size**2 * float(res.stiffness[0, 0])
        sizes = [size] * self.shapes + [speed] * self.shapes
        sizes += [omega, energy / speed, energy / speed, energy]
        return 0.1 * rtol * np.array(sizes)
