"""Rigid contact: exact plastic impact with Coulomb friction, then persistent contact.

    0 <= g, N >= 0, g N = 0 (eq. 37);  while g = 0 lasts, N and F hold g'' = 0, in stick slip' = 0:
    stick      D (N, F) = -(normal_bias, slip_bias)      as long as |F| <= mu N
    slip s     N = -normal_bias/(D_nn - s mu D_nt),  F = -s mu N
    impact     the same two lines for the impulses, with (gap_rate, slip) in place of the biases

s = +-1 is the sign of the slip; D is the 2x2 Delassus matrix of tip and rotor.  It is the limit of
a time-stepping multiplier law with stick as its step goes to zero.  Slip is refused where
D_nn <= mu |D_nt|: there it has no or two solutions (Painleve).
"""

from __future__ import annotations

from math import copysign

import numpy as np
from scipy.optimize import minimize_scalar

from oracle.motor import Contact, Law, Mechanics, OracleMotor
from oracle.run import (
    PHASE_LIMIT,
    SHORTEST,
    ContactBook,
    Event,
    OracleRun,
    PhaseEnd,
    Stepper,
    finish,
    fly,
    run_phase,
    touching,
)

FREE = 2
"""Mode of no contact; 0 is stick, +1 and -1 are slip."""


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


def impact(
    mechanics: Mechanics, book: ContactBook, t: float, y: np.ndarray, mu: float
) -> tuple[np.ndarray, int]:
    """State after the plastic impact at (t, y), and the mode it leaves.

    The loss -p.(v_before + v_after)/2 is booked; v = (gap_rate, slip).
    """
    before = mechanics.contact(t, y)
    if before.gap_rate >= 0.0:
        return y, start_mode(before, mu)
    mode, p_n, p_t = stick_or_slip(before, before.gap_rate, before.slip, mu)
    after = mechanics.push(y, before, p_n, p_t)
    c = mechanics.contact(t, after)
    book.impact_loss -= 0.5 * p_n * (before.gap_rate + c.gap_rate)
    book.impact_loss -= 0.5 * p_t * (before.slip + c.slip)
    return after, mode


def start_mode(c: Contact, mu: float) -> int:
    """Mode of a contact without approach: the sign of the slip; at zero slip the forces decide."""
    if mu == 0.0:
        return 1
    if c.slip != 0.0:
        return int(copysign(1, c.slip))
    if c.normal_bias >= 0.0:
        return FREE
    return stick_or_slip(c, c.normal_bias, c.slip_bias, mu)[0]


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
    moved[2 * n + 6 :] = y[2 * n + 6 :]
    return moved


def force_law(mode: int, mu: float) -> Law:
    """(N, F) [N] that hold the surface in the given mode."""
    if mode == 0:
        return lambda c: sticking(c, c.normal_bias, c.slip_bias)
    return lambda c: sliding(c, c.normal_bias, mu, mode)


def phase_events(mechanics: Mechanics, c: Contact, mode: int, mu: float) -> list[Event]:
    """Switches of a phase that begins at `c`.

    Release at N = 0 (0), then the ways out of the mode: slip zero (1), or in stick the cone at
    F = +mu N (1) and F = -mu N (2).
    """
    law = force_law(mode, mu)
    found = [Event(lambda t, y: law(mechanics.contact(t, y))[0], -1)]

    def margin(sign: int) -> Event:
        def value(t: float, y: np.ndarray) -> float:
            normal, friction = law(mechanics.contact(t, y))
            return mu * normal - sign * friction

        return Event(value, -1)

    if mode == 0:
        return [*found, margin(+1), margin(-1)]
    if mu == 0.0:
        return found
    floor = min(mode * c.slip, 0.0) - SHORTEST
    return [*found, Event(lambda t, y: mode * mechanics.contact(t, y).slip - floor, -1)]


def peak_force(mechanics: Mechanics, law: Law, phase: PhaseEnd, start: float) -> float:
    """Largest N [N] of a phase from `start` on: best of a grid, refined between its neighbours."""

    course = phase.course
    if course is None:
        raise ValueError("The phase was integrated without its course; no peak can be sought.")

    def force(t: float) -> float:
        return law(mechanics.contact(t, course(t)))[0]

    grid = np.linspace(start, phase.t, 41)
    values = [force(t) for t in grid]
    best = int(np.argmax(values))
    left, right = grid[max(best - 1, 0)], grid[min(best + 1, 40)]
    if not left < right:
        return values[best]
    fine = {"xatol": 1e-3 * (right - left)}
    inside = minimize_scalar(lambda t: -force(t), bounds=(left, right), method="bounded", options=fine)
    return max(values[best], -float(inside.fun))


def early_release(mechanics: Mechanics, law: Law, phase: PhaseEnd, start: float) -> float | None:
    """First instant [s] of a phase at which the surface would have to pull, between two that push.

    Release is looked for by the sign of N where integration steps end, which a dip of N below zero
    within a step does not show.  N is smooth over a few steps, so that a dip lies next to a step
    end where N is lower than at both neighbours; there the minimum is sought.
    """
    course = phase.course
    if course is None:
        raise ValueError("The phase was integrated without its course; no dip can be sought.")

    def force(t: float) -> float:
        return law(mechanics.contact(t, course(t)))[0]

    times = course.ts[course.ts >= start]
    values = np.array([force(t) for t in times])
    for k in range(1, len(times) - 1):
        if not values[k - 1] >= values[k] <= values[k + 1]:
            continue
        around = (times[k - 1], times[k + 1])
        fine = {"xatol": 1e-4 * (around[1] - around[0])}
        lowest = minimize_scalar(force, bounds=around, method="bounded", options=fine)
        if lowest.fun < 0.0:
            return float(lowest.x)
    return None


def hold(
    mechanics: Mechanics, mode: int, mu: float, t: float, y: np.ndarray, end: float, stepper: Stepper
) -> PhaseEnd:
    """One phase in one mode from (t, y) to its first switch or `end` [s].

    A release that hides within a step is brought to light by repeating the phase up to the minimum
    of N, where the last step ends below zero.
    """
    law, stop = force_law(mode, mu), end
    switches = phase_events(mechanics, mechanics.contact(t, y), mode, mu)
    while True:
        phase = run_phase(mechanics, law, switches, t, y, stop, stepper, keep_course=True)
        earlier = early_release(mechanics, law, phase, t)
        if earlier is None:
            return phase
        stop = earlier


def ride(
    mechanics: Mechanics, mu: float, book: ContactBook, t: float, y: np.ndarray, end: float, stepper: Stepper
) -> tuple[float, np.ndarray]:
    """One contact, from touch-down (t, y) through its impact to release or `end` [s]."""
    book.open(t, y)
    y, mode = impact(mechanics, book, t, y, mu)
    for _ in range(PHASE_LIMIT):
        y = settle(mechanics, t, y, mode)
        c = mechanics.contact(t, y)
        if mode == 0:
            # The cone of the impact is not that of the forces after it.
            mode = start_mode(c._replace(slip=0.0), mu)
        if mode == FREE or force_law(mode, mu)(c)[0] <= 0.0:
            break
        law = force_law(mode, mu)
        result = hold(mechanics, mode, mu, t, y, end, stepper)
        book.add(result.t - t if mode == 0 else 0.0, peak_force(mechanics, law, result, t))
        left, t, y = mode, result.t, result.y
        if result.fired in (None, 0):
            y = settle(mechanics, t, y, mode)
            break
        # A slip at zero is looked at as stick; out of the cone it slips against its friction.
        mode = 0 if left != 0 else (-1 if result.fired == 1 else 1)
    else:
        raise RuntimeError(f"More than {PHASE_LIMIT} stick-slip phases in one contact at {t} s.")
    book.close(t, y)
    return t, y


def solve_rigid_stick(
    motor: OracleMotor,
    duration: float,
    rtol: float = 1e-10,
    atol: np.ndarray | float | None = None,
    *,
    method: str = "DOP853",
    flight_step: float = 2e-6,
    contact_step: float = 1e-6,
) -> OracleRun:
    """Run the motor with rigid contact and plastic impacts from rest for `duration` [s].

    atol None scales with rtol and the size of every state.  A negative clearance has no rigid start
    and is refused.
    """
    if not duration > 0.0 or motor.clearance < 0.0:
        raise ValueError(
            f"duration {duration} s must be positive, clearance {motor.clearance} m not negative."
        )
    mechanics = Mechanics(motor)
    scaled = mechanics.tolerances(rtol) if atol is None else atol
    stepper = Stepper(method, rtol, scaled, flight_step, contact_step)
    book = ContactBook(slice(2 * mechanics.shapes + 6, 2 * mechanics.shapes + 8))
    t, y = 0.0, mechanics.initial_state()
    c = mechanics.contact(t, y)
    initial = sum(mechanics.energies(y))
    down = touching(c.gap, c.gap_rate, c.normal_bias)
    while t < duration:
        if down:
            t, y = ride(mechanics, motor.friction_coefficient, book, t, y, duration, stepper)
            down = False
        else:
            t, y, down = fly(mechanics, t, y, duration, stepper)
    return finish(mechanics, y, book, initial, 0.0)
