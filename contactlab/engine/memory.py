"""Internal variables of a law in the engine: their flow over a step, and reset maps.

Over a step the variables flow as a polynomial through their values z at its start and at the nodes,

    dz_k/dt (node i) = rate_k(contact at i, z at i),

solved one variable after the other by Newton's method with the variable's own derivative, so that a fast
relaxation is no matter of the step; what couples variables is met by the sweeps of the step. In flight and in
time stepping the motion is held meanwhile: there the flow is of the order of the rest.
"""

from math import copysign

import numpy as np

from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.engine.kinematics import contact_after, contact_at
from contactlab.engine.nodes import solve_linear
from contactlab.engine.propagator import step_length
from contactlab.engine.state import (
    BETWEEN,
    COLLOCATED,
    FLIGHT,
    HEAD,
    HELD,
    LAST,
    NODES,
    START,
    Law,
    Memory,
    Run,
    internal_at,
    value_at,
)
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

RELAXED, RELAXED_GROWTH = 0.25, 1.15
"""First step of a flow in flight over the shortest relaxation time, and the ratio of each step to the one
before: a fast exponential decays before the steps are too long for it, to an error of 1e-11."""


@part_kernel
def recall(run: Run, law: Law, place: int) -> None:
    """Let the law's kernels read the internal variables at a place of the step."""
    for k in range(run.state.law.variables):
        law.row[HEAD + k] = run.step.memory[place, k]


@part_kernel
def recall_start(run: Run, law: Law) -> None:
    """Let the law's kernels read those where the step starts."""
    for k in range(run.state.law.variables):
        run.step.memory[START, k] = run.state.memory[k]
    recall(run, law, START)


@part_kernel
def guess_memory(run: Run, memory: Memory | None) -> None:
    """Extrapolate the internal variables from the start at their rates; the coupled one at its own."""
    state, step, nodes = run.state, run.step, run.propagator.rule.nodes
    if state.law.coupled != 0:
        for i in range(NODES):
            step.memory[i, 0] = state.memory[0] + nodes[i] * state.length * state.internal_rate.node[i]
    if memory is None:
        return
    for k in range(state.law.coupled, state.law.variables):
        for i in range(NODES):
            step.memory[i, k] = state.memory[k] + nodes[i] * state.length * step.memory_rate[k]


@inner_kernel
def correct_memory(run: Run, law: Law, memory: Memory | None, h: float) -> float:
    """Take a Newton step of each internal variable but the coupled one over a step of length h.

    Returns the largest correction, relative to the size of its variable [1].
    """
    if memory is None:
        return 0.0
    state, step, system = run.state, run.step, run.step.system
    derivative = run.propagator.rule.derivative
    flies, sticks = step.kind == FLIGHT, state.mode == STICK
    most = 0.0
    for k in range(state.law.coupled, state.law.variables):
        if flies and step.memory_lasts[k] == 0.0:
            continue
        # One variable after the other, each with its own derivative alone: a stiff relaxation is solved at
        # once, and the coupling of two variables is left to the next sweep.
        first, size, moves = state.memory[k], abs(state.memory[k]), False
        for i in range(NODES):
            z, g_z = step.memory[i, k], 0.0
            recall(run, law, i)
            slip, normal = 0.0 if sticks else step.slip[i], state.normal.node[i]
            if slip == 0.0 and state.mode == SLIP and state.law.friction_kind == SET_VALUED:
                # Where a slip ends exactly the law must not take it for stick.
                slip = state.sign * SLIP_ROUND_OFF
            # Of a step that the release cuts, what lies beyond it goes on as at the release.
            gap = min(step.gap[i], step.end[i]) if step.kind == COLLOCATED else step.gap[i]
            rate = step.gap_rate[i]
            g = memory.rate(k, gap, rate, slip, normal, law.parameters)
            # Its sign is odd, so that a mirrored step has mirrored numbers.
            dz = copysign(NUDGE * (abs(z) + abs(h * g)), z if z != 0.0 else g)
            if dz != 0.0:
                law.row[HEAD + k] = z + dz
                g_z = (memory.rate(k, gap, rate, slip, normal, law.parameters) - g) / dz
            size = max(size, abs(z))
            # Row i of eq. 5.2, linearised in the values of this variable alone.
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
            # NaN fails every comparison, and is passed on.
            most = abs(change) / size if not abs(change) <= most * size else most
    return float(most)


@inner_kernel
def _memory_at(run: Run, law: Law, memory: Memory, s: float) -> None:
    state, step, rule = run.state, run.step, run.propagator.rule
    if step.kind != COLLOCATED:
        gap, rate, slip, _, _, _, _ = contact_at(run.plant, LAST)
        _relax(run, law, memory, s, gap, rate, slip)
    if step.kind != COLLOCATED or s == state.length:
        for k in range(state.law.coupled, state.law.variables):
            step.memory[BETWEEN, k] = step.memory[LAST, k]
    else:
        x = s / state.length
        for k in range(state.law.coupled, state.law.variables):
            first, total = state.memory[k], 0.0
            for d in range(NODES - 1, -1, -1):
                coefficient = 0.0
                for m in range(NODES):
                    rate = 0.0
                    for i in range(NODES):
                        rate += rule.derivative[m, i] * (step.memory[i, k] - first)
                    # The polynomial of the rate through its values at the nodes, integrated: at x = 0 it is
                    # the first value by itself.
                    coefficient += rate * rule.lagrange[m, d]
                total = (total + coefficient / (d + 1)) * x
            step.memory[BETWEEN, k] = first + total


@part_kernel
def memory_at(run: Run, law: Law, memory: Memory | None, s: float) -> None:
    """Leave the internal variables at time s of the step BETWEEN, where its motion stands, recalled."""
    if memory is not None:
        _memory_at(run, law, memory, s)
    if run.state.law.coupled != 0:
        run.step.memory[BETWEEN, 0] = run.state.memory[0]
        if run.step.kind == COLLOCATED:
            run.step.memory[BETWEEN, 0] = internal_at(run.state, s / run.state.length)
    recall(run, law, BETWEEN)


@inner_kernel
def _flow_again(run: Run, law: Law, memory: Memory, s: float) -> None:
    """Integrate over a time s again what an event truncated: it was solved across the event."""
    state, step, nodes = run.state, run.step, run.propagator.rule.nodes
    if step.kind != COLLOCATED or not 0.0 < s < state.length or state.law.variables == state.law.coupled:
        return
    for k in range(state.law.coupled, state.law.variables):
        for i in range(NODES):
            step.memory[i, k] = state.memory[k] + nodes[i] * (step.memory[BETWEEN, k] - state.memory[k])
    for i in range(NODES):
        at = nodes[i] * s
        # Nodes of the part that is taken: motion and force are known there; only the variables were solved
        # together with what lies beyond the event.
        step.gap[i], step.gap_rate[i], step.slip[i], _, _, _, _ = contact_after(run, at)
        state.normal.node[i] = value_at(state.normal, at / state.length)
    _flow_out(run, law, memory, s)
    for k in range(state.law.coupled, state.law.variables):
        step.memory[BETWEEN, k] = step.memory[LAST, k]


@part_kernel
def take_memory(run: Run, law: Law, memory: Memory | None, s: float) -> None:
    """Leave the state's internal variables at time s, where the step has been cut or ends."""
    state = run.state
    if state.law.variables == 0:
        return
    memory_at(run, law, memory, s)
    if memory is not None:
        _flow_again(run, law, memory, s)
    for k in range(state.law.variables):
        state.memory[k] = run.step.memory[BETWEEN, k]


@inner_kernel
def _flow_out(run: Run, law: Law, memory: Memory, s: float) -> None:
    """Correct the internal variables over a time s until nothing is left to correct."""
    for _ in range(MOST_CORRECTIONS):
        if s == 0.0 or correct_memory(run, law, memory, s) <= FLOWED:
            break


@inner_kernel
def _relax(run: Run, law: Law, memory: Memory, s: float, gap: float, rate: float, slip: float) -> None:
    """Integrate the variables over a time s in which gap [m], gap rate and slip [m/s] are constant."""
    state, step = run.state, run.step
    if state.law.variables == state.law.coupled:
        for k in range(state.law.variables):
            step.memory[LAST, k] = state.memory[k]
        return
    # The motion is frozen at what the contact is at the end, in flight without a force: an error of first
    # order, as that of time stepping, and in flight none where a rate does not depend on the gap.
    normal = state.normal.node[0] if step.kind == HELD else 0.0
    recall_start(run, law)
    for i in range(NODES):
        step.gap[i], step.gap_rate[i], step.slip[i] = gap, rate, slip
        state.normal.node[i] = normal
        for k in range(state.law.variables):
            step.memory[i, k] = state.memory[k]
    left, h = s, s
    if step.kind == FLIGHT:
        # The collocation holds a stiff decay only where its steps follow it: the first one is a quarter of
        # the shortest relaxation time.
        fastest = _fastest_relaxation(run, law, memory, s, gap, rate, slip)
        h = RELAXED / fastest if fastest * s > RELAXED else s
    # Steps grow geometrically from half the fastest relaxation: a decay is over before they are too long.
    _flow_out(run, law, memory, h)
    while h < left:
        left -= h
        h = min(RELAXED_GROWTH * h, left)
        for k in range(state.law.variables):
            state.memory[k] = step.memory[LAST, k]
            for i in range(NODES):
                step.memory[i, k] = state.memory[k]
        _flow_out(run, law, memory, h)
    for k in range(state.law.variables):
        state.memory[k] = step.memory[START, k]


@inner_kernel
def _fastest_relaxation(
    run: Run, law: Law, memory: Memory, s: float, gap: float, rate: float, slip: float
) -> float:
    """Return the largest derivative of a variable's rate by the variable [1/s], in a flight over s."""
    most = 0.0
    for k in range(run.state.law.coupled, run.state.law.variables):
        if run.step.memory_lasts[k] == 0.0:
            continue
        # -dr/dz of eq. 5.1 by a difference; a variable whose life is the contact does not flow in flight.
        z, g = law.row[HEAD + k], memory.rate(k, gap, rate, slip, 0.0, law.parameters)
        dz = NUDGE * (abs(z) + abs(s * g))
        if dz != 0.0:
            law.row[HEAD + k] = z + dz
            nudged = memory.rate(k, gap, rate, slip, 0.0, law.parameters)
            law.row[HEAD + k] = z
            most = max(most, abs((nudged - g) / dz))
    return float(most)


@part_kernel
def note_limit(run: Run, memory: Memory | None) -> None:
    """Note whether the gap at which the next contact begins may move in flight."""
    if memory is None:
        return
    state = run.state
    run.step.limit_moves = 0
    for k in range(state.law.coupled, state.law.variables):
        if run.step.memory_lasts[k] != 0.0:
            run.step.limit_moves = 1


@inner_kernel
def limit_at(
    run: Run, law: Law, memory: Memory | None, s: float, contact: tuple[float, float, float]
) -> tuple[float, float]:
    """Return the gap at which the next contact begins [m] and its rate [m/s], at time s of a flight step.

    The internal variables flow up to s under the gap [m], gap rate and slip [m/s] that there are at s.
    """
    if memory is None or run.step.limit_moves == 0:
        return run.state.limits.contact_gap, 0.0
    return _moving_limit_at(run, law, memory, s, contact)


@part_kernel
def end_at(run: Run, law: Law, memory: Memory | None, rate: float) -> float:
    """Return the gap at which the contact ends at a gap rate [m/s], of what is recalled [m]."""
    if memory is None or run.state.law.has_limits == 0:
        return 0.0
    return float(memory.limits(rate, law.parameters)[1])


@inner_kernel
def open_step(
    run: Run, law: Law, memory: Memory | None, gap: float, gap_rate: float, slip: float, normal: float
) -> None:
    """Take the rates of the internal variables at the start of a step."""
    if memory is None:
        return
    recall_start(run, law)
    for k in range(run.state.law.coupled, run.state.law.variables):
        run.step.memory_rate[k] = memory.rate(k, gap, gap_rate, slip, normal, law.parameters)


@inner_kernel
def missed_flow_of(run: Run, k: int) -> float:
    """Return what the polynomial of variable k misses of its rate at the step's start, over the step.

    The polynomial's rates at the nodes are those of the law; extrapolated to the start, which no node is at,
    they differ from the rate there as the multipliers do (eq. 4.12). It is relative to the variable [1], or
    to its first value where it has decayed below that.
    """
    state, step, rule = run.state, run.step, run.propagator.rule
    first, flow, slope = state.memory[k], state.length * step.memory_rate[k], 0.0
    size = max(abs(first), abs(step.memory_first[k]), abs(flow))
    for m in range(NODES):
        size = max(size, abs(step.memory[m, k]))
        for i in range(NODES):
            slope += rule.lagrange[m, 0] * rule.derivative[m, i] * (step.memory[i, k] - first)
    # As eq. 3.10 for a force: an extrapolation of the collocated rates to the start, against the law's rate
    # there.
    missed = abs(slope - flow)
    return float(missed / size if missed > 0.0 else 0.0)


@inner_kernel
def missed_flow(run: Run, memory: Memory | None) -> float:
    """Return the most that a variable but the coupled one misses of its rate, see `missed_flow_of` [1]."""
    most = 0.0
    if memory is None:
        return most
    for k in range(run.state.law.coupled, run.state.law.variables):
        most = max(most, missed_flow_of(run, k))
    return most


@part_kernel
def add_missed_flow(
    run: Run, law: Law, memory: Memory | None, at: tuple[float, float, float], normal: float, x: float
) -> None:
    """Move the recalled variables but the coupled one by what they miss of their rates at x = s/h.

    It lasts for a step in contact at its longest, or until the variable has forgotten it; `at` has gap [m],
    gap rate and slip [m/s] there.
    """
    if memory is None:
        return
    state, step, rule = run.state, run.step, run.propagator.rule
    longest, weights = step_length(run.propagator, rule.contact_level), step.system[0]
    gap, rate, slip = at
    slip = 0.0 if state.mode == STICK else slip
    for i in range(NODES):
        weights[i] = 0.0
        for m in range(NODES):
            at_x = 0.0
            for d in range(NODES - 1, -1, -1):
                at_x = at_x * x + rule.lagrange[m, d]
            # l_m(x) times row m of delta: weights of the values in the rate of the polynomial at x.
            weights[i] += at_x * rule.derivative[m, i]
    for k in range(state.law.coupled, state.law.variables):
        missed = memory.rate(k, gap, rate, slip, normal, law.parameters)
        z, flow = law.row[HEAD + k], missed
        for i in range(NODES):
            missed -= weights[i] * (step.memory[i, k] - state.memory[k]) / state.length
        # Eq. 3.11: a rate that is missed displaces the variable for a step, or for as long as the variable
        # remembers.
        dz = copysign(NUDGE * (abs(z) + abs(state.length * flow)), z if z != 0.0 else flow)
        if dz != 0.0:
            law.row[HEAD + k] = z + dz
            forgetting = (flow - memory.rate(k, gap, rate, slip, normal, law.parameters)) / dz
            law.row[HEAD + k] = z + missed * longest / (1.0 + longest * max(forgetting, 0.0))


@inner_kernel
def guard_at(run: Run, law: Law, memory: Memory | None, s: float) -> float:
    """Return the guard that is looked at, at time s of a collocated step."""
    if memory is None:
        return 1.0
    state = run.state
    gap, rate, slip, _, _, _, _ = contact_after(run, s)
    memory_at(run, law, memory, s)
    normal = value_at(state.normal, s / state.length)
    slip = 0.0 if state.mode == STICK else slip
    return float(memory.guard(state.guard, gap, rate, slip, normal, law.parameters))


@inner_kernel
def _stored_apart(run: Run, law: Law, memory: Memory) -> float:
    """Return what the law stores where a contact with the recalled variables would begin [J]."""
    if run.state.law.compliant == 0:
        return 0.0
    begins = memory.limits(0.0, law.parameters)[0]
    return float(law.force(begins, 0.0, 0.0, 0.0, law.parameters)[3])


@part_kernel
def stored_apart(run: Run, law: Law, memory: Memory | None) -> float:
    """Return what the contacts so far have left stored in flight [J]; of the recalled variables."""
    if memory is None:
        return float(run.state.limits.stored_energy)
    if run.state.law.variables == run.state.law.coupled or run.state.touchdowns == 0:
        return float(run.state.limits.stored_energy)
    return _stored_apart(run, law, memory)


@inner_kernel
def _moving_limit_at(
    run: Run, law: Law, memory: Memory, s: float, contact: tuple[float, float, float]
) -> tuple[float, float]:
    state, step = run.state, run.step
    gap, rate, slip = contact
    _relax(run, law, memory, s, gap, rate, slip)
    recall(run, law, LAST)
    begins = float(memory.limits(rate, law.parameters)[0])
    # The time in which one variable at most changes by a part NUDGE of itself.
    dt, moves = np.inf, False
    for k in range(state.law.coupled, state.law.variables):
        step.memory_rate[k] = 0.0
        if step.memory_lasts[k] != 0.0:
            step.memory_rate[k] = memory.rate(k, gap, rate, slip, 0.0, law.parameters)
        if step.memory_rate[k] != 0.0:
            moves = True
            if law.row[HEAD + k] != 0.0:
                dt = min(dt, NUDGE * abs(law.row[HEAD + k] / step.memory_rate[k]))
    if not moves:
        return min(begins, state.limits.release_gap), 0.0
    if dt == np.inf:
        dt = NUDGE * step_length(run.propagator, 0)
    for k in range(state.law.coupled, state.law.variables):
        law.row[HEAD + k] += dt * step.memory_rate[k]
    # The rate of the limit is a difference along the flow of the variables.
    after = memory.limits(rate, law.parameters)[0]
    if state.limits.release_gap < begins:
        return state.limits.release_gap, 0.0
    return begins, float((after - begins) / dt)


@inner_kernel
def jump(run: Run, law: Law, memory: Memory | None, event: int) -> None:
    """Apply the law's reset map at an event where the step starts; stored energy that is gone is lost.

    What stays stored while apart is that where the next contact would begin.
    """
    if memory is None:
        return
    state = run.state
    gap, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    slip = 0.0 if state.mode == STICK else slip
    recall_start(run, law)
    normal, stored = state.normal.node[0], 0.0
    if state.law.compliant != 0:
        # A located release may be clear of the contact by round-off, where the law has no force.
        gap = min(gap, end_at(run, law, memory, rate))
        normal, _, _, before, _ = law.force(gap, rate, slip, state.impact_speed, law.parameters)
        stored = state.limits.stored_energy if event == AT_TOUCH else before
    for k in range(state.law.coupled, state.law.variables):
        # Eq. 5.3. Every variable jumps from the values before the event: the law reads the row, which is not
        # written until all are known.
        state.memory[k] = memory.jump(k, event, gap, rate, slip, normal, law.parameters)
    recall_start(run, law)
    # Eq. 5.4: what the jump takes from the stored energy is lost; at a release all but what stays stored
    # while the contact is open.
    if event == AT_RELEASE:
        state.limits.stored_energy = _stored_apart(run, law, memory)
        stored -= state.limits.stored_energy
    elif state.law.compliant != 0:
        stored -= law.force(gap, rate, slip, state.impact_speed, law.parameters)[3]
    state.total.contact_loss += stored
    state.contact.energy_loss += stored


@part_kernel
def note_release(run: Run, law: Law, memory: Memory | None) -> None:
    """Note the gap of a release below the gap at which the next contact would begin."""
    if memory is None or run.state.law.has_limits == 0:
        return
    gap, rate, _, _, _, _, _ = contact_at(run.plant, START)
    recall_start(run, law)
    # A contact may end at a gap below that at which the next one would begin, which would then begin at once:
    # it begins where this one ended.
    begins, ends = memory.limits(rate, law.parameters)
    run.state.limits.release_gap = gap if ends < begins and gap < begins else np.inf


@inner_kernel
def _is_clear(run: Run, law: Law, memory: Memory | None) -> bool:
    """Set where the next contact begins; returns whether the gap exceeds that of a first one (BETWEEN)."""
    if memory is None or run.state.law.has_limits == 0:
        return True
    state = run.state
    gap, rate, _, _, _, _, _ = contact_at(run.plant, START)
    recall_start(run, law)
    begins = min(memory.limits(rate, law.parameters)[0], state.limits.release_gap)
    for k in range(state.law.variables):
        law.row[HEAD + k] = run.step.memory[BETWEEN, k]
    # Where a first contact would begin: with the variables of the contact reset. Once the gap exceeds that,
    # nothing of the last contact can be met again.
    anew = memory.limits(rate, law.parameters)[0]
    if anew <= begins or gap > anew:
        state.limits.contact_gap, state.limits.remembered, state.limits.release_gap = anew, 0, np.inf
        return True
    state.limits.contact_gap, state.limits.remembered = begins, 1
    return False


@part_kernel
def lose_earlier(run: Run, energy: float) -> None:
    """Count energy [J] as lost by the contact before."""
    if run.state.contact_count > 0:
        run.step.contacts[run.state.contact_count - 1].energy_loss += energy
    else:
        run.state.earlier_loss += energy


@inner_kernel
def leave(run: Run, law: Law, memory: Memory | None) -> None:
    """Set where the next contact begins, after a release or a step of flight.

    Variables of the contact are reset once the gap is clear of where a first contact would begin; until then
    the last one puts off the next. What is stored while apart is lost as it goes, by the contact before.
    """
    state, step = run.state, run.step
    for k in range(state.law.variables):
        lasts = step.memory_lasts[k] != 0.0
        step.memory[BETWEEN, k] = state.memory[k] if lasts else step.memory_first[k]
    if _is_clear(run, law, memory):
        for k in range(state.law.variables):
            state.memory[k] = step.memory[BETWEEN, k]
    if memory is None or state.law.variables == state.law.coupled:
        return
    recall_start(run, law)
    stored = stored_apart(run, law, memory)
    state.total.contact_loss += state.limits.stored_energy - stored
    lose_earlier(run, state.limits.stored_energy - stored)
    state.limits.stored_energy = stored


@inner_kernel
def press(run: Run, law: Law, memory: Memory | None) -> None:
    """Count what a contact that is pressed together at the start stores as brought along."""
    if memory is None:
        return
    state = run.state
    recall_start(run, law)
    gap, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    pressed = law.force(gap, rate, slip, state.impact_speed, law.parameters)[3]
    state.total.contact_loss += pressed
    state.contact.energy_loss += pressed
