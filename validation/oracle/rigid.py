"""Rigid laws with any impact, in the limit of no step: impacts are maps, flights exact, contact by DOP853.

    0 <= g, N >= 0, g N = 0;  while g = 0 lasts, N and F hold g'' = 0, in stick slip' = 0:
    stick      D (N, F) = -(normal_bias, slip_bias)      as long as |F| <= mu N
    slip s     N = -normal_bias/(D_nn - s mu D_nt),  F = -s mu N

An impact answers gap rate and slip with impulses, from the Delassus matrix D. What rebounds flies; below the
rate `SLOW` what is left of the rebounds goes in one impulse, with the friction of its slip, and the contact
lasts.

    lagrange_slip         gdot+ = 0, p_t = -mu p_n sign(slip), whatever it does to the slip
    newton, moreau_jean   gdot+ = -e gdot-, stick or slip at the end
    johnson               the same, e from m V^2/2 = pi a^4 p_d/(4 R) and 3 P^2/(10 a E*), P = pi a^2 p_d
    poisson, stronge      Routh's process, piece by piece
    brach                 p_t = r p_n with the least of mu, the r that ends the slip, the r without a loss
    chatterjee_ruina      (1 + e) p_I + k (p_II - p_I), k = 1 + e_t or less on the cone

Slip is refused where D_nn <= mu |D_nt|: there it has no or two solutions (Painleve).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import copysign, hypot, inf, log1p, pi, sqrt
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from oracle.composed import JudgedRun, pieces
from oracle.flight import Flight
from oracle.motor import Contact, Law, Mechanics, OracleMotor

SLOW = 1e-7
"""Rebound [m/s] that is none."""
FREE = 2
MOST = 20_000

Impact = Callable[[Contact, float, float], tuple[float, float]]
"""Gives p_n, p_t [N s] from contact, gap rate and slip [m/s]."""

Event = Callable[[float, np.ndarray], float]
"""A function of time and state that falls through zero."""


def sticking(c: Contact, normal: float, tangential: float) -> tuple[float, float]:
    """-D^-1 (normal, tangential): what brings both to zero."""
    determinant = c.dnn * c.dtt - c.dnt * c.dnt
    p_n = (c.dnt * tangential - c.dtt * normal) / determinant
    return p_n, (c.dnt * normal - c.dnn * tangential) / determinant


def sliding(c: Contact, normal: float, mu: float, sign: int) -> tuple[float, float]:
    """What brings `normal` to zero with the friction of a slip of this sign."""
    if c.dnn <= mu * abs(c.dnt):
        raise ValueError(
            f"D_nn = {c.dnn} 1/kg is not above mu |D_nt| = {mu * abs(c.dnt)} 1/kg: rigid slip has "
            "no unique solution; take a smaller friction coefficient or the compliant contact."
        )
    p_n = -normal / (c.dnn - sign * mu * c.dnt)
    return p_n, -sign * mu * p_n


def stick_or_slip(c: Contact, normal: float, tangential: float, mu: float) -> tuple[int, float, float]:
    """Mode and the two unknowns that end at zero `normal` and, if the cone allows, zero slip.

    Stick if it fits into the cone; else the slip against the friction that stick would have needed,
    the only sign that leaves a slip of its own sign as long as D_nn > mu |D_nt|.
    """
    p_n, p_t = sticking(c, normal, tangential)
    # At equality the contact still sticks.
    if abs(p_t) <= mu * p_n:
        return 0, p_n, p_t
    sign = -int(copysign(1, p_t))
    return sign, *sliding(c, normal, mu, sign)


def settle(mechanics: Mechanics, t: float, y: np.ndarray, mode: int) -> np.ndarray:
    """The nearest state, in the mass metric, with zero gap and gap rate, and in stick zero slip.

    It removes what event location and integration leave, at the size of their tolerances.
    """
    n, out = mechanics.shapes, y.copy()
    c = mechanics.contact(t, out)
    out[:n] += mechanics.tip_response @ c.n_row * (-c.gap / c.dnn)
    c = mechanics.contact(t, out)
    p_n, p_t = sticking(c, c.gap_rate, c.slip) if mode == 0 else (-c.gap_rate / c.dnn, 0.0)
    moved = mechanics.push(out, c, p_n, p_t)
    # A correction is no physical impulse.
    moved[2 * n + 1 :] = y[2 * n + 1 :]
    return moved


def force_law(mode: int, mu: float) -> Law:
    """(N, F) [N] that hold the surface in the given mode."""
    if mode == 0:
        return lambda c: sticking(c, c.normal_bias, c.slip_bias)
    return lambda c: sliding(c, c.normal_bias, mu, mode)


def newton(mu: float, e: float) -> Impact:
    """Restitution of the gap rate."""
    return lambda c, rate, slip: stick_or_slip(c, (1.0 + e) * rate, slip, mu)[1:]


def slip_only(mu: float) -> Impact:
    """Friction against the slip that is brought, even where it reverses it."""
    return lambda c, rate, slip: sliding(c, rate, mu, int(copysign(1, slip)))


def johnson(mu: float, modulus: float, strength: float, radius: float) -> Impact:
    """Newton's with the restitution of a ball that has yielded all over."""
    pressure = 3.0 * strength

    def impact(c: Contact, rate: float, slip: float) -> tuple[float, float]:
        brought = 0.5 * rate * rate / c.dnn
        a = (4.0 * radius * brought / (pi * pressure)) ** 0.25
        back = 3.0 * (pi * a * a * pressure) ** 2 / (10.0 * a * modulus)
        return newton(mu, min(1.0, sqrt(back / brought)))(c, rate, slip)

    return impact


def process(mu: float, e: float, of_energy: bool) -> Impact:  # noqa: C901 - the pieces of one process
    """Routh's process: pieces in which gap rate and slip are linear in the normal impulse."""

    def impact(c: Contact, rate: float, slip: float) -> tuple[float, float]:
        p_n = p_t = work = 0.0
        target, compressing = inf, True
        for _ in range(8):
            if slip != 0.0:
                ratio = -mu * copysign(1.0, slip)
            elif abs(c.dnt) <= mu * c.dtt:
                ratio = -c.dnt / c.dtt
            else:
                ratio = -mu * copysign(1.0, c.dnt)
            gains, drags = c.dnn + c.dnt * ratio, c.dnt + c.dtt * ratio
            if abs(drags) < 1e-12 * c.dtt:
                drags = 0.0
            to_rest = -slip / drags if slip * drags < 0.0 else inf
            if compressing:
                to_end = -rate / gains if gains > 0.0 else inf
            elif of_energy:
                # rate p + gains p^2/2 = what is still to be given back.
                left = target - work
                to_end = 2.0 * left / (rate + sqrt(rate * rate + 2.0 * gains * left))
            else:
                to_end = target - p_n
            p = min(to_rest, to_end)
            work += rate * p + 0.5 * gains * p * p
            p_n, p_t, rate = p_n + p, p_t + ratio * p, rate + gains * p
            slip = 0.0 if to_rest <= to_end else slip + drags * p
            if to_end <= to_rest:
                if not compressing:
                    return p_n, p_t
                compressing, rate = False, 0.0
                target = -e * e * work if of_energy else (1.0 + e) * p_n
                work = 0.0
                if e == 0.0:
                    return p_n, p_t
        raise RuntimeError("Routh's process does not end.")

    return impact


def brach(mu: float, e: float) -> Impact:
    """The least of three ratios."""

    def impact(c: Contact, rate: float, slip: float) -> tuple[float, float]:
        def impulses(r: float) -> tuple[float, float]:
            p_n = -(1.0 + e) * rate / (c.dnn + r * c.dnt)
            return p_n, r * p_n

        def left(r: float) -> float:
            p_n, p_t = impulses(r)
            return slip + c.dnt * p_n + c.dtt * p_t

        def loss(r: float) -> float:
            p_n, p_t = impulses(r)
            return -0.5 * (p_n * (1.0 - e) * rate + p_t * (slip + left(r)))

        if left(0.0) == 0.0:
            return impulses(0.0)
        s = -copysign(1.0, left(0.0))
        most = mu
        if left(0.0) * left(s * mu) <= 0.0:
            most = abs(brentq(left, 0.0, s * mu, xtol=1e-16))
        if loss(s * most) < 0.0:
            most = abs(brentq(loss, 0.0, s * most, xtol=1e-16)) if loss(0.0) > 0.0 else 0.0
        return impulses(s * most)

    return impact


def chatterjee_ruina(mu: float, e: float, e_t: float) -> Impact:
    """Between two plastic impacts, overdone."""

    def impact(c: Contact, rate: float, slip: float) -> tuple[float, float]:
        first = np.array([-rate / c.dnn, 0.0])
        second = np.array(sticking(c, rate, slip))

        def total(k: float) -> np.ndarray:
            return (1.0 + e) * first + k * (second - first)

        def outside(k: float) -> float:
            p_n, p_t = total(k)
            return float(abs(p_t) - mu * p_n)

        k = 1.0 + e_t
        if outside(k) > 0.0:
            k = brentq(outside, 0.0, k, xtol=1e-16)
        p_n, p_t = total(k)
        return float(p_n), float(p_t)

    return impact


class Rough(NamedTuple):
    """Friction of a contact that lasts: kinetic mu, and a static cone that may age in stick."""

    mu: float
    ratio: float = 1.0
    strengthening: float = 0.0
    ageing_time: float = 1.0
    longest_age: float = 1e5

    def static(self, age: float) -> float:
        """Static coefficient."""
        grown = log1p(min(age, self.longest_age) / self.ageing_time)
        return self.mu * self.ratio + self.strengthening * grown


def plastic_ageing(rough: Rough) -> Impact:
    """The plastic impact: static friction holds only what the stick would not have to stop."""

    def impact(c: Contact, rate: float, slip: float) -> tuple[float, float]:
        p_n, p_t = sticking(c, rate, slip)
        if p_t * slip >= 0.0 and abs(p_t) <= rough.static(0.0) * p_n:
            return p_n, p_t
        return stick_or_slip(c, rate, slip, rough.mu)[1:]

    return impact


class RigidJudge:
    """One motor with one rigid law."""

    def __init__(self, motor: OracleMotor, impact: Impact, rough: Rough, rtol: float) -> None:
        self.impact, self.rough = impact, rough
        self.take(motor)
        self.rtol, self.atol = rtol, self.mechanics.tolerances(rtol)[:-1]

    def take(self, motor: OracleMotor) -> None:
        """Go on with another motor."""
        self.mechanics = Mechanics(motor)
        self.flight = Flight(self.mechanics)

    def at_rest(self, c: Contact, age: float) -> int:
        """Mode at zero slip: the forces decide."""
        p_n, p_t = sticking(c, c.normal_bias, c.slip_bias)
        if abs(p_t) <= self.rough.static(age) * p_n:
            return 0
        if c.normal_bias >= 0.0:
            return FREE
        return stick_or_slip(c._replace(), c.normal_bias, c.slip_bias, self.rough.mu)[0] or -int(
            copysign(1, p_t)
        )

    def phase(
        self, law: Law, events: list[Event], t: float, y: np.ndarray, end: float
    ) -> tuple[float, np.ndarray, int | None]:
        """Integrate in contact until the first event, whose number is returned, or to `end` [s]."""

        def falling(value: Event) -> Event:
            def event(t: float, y: np.ndarray) -> float:
                return value(t, y)

            event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
            return event

        done = solve_ivp(
            lambda t, y: self.mechanics.derivative(t, y, law), (t, end), y, "DOP853",
            events=[falling(event) for event in events], rtol=self.rtol, atol=self.atol, max_step=1e-6,
        )  # fmt: skip
        if done.status < 0:
            raise RuntimeError(f"The contact at {t} s: {done.message}")
        fired = [i for i, hits in enumerate(done.t_events) if len(hits) and hits[-1] == done.t[-1]]
        return float(done.t[-1]), done.y[:, -1].copy(), fired[0] if fired else None

    def last(  # noqa: C901 - the modes of one contact
        self, t: float, y: np.ndarray, end: float
    ) -> tuple[float, np.ndarray]:
        """A contact that lasts, from zero gap and gap rate to its release or `end`."""
        mechanics, mu, arrived = self.mechanics, self.rough.mu, False
        for _ in range(MOST):
            c = mechanics.contact(t, y)
            speed = hypot(c.slip, 1e-6)
            if arrived or abs(c.slip) < 1e-9 * speed or abs(c.slip) < 1e-11:
                mode = self.at_rest(c, 0.0)
            else:
                mode = int(copysign(1, c.slip))
            while True:
                if mode == FREE:
                    return t, y
                y = settle(mechanics, t, y, mode)
                c, law, begun = mechanics.contact(t, y), force_law(mode, mu), t
                if law(c)[0] <= 0.0:
                    return t, y
                events: list[Event] = [lambda t, y, law=law: law(mechanics.contact(t, y))[0]]
                if mode == 0:
                    for sign in (1.0, -1.0):

                        def room(t: float, y: np.ndarray, sign: float = sign, begun: float = begun) -> float:
                            p_n, p_t = sticking(c := mechanics.contact(t, y), c.normal_bias, c.slip_bias)
                            return self.rough.static(t - begun) * p_n - sign * p_t

                        events.append(room)
                else:
                    floor = min(mode * c.slip, 0.0) - 1e-18
                    events.append(lambda t, y, m=mode, f=floor: m * mechanics.contact(t, y).slip - f)
                t, y, fired = self.phase(law, events, t, y, end)
                if fired in (None, 0):
                    return t, settle(mechanics, t, y, mode)
                if mode != 0:
                    arrived = True
                    break
                mode = -1 if fired == 1 else 1
        raise RuntimeError(f"More than {MOST} phases at {t} s.")

    def meet(self, t: float, y: np.ndarray) -> tuple[np.ndarray, bool]:
        """The state after an impact, and whether the contact lasts."""
        mechanics = self.mechanics
        c = mechanics.contact(t, y)
        if c.gap_rate < 0.0:
            y = mechanics.push(y, c, *self.impact(c, c.gap_rate, c.slip))
        c = mechanics.contact(t, y)
        if c.gap_rate >= SLOW:
            return y, False
        if abs(c.slip) > SLOW:
            y = mechanics.push(y, c, *sliding(c, c.gap_rate, self.rough.mu, int(copysign(1, c.slip))))
        return settle(mechanics, t, y, 1), True

    def run(self, duration: float, changes: Sequence[tuple[float, OracleMotor]] = ()) -> JudgedRun:
        """From rest, the gap open, for a duration [s]; from times on other motors, of the same resonator."""
        run, n = JudgedRun(), self.mechanics.shapes
        t, y, lasts = 0.0, self.mechanics.initial_state(), False
        before, begun = y[2 * n + 1 : 2 * n + 3].copy(), t
        for motor, end in pieces(changes, duration):
            if motor is not None:
                self.take(motor)
            while t < end:
                if not lasts:
                    t, y, down = self.flight.until(t, y, end, lambda _: 0.0)
                    if not down:
                        break
                    before, begun = y[2 * n + 1 : 2 * n + 3].copy(), t
                    y, lasts = self.meet(t, y)
                if lasts:
                    t, y = self.last(t, y, end)
                    lasts = t == end
                if not lasts or t == duration:
                    run.note(begun, t, before, y[2 * n + 1 : 2 * n + 3])
                if len(run.starts) > MOST:
                    raise RuntimeError(f"More than {MOST} contacts.")
        run.rotor_velocity = float(y[2 * n])
        run.u = float(self.mechanics.tip_state(y)[0])
        run.contact_work = float("nan")
        return run
