"""The internal variables of a law in the engine: recalled for its kernels, flowing over a step, jumping.

Over a step the variables flow as a polynomial through their values z at its start and at the nodes,

    dz_k/dt (node i) = rate_k(contact at i, z at i),

solved one variable after the other by Newton's method with the variable's own derivative, so that a fast
relaxation is no matter of the step; what couples variables is met by the sweeps of the step. In flight and in
a rigid contact the motion is held meanwhile: there the flow is of the order of the rest.
"""

import numpy as np

from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.context import HEAD, IMPACT, STEP, Law, Memory, Run
from contactlab.engine.kinematics import contact_after, contact_at
from contactlab.engine.linear import solve_linear
from contactlab.engine.propagator import step_length
from contactlab.engine.state import BETWEEN, COLLOCATED, FLIGHT, HELD, LAST, NODES, START, value_at
from contactlab.laws.base import SET_VALUED, SLIP, STICK
from contactlab.laws.memory import AT_RELEASE, AT_TOUCH

NUDGE = 1e-7
"""Relative difference of a variable for the derivative of its rate; it sets Newton's pace, not its end."""

SLIP_ROUND_OFF = 1e-13
"""Slip velocity [m/s] that a located reversal may leave."""

FLOWED = 1e-12
"""Correction over the size of a variable that is round-off."""

MOST_CORRECTIONS = 25
"""Of a flow without collocation."""

RELAXED, RELAXED_GROWTH = 0.5, 1.5
"""First step of a flow in flight over the shortest relaxation time, and the ratio of each step to the one
before: a fast exponential decays before the steps are too long for it, to an error of 3e-7."""


@part_kernel
def recall(run: Run, memory: Memory | None, place: int) -> None:
    """Let the law's kernels see the internal variables of a place of the step."""
    if memory is None:
        return
    for k in range(run.state.variables):
        memory.row[HEAD + k] = run.step.memory[place, k]


@part_kernel
def recall_start(run: Run, memory: Memory | None) -> None:
    """Let them see the internal variables where the step starts."""
    if memory is None:
        return
    for k in range(run.state.variables):
        run.step.memory[START, k] = run.state.memory[k]
        memory.row[HEAD + k] = run.state.memory[k]


@part_kernel
def tell(run: Run, memory: Memory | None) -> None:
    """Tell a rigid law its memory, the length of its step [s], and whether that is of an impact."""
    if memory is None:
        return
    state = run.state
    recall_start(run, memory)
    if state.told != 0:
        memory.row[STEP] = state.length
        memory.row[IMPACT] = 1.0 if state.contact.duration == 0.0 else 0.0


@part_kernel
def guess_memory(run: Run, memory: Memory | None) -> None:
    """Let the internal variables go on from the start at their rates."""
    if memory is None:
        return
    state, step, nodes = run.state, run.step, run.propagator.rule.nodes
    for k in range(state.variables):
        for i in range(NODES):
            step.memory[i, k] = state.memory[k] + nodes[i] * state.length * step.memory_rate[k]


@inner_kernel
def correct_memory(run: Run, memory: Memory | None, h: float) -> float:
    """Take a Newton step of each internal variable over a step of length h; gives the largest correction.

    It is relative to the size of its variable [1].
    """
    if memory is None:
        return 0.0
    state, step, system = run.state, run.step, run.step.system
    derivative = run.propagator.rule.derivative
    flies, sticks = step.kind == FLIGHT, state.mode == STICK
    most = 0.0
    for k in range(state.variables):
        if flies and step.memory_lasts[k] == 0.0:
            continue
        first, size, moves = state.memory[k], abs(state.memory[k]), False
        for i in range(NODES):
            z, g_z = step.memory[i, k], 0.0
            recall(run, memory, i)
            slip, normal = 0.0 if sticks else step.slip[i], state.normal.node[i]
            if slip == 0.0 and state.mode == SLIP and state.friction_kind == SET_VALUED:
                # Where a slip ends exactly the law must not take it for stick.
                slip = state.sign * SLIP_ROUND_OFF
            # Of a step that the release cuts, what lies beyond it goes on as at the release.
            gap = min(step.gap[i], step.end[i]) if step.kind == COLLOCATED else step.gap[i]
            rate = step.gap_rate[i]
            g = memory.rate(k, gap, rate, slip, normal, memory.parameters)
            dz = NUDGE * ((abs(z) + abs(h * g)) if z >= 0.0 else -(abs(z) + abs(h * g)))
            if dz != 0.0:
                memory.row[HEAD + k] = z + dz
                g_z = (memory.rate(k, gap, rate, slip, normal, memory.parameters) - g) / dz
            size = max(size, abs(z))
            left = h * g
            for m in range(NODES):
                left -= derivative[i, m] * (step.memory[m, k] - first)
                system[i, m] = derivative[i, m] - (h * g_z if m == i else 0.0)
            system[i, NODES] = left
            moves = moves or left != 0.0
        if not moves:
            continue
        solve_linear(system, NODES)
        for i in range(NODES):
            change = system[i, NODES]
            step.memory[i, k] += change
            # What is no number fails every comparison, and is told so.
            most = abs(change) / size if not abs(change) <= most * size else most
    return float(most)


@inner_kernel
def _memory_at(run: Run, memory: Memory, s: float) -> None:
    state, step, rule = run.state, run.step, run.propagator.rule
    if step.kind != COLLOCATED:
        gap, rate, slip, _, _, _, _ = contact_at(run.plant, LAST)
        _relax(run, memory, s, gap, rate, slip)
    if step.kind != COLLOCATED or s == state.length:
        for k in range(state.variables):
            step.memory[BETWEEN, k] = step.memory[LAST, k]
    else:
        x = s / state.length
        for k in range(state.variables):
            first, total = state.memory[k], 0.0
            for d in range(NODES - 1, -1, -1):
                coefficient = 0.0
                for m in range(NODES):
                    rate = 0.0
                    for i in range(NODES):
                        rate += rule.derivative[m, i] * (step.memory[i, k] - first)
                    coefficient += rate * rule.lagrange[m, d]
                total = (total + coefficient / (d + 1)) * x
            step.memory[BETWEEN, k] = first + total
    recall(run, memory, BETWEEN)


@part_kernel
def memory_at(run: Run, memory: Memory | None, s: float) -> None:
    """Leave the internal variables at time s of the step BETWEEN, recalled."""
    if memory is not None:
        _memory_at(run, memory, s)


@inner_kernel
def _take_memory(run: Run, memory: Memory, s: float) -> None:
    state, step, nodes = run.state, run.step, run.propagator.rule.nodes
    memory_at(run, memory, s)
    if step.kind == COLLOCATED and 0.0 < s < state.length:
        for k in range(state.variables):
            for i in range(NODES):
                step.memory[i, k] = state.memory[k] + nodes[i] * (step.memory[BETWEEN, k] - state.memory[k])
        for i in range(NODES):
            at = nodes[i] * s
            step.gap[i], step.gap_rate[i], step.slip[i], _, _, _, _ = contact_after(run, at)
            state.normal.node[i] = value_at(state.normal, at / state.length)
        _flow_out(run, memory, s)
        for k in range(state.variables):
            step.memory[BETWEEN, k] = step.memory[LAST, k]
    for k in range(state.variables):
        state.memory[k] = step.memory[BETWEEN, k]


@part_kernel
def take_memory(run: Run, memory: Memory | None, s: float) -> None:
    """Leave the state's internal variables at time s, where the step has been cut or ends.

    What an event cuts has been solved through what lies behind it, where a rate may be another: there the
    flow is solved once more, over what is taken.
    """
    if memory is not None:
        _take_memory(run, memory, s)


@inner_kernel
def _flow_out(run: Run, memory: Memory, s: float) -> None:
    """Correct the internal variables over a time s until nothing is left to correct."""
    for _ in range(MOST_CORRECTIONS):
        if s == 0.0 or correct_memory(run, memory, s) <= FLOWED:
            break


@inner_kernel
def _relax(run: Run, memory: Memory, s: float, gap: float, rate: float, slip: float) -> None:
    """Integrate the variables over a time s in which gap [m], gap rate and slip [m/s] are constant."""
    state, step = run.state, run.step
    normal = state.normal.node[0] if step.kind == HELD else 0.0
    for i in range(NODES):
        step.gap[i], step.gap_rate[i], step.slip[i] = gap, rate, slip
        state.normal.node[i] = normal
        for k in range(state.variables):
            step.memory[i, k] = state.memory[k]
    recall_start(run, memory)
    left, h = s, s
    if step.kind == FLIGHT:
        fastest = _fastest_relaxation(run, memory, s, gap, rate, slip)
        h = RELAXED / fastest if fastest * s > RELAXED else s
    _flow_out(run, memory, h)
    while h < left:
        left -= h
        h = min(RELAXED_GROWTH * h, left)
        for k in range(state.variables):
            state.memory[k] = step.memory[LAST, k]
            for i in range(NODES):
                step.memory[i, k] = state.memory[k]
        _flow_out(run, memory, h)
    for k in range(state.variables):
        state.memory[k] = step.memory[START, k]


@inner_kernel
def _fastest_relaxation(run: Run, memory: Memory, s: float, gap: float, rate: float, slip: float) -> float:
    """Return the largest derivative of a variable's rate by the variable [1/s], in a flight over s."""
    most = 0.0
    for k in range(run.state.variables):
        if run.step.memory_lasts[k] == 0.0:
            continue
        z, g = memory.row[HEAD + k], memory.rate(k, gap, rate, slip, 0.0, memory.parameters)
        dz = NUDGE * (abs(z) + abs(s * g))
        if dz != 0.0:
            memory.row[HEAD + k] = z + dz
            nudged = memory.rate(k, gap, rate, slip, 0.0, memory.parameters)
            memory.row[HEAD + k] = z
            most = max(most, abs((nudged - g) / dz))
    return float(most)


@part_kernel
def note_limit(run: Run, memory: Memory | None) -> None:
    """Note whether the gap at which the next contact begins may move in flight."""
    if memory is None:
        return
    run.step.limit_moves = 0
    for k in range(run.state.variables):
        if run.step.memory_lasts[k] != 0.0:
            run.step.limit_moves = 1


@inner_kernel
def limit_at(
    run: Run, memory: Memory | None, s: float, gap: float, rate: float, slip: float
) -> tuple[float, float]:
    """Return the gap at which the next contact begins [m] and its rate [m/s], at time s of a flight step.

    The internal variables flow up to s under the gap [m], gap rate and slip [m/s] that there are at s.
    """
    if memory is None or run.step.limit_moves == 0:
        return run.state.begins, 0.0
    return _limit_at(run, memory, s, gap, rate, slip)


@inner_kernel
def _limit_at(
    run: Run, memory: Memory, s: float, gap: float, rate: float, slip: float
) -> tuple[float, float]:
    state, step = run.state, run.step
    _relax(run, memory, s, gap, rate, slip)
    recall(run, memory, LAST)
    begins = float(memory.limits(memory.parameters)[0])
    # The time in which one variable at most changes by a part NUDGE of itself.
    dt, moves = np.inf, False
    for k in range(state.variables):
        step.memory_rate[k] = 0.0
        if step.memory_lasts[k] != 0.0:
            step.memory_rate[k] = memory.rate(k, gap, rate, slip, 0.0, memory.parameters)
        if step.memory_rate[k] != 0.0:
            moves = True
            if memory.row[HEAD + k] != 0.0:
                dt = min(dt, NUDGE * abs(memory.row[HEAD + k] / step.memory_rate[k]))
    if not moves:
        return begins, 0.0
    if dt == np.inf:
        dt = NUDGE * step_length(run.propagator, 0)
    for k in range(state.variables):
        memory.row[HEAD + k] += dt * step.memory_rate[k]
    return begins, float((memory.limits(memory.parameters)[0] - begins) / dt)


@part_kernel
def end_at(memory: Memory | None) -> float:
    """Give the gap at which the contact ends with the internal variables that are recalled [m]."""
    if memory is None:
        return 0.0
    return float(memory.limits(memory.parameters)[1])


@inner_kernel
def open_step(
    run: Run, memory: Memory | None, gap: float, gap_rate: float, slip: float, normal: float
) -> None:
    """Take the rates of the internal variables at the start of a step."""
    if memory is None:
        return
    recall_start(run, memory)
    for k in range(run.state.variables):
        run.step.memory_rate[k] = memory.rate(k, gap, gap_rate, slip, normal, memory.parameters)


@inner_kernel
def guard_at(run: Run, memory: Memory | None, s: float) -> float:
    """Give the guard that is looked at, at time s of a collocated step."""
    if memory is None:
        return 1.0
    state = run.state
    gap, rate, slip, _, _, _, _ = contact_after(run, s)
    memory_at(run, memory, s)
    normal = value_at(state.normal, s / state.length)
    slip = 0.0 if state.mode == STICK else slip
    return float(memory.guard(state.guard, gap, rate, slip, normal, memory.parameters))


@inner_kernel
def _stored_apart(run: Run, law: Law, memory: Memory) -> float:
    """Give what the law stores where a contact with the recalled variables would begin [J]."""
    if run.state.compliant == 0:
        return 0.0
    begins = memory.limits(memory.parameters)[0]
    return float(law.force(begins, 0.0, 0.0, 0.0, law.parameters)[3])


@part_kernel
def stored_apart(run: Run, law: Law, memory: Memory | None) -> float:
    """Return what the contacts so far have left stored in flight [J]; of the recalled variables."""
    if memory is None or run.state.variables == 0 or run.state.touchdowns == 0:
        return float(run.state.apart)
    return _stored_apart(run, law, memory)


@inner_kernel
def _jump(run: Run, law: Law, memory: Memory, event: int) -> None:
    state = run.state
    gap, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    slip = 0.0 if state.mode == STICK else slip
    recall_start(run, memory)
    normal, stored = state.normal.node[0], 0.0
    if state.compliant != 0:
        gap = min(gap, end_at(memory))
        normal, _, _, before, _ = law.force(gap, rate, slip, state.impact_speed, law.parameters)
        stored = state.apart if event == AT_TOUCH else before
    for k in range(state.variables):
        state.memory[k] = memory.jump(k, event, gap, rate, slip, normal, memory.parameters)
    recall_start(run, memory)
    if event == AT_RELEASE:
        state.apart = _stored_apart(run, law, memory)
        stored -= state.apart
    elif state.compliant != 0:
        stored -= law.force(gap, rate, slip, state.impact_speed, law.parameters)[3]
    state.total.contact_loss += stored
    state.contact.energy_loss += stored


@part_kernel
def jump(run: Run, law: Law, memory: Memory | None, event: int) -> None:
    """Let the internal variables jump at an event where the step starts; what is stored less is lost.

    What stays stored while apart is that where the next contact would begin.
    """
    if memory is not None:
        _jump(run, law, memory, event)


@inner_kernel
def _leave(run: Run, law: Law, memory: Memory) -> None:
    state, step = run.state, run.step
    if state.variables == 0:
        return
    for k in range(state.variables):
        lasts = step.memory_lasts[k] != 0.0
        step.memory[BETWEEN, k] = state.memory[k] if lasts else step.memory_first[k]
    recall_start(run, memory)
    begins = memory.limits(memory.parameters)[0]
    recall(run, memory, BETWEEN)
    anew = memory.limits(memory.parameters)[0]
    state.begins, state.kept = begins, 1
    if anew <= begins or contact_at(run.plant, START)[0] > anew:
        for k in range(state.variables):
            state.memory[k] = step.memory[BETWEEN, k]
        state.begins, state.kept = anew, 0
    recall_start(run, memory)
    stored = stored_apart(run, law, memory)
    state.total.contact_loss += state.apart - stored
    if state.stored > 0:
        # It was stored in the contact before.
        run.step.contacts[state.stored - 1].energy_loss += state.apart - stored
    state.apart = stored


@part_kernel
def leave(run: Run, law: Law, memory: Memory | None) -> None:
    """Set where the next contact begins, after a release or a step of flight.

    What lives for a contact is forgotten once the gap is clear of where a first contact would begin; until
    then it puts off the next one. What is stored while apart is lost as it goes, by the contact before.
    """
    if memory is not None:
        _leave(run, law, memory)
