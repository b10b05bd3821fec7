"""Rigid contact that always slips, in the time stepping of its authors.

Andersen, Blanke and Helbo (2001), eqs. 49-59 in consistent form.  One step of length h in contact,
backward Euler in shape coordinates, with the sign s of the slip taken where the step begins:

    predict   (M + h C + h^2 K) r'_n = M r'_(n-1) + h (Gamma U_n - K r_(n-1)) + S'(n - s mu t) p
              with n.S r'_n = 0, directions n, t at r_(n-1);   r_n = r_(n-1) + h r'_n
    correct   r_n onto gap = 0 along M^-1 S' n;  then, directions at r_n,
              (M + h C) r'_n = M r'_(n-1) + h (Gamma U_n - K r_n) + S'(n - s mu t) p
              with n.S r'_n = 0
    rotor     (J + h C_r) Omega_n = J Omega_(n-1) + R s mu p - h tau

p is the normal impulse of the step [N s], so that N = p/h: the impact is one step, and its force grows as
1/h.  A step whose p is not positive is taken without contact and ends it.  Flights are integrated
and their touch-downs located as for the other oracles.

First order in h.  Where the bodies would stick no slip-only motion exists: the sign then changes
from step to step, and what converges is the mean.  Refused where D_nn <= mu |D_nt|, as rigid slip.
"""

from __future__ import annotations

import numpy as np

from oracle.composed import JudgedRun
from oracle.flight import Flight
from oracle.motor import Contact, Mechanics, OracleMotor


class BackwardEuler:
    """Steps of one length h [s] of one motor."""

    def __init__(self, mechanics: Mechanics, step: float) -> None:
        """Invert the two implicit matrices."""
        res = mechanics.resonator
        self.mechanics, self.step = mechanics, step
        self.tip = res.tip
        damped_mass = res.mass + step * res.damping
        self.predictor = np.linalg.inv(damped_mass + step**2 * res.stiffness)
        self.corrector = np.linalg.inv(damped_mass)

    def impulse(self, rates: np.ndarray, response: np.ndarray, c: Contact, s: float) -> float:
        """p [N s] that ends with n.S r' = 0, from the contact-free `rates` and response to S' f."""
        mu = self.mechanics.motor.friction_coefficient
        normal, tangential = np.array(c.n_row), np.array(c.t_row)
        through = normal @ self.tip @ response
        reach = through @ (normal - s * mu * tangential)
        if reach <= 0.0:
            raise ValueError(f"D_nn - s mu D_nt = {reach} 1/kg: rigid slip has no unique solution.")
        return float(-(normal @ self.tip @ rates) / reach)

    def push(self, c: Contact, s: float) -> np.ndarray:
        """Load on (u, slope) of a unit normal impulse with its friction."""
        mu = self.mechanics.motor.friction_coefficient
        return np.array(c.n_row) - s * mu * np.array(c.t_row)

    def onto_surface(self, t: float, y: np.ndarray) -> np.ndarray:
        """y moved to zero gap along M^-1 S' n; the second pass removes the surface's curvature."""
        out, n = y.copy(), self.mechanics.shapes
        for _ in range(2):
            c = self.mechanics.contact(t, out)
            out[:n] -= self.mechanics.tip_response @ c.n_row * (c.gap / c.dnn)
        return out

    def take(self, t: float, y: np.ndarray) -> tuple[np.ndarray, float, float]:
        """State at t + h, normal impulse [N s] (zero: released), sign of the slip."""
        m, res, n = self.mechanics.motor, self.mechanics.resonator, self.mechanics.shapes
        h = self.step
        before = self.mechanics.contact(t, y)
        s = float(np.sign(before.slip))
        drive = res.mass @ y[n : 2 * n] + h * res.coupling @ self.mechanics.voltages(t + h)

        out = y.copy()
        free = self.predictor @ (drive - h * res.stiffness @ y[:n])
        response = self.predictor @ self.tip.T
        p = max(self.impulse(free, response, before, s), 0.0)
        out[n : 2 * n] = free + response @ self.push(before, s) * p
        out[:n] = y[:n] + h * out[n : 2 * n]
        if p > 0.0:
            closed = self.onto_surface(t + h, out)
            after = self.mechanics.contact(t + h, closed)
            free = self.corrector @ (drive - h * res.stiffness @ closed[:n])
            response = self.corrector @ self.tip.T
            p = max(self.impulse(free, response, after, s), 0.0)
            if p > 0.0:
                out = closed
            out[n : 2 * n] = free + response @ self.push(after, s) * p
        torque = m.rotor_radius * s * m.friction_coefficient * p - h * m.load_torque
        omega = (m.rotor_inertia * y[2 * n] + torque) / (m.rotor_inertia + h * m.rotor_damping)
        out[2 * n] = omega
        return out, p, s


def solve_rigid_slip(motor: OracleMotor, duration: float, step: float) -> JudgedRun:
    """Run the motor with rigid contact that always slips from rest for `duration` [s].

    step: h [s] in contact. A run that ends in contact ends up to one step late.
    """
    mechanics, run = Mechanics(motor), JudgedRun(contact_work=float("nan"))
    euler, flight, mu = BackwardEuler(mechanics, step), Flight(mechanics), motor.friction_coefficient
    t, y = 0.0, mechanics.initial_state()
    while t < duration:
        t, y, down = flight.until(t, y, duration, lambda _: 0.0)
        if not down:
            break
        begun, normal, friction = t, 0.0, 0.0
        while t < duration:
            y, p, s = euler.take(t, y)
            t += step
            if p == 0.0:
                break
            normal, friction = normal + p, friction - s * mu * p
        # A contact that never pushed was none.
        if normal > 0.0:
            run.starts.append(begun)
            run.durations.append(t - begun)
            run.normal_impulses.append(normal)
            run.friction_impulses.append(friction)
    run.rotor_velocity = float(y[2 * mechanics.shapes])
    run.u = float(mechanics.tip_state(y)[0])
    return run
