"""Compliant contact: Hertz normal force with set-valued Coulomb friction, switches as events.

    N = K max(-g, 0)^1.5
    slip   F = -mu N sign(slip)
    stick  F holds slip' = 0:  F = -(slip_bias + D_nt N)/D_tt,  as long as |F| <= mu_s N

Phases: free, slip of sign +1, slip of sign -1, stick (mode 0).  When stick begins and ends the slip
is brought to exactly zero by a touch to the rotor speed, at the rounding of the event location;
within stick the accelerations hold it.
Not valid when the contact is as short as the wave travel time in the tip, nor for a damped contact.
"""

from __future__ import annotations

from math import copysign

import numpy as np

from oracle.motor import Contact, Law, Mechanics, OracleMotor
from oracle.run import (
    PHASE_LIMIT,
    SHORTEST,
    ContactBook,
    Event,
    OracleRun,
    Stepper,
    finish,
    fly,
    run_phase,
    touching,
)


class HertzCoulomb:
    """The contact law of one run: normal stiffness K [N/m^1.5], friction coefficients mu and mu_s."""

    def __init__(self, stiffness: float, mu: float, static_ratio: float = 1.0) -> None:
        """Set K [N/m^1.5], mu [1] and mu_s / mu [1]."""
        self.stiffness = stiffness
        self.mu = mu
        self.static = mu * static_ratio

    def normal(self, c: Contact) -> float:
        """N [N]."""
        return self.stiffness * max(-c.gap, 0.0) ** 1.5

    def stored(self, c: Contact) -> float:
        """Energy of the indentation, 2/5 K max(-g, 0)^2.5 [J]."""
        return 0.4 * self.stiffness * max(-c.gap, 0.0) ** 2.5

    def sticking_force(self, c: Contact) -> float:
        """F [N] that keeps the slip rate at zero."""
        return -(c.slip_bias + c.dnt * self.normal(c)) / c.dtt

    def in_mode(self, mode: int) -> Law:
        """(N, F) of the given mode."""
        if mode == 0:
            return lambda c: (self.normal(c), self.sticking_force(c))
        return lambda c: (n := self.normal(c), -mode * self.mu * n)

    def mode_at(self, c: Contact) -> int:
        """Mode that begins at this instant: the sign of the slip, or stick.

        Stick needs zero slip and a force inside the cone.  Outside it the slip starts against the
        friction that stick would need.
        """
        if self.mu == 0.0:
            return 1
        if c.slip != 0.0:
            return int(copysign(1, c.slip))
        force = self.sticking_force(c)
        # At equality the contact still sticks; an untouched symmetric motor has both sides zero.
        return 0 if abs(force) <= self.static * self.normal(c) else -int(copysign(1, force))

    def events(self, mechanics: Mechanics, c: Contact, mode: int) -> list[Event]:
        """Switches of a phase that begins at `c`.

        Release (0), deepest point (1, passed), then the ways out of the mode: slip zero (2), or in
        stick the cone at F = +mu_s N (2) and F = -mu_s N (3).
        """
        ceiling = max(c.gap, 0.0) + SHORTEST
        found = [
            Event(lambda t, y: mechanics.contact(t, y).gap - ceiling, +1),
            Event(lambda t, y: mechanics.contact(t, y).gap_rate, +1, terminal=False),
        ]

        def margin(sign: int) -> Event:
            def value(t: float, y: np.ndarray) -> float:
                now = mechanics.contact(t, y)
                return self.static * self.normal(now) - sign * self.sticking_force(now)

            return Event(value, -1)

        if mode == 0:
            return [*found, margin(+1), margin(-1)]
        if self.mu == 0.0:
            return found
        floor = min(mode * c.slip, 0.0) - SHORTEST
        return [*found, Event(lambda t, y: mode * mechanics.contact(t, y).slip - floor, -1)]


def without_slip(mechanics: Mechanics, y: np.ndarray) -> np.ndarray:
    """The state with the rotor turned to exactly the tip's speed."""
    out, omega = y.copy(), 2 * mechanics.shapes
    tip_speed = mechanics.contact(0.0, y).slip + mechanics.motor.rotor_radius * y[omega]
    out[omega] = tip_speed / mechanics.motor.rotor_radius
    return out


def dwell(
    mechanics: Mechanics,
    law: HertzCoulomb,
    book: ContactBook,
    t: float,
    y: np.ndarray,
    end: float,
    stepper: Stepper,
) -> tuple[float, np.ndarray]:
    """One contact, from touch-down (t, y) to release or `end` [s]."""
    book.open(t, y)
    mode = law.mode_at(mechanics.contact(t, y))
    for _ in range(PHASE_LIMIT):
        events = law.events(mechanics, mechanics.contact(t, y), mode)
        result = run_phase(mechanics, law.in_mode(mode), events, t, y, end, stepper)
        instants = [(t, y), (result.t, result.y), *result.hits[1]]
        peak = max(law.normal(mechanics.contact(*instant)) for instant in instants)
        book.add(result.t - t if mode == 0 else 0.0, peak)
        t, y = result.t, result.y
        if result.fired in (None, 0):
            book.close(t, y)
            return t, y
        y = without_slip(mechanics, y)
        if mode == 0:
            # The slip starts against the friction: at F = +mu_s N (event 2) it is negative.
            mode = -1 if result.fired == 2 else 1
        else:
            c = mechanics.contact(t, y)
            mode = law.mode_at(c._replace(slip=0.0))
    raise RuntimeError(f"More than {PHASE_LIMIT} stick-slip phases in one contact at {t} s.")


def solve_hertz(
    motor: OracleMotor,
    stiffness: float,
    duration: float,
    rtol: float = 1e-10,
    atol: np.ndarray | float | None = None,
    *,
    method: str = "DOP853",
    flight_step: float = 2e-6,
    contact_step: float = 1e-6,
    static_ratio: float = 1.0,
) -> OracleRun:
    """Run the motor with Hertz contact from rest for `duration` [s].

    stiffness: K [N/m^1.5], about 1e10 for a 5 mm steel tip.  atol None scales with rtol and the
    size of every state.  A negative clearance starts indented.  The explicit method suits four to
    eight shapes; with more, give method="Radau".
    """
    if not (stiffness > 0.0 and duration > 0.0):
        raise ValueError(f"stiffness {stiffness} N/m^1.5 and duration {duration} s must both be positive.")
    mechanics = Mechanics(motor)
    law = HertzCoulomb(float(stiffness), motor.friction_coefficient, static_ratio)
    scaled = mechanics.tolerances(rtol) if atol is None else atol
    stepper = Stepper(method, rtol, scaled, flight_step, contact_step)
    book = ContactBook(slice(2 * mechanics.shapes + 6, 2 * mechanics.shapes + 8))
    t, y = 0.0, mechanics.initial_state()
    c = mechanics.contact(t, y)
    initial = sum(mechanics.energies(y)) + law.stored(c)
    down = touching(c.gap, c.gap_rate, c.normal_bias)
    while t < duration:
        if down:
            t, y = dwell(mechanics, law, book, t, y, duration, stepper)
            down = False
        else:
            t, y, down = fly(mechanics, t, y, duration, stepper)
    return finish(mechanics, y, book, initial, law.stored(mechanics.contact(t, y)))
