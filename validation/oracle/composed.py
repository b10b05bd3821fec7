"""Any composed law, and Archard's, on the motor: DOP853 in contact, every switch an event.

The normal force, damping and friction are those of `normal_parts` and `friction_parts`. The state is that of
the motor, the work of the contact, and the internal variables:

    y = (r, r', Omega, P_n, P_t, W, z of the friction, z of the normal force)

W = -int (N gdot + F v) dt is what the contact has taken from the motor: its losses and what it stores.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

from oracle.flight import Flight
from oracle.friction_parts import At, Friction
from oracle.motor import Contact, Mechanics, OracleMotor
from oracle.normal_parts import Damping, Normal, undamped

SHORTEST = 1e-18
MOST = 5_000


@dataclass(frozen=True)
class Parts:
    """A law of parts; wear is that of Archard: k/(H A) [1/Pa/m2], z the depth worn off [m]."""

    normal: Normal
    friction: Friction
    damped: Damping = undamped
    wear: float = 0.0


@dataclass
class JudgedRun:
    """End of a run and its contacts, SI units."""

    rotor_velocity: float = 0.0
    u: float = 0.0
    contact_work: float = 0.0
    starts: list[float] = field(default_factory=list)
    durations: list[float] = field(default_factory=list)
    normal_impulses: list[float] = field(default_factory=list)
    friction_impulses: list[float] = field(default_factory=list)

    def note(self, begun: float, ended: float, before: np.ndarray, after: np.ndarray) -> None:
        """Add a contact, with the impulses before and after it [N s]."""
        p_n, p_t = after - before
        self.starts.append(begun)
        self.durations.append(ended - begun)
        self.normal_impulses.append(float(p_n))
        self.friction_impulses.append(float(p_t))


class Cut(NamedTuple):
    """A contact that goes on: when it began, the impulses until then, its impact speed and its modes."""

    begun: float
    impulses: np.ndarray
    speed: float
    modes: tuple[int, int]


def pieces(
    changes: Sequence[tuple[float, OracleMotor]], duration: float
) -> Iterator[tuple[OracleMotor | None, float]]:
    """The motor that a piece begins with, None for the first one, and the end of the piece [s]."""
    motors = [None, *(motor for _, motor in changes)]
    yield from zip(motors, [*(time for time, _ in changes), duration], strict=True)


class Judge:
    """One motor with one law."""

    def __init__(self, motor: OracleMotor, parts: Parts, rtol: float) -> None:
        self.parts, self.rtol = parts, rtol
        self.take(motor)
        self.n = n = self.mechanics.shapes
        self.first = 2 * n + 4
        self.second = self.first + len(parts.friction.sizes)
        self.third = self.second + len(parts.normal.sizes)
        own = [*parts.friction.sizes, *parts.normal.sizes, 1e-9]
        self.atol = rtol * np.concatenate([self.mechanics.tolerances(1.0), 0.1 * np.array(own)])

    def take(self, motor: OracleMotor) -> None:
        """Go on with another motor."""
        self.mechanics = Mechanics(motor)
        self.flight = Flight(self.mechanics)

    def split(self, y: np.ndarray) -> tuple[list[float], list[float], float]:
        """z of friction and normal force, and the wear [m]."""
        return (
            y[self.first : self.second].tolist(),
            y[self.second : self.third].tolist(),
            float(y[self.third]),
        )

    def instant(
        self, c: Contact, y: np.ndarray, mode: int, speed: float
    ) -> tuple[At, list[float], list[float], float]:
        """What friction sees, z of both, and the depth [m]."""
        z_f, z_n, worn = self.split(y)
        d, rate = -c.gap - worn, -c.gap_rate
        elastic, stiffness, slope = self.parts.normal.spring(mode, d, rate, z_n)
        normal = self.parts.damped(elastic, rate, speed)
        hold = -(c.slip_bias + c.dnt * normal) / c.dtt
        at = At(normal, stiffness, slope * rate, c.slip, hold, self.parts.normal.pace(d, rate, z_n))
        return at, z_f, z_n, d

    def derivative(self, t: float, y: np.ndarray, modes: tuple[int, int], speed: float) -> np.ndarray:
        """Time derivative of y in contact."""
        mechanics, n, m = self.mechanics, self.n, self.mechanics.motor
        acceleration = mechanics.free_acceleration(t, y)
        c = mechanics.contact_under(y, acceleration)
        at, z_f, z_n, d = self.instant(c, y, modes[0], speed)
        sticks = self.parts.friction.set_valued and modes[1] == 0
        friction = self.parts.friction.force(modes[1], at, z_f)
        normal, slip = at.normal, 0.0 if sticks else c.slip
        load = (normal * c.n_row[0] + friction * c.t_row[0], normal * c.n_row[1] + friction * c.t_row[1])
        out = np.empty_like(y)
        out[:n] = y[n : 2 * n]
        out[n : 2 * n] = acceleration + mechanics.tip_response @ load
        omega = y[2 * n]
        torque = -m.rotor_radius * friction - m.rotor_damping * omega - m.load_torque
        out[2 * n : 2 * n + 4] = (
            torque / m.rotor_inertia, normal, friction, -normal * c.gap_rate - friction * c.slip
        )  # fmt: skip
        out[self.first : self.second] = self.parts.friction.rates(modes[1], at, z_f)
        out[self.second : self.third] = self.parts.normal.rates(d, z_n)
        out[self.third] = self.parts.wear * max(normal, 0.0) * abs(slip)
        return out

    def without_slip(self, t: float, y: np.ndarray) -> np.ndarray:
        """The state with the rotor at exactly the tip's speed."""
        out = y.copy()
        c = self.mechanics.contact(t, y)
        out[2 * self.n] += c.slip / self.mechanics.motor.rotor_radius
        return out

    def events(
        self, t: float, y: np.ndarray, modes: tuple[int, int], speed: float
    ) -> list[tuple[str, int, Callable[[float, np.ndarray], float]]]:
        """Kind, number and function (falling through zero) of every event of a phase."""
        parts, result = self.parts, []

        def add(kind: str, k: int, value: Callable[[Contact, np.ndarray], float]) -> None:
            start = value(self.mechanics.contact(t, y), y)
            offset = max(-start, 0.0) + SHORTEST
            result.append((kind, k, lambda t, y: value(self.mechanics.contact(t, y), y) + offset))

        def depth(c: Contact, y: np.ndarray) -> float:
            return -c.gap - float(y[self.third])

        add("release", 0, lambda c, y: parts.normal.left(modes[0], depth(c, y), self.split(y)[1]))
        for k, switch in enumerate(parts.normal.switches(modes[0])):
            add("normal", k, lambda c, y, f=switch: f(depth(c, y), -c.gap_rate, self.split(y)[1]))
        for k, switch in enumerate(parts.friction.switches(modes[1], self.split(y)[0])):

            def of(c: Contact, y: np.ndarray, f: Any = switch) -> float:
                at, z_f, _, _ = self.instant(c, y, modes[0], speed)
                return float(f(at, z_f))

            add("friction", k, of)
        return result

    def begin(self, t: float, y: np.ndarray, cut: Cut | None) -> tuple[np.ndarray, Cut]:
        """A contact that begins or goes on; one that sticks holds what it can under the forces there."""
        parts, n = self.parts, self.n
        if cut is None:
            speed = max(-self.mechanics.contact(t, y).gap_rate, 0.0)
            mode = parts.normal.touch(self.split(y)[1])
            cut = Cut(t, y[2 * n + 1 : 2 * n + 3].copy(), speed, (mode, 0))
        elif not parts.friction.set_valued or cut.modes[1] != 0:
            return y, cut
        else:
            y = self.without_slip(t, y)
        at, z_f, _, _ = self.instant(self.mechanics.contact(t, y), y, cut.modes[0], cut.speed)
        return y, cut._replace(modes=(cut.modes[0], parts.friction.touch(at, z_f)))

    def dwell(
        self, run: JudgedRun, t: float, y: np.ndarray, end: float, cut: Cut | None = None
    ) -> tuple[float, np.ndarray, Cut | None]:
        """One contact from its touch-down, or from where a change cut it, to its release or `end` [s]."""
        parts, n = self.parts, self.n
        y, (begun, impulses, speed, modes) = self.begin(t, y, cut)
        loaded = begun
        for _ in range(MOST):
            watched = self.events(t, y, modes, speed)
            functions = []
            for _, _, value in watched:

                def function(t: float, y: np.ndarray, value: Any = value) -> float:
                    return float(value(t, y))

                function.terminal, function.direction = True, -1  # type: ignore[attr-defined]
                functions.append(function)
            done = solve_ivp(
                lambda t, y, modes=modes: self.derivative(t, y, modes, speed),
                (t, end), y, "Radau" if parts.friction.stiff else "DOP853", events=functions,
                rtol=self.rtol, atol=self.atol, max_step=2e-6, dense_output=parts.damped is not undamped,
            )  # fmt: skip
            if done.status < 0:
                raise RuntimeError(f"The contact at {t} s: {done.message}")
            loaded = self.loaded_until(done, modes, speed, loaded)
            t, y = float(done.t[-1]), done.y[:, -1].copy()
            fired = [i for i, hits in enumerate(done.t_events) if len(hits) and hits[-1] == t]
            if not fired:
                return t, y, Cut(begun, impulses, speed, modes)
            if watched[fired[0]][0] == "release":
                break
            kind, k, _ = watched[fired[0]]
            c = self.mechanics.contact(t, y)
            if kind == "normal":
                z_n = self.split(y)[1]
                mode, z_n = parts.normal.switched(modes[0], -c.gap - float(y[self.third]), z_n)
                modes = mode, modes[1]
                y[self.second : self.third] = z_n
                continue
            if parts.friction.set_valued:
                y = self.without_slip(t, y)
                c = self.mechanics.contact(t, y)
            at, z_f, _, _ = self.instant(c, y, modes[0], speed)
            mode, z_f = parts.friction.switched(modes[1], k, at, z_f)
            modes = modes[0], mode
            y[self.first : self.second] = z_f
        else:
            raise RuntimeError(f"More than {MOST} phases in the contact at {begun} s.")
        run.note(begun, loaded, impulses, y[2 * n + 1 : 2 * n + 3])
        return t, y, None

    def loaded_until(self, done: Any, modes: tuple[int, int], speed: float, before: float) -> float:
        """The last time of a phase at which the bodies press each other, `before` if they never do [s]."""
        if self.parts.damped is undamped:
            return float(done.t[-1])

        def presses(t: float) -> bool:
            y = done.sol(t)
            return self.instant(self.mechanics.contact(t, y), y, modes[0], speed)[0].normal > 0.0

        pressing = [i for i, t in enumerate(done.t[:-1]) if presses(t)]
        if not pressing:
            return before
        left, right = float(done.t[pressing[-1]]), float(done.t[pressing[-1] + 1])
        for _ in range(50):
            middle = 0.5 * (left + right)
            left, right = (middle, right) if presses(middle) else (left, middle)
        return left

    def fly(self, t: float, y: np.ndarray, end: float) -> tuple[float, np.ndarray]:
        """From a release, or the start, to the next touch-down or `end` [s]."""
        normal, friction = self.parts.normal, self.parts.friction
        _, z_n, worn = self.split(y)
        fresh = self.first, self.second

        def clear(y: np.ndarray) -> None:
            y[fresh[0] : fresh[1]] = friction.fresh()
            if not normal.lasts:
                y[self.second : self.third] = normal.fresh()

        if normal.lasts or normal.begins(z_n) == 0.0:

            def level(s: float) -> float:
                return -worn - (normal.begins(normal.in_flight(z_n, s)) if normal.sizes else 0.0)

            clear(y)
            start = t
            t, y, _ = self.flight.until(t, y, end, level)
            y[self.second : self.third] = normal.in_flight(z_n if normal.lasts else normal.fresh(), t - start)
            return t, y
        # Over a dent: it is clear where the gap has opened, or touched again before.
        dent = normal.begins(z_n)
        t_down, y_down, _ = self.flight.until(t, y, end, lambda _: -dent)
        t_up, y_up, up = self.flight.until(t, y, end, lambda _: 0.0, upwards=True)
        if up and t_up < t_down:
            clear(y_up)
            return self.fly(t_up, y_up, end)
        return t_down, y_down

    def run(self, duration: float, changes: Sequence[tuple[float, OracleMotor]] = ()) -> JudgedRun:
        """From rest, the gap open, for a duration [s]; from times on other motors, of the same resonator."""
        n, run = self.n, JudgedRun()
        y = np.zeros(self.third + 1)
        y[: 2 * n + 1] = self.mechanics.initial_state()[: 2 * n + 1]
        y[self.first : self.second] = self.parts.friction.fresh()
        y[self.second : self.third] = self.parts.normal.fresh()
        t, cut = 0.0, None
        for motor, end in pieces(changes, duration):
            if motor is not None:
                self.take(motor)
            while t < end:
                if cut is None:
                    t, y = self.fly(t, y, end)
                if t < end:
                    t, y, cut = self.dwell(run, t, y, end, cut)
                if len(run.starts) > MOST:
                    raise RuntimeError(f"More than {MOST} contacts.")
        if cut is not None:
            run.note(cut.begun, t, cut.impulses, y[2 * n + 1 : 2 * n + 3])
        run.rotor_velocity = float(y[2 * n])
        run.u = float(self.mechanics.tip_state(y)[0])
        run.contact_work = float(y[2 * n + 3])
        return run
