"""Runs a motor with Hertz contact by CVODE of SUNDIALS: Adams' method, one smooth phase after the other.

The equations are those of the independent solver (`oracle.motor`). Friction is set-valued: flight, stick and
slip with either sign are smooth problems of their own, which a root function ends.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from oracle.motor import Contact, Mechanics, OracleMotor
from sksundae.cvode import CVODE

Array = NDArray[np.float64]

LONGEST_STEP = 2e-6
"""Signs of root functions are compared from step to step: a dip within one step would be missed [s]."""

FLIGHT, STICK = 2, 0


@dataclass
class CvodeRun:
    """End state, sums of impulses [N s], time in contact and in stick [s], each touch-down [s]."""

    rotor_velocity: float = 0.0
    tip_normal_displacement: float = 0.0
    tip_slope: float = 0.0
    normal_impulse: float = 0.0
    friction_impulse: float = 0.0
    time_in_contact: float = 0.0
    time_in_stick: float = 0.0
    start_time: list[float] = field(default_factory=list)


@dataclass(frozen=True)
class HertzMotor:
    """Equations and root functions of a motor with stiffness K [N m^-3/2]."""

    mechanics: Mechanics
    stiffness: float

    def normal(self, c: Contact) -> float:
        return self.stiffness * max(-c.gap, 0.0) ** 1.5

    def holding(self, c: Contact) -> float:
        """F [N] that leaves no slip rate."""
        return -(c.slip_bias + c.dnt * self.normal(c)) / c.dtt

    def forces(self, phase: int) -> Callable[[Contact], tuple[float, float]]:
        mu = self.mechanics.motor.friction_coefficient
        if phase == FLIGHT:
            return lambda _: (0.0, 0.0)
        if phase == STICK:
            return lambda c: (self.normal(c), self.holding(c))
        return lambda c: (self.normal(c), -phase * mu * self.normal(c))

    def roots(self, phase: int) -> tuple[list[int], Callable[[Contact], list[float]]]:
        """Directions and values of what ends a phase: the gap, then slip zero or both edges of the cone."""
        mu = self.mechanics.motor.friction_coefficient
        if phase == FLIGHT:
            return [-1], lambda c: [c.gap]
        if mu == 0.0:
            return [1], lambda c: [c.gap]
        if phase == STICK:
            signs = (-1.0, 1.0)
            return [1, -1, -1], lambda c: [c.gap, *(mu * self.normal(c) + s * self.holding(c) for s in signs)]
        return [1, -1], lambda c: [c.gap, phase * c.slip]

    def after(self, phase: int, root: int, t: float, y: Array) -> int:
        """The phase that follows a root; a slip at zero is made exactly zero."""
        c = self.mechanics.contact(t, y)
        if phase == FLIGHT:
            return 1 if c.slip >= 0.0 else -1
        if root == 0:
            return FLIGHT
        if phase == STICK:
            # Past F = mu N the tip slips backwards, for friction opposes it.
            return -1 if root == 1 else 1
        motor = self.mechanics.motor
        y[2 * self.mechanics.shapes] += c.slip / motor.rotor_radius
        force = self.holding(c := self.mechanics.contact(t, y))
        return STICK if abs(force) <= motor.friction_coefficient * self.normal(c) else -int(np.sign(force))


def equations(hertz: HertzMotor, phase: int) -> tuple[Any, Any]:
    """Right-hand side and root function of a phase, as CVODE takes them."""
    mechanics, forces = hertz.mechanics, hertz.forces(phase)
    directions, values = hertz.roots(phase)

    def rates(t: float, y: Array, out: Array) -> None:
        out[:] = mechanics.derivative(t, y, forces)

    def events(t: float, y: Array, out: Array) -> None:
        out[:] = values(mechanics.contact(t, y))

    events.direction, events.terminal = directions, [True] * len(directions)  # type: ignore[attr-defined]
    return rates, events


def solve(motor: OracleMotor, stiffness: float, duration: float, rtol: float) -> CvodeRun:
    """Run a motor from rest for `duration` [s]; its tip must not begin inside the rotor."""
    mechanics = Mechanics(motor)
    hertz, atol = HertzMotor(mechanics, stiffness), mechanics.tolerances(rtol)[:-1]
    run, t, y, phase = CvodeRun(), 0.0, mechanics.initial_state(), FLIGHT
    while t < duration:
        rates, events = equations(hertz, phase)
        solver = CVODE(
            rates, method="Adams", rtol=rtol, atol=atol, max_step=LONGEST_STEP, max_num_steps=1_000_000,
            eventsfn=events, num_events=len(events.direction),
        )  # fmt: skip
        result = solver.solve([t, duration], y)
        if not result.success:
            raise RuntimeError(f"CVODE failed in phase {phase} after {t} s: {result.message}")
        end, y = float(result.t[-1]), np.array(result.y[-1])
        run.time_in_contact += 0.0 if phase == FLIGHT else end - t
        run.time_in_stick += end - t if phase == STICK else 0.0
        t = end
        if result.i_events is None:
            break
        if phase == FLIGHT:
            run.start_time.append(t)
        phase = hertz.after(phase, int(np.flatnonzero(result.i_events[-1])[0]), t, y)
    run.tip_normal_displacement, run.tip_slope, *_ = mechanics.tip_state(y)
    run.rotor_velocity, run.normal_impulse, run.friction_impulse = (
        float(v) for v in y[2 * mechanics.shapes :]
    )
    return run
