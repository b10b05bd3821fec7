"""Where in a step something happens: a function of time for every event, one finder of its zero, extremes."""

from typing import Any

from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.compiler.lanes import largest, load
from contactlab.engine.friction import friction_at
from contactlab.engine.kinematics import contact_after
from contactlab.engine.memory import end_at, guard_at, limit_at, memory_at
from contactlab.engine.state import (
    CONE,
    GUARD,
    NODES,
    NOTHING,
    PEAK,
    RELEASE,
    REVERSAL,
    TOUCH,
    Law,
    Memory,
    Run,
    slope_at,
    value_at,
)
from contactlab.laws.base import RATE_DEPENDENT, SET_VALUED, STICK

SUMMIT = PEAK + 1
"""The gap at its widest, which ends no step."""

MOST_EVALUATIONS = 100
"""Of the bracket around the instant of an event."""

TIME_DIGIT = 1e-14
"""Length of the bracket over that of the step at which a search ends."""

CONE_ROUND_OFF = 1e-9
"""Relative excess of friction over its bound that still sticks: the bound is reached, not left."""


@inner_kernel
def event_value(run: Run, law: Law, s: float, event: int) -> float:
    """Return a function of time in the step whose zero is the event: of REVERSAL, what must keep its sign."""
    state = run.state
    x = s / state.length
    if event == CONE:
        # Room in the cone, |F| <= b about the middle of the bounds: positive in stick.
        return value_at(state.bound, x) - abs(value_at(state.friction, x) - value_at(state.bias, x))
    if event == PEAK:
        return slope_at(state.normal, x)
    if event == RELEASE and state.law.compliant == 0:
        return value_at(state.normal, x)
    if event == GUARD:
        return float(guard_at(run, law, law.memory, s))
    gap, rate, slip, _, _, _, _ = contact_after(run, s)
    if event == SUMMIT:
        return rate
    if event == TOUCH:
        return float(gap - limit_at(run, law, law.memory, s, (gap, rate, slip))[0])
    memory_at(run, law, law.memory, s)
    end = end_at(run, law, law.memory, rate)
    if event == RELEASE:
        return float(gap - end)
    if state.law.friction_kind == SET_VALUED or gap >= end:
        return slip
    normal = max(value_at(state.normal, x), 0.0)
    # A slider slips by what its spring does not take: the difference of the rate with which it would stretch
    # and that with which its bound lets it.
    stretching = friction_at(law, (gap, rate, slip), end, normal)[1]
    return stretching - value_at(state.internal_rate, x)


@inner_kernel
def locate(run: Run, law: Law, event: int, left: float, right: float, digit: float) -> float:
    """Find the time of an event between left and right [s], where its function has different signs.

    Regula falsi that halves the value of an end that stays twice (the Illinois rule); a value of at most
    `digit` counts as zero.
    """
    at_left = event_value(run, law, left, event)
    at_right = event_value(run, law, right, event)
    if at_left == 0.0 or at_left * at_right > 0.0:
        # The zero lies at an end, to round-off: the nearer one.
        return left if abs(at_left) <= abs(at_right) else right
    stayed = 0
    before = left
    s = right
    for _ in range(MOST_EVALUATIONS):
        # The secant through both ends, which keeps the bracket. Round-off may put it onto an end, or NaN
        # anywhere: then the middle.
        s = (at_left * right - at_right * left) / (at_left - at_right)
        if not left < s < right:
            s = 0.5 * (left + right)
        value = event_value(run, law, s, event)
        if abs(value) <= digit or abs(s - before) <= TIME_DIGIT * run.state.length:
            break
        before = s
        # The new value replaces the end of its sign. An end that stays a second time has its value halved:
        # for a curved function the secants would otherwise approach the zero from one side, and slowly.
        if value * at_right > 0.0:
            right, at_right = s, value
            if stayed < 0:
                at_left *= 0.5
            stayed = -1
        else:
            left, at_left = s, value
            if stayed > 0:
                at_right *= 0.5
            stayed = 1
    return s


@inner_kernel
def locate_gap(
    run: Run,
    law: Law,
    event: int,
    left: tuple[float, float, float],
    right: tuple[float, float, float],
    digit: float,
) -> float:
    """Find the time of a TOUCH or RELEASE between two instants, at which the gap has different signs.

    An instant is time [s], gap over that of the event [m] and its rate [m/s]. The time is that of gap zero on
    the inverse cubic through both; the new instant takes the place of the one with its sign. It ends where
    what a last Newton step leaves is at most `digit` [m], or no digit of the time. A law with limits of its
    own, which may depend on the gap rate, has no such rate.
    """
    if run.state.law.has_limits != 0:
        return locate(run, law, event, left[0], right[0], digit)
    a, gap_a, rate_a = left
    b, gap_b, rate_b = right
    if gap_a == 0.0 or gap_a * gap_b > 0.0:
        # The zero lies at an end, to round-off: the nearer one.
        return a if abs(gap_a) <= abs(gap_b) else b
    s = b
    for count in range(MOST_EVALUATIONS):
        # Hermite's cubic of the time over the gap: x is the share of the change of the gap up to zero.
        change, h = gap_b - gap_a, b - a
        x = -gap_a / change
        y = 1.0 - x
        s = a + h * x * x * (1.0 + 2.0 * y) + change * x * y * (y / rate_a - x / rate_b)
        # A rate near zero puts it anywhere. Every fourth is the middle, so that the bracket shrinks whatever
        # the rates are.
        if not a < s < b or count % 4 == 3:
            s = 0.5 * (a + b)
        gap, rate, _, _, _, _, _ = contact_after(run, s)
        newton = -gap / rate if rate != 0.0 else h
        # The gap that a Newton step leaves, by the curvature between the ends.
        left_over = 0.5 * abs((rate_b - rate_a) / h) * newton * newton
        enough = max(digit, TIME_DIGIT * run.state.length * abs(rate))
        if a <= s + newton <= b and left_over <= enough:
            return s + newton
        if abs(gap) <= digit or h <= TIME_DIGIT * run.state.length:
            break
        if gap * gap_b > 0.0:
            b, gap_b, rate_b = s, gap, rate
        else:
            a, gap_a, rate_a = s, gap, rate
    return s


@part_kernel
def keeps_slip(run: Run) -> bool:
    """Return whether set-valued friction has a slip that is prescribed, which no friction can hold.

    It reverses at ends of pieces alone, where steps end too.
    """
    state = run.state
    return bool(
        run.plant.wave.led_slip != 0 and state.law.compliant != 0 and state.law.friction_kind == SET_VALUED
    )


@inner_kernel
def _release_before(run: Run, law: Law, i: int, rate: float) -> float:
    """Locate a release between node i and that before, or the step's start with its gap rate; else -1."""
    step, nodes, h = run.step, run.propagator.rule.nodes, run.state.length
    left, before = (nodes[i - 1] * h, step.gap_rate[i - 1]) if i > 0 else (0.0, rate)
    opening, now = step.gap[i] - step.end[i], step.gap_rate[i]
    end = nodes[i] * h, opening, now
    if before > 0.0 > now and opening < 0.0:
        # The gap may open and close between two nodes.
        at = locate(run, law, SUMMIT, left, end[0], 0.0)
        end = at, event_value(run, law, at, RELEASE), 0.0
        if not end[1] >= 0.0:
            return -1.0
    # A gap that is open while it closes is round-off of a touch-down.
    elif not (opening >= 0.0 and now >= 0.0):
        return -1.0
    opened = step.gap[i - 1] - step.end[i - 1] if i > 0 else event_value(run, law, 0.0, RELEASE)
    at = locate_gap(run, law, RELEASE, (left, opened, before), end, 0.0)
    return nodes[i] * h if at == left and before < 0.0 else at


@inner_kernel
def first_event(run: Run, law: Law, rate: float) -> tuple[int, float]:
    """Find the earliest event in the step and its time, or NOTHING and the step's length.

    `rate` is the gap rate at its start [m/s].
    """
    state, step, left = run.state, run.step, 0.0
    sticks = state.mode == STICK
    slides = not sticks and state.law.friction_kind != RATE_DEPENDENT and not keeps_slip(run)
    slides = slides and largest(load(state.bound.node)) > 0.0
    for i in range(NODES):
        right = run.propagator.rule.nodes[i] * state.length
        # From node to node, as the values there are known already: an event is looked for where one of its
        # signs has changed. All that happens in one interval is located, and the earliest is taken.
        first, s = NOTHING, right
        ceiling = state.bound.node[i] * (1.0 + CONE_ROUND_OFF)
        if sticks and abs(state.friction.node[i] - state.bias.node[i]) > ceiling:
            first, s = CONE, locate(run, law, CONE, left, right, 0.0)
        elif slides and state.sign * step.sliding[i] < 0.0:
            first, s = REVERSAL, locate(run, law, REVERSAL, left, right, 0.0)
        released = _release_before(run, law, i, rate)
        if released >= 0.0 and (first == NOTHING or released < s):
            first, s = RELEASE, released
        if first != NOTHING:
            return first, s
        left = right
    return NOTHING, state.length


@inner_kernel
def first_guard(run: Run, law: Law, memory: Memory | None, event: int, s: float) -> tuple[int, float]:
    """Find the earliest guard that falls through zero before an event at time s, or give that back.

    One that is below zero from the start on, and stays, falls at once.
    """
    if memory is None:
        return event, s
    state, chosen = run.state, run.state.guard
    for guard in range(state.law.guards):
        state.guard = guard
        # Only up to the earliest event so far: what lies behind it does not happen.
        left, before = 0.0, guard_at(run, law, memory, 0.0)
        for i in range(NODES):
            right = min(run.propagator.rule.nodes[i] * state.length, s)
            now = guard_at(run, law, memory, right)
            if now < 0.0:
                at = locate(run, law, GUARD, left, right, 0.0) if before > 0.0 else left
                if event != GUARD or at < s:
                    event, s, chosen = GUARD, at, guard
                break
            if right == s:
                break
            left, before = right, now
    state.guard = chosen
    return event, s


@inner_kernel
def track_extremes(run: Run, law: Law, gap: float, rate: float, normal: float) -> None:
    """Note largest normal force and penetration of the contact so far, between the nodes as well.

    Gap [m], its rate [m/s] and normal force [N] are those at the step's start.
    """
    state = run.state
    _track(run, law, state.contact, 0.0, gap, rate, normal)
    if state.contact.start_time < state.run_start:
        # The first step of a run that goes on is that of the run before.
        first = max(state.run_start - state.time, 0.0)
        if first > 0.0:
            gap, rate, _, _, _, _, _ = contact_after(run, first)
            normal = value_at(state.normal, first / state.length)
        _track(run, law, state.contact_of_run, first, gap, rate, normal)


@inner_kernel
def _track(run: Run, law: Law, contact: Any, first: float, gap: float, rate: float, normal: float) -> None:
    """Note the extremes in a row of contacts, from a time in the step on [s]."""
    state, step = run.state, run.step
    s, h = state.accepted_length, state.length
    peak, deepest = max(contact.peak_normal_force, normal), max(contact.max_penetration, -gap)
    left, before = first, rate
    for i in range(NODES):
        right, gap, now = run.propagator.rule.nodes[i] * h, step.gap[i], step.gap_rate[i]
        if right <= first:
            continue
        if right > s:
            # An event or the end of the run cuts the step here.
            right = s
            gap, now, _, _, _, _, _ = contact_after(run, s)
        peak = max(peak, state.normal.node[i] if s == h else value_at(state.normal, right / h))
        deepest = max(deepest, -gap)
        if before < 0.0 <= now and left < right:
            # The turning point by a line through the rates, and from there by the gap's parabola.
            curvature = (now - before) / (right - left)
            gap, slope, _, _, _, _, _ = contact_after(run, left - before / curvature)
            deepest = max(deepest, 0.5 * slope * slope / curvature - gap)
        if right == s:
            break
        left, before = right, now
    # A peak of the polynomial itself: nodes would miss it by the square of their distance, and differently
    # for every length of steps.
    if slope_at(state.normal, first / h) > 0.0 > slope_at(state.normal, s / h):
        at = locate(run, law, PEAK, first, s, 0.0)
        peak = max(peak, value_at(state.normal, at / h))
    contact.peak_normal_force, contact.max_penetration = peak, deepest
