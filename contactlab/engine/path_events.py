"""Where a guard falls through zero on a path, a slider begins or ends to slide, or the slip reverses."""

import numpy as np

from contactlab.compiler.kernels import inner_kernel
from contactlab.engine.memory import SLIP_ROUND_OFF
from contactlab.engine.path_contact import HALVINGS, Path, bounds_of, forces_of, press, recall, seen_slip
from contactlab.engine.path_step import DENSE, DERIVATIVE, NODE, dense_at
from contactlab.engine.state import HEAD, NODES, UNSOLVED, Law, Memory
from contactlab.laws.base import ELASTOPLASTIC, RATE_DEPENDENT, SET_VALUED, SLIP, STICK
from contactlab.laws.memory import AT_SLIP, AT_STICK

CONTINUOUS = 1e-6
"""Relative jump of the friction at the end of stick that is round-off [1]."""

AT_REST = 1e-12
"""Friction beyond its bound over the bound, and slip over the fastest one, that are round-off [1]: a load
point that comes to rest leaves a slider on its bound, where it stays."""


@inner_kernel
def _event_at(path: Path, law: Law, memory: Memory | None, which: int, x: float, node: int) -> float:
    """Return what falls through zero at an event, at a share x of the step, or at a node from zero on."""
    state, step = path.states[0], path.steps[0]
    if node >= 0:
        gap, rate, load, slip = step.gap[node], step.gap_rate[node], step.load[node], step.slip[node]
        extension, speed = step.extension[node], step.speed[node]
        recall(path, node)
    else:
        gap, rate, load, slip, extension, _, speed = dense_at(path, law, x)
    if which < state.guards:
        if memory is None:
            return 1.0
        normal, _, _, _, _, _ = forces_of(path, law, gap, rate, load, slip)
        return float(memory.guard(which, gap, rate, seen_slip(path, slip), normal, law.parameters))
    if state.friction_kind == SET_VALUED:
        if state.framed == 0:
            return 1.0
        if state.mode == SLIP:
            return float(state.sign * slip)
        _, least, most, _, _ = bounds_of(path, law, gap, rate, load, 0.0)
        friction = -(extension + state.relaxation * speed) / state.compliance
        return float(min(most - friction, friction - least) + AT_REST * max(most, -least))
    if state.friction_kind == ELASTOPLASTIC:
        normal, least, most, friction, flow, _ = forces_of(path, law, gap, rate, load, slip)
        if state.mode == STICK:
            return min(most - friction, friction - least) + AT_REST * max(most, -least)
        stretched = 0.0
        for m in range(NODES):
            by = 0.0
            if node >= 0:
                by = DERIVATIVE[node, m]
            else:
                for d in range(NODES, 0, -1):
                    by = by * x + d * DENSE[m + 1, d]
            stretched += by * (step.memory[m, 0] - state.memory[0])
        return float(state.sign * (flow - stretched / state.length))
    if state.framed == 0 or state.sign == 0:
        return 1.0
    return float(state.sign * slip)


@inner_kernel
def find_event(path: Path, law: Law, memory: Memory | None) -> float:
    """Return the share of the step at which the first event lies, beyond one for none, and note which."""
    state = path.states[0]
    earliest = 2.0
    state.event = -1
    if state.guards == 0 and state.framed == 0 and state.friction_kind != ELASTOPLASTIC:
        return earliest
    for which in range(state.guards + 1):
        begin, low = 0.0, 1.0
        last = NODES - 1
        reverses = which == state.guards and state.friction_kind == RATE_DEPENDENT
        # A reversal lasts: in short steps what Newton's method has left may change the sign in between, and
        # at rest there is none.
        if reverses and _event_at(path, law, memory, which, NODE[last], last) > -AT_REST * state.fastest:
            continue
        for i in range(NODES):
            high = _event_at(path, law, memory, which, NODE[i], i)
            if high > 0.0:
                begin, low = NODE[i], high
                continue
            if begin >= earliest:
                break
            if i == 0:
                low = _event_at(path, law, memory, which, 0.0, -1)
            end = NODE[i]
            if not low > 0.0:
                end = 0.0
            # Illinois' method; the end stays where it has fallen.
            side = 0
            while end - begin > 1e-15 and end > 0.0:
                middle = begin + (end - begin) * low / (low - high)
                if not begin < middle < end:
                    middle = 0.5 * (begin + end)
                    if not begin < middle < end:
                        break
                value = _event_at(path, law, memory, which, middle, -1)
                if value > 0.0:
                    begin, low = middle, value
                    high = 0.5 * high if side == 1 else high
                    side = 1
                else:
                    end, high = middle, value
                    low = 0.5 * low if side == -1 else low
                    side = -1
                if value == 0.0:
                    break
            if end < earliest:
                earliest, state.event = end, which
            break
    return earliest


@inner_kernel
def jump_path(path: Path, law: Law, memory: Memory | None, event: int, slip: float) -> None:
    """Apply the law's reset map at the present time."""
    if memory is None:
        return
    state, step = path.states[0], path.steps[0]
    for k in range(state.variables):
        path.row[HEAD + k] = state.memory[k]
    gap, rate, load, _, _ = press(path, law, state.time, True)
    normal, _, _, _, _ = bounds_of(path, law, gap, rate, load, slip)
    for k in range(state.coupled, state.variables):
        step.memory[NODES, k] = memory.jump(k, event, gap, rate, slip, normal, law.parameters)
    for k in range(state.coupled, state.variables):
        state.memory[k] = step.memory[NODES, k]
        path.row[HEAD + k] = state.memory[k]


@inner_kernel
def slip_of_frame(path: Path, law: Law, sign: int) -> float:
    """Return the largest slip velocity of a sign that balances the frame now [m/s]; NaN where none does.

    Set-valued friction without damping has one, zero, where its slip goes on from its stick.
    """
    state = path.states[0]
    gap, rate, load, _, speed = press(path, law, state.time, False)
    if state.friction_kind == SET_VALUED:
        state.mode, state.sign = SLIP, sign
    damping = state.relaxation / state.compliance
    pull = sign * (state.extension / state.compliance + damping * speed)
    if state.relaxation == 0.0 and state.friction_kind == SET_VALUED:
        resistance = -sign * forces_of(path, law, gap, rate, load, sign * SLIP_ROUND_OFF)[3]
        return 0.0 if abs(pull - resistance) <= CONTINUOUS * abs(pull) else np.nan
    above = max(pull / damping, 0.0) if damping > 0.0 else max(abs(speed), SLIP_ROUND_OFF)
    fast = above
    for _ in range(HALVINGS):
        if not pull - damping * above + sign * forces_of(path, law, gap, rate, load, sign * above)[3] > 0.0:
            break
        above *= 4.0
    fast = above
    for _ in range(4 * HALVINGS):
        fast *= 0.5
        if pull - damping * fast + sign * forces_of(path, law, gap, rate, load, sign * fast)[3] > 0.0:
            break
        above = fast
    else:
        return 0.0
    for _ in range(HALVINGS):
        middle = 0.5 * (fast + above)
        if pull - damping * middle + sign * forces_of(path, law, gap, rate, load, sign * middle)[3] > 0.0:
            fast = middle
        else:
            above = middle
    return fast


@inner_kernel
def switch(path: Path, law: Law, memory: Memory | None) -> None:
    """Let a slider begin or end to slide, or the slip reverse, at the present time."""
    state = path.states[0]
    if state.event < state.guards:
        jump_path(path, law, memory, state.event, state.slip)
        return
    if state.friction_kind == RATE_DEPENDENT:
        state.sign = -state.sign
        return
    if state.mode == SLIP:
        state.mode = STICK
        jump_path(path, law, memory, AT_STICK, 0.0)
        return
    gap, rate, load, _, _ = press(path, law, state.time, True)
    for k in range(state.variables):
        path.row[HEAD + k] = state.memory[k]
    _, least, most, friction, _, _ = forces_of(path, law, gap, rate, load, 0.0)
    if state.friction_kind == SET_VALUED:
        friction = state.force
    sign = 1 if friction - least < most - friction else -1
    if state.friction_kind == SET_VALUED:
        state.slip = slip_of_frame(path, law, sign)
        if not state.slip >= 0.0:
            state.ending = UNSOLVED
            return
        state.slip *= sign
    state.mode, state.sign = SLIP, sign
    jump_path(path, law, memory, AT_SLIP, sign * SLIP_ROUND_OFF)
    if state.framed == 1 and state.friction_kind == ELASTOPLASTIC and state.relaxation == 0.0:
        # On a bound that is no function of the slip velocity what the event's location has left would be a
        # velocity in the next step, however short.
        bound = forces_of(path, law, gap, rate, load, state.slip)[3]
        if bound == forces_of(path, law, gap, rate, load, 0.5 * state.slip + sign * SLIP_ROUND_OFF)[3]:
            state.extension = -state.compliance * bound
