"""What a reference run leaves, and what its contact models share: phase, flight and book."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.integrate import OdeSolution, solve_ivp

from oracle.motor import Law, Mechanics

SHORTEST = 1e-18
"""An event is armed this far on the safe side of its start value, in its own unit (m or m/s)."""

PHASE_LIMIT = 10_000
"""More phases in one contact, or contacts in one run, mean that the run no longer advances."""


@dataclass(frozen=True, kw_only=True)
class OracleRun:
    """End state, contacts and energy ledger of one run, SI units, signs as in `oracle.motor`.

    The arrays have one entry a contact, in time order.  A contact still open at the end of the run
    is listed with what it gathered so far.  friction_impulse is that on the tip along t; the rotor
    receives -R times it.  peak_normal_force is the largest finite force: the impulse of a rigid
    impact is not in it, but is in normal_impulse.  contact_loss is what rigid impacts take, their
    friction included.

        E(end) - initial_energy = drive_work - damping_loss - friction_loss - contact_loss
                                  - load_work + energy_residual
    """

    u: float
    theta: float
    u_rate: float
    theta_rate: float
    rotor_velocity: float
    rotor_angle: float
    start_time: np.ndarray
    duration: np.ndarray
    stick_duration: np.ndarray
    normal_impulse: np.ndarray
    friction_impulse: np.ndarray
    peak_normal_force: np.ndarray
    time_in_contact: float
    drive_work: float
    damping_loss: float
    friction_loss: float
    contact_loss: float
    load_work: float
    kinetic_energy: float
    strain_energy: float
    contact_energy: float
    initial_energy: float

    @property
    def energy(self) -> float:
        """Kinetic, strain and contact energy at the end [J]."""
        return self.kinetic_energy + self.strain_energy + self.contact_energy

    @property
    def energy_residual(self) -> float:
        """What the ledger leaves unexplained [J]; integration error only."""
        spent = self.damping_loss + self.friction_loss + self.contact_loss + self.load_work
        return self.energy - self.initial_energy - self.drive_work + spent


@dataclass
class ContactBook:
    """Rows of the contacts; `impact_loss` [J] gathers what rigid impacts take."""

    impulses: slice
    rows: list[list[float]] = field(default_factory=list)
    impact_loss: float = 0.0
    _start: tuple[float, np.ndarray] | None = None
    _stick: float = 0.0
    _peak: float = 0.0

    def open(self, t: float, y: np.ndarray) -> None:
        """A contact begins; y is the state before any impact."""
        if len(self.rows) >= PHASE_LIMIT:
            raise RuntimeError(f"More than {PHASE_LIMIT} contacts up to {t} s: no advance.")
        self._start, self._stick, self._peak = (t, y[self.impulses].copy()), 0.0, 0.0

    def add(self, stick: float, peak: float) -> None:
        """Book sticking time [s] and a normal force [N] seen in a phase."""
        self._stick += stick
        self._peak = max(self._peak, peak)

    def close(self, t: float, y: np.ndarray) -> None:
        """The contact ends."""
        if self._start is None:
            raise RuntimeError(f"A contact is closed at {t} s that was never opened.")
        start, before = self._start
        p_n, p_t = y[self.impulses] - before
        self.rows.append([start, t - start, self._stick, p_n, p_t, self._peak])


class Event(NamedTuple):
    """A zero of value(t, y) crossed upwards (direction +1) or downwards (-1)."""

    value: Callable[[float, np.ndarray], float]
    direction: int
    terminal: bool = True


class PhaseEnd(NamedTuple):
    """End of a phase.

    fired is the index of the event that ended it, None at the time limit; hits has the (t, y) of
    every event; course gives y at any time of the phase, if it was asked for.
    """

    t: float
    y: np.ndarray
    fired: int | None
    hits: list[list[tuple[float, np.ndarray]]]
    course: OdeSolution | None


class _Watched:
    """An event as scipy wants it: a callable with attributes."""

    def __init__(self, event: Event) -> None:
        self.value, self.direction, self.terminal = event

    def __call__(self, t: float, y: np.ndarray) -> float:
        return self.value(t, y)


class Stepper(NamedTuple):
    """How phases are integrated: scipy method, tolerances, largest steps [s]."""

    method: str
    rtol: float
    atol: np.ndarray | float
    flight_step: float
    contact_step: float


def run_phase(
    mechanics: Mechanics,
    law: Law | None,
    events: list[Event],
    t: float,
    y: np.ndarray,
    end: float,
    stepper: Stepper,
    keep_course: bool = False,
) -> PhaseEnd:
    """Integrate one smooth phase from (t, y) until a terminal event or `end` [s]."""

    result = solve_ivp(
        lambda time, state: mechanics.derivative(time, state, law),
        (t, end),
        y,
        method=stepper.method,
        dense_output=keep_course,
        events=[_Watched(event) for event in events],
        rtol=stepper.rtol,
        atol=stepper.atol,
        max_step=stepper.flight_step if law is None else stepper.contact_step,
    )
    if result.status < 0 or not np.all(np.isfinite(result.y[:, -1])):
        raise RuntimeError(f"The integration from {t} s to {end} s failed: {result.message}")
    found = zip(result.t_events, result.y_events, strict=True)
    hits = [list(zip(times, states, strict=True)) for times, states in found]
    fired = [i for i, event in enumerate(events) if event.terminal and len(hits[i])]
    last = float(result.t[-1])
    # Of several terminal events in one step only the earliest ends the phase.
    first = next((i for i in fired if hits[i][-1][0] == last), None)
    return PhaseEnd(last, result.y[:, -1], first, hits, result.sol)


def below(mechanics: Mechanics, level: float) -> Event:
    """The gap falls below `level` [m]."""
    return Event(lambda t, y: mechanics.contact(t, y).gap - level, -1)


def fly(
    mechanics: Mechanics, t: float, y: np.ndarray, end: float, stepper: Stepper
) -> tuple[float, np.ndarray, bool]:
    """Free flight from (t, y) to the touch-down or to `end` [s]; returns time, state, touched.

    Every minimum of the gap is located too: a dip that begins and ends within one step shows there,
    and the flight is then repeated up to the minimum, where the gap is negative and the touch-down
    can be bracketed.
    """
    stop = end
    lowest = Event(lambda time, state: mechanics.contact(time, state).gap_rate, +1, terminal=False)
    while t < end:
        floor = min(mechanics.contact(t, y).gap, 0.0) - SHORTEST
        result = run_phase(mechanics, None, [below(mechanics, floor), lowest], t, y, stop, stepper)
        minima = [hit for hit in result.hits[1] if t < hit[0] < result.t]
        dips = [hit for hit in minima if mechanics.contact(*hit).gap < floor]
        if dips:
            stop = float(dips[0][0])
            continue
        t, y, stop = result.t, result.y, end
        if result.fired is not None:
            return t, y, True
    return t, y, False


def touching(gap: float, gap_rate: float, normal_bias: float) -> bool:
    """Whether a start at this gap [m], gap rate [m/s] and free acceleration [m/s^2] is in contact.

    At exactly zero gap the next derivative that is not zero decides.
    """
    return (gap, gap_rate, normal_bias) < (0.0, 0.0, 0.0)


def finish(
    mechanics: Mechanics, y: np.ndarray, book: ContactBook, initial_energy: float, contact_energy: float
) -> OracleRun:
    """Collect the run from its last state and its book."""
    n = mechanics.shapes
    names = ["start_time", "duration", "stick_duration"]
    names += ["normal_impulse", "friction_impulse", "peak_normal_force"]
    table = np.array(book.rows, dtype=float).reshape(-1, len(names))
    columns = dict(zip(names, table.T, strict=True))
    u, theta, u_rate, theta_rate = mechanics.tip_state(y)
    kinetic, strain = mechanics.energies(y)
    omega, angle, drive, damping, friction, load = (float(value) for value in y[2 * n : 2 * n + 6])
    return OracleRun(
        u=u,
        theta=theta,
        u_rate=u_rate,
        theta_rate=theta_rate,
        rotor_velocity=omega,
        rotor_angle=angle,
        time_in_contact=float(columns["duration"].sum()),
        drive_work=drive,
        damping_loss=damping,
        friction_loss=friction,
        contact_loss=book.impact_loss,
        load_work=load,
        kinetic_energy=kinetic,
        strain_energy=strain,
        contact_energy=contact_energy,
        initial_energy=initial_energy,
        **columns,
    )
