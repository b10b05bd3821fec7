"""What a law remembers along drawn paths, by an integration of its own that no engine has a part in.

On a `Path` gap, gap rate and slip are given functions of time. The internal
variables flow by Runge's and Kutta's method, guards and releases are found where they are, and what jumps is
written down: the states at which a law's kernels are evaluated are those that its own history leads to.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache, lru_cache
from math import ceil, copysign, cos, isfinite, pi, sin
from typing import NamedTuple, final

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from contactlab.arrays import Array
from contactlab.laws.base import ELASTOPLASTIC, SET_VALUED, PenaltyLaw
from contactlab.laws.memory import AT_RELEASE, AT_SLIP, AT_STICK, AT_TOUCH
from contactlab.testing.plants import Bench, Evaluator

GRID = 360
"""Steps on a path; it goes in and out three times and a half, with ripples."""

RIPPLES = (((1.0, 1.0), (0.35, 2.7), (0.1, 4.3)), ((0.8, 1.7), (0.4, 3.1), (0.4, 0.9)))
"""Shares of the sines of gap and of slip, and their frequencies over that of the first of the gap."""

DEAD = 0.3
"""Share of the slip's swing that is none, so that there is stick."""

Waves = tuple[tuple[float, float, float], ...]
"""Share, angular frequency [rad/s] and phase of each."""


@final
@dataclass(frozen=True)
class Path:
    """Gap [m], gap rate and slip [m/s] of a time [s]: sums of sines; the slip stands now and then."""

    duration: float
    begin: float  # gap about which it swings [m]
    depth: float  # [m]
    speed: float  # of the slip [m/s]
    waves: Waves
    slip_waves: Waves

    def at(self, time: float) -> tuple[float, float, float]:
        """Return all three."""
        gap, rate = self.begin, 0.0
        for share, omega, phase in self.waves:
            gap -= self.depth * share * sin(omega * time + phase)
            rate -= self.depth * share * omega * cos(omega * time + phase)
        swing = self._swing(time)
        return gap, rate, copysign(self.speed * max(abs(swing) - DEAD, 0.0), swing)

    def _swing(self, time: float) -> float:
        return sum(share * sin(omega * time + phase) for share, omega, phase in self.slip_waves)

    def switches(self) -> Array:
        """Return the times at which stick begins or ends, in their order."""

        def swing(time: float) -> float:
            return abs(self._swing(time)) - DEAD

        grid = np.linspace(0.0, self.duration, GRID + 1)
        values = np.array([swing(t) for t in grid.tolist()])
        at = np.flatnonzero(values[1:] * values[:-1] < 0.0)
        return np.array([root(swing, grid[i], grid[i + 1]) for i in at.tolist()])


def drawn_path(number: int, begin: float) -> Path:
    """Draw a path about the gap at which a first contact begins: depths to 5 um, slips to 1 m/s."""
    rng = np.random.default_rng([7, number])
    depth, approach = 10.0 ** rng.uniform(-7.5, -5.3), 10.0 ** rng.uniform(-1.5, -0.3)
    turn, phase = approach / depth, rng.uniform(0.0, 2.0 * pi, (2, 3))
    # It begins clear of the contact.
    phase[0, 0] = -0.5 * pi
    waves, slip_waves = (
        tuple((share, turn * ratio, float(at)) for (share, ratio), at in zip(shares, phases, strict=True))
        for shares, phases in zip(RIPPLES, phase, strict=True)
    )
    speed = 10.0 ** rng.uniform(-3.0, 0.0)
    return Path(7.0 * pi / turn, begin, depth, speed, waves, slip_waves)


def root(function: Callable[[float], float], start: float, end: float) -> float:
    """Return where a function that has two signs at the ends is zero, or the end that is zero already."""
    if function(start) * function(end) >= 0.0:
        return end
    return float(brentq(function, start, end, xtol=1e-18, rtol=1e-13))


PATHS = 3
"""Of a law."""

MOST_EVENTS = 400
"""On one path: more are a chatter."""

MOST_PARTS = 256
"""Of a step in which a variable relaxes faster than the path goes; beyond, an implicit method takes over."""

ASKED = 5
"""Steps between two states at which the kernels are evaluated."""


class Instant(NamedTuple):
    """A state in contact that a law's own history has led to."""

    path: Path
    time: float
    gap: float
    rate: float
    slip: float
    speed: float  # at which the contact began
    kept: Array


class Jump(NamedTuple):
    """What an event did to what is kept."""

    event: int
    at: Instant
    kept: Array  # after it


@final
@dataclass
class Flow:
    """Collect what a law has gone through."""

    instants: list[Instant] = field(default_factory=list)
    jumps: list[Jump] = field(default_factory=list)
    limits: list[tuple[float, float]] = field(default_factory=list)
    faults: list[str] = field(default_factory=list)
    chatter: list[str] = field(default_factory=list)  # of the guards
    largest: Array = field(default_factory=lambda: np.zeros(0))  # of every guard
    lowest: Array = field(default_factory=lambda: np.zeros(0))  # and of what is beside an event of its own
    span: Array = field(default_factory=lambda: np.zeros(0))  # of what is kept

    def see(self, evaluator: Evaluator, at: Instant, guards: Array, every: bool) -> None:
        """Take the state at the end of a step."""
        self.span = np.maximum(self.span, np.abs(at.kept))
        self.largest = np.maximum(self.largest, np.abs(guards))
        self.lowest = np.minimum(self.lowest, guards)
        if every:
            self.instants.append(at)
            self.limits.append(evaluator.limits(at.kept))


@final
class Walker:
    """Take a compliant law along one path."""

    def __init__(self, evaluator: Evaluator, path: Path, flow: Flow) -> None:
        self.evaluator, self.path, self.flow = evaluator, path, flow
        self.kept, self.speed, self.events, self.fired = evaluator.initial.copy(), 0.0, 0, 0
        self.in_contact, self.forgotten = False, True
        self.lasting = np.array([each.life == "run" for each in evaluator.variables], dtype=bool)
        self.friction_kind = evaluator.law.friction_kind

    def state(self, time: float, kept: Array) -> Instant:
        """Return the state at a time; a contact ends where it does, whatever round-off says."""
        gap, rate, slip = self.path.at(time)
        if self.in_contact:
            gap = min(gap, self.evaluator.limits(kept)[1])
        return Instant(self.path, time, gap, rate, slip, self.speed, kept)

    def normal(self, at: Instant) -> float:
        """Return the normal force, none out of contact [N]."""
        if not self.in_contact:
            return 0.0
        return float(self.evaluator.force(at.gap, at.rate, at.slip, at.speed, at.kept)[0])

    def rates(self, time: float, kept: Array) -> Array:
        """Return the rates of what is kept; in flight only what has the life of the run has any."""
        if not kept.size or not (self.in_contact or self.lasting.any()):
            return np.zeros(kept.size)
        at = self.state(time, kept)
        slip = at.slip if self.in_contact else 0.0
        result = self.evaluator.rates(at.gap, at.rate, slip, self.normal(at), kept)
        return result if self.in_contact else np.where(self.lasting, result, 0.0)

    def guards(self, time: float, kept: Array) -> Array:
        """Return all guards at a time."""
        at = self.state(time, kept)
        return self.evaluator.guards(at.gap, at.rate, at.slip, self.normal(at), kept)

    def flown(self, time: float, length: float, parts: int) -> Array:
        """Return what is kept a length of time later, by so many steps of Runge and Kutta.

        Where the most steps are too few for a fast relaxation, by an implicit method.
        """
        kept, h = self.kept, length / max(parts, 1)
        for i in range(parts if kept.size else 0):
            t = time + i * h
            first = self.rates(t, kept)
            second = self.rates(t + 0.5 * h, kept + 0.5 * h * first)
            third = self.rates(t + 0.5 * h, kept + 0.5 * h * second)
            fourth = self.rates(t + h, kept + h * third)
            kept = kept + h / 6.0 * (first + 2.0 * second + 2.0 * third + fourth)
        if parts == MOST_PARTS:
            # Explicit steps that are too long lead beyond what can be reached.
            reach = np.abs(self.kept) + 10.0 * np.abs(self.rates(time, self.kept)) * length
            if not (np.abs(kept) <= reach + 1e3 * self.path.depth).all():
                kept = self._relaxed(time, length)
        return self._slid(time + length, kept)

    def _relaxed(self, time: float, length: float) -> Array:
        """Return what is kept a length of time later, by an implicit method for fast relaxation."""
        if length <= 0.0:
            return self.kept
        size = np.maximum(np.abs(self.kept), self.path.depth)
        result = solve_ivp(
            self.rates, (time, time + length), self.kept, method="Radau", rtol=1e-8, atol=1e-12 * size
        )
        return np.asarray(result.y[:, -1]) if result.success else np.full(self.kept.size, np.nan)

    def _slid(self, time: float, kept: Array) -> Array:
        """Keep the stretch of a spring on the bound of its slider."""
        if not (self.friction_kind == ELASTOPLASTIC and self.in_contact):
            return kept
        at = self.state(time, kept)
        normal, bound, _, _ = self.evaluator.force(at.gap, at.rate, at.slip, at.speed, kept)
        stiffness = self.evaluator.friction(at.gap, at.rate, at.slip, normal, kept)[3]
        most = bound / stiffness if stiffness > 0.0 else 0.0
        kept = kept.copy()
        kept[0] = min(max(kept[0], -most), most)
        return kept

    def parts(self, time: float, length: float) -> int:
        """Return the steps that a length of time is cut into, by how fast each variable relaxes."""
        if not self.kept.size:
            return 1
        rates, fastest = self.rates(time, self.kept), 0.0
        for k in range(self.kept.size):
            nudge = 1e-6 * (abs(self.kept[k]) + abs(length * rates[k]))
            if nudge > 0.0:
                other = self.kept.copy()
                other[k] += nudge
                fastest = max(fastest, abs(float(self.rates(time, other)[k] - rates[k])) / nudge)
        if not isfinite(fastest):
            return 1
        return min(ceil(2.0 * fastest * length) or 1, MOST_PARTS)

    def walk(self) -> None:
        """Go the whole path, and write down what happens."""
        path = self.path
        switches = path.switches()
        grid = np.union1d(np.linspace(0.0, path.duration, GRID + 1), switches)
        for i, (start, end) in enumerate(zip(grid[:-1].tolist(), grid[1:].tolist(), strict=True)):
            if self.in_contact and self.friction_kind == SET_VALUED and start in switches:
                slips = path.at(0.5 * (start + end))[2] != 0.0
                self.happens(AT_SLIP if slips else AT_STICK, start)
            self.advance(start, end)
            if self.in_contact and path.at(end)[0] < self.evaluator.limits(self.kept)[1]:
                at = self.state(end, self.kept)
                self.flow.see(self.evaluator, at, self.guards(end, self.kept), i % ASKED == 0)
            if not np.isfinite(self.kept).all():
                self.flow.faults.append(f"what it remembers becomes {self.kept.tolist()}")
                return
            if self.events > MOST_EVENTS:
                often = self.fired > MOST_EVENTS // 2
                what = f"its guards fire {self.fired}" if often else f"contact begins and ends {self.events}"
                (self.flow.chatter if often else self.flow.faults).append(f"{what} times")
                return

    def advance(self, time: float, end: float) -> None:
        """Go on to the end of a grid step, event by event."""
        while time < end and self.events <= MOST_EVENTS:
            step = self._in_contact if self.in_contact else self._in_flight
            time = step(time, end)

    def happens(self, event: int, time: float) -> None:
        """Let what is kept jump."""
        at = self.state(time, self.kept)
        # Nothing slips where stick begins or ends.
        at = at._replace(slip=0.0) if event in (AT_SLIP, AT_STICK) else at
        after = self.evaluator.jumped(event, at.gap, at.rate, at.slip, self.normal(at), self.kept)
        self.flow.jumps.append(Jump(event, at, after))
        self.kept, self.events, self.fired = after, self.events + 1, self.fired + (event >= 0)

    def _in_flight(self, time: float, end: float) -> float:
        evaluator = self.evaluator
        begin, anew = evaluator.limits(self.kept)[0], evaluator.limits(self._fresh())[0]
        gap = self.path.at(end)[0]
        if self.forgotten:
            begin = anew
        elif max(gap, self.path.at(time)[0]) > anew:
            self.kept, self.forgotten = self._fresh(), True
            return time
        if not gap < begin:
            self.kept = self.flown(time, end - time, self.parts(time, end - time))
            return end
        touch = time
        if self.path.at(time)[0] > begin:
            touch = root(lambda t: self.path.at(t)[0] - begin, time, end)
        elif self.path.at(time)[1] >= 0.0:
            # It may open still, and does not close again within the step but by a turn.
            return end
        self.kept = self.flown(time, touch - time, self.parts(time, touch - time))
        self.speed, self.in_contact, self.forgotten = max(-self.path.at(touch)[1], 0.0), True, False
        self.happens(AT_TOUCH, touch)
        return touch

    def _fresh(self) -> Array:
        """Return what is left of a contact that is forgotten."""
        return np.where(self.lasting, self.kept, self.evaluator.initial)

    def _in_contact(self, time: float, end: float) -> float:
        parts = self.parts(time, end - time)

        # Guards, release and the step itself evaluate the end.
        @cache
        def after(t: float) -> Array:
            return self.flown(time, t - time, parts) if t > time else self.kept

        def open_by(t: float) -> float:
            kept = after(t)
            return self.path.at(t)[0] - self.evaluator.limits(kept)[1]

        def falls(k: int) -> Callable[[float], float]:
            return lambda t: float(self.guards(t, after(t))[k])

        first, event = end, None
        before, behind = self.guards(time, self.kept), self.guards(end, after(end))
        for k in np.flatnonzero((before > 0.0) & (behind <= 0.0)).tolist():
            when = root(falls(k), time, first) if falls(k)(first) <= 0.0 else end
            first, event = (when, k) if when < first or event is None else (first, event)
        if open_by(first) > 0.0 and self.path.at(first)[1] > 0.0:
            first = root(open_by, time, first) if open_by(time) < 0.0 else time
            event = AT_RELEASE
        self.kept = after(first)
        if event is None:
            return end
        self.happens(event, first)
        if event == AT_RELEASE:
            self.in_contact = False
        return first


@lru_cache(maxsize=1)
def flow_of(bench: Bench) -> Flow:
    """Take a compliant law that remembers, or has limits of its own, along all paths."""
    law, flow = bench.law, Flow()
    if not isinstance(law, PenaltyLaw) or (not law.internal_variables and law.limits is None):
        return flow
    evaluator = Evaluator(law)
    flow.span = np.zeros(len(law.internal_variables))
    flow.largest, flow.lowest = np.zeros(law.guards), np.zeros(law.guards)
    for number in range(PATHS):
        path = drawn_path(number, evaluator.limits(evaluator.initial)[0])
        Walker(evaluator, path, flow).walk()
    return flow
