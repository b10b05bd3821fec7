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

from dataclasses import dataclass, field

import numpy as np

from oracle.motor import Contact, Mechanics, OracleMotor
from oracle.run import PHASE_LIMIT, Stepper, fly, touching


@dataclass(frozen=True, kw_only=True)
class SlipOnlyRun:
    """End state and contacts of one run, SI units, signs as in `oracle.motor`.

    The arrays have one entry a contact, in time order: impulses of the contact [N s], its largest
    force [N], and the slip [m/s] before and after its first step, the impact.
    """

    rotor_velocity: float
    rotor_angle: float
    u: float
    theta: float
    start_time: np.ndarray
    duration: np.ndarray
    normal_impulse: np.ndarray
    friction_impulse: np.ndarray
    peak_normal_force: np.ndarray
    slip_before: np.ndarray
    slip_after: np.ndarray

    @property
    def reversals(self) -> np.ndarray:
        """Whether the friction impulse of each impact turned the slip round."""
        return self.slip_before * self.slip_after < 0.0


@dataclass
class _Book:
    """What the contact that is going on has gathered, and the rows of the finished ones."""

    rows: list[list[float]] = field(default_factory=list)
    start: float = 0.0
    normal: float = 0.0
    friction: float = 0.0
    largest: float = 0.0
    slips: list[float] = field(default_factory=list)

    def open(self, t: float, slip: float) -> None:
        """A contact begins at t [s] with this slip [m/s]."""
        if len(self.rows) >= PHASE_LIMIT:
            raise RuntimeError(f"More than {PHASE_LIMIT} contacts up to {t} s: no advance.")
        self.start, self.normal, self.friction, self.largest = t, 0.0, 0.0, 0.0
        self.slips = [slip]

    def add(self, p_n: float, p_t: float, slip: float) -> None:
        """Book the impulses [N s] of a step and the slip [m/s] that it leaves."""
        self.normal += p_n
        self.friction += p_t
        self.largest = max(self.largest, p_n)
        if len(self.slips) == 1:
            self.slips.append(slip)

    def close(self, t: float, step: float) -> None:
        """The contact ends at t [s]; one that never pushed was none."""
        if self.normal > 0.0:
            row = [self.start, t - self.start, self.normal, self.friction, self.largest / step]
            self.rows.append([*row, *self.slips])


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
        out[2 * n + 1] = y[2 * n + 1] + h * omega
        return out, p, s


def slide(euler: BackwardEuler, book: _Book, t: float, y: np.ndarray, end: float) -> tuple[float, np.ndarray]:
    """One contact, from touch-down (t, y) to release or the last whole step before `end` [s]."""
    mu, h = euler.mechanics.motor.friction_coefficient, euler.step
    book.open(t, euler.mechanics.contact(t, y).slip)
    while t < end:
        y, p, s = euler.take(t, y)
        t += h
        if p == 0.0:
            break
        book.add(p, -s * mu * p, euler.mechanics.contact(t, y).slip)
    book.close(t, h)
    return t, y


def solve_rigid_slip(motor: OracleMotor, duration: float, step: float, rtol: float = 1e-10) -> SlipOnlyRun:
    """Run the motor with rigid contact that always slips from rest for `duration` [s].

    step: h [s] in contact.  rtol: of the flights.  A run that ends in contact ends up to one step late.
    """
    if not (duration > 0.0 and step > 0.0) or motor.clearance < 0.0:
        raise ValueError(
            f"duration {duration} s and step {step} s must be positive, clearance "
            f"{motor.clearance} m not negative."
        )
    mechanics = Mechanics(motor)
    euler, book = BackwardEuler(mechanics, step), _Book()
    stepper = Stepper("DOP853", rtol, mechanics.tolerances(rtol), 2e-6, 1e-6)
    t, y, n = 0.0, mechanics.initial_state(), mechanics.shapes
    c = mechanics.contact(t, y)
    down = touching(c.gap, c.gap_rate, c.normal_bias)
    while t < duration:
        if down:
            t, y = slide(euler, book, t, y, duration)
            down = False
        else:
            t, y, down = fly(mechanics, t, y, duration, stepper)
    names = ["start_time", "duration", "normal_impulse", "friction_impulse", "peak_normal_force"]
    names += ["slip_before", "slip_after"]
    table = np.array(book.rows, dtype=float).reshape(-1, len(names))
    u, theta, *_ = mechanics.tip_state(y)
    return SlipOnlyRun(
        rotor_velocity=float(y[2 * n]),
        rotor_angle=float(y[2 * n + 1]),
        u=u,
        theta=theta,
        **dict(zip(names, table.T, strict=True)),
    )
