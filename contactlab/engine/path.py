"""A law on a prescribed path, or behind a frame without inertia whose far end goes along it.

    x' = v,   e = x_L - x,   k e + c (x_L' - v) + F(g, g', v, z) = 0,   z' = r(g, g', v, z)

The load point x_L and the gap g, or the normal force, are splines of time; k and c are stiffness and damping
of the frame, F the friction that the law answers with and z its internal variables. A path is the frame of
infinite stiffness: v = x_L'. A step is collocated at the Radau nodes, as one in contact of a run is: z and e
are polynomials through their values at the start and at the nodes, where the equations hold. Newton's method
takes friction, variables and slip velocity at once. Steps end where the path has a kink, and where a guard
falls through zero, a slider begins or ends to slide, or the slip reverses.
"""

from typing import Any

import numpy as np

from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.engine.memory import SLIP_ROUND_OFF
from contactlab.engine.path_contact import (
    HALVINGS,
    Path,
    bounds_of,
    forces_of,
    load_point,
    moves_freely,
    press,
    recall,
    seen_slip,
    slides,
)
from contactlab.engine.path_events import CONTINUOUS, find_event, jump_path, slip_of_frame, switch
from contactlab.engine.path_step import (
    NODE,
    WEIGHT,
    collocate_path,
    dense_at,
    guess_nodes,
    lay_polynomials,
    open_step,
    step_error,
)
from contactlab.engine.state import (
    CHATTERED,
    HEAD,
    INCONSISTENT,
    NODES,
    NOT_FINITE,
    RUNNING,
    SPEED,
    UNSOLVED,
    Law,
    Memory,
)
from contactlab.laws.base import RATE_DEPENDENT, SET_VALUED, SLIP, STICK
from contactlab.laws.memory import AT_SLIP, AT_STICK, AT_TOUCH

PIECES = 5
"""Pieces of a path that a step may span: as many as it has nodes, so that no sample goes unseen."""

ERROR_ORDER = NODES + 1
"""Order of the error of a step between its nodes."""

SAFETY, LEAST_FACTOR, MOST_FACTOR = 0.9, 0.1, 5.0
"""Of the next step: share of the length whose error is the tolerance, and bounds of the change."""

FRESH = 0.1
"""First step after an event over the one before it."""

FIRST = 1e-3
"""First step of all over the longest one."""

SHORTEST = 1e-14
"""Shortest step over the duration."""

AGAIN = 1e-9
"""Least first step after an event over the duration: in a shorter one forces change by round-off."""

AT_ONCE = 1e-10
"""Share of a step within which an event lies at its start."""

AT_END = 1e-9
"""Share of a step within which an event lies at its end."""

WATCHED, LEAST_WAY = 1000, 1e-6
"""Number of steps and events in which a path must go on by this share of it."""

MOST_AT_ONCE = 100
"""Events without a step between them."""


@inner_kernel
def _forces_at(path: Path, law: Law, x: float) -> tuple[float, float, float, float, float, float]:
    """Return normal force, friction [N], slip, gap rate [m/s], normal loss and the frame's loss [W], at x."""
    state = path.states[0]
    gap, rate, load, slip, extension, _, speed = dense_at(path, law, x)
    normal, _, _, friction, _, _ = forces_of(path, law, gap, rate, load, slip)
    lost = 0.0
    if state.framed == 1:
        friction = -(extension + state.relaxation * (speed - slip)) / state.compliance
        lost = state.relaxation / state.compliance * (speed - slip) ** 2
    loss = bounds_of(path, law, gap, rate, load, seen_slip(path, slip))[4]
    return normal, friction, slip, rate, loss, lost


@inner_kernel
def _record(path: Path, law: Law, x: float, last: float) -> float:
    """Integrate forces and powers from one share of the step to another, and return that."""
    state = path.states[0]
    h = (x - last) * state.length
    for i in range(NODES):
        normal, friction, slip, rate, loss, lost = _forces_at(path, law, last + NODE[i] * (x - last))
        weight = h * WEIGHT[i]
        state.normal_impulse += weight * normal
        state.friction_impulse += weight * friction
        state.friction_work -= weight * friction * slip
        state.normal_work -= weight * normal * rate
        state.contact_loss += weight * loss
        state.damping_loss += weight * lost
        speed = load_point(path, state.time + (last + NODE[i] * (x - last)) * state.length, True)[3]
        state.drive_work -= weight * (friction * speed + normal * rate)
    return x


@inner_kernel
def _stored_at(path: Path, law: Law, gap: float, rate: float, load: float, slip: float) -> float:
    """Return the energy that the contact stores [J], of what is recalled."""
    seen = seen_slip(path, slip)
    normal, _, _, stored, _ = bounds_of(path, law, gap, rate, load, seen)
    if path.states[0].friction_kind == SET_VALUED:
        return stored
    return float(stored + law.friction(gap, rate, seen, normal, law.parameters)[2])


@inner_kernel
def _write(path: Path, law: Law) -> None:
    """Write forces at the instants and records that a step has passed."""
    state, end = path.states[0], path.states[0].reached
    at_end = end >= state.end
    while state.next_instant < path.instants.size:
        time = path.instants[state.next_instant]
        if time > end and not at_end:
            break
        x = min(max((time - state.time) / state.length, 0.0), 1.0)
        gap, rate, load, slip, extension, _, speed = dense_at(path, law, x)
        normal, _, _, friction, _, _ = forces_of(path, law, gap, rate, load, slip)
        if state.framed == 1:
            friction = -(extension + state.relaxation * (speed - slip)) / state.compliance
        path.forces[state.next_instant, 0], path.forces[state.next_instant, 1] = normal, friction
        state.next_instant += 1
    if path.records.size == 0:
        return
    last = 0.0
    while state.next_record < path.records.size:
        time = path.records[state.next_record]
        if time > end and not at_end:
            break
        x = min(max((time - state.time) / state.length, 0.0), 1.0)
        if x > last:
            last = _record(path, law, x, last)
        _note(path, law, x)
    if last < 1.0:
        _record(path, law, 1.0, last)


@inner_kernel
def _note(path: Path, law: Law, x: float) -> None:
    """Write the next record, at a share x of the step."""
    state, row = path.states[0], path.series[path.states[0].next_record]
    gap, rate, load, slip, extension, way, _ = dense_at(path, law, x)
    for k in range(state.variables):
        path.traces[state.next_record, k] = path.row[HEAD + k]
    row.way, row.slip_velocity, row.gap, row.gap_rate = way - extension, slip, gap, rate
    row.normal_impulse, row.friction_impulse = state.normal_impulse, state.friction_impulse
    row.strain_energy = 0.5 * extension * extension / state.compliance if state.framed == 1 else 0.0
    row.contact_energy = _stored_at(path, law, gap, rate, load, slip)
    row.drive_work, row.damping_loss = state.drive_work, state.damping_loss
    row.friction_work, row.normal_work = state.friction_work, state.normal_work
    row.contact_loss = state.contact_loss
    row.mode = state.mode
    state.next_record += 1


@inner_kernel
def _bring_back(path: Path, law: Law) -> None:
    """Bring a variable back to the limit beyond which friction does not feel it: the step's error."""
    state, step, last = path.states[0], path.steps[0], NODES - 1
    gap, rate, load, slip = step.gap[last], step.gap_rate[last], step.load[last], step.slip[last]
    felt, past = 0.0, state.memory[0]
    force = forces_of(path, law, gap, rate, load, slip)[3]
    for _ in range(HALVINGS):
        path.row[HEAD] = 0.5 * (felt + past)
        if forces_of(path, law, gap, rate, load, slip)[3] == force:
            past = path.row[HEAD]
        else:
            felt = path.row[HEAD]
    state.memory[0] = past
    path.row[HEAD] = past


@inner_kernel
def _take(path: Path, law: Law) -> None:
    """Move the state to the end of the step."""
    state, step = path.states[0], path.steps[0]
    last = NODES - 1
    _write(path, law)
    for k in range(state.variables):
        state.memory[k] = step.memory[last, k]
        for i in range(NODES):
            state.largest[state.alike[k]] = max(state.largest[state.alike[k]], abs(step.memory[i, k]))
    if state.framed == 1:
        state.extension = step.extension[last]
    state.force = step.friction[last]
    if moves_freely(path) and state.relaxation == 0.0 and step.steepness[last] == 0.0:
        # Friction that is no function of the slip velocity holds the extension: what Newton's method has left
        # of that would be a velocity in the next step, however short.
        recall(path, last)
        if state.coupled == 1 and not slides(path) and step.push[last, 0] == 0.0:
            _bring_back(path, law)
        gap, rate, load = step.gap[last], step.gap_rate[last], step.load[last]
        state.extension = -state.compliance * forces_of(path, law, gap, rate, load, step.slip[last])[3]
    for i in range(NODES):
        state.force_scale = max(state.force_scale, abs(step.friction[i]))
        state.fastest = max(state.fastest, abs(step.slip[i]))
        state.most_normal = max(state.most_normal, step.normal[i])
    state.slip = step.slip[last]
    state.last_gap, state.last_normal, state.last_speed = step.gap[last], step.normal[last], step.speed[last]
    state.stick_time += state.length if state.mode == STICK else 0.0
    state.before, state.goes_on = state.length, 1
    state.steps += 1
    state.at_once = 0


@inner_kernel
def _begin(path: Path, law: Law, memory: Memory | None) -> None:
    """Touch down at the start of the path, with the frame's first force."""
    state = path.states[0]
    for k in range(state.variables):
        path.row[HEAD + k] = state.memory[k]
    gap, rate, load, _, speed = press(path, law, state.time, False)
    path.row[SPEED] = max(-rate, 0.0)
    state.mode, state.sign = SLIP if state.friction_kind == RATE_DEPENDENT else STICK, 0
    jump_path(path, law, memory, AT_TOUCH, speed)
    state.extension = state.compliance * state.first_force
    state.force = -state.first_force
    state.goes_on, state.slip = 0, speed
    lay_polynomials(path)
    if state.framed == 0:
        return
    if state.friction_kind == SET_VALUED:
        _, least, most, _, _ = bounds_of(path, law, gap, rate, load, 0.0)
        state.force = -state.first_force - state.relaxation / state.compliance * speed
        if least <= state.force <= most:
            return
        sign = 1 if state.force < least else -1
        # A load point that moves at once pulls by the damper.
        state.slip = slip_of_frame(path, law, sign)
        if not state.slip >= 0.0:
            state.ending, state.force = INCONSISTENT, min(max(-state.first_force, least), most)
            return
        state.slip *= sign
        jump_path(path, law, memory, AT_SLIP, state.slip)
        return
    friction = forces_of(path, law, gap, rate, load, speed)[3]
    other = forces_of(path, law, gap, rate, load, 0.5 * speed + SLIP_ROUND_OFF)[3]
    if friction != other or state.relaxation > 0.0:
        pull = state.extension + state.relaxation * speed
        sign = 1 if pull > 0.0 else -1
        state.slip = 0.0 if pull == 0.0 else sign * slip_of_frame(path, law, sign)
        state.sign = 0
    else:
        # Friction that is no function of the slip velocity has the force of its variables.
        if abs(friction + state.first_force) > CONTINUOUS * max(abs(friction), abs(state.first_force)):
            state.ending, state.force = INCONSISTENT, friction
        state.extension = -state.compliance * friction
    state.force_scale = max(abs(friction), abs(state.first_force))


@inner_kernel
def _turn(path: Path, law: Law, memory: Memory | None, middle: float) -> None:
    """Set slip or stick of a path that reverses or stands still, by the velocity in the middle of a step."""
    state = path.states[0]
    if state.framed == 1 or state.friction_kind != SET_VALUED:
        return
    speed = load_point(path, middle, True)[3]
    mode = STICK if speed == 0.0 else SLIP
    state.sign = 1 if speed > 0.0 else -1
    if mode != state.mode:
        state.mode = mode
        jump_path(path, law, memory, AT_STICK if mode == STICK else AT_SLIP, 0.0 if mode == STICK else speed)


@inner_kernel
def _watch(state: Any) -> None:
    """End a motion whose steps and events come to no end."""
    state.watched += 1
    if state.watched < WATCHED:
        return
    if state.time - state.watched_from < LEAST_WAY * state.end:
        state.ending = CHATTERED
    state.watched, state.watched_from = 0, state.time


@inner_kernel
def run_path(path: Path, law: Law) -> None:
    """Take a law along a path from its start to its end, or to where it has no step."""
    state, step, memory = path.states[0], path.steps[0], law.memory
    _begin(path, law, memory)
    length, least = FIRST * (path.breaks[0] - state.time), SHORTEST * state.end
    again = AGAIN * state.end
    if state.variables == 0 and state.framed == 0:
        length = np.inf
    if path.records.size > 0:
        _note(path, law, 0.0)
    while state.time < state.end and state.ending == RUNNING:
        while path.breaks[state.next_break] <= state.time:
            state.next_break += 1
            # Behind a kink nothing of the last polynomials goes on.
            state.goes_on, length = 0, max(FRESH * length, again)
        until = path.breaks[state.next_break]
        load_point(path, state.time, False)
        if state.piece + PIECES < path.edges.size - 1 and (state.variables > 0 or state.framed == 1):
            until = min(until, path.edges[state.piece + PIECES])
        left = until - state.time
        # Two equal steps in place of a long and a short one.
        h = left if length >= left else 0.5 * left if length > 0.5 * left else length
        _turn(path, law, memory, state.time + 0.5 * h)
        open_step(path, law, h)
        guess_nodes(path, state.slip)
        if not collocate_path(path, law, memory):
            state.rejected += 1
            state.goes_on, length = 0, LEAST_FACTOR * h
            _restore(path)
            if not length > least:
                state.ending = UNSOLVED
            continue
        error = step_error(path, law, memory)
        if not error < np.inf:
            state.ending = NOT_FINITE
            break
        factor = MOST_FACTOR
        if error > 0.0:
            factor = min(max(SAFETY * error ** (-1.0 / ERROR_ORDER), LEAST_FACTOR), MOST_FACTOR)
        if error > 1.0:
            state.rejected += 1
            length = factor * h
            _restore(path)
            if not length > least:
                state.ending = UNSOLVED
            continue
        if state.framed == 1 and state.sign == 0 and state.mode == SLIP and step.slip[0] != 0.0:
            state.sign = 1 if step.slip[0] > 0.0 else -1
        lay_polynomials(path)
        share = find_event(path, law, memory)
        if share > 1.0 - AT_END and h == left:
            # At a kink of the path but for round-off.
            share = max(share, 1.0)
        if share <= AT_ONCE:
            state.at_once += 1
            reverses = state.event == state.guards and state.friction_kind == RATE_DEPENDENT
            state.goes_on, length = 0, h if reverses else max(FRESH * h, again)
            _restore(path)
            if state.at_once > MOST_AT_ONCE:
                state.ending = CHATTERED
            switch(path, law, memory)
            _watch(state)
            continue
        if share < 1.0:
            # Solved once more up to the event: what lies beyond it does not count.
            open_step(path, law, share * h)
            if not collocate_path(path, law, memory):
                state.rejected += 1
                state.goes_on, length = 0, 0.5 * share * h
                _restore(path)
                if not length > least:
                    state.ending = UNSOLVED
                continue
            lay_polynomials(path)
        # To the last digit of the clock.
        state.reached = until if share >= 1.0 and h == left else state.time + state.length
        _take(path, law)
        state.time = state.reached
        _watch(state)
        if share <= 1.0:
            state.goes_on = 0
            length = max(FRESH * h, again)
            switch(path, law, memory)
        else:
            length = max(factor * h, length) if h < length else factor * h


@part_kernel
def _restore(path: Path) -> None:
    """Forget the nodes of a step that is not taken: there is no polynomial to go on from."""
    path.states[0].goes_on = 0
