"""Friction with an internal variable in a collocated step: a spring with a slider, or one that rates drive.

At every node friction and internal variable satisfy

    F_i = f(slip_i, z_i),   (dz/dt)_i = g(slip_i, z_i)

with the law's f and g, dz/dt the rate of the polynomial through the variable at the step's start and at the
nodes, and slip_i what the frictions at all nodes leave. Newton's method solves both at once, so that
stiff springs and steep creep are no matter of the step. What rate-dependent friction does cost are its
changes between creep and slip: each takes some tens of steps, down to the time in which the slip
crosses the creep velocity and up again. A slider keeps F on the bound; its spring follows.
"""

from math import copysign

import numpy as np

from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.engine.kinematics import contact_after, contact_at
from contactlab.engine.memory import (
    SLIP_ROUND_OFF,
    add_missed_flow,
    end_at,
    jump,
    memory_at,
    missed_flow_of,
    recall,
    recall_start,
)
from contactlab.engine.nodes import mobilities, push_nodes, solve_linear
from contactlab.engine.propagator import step_length
from contactlab.engine.state import HEAD, NODES, START, Law, Run, value_at
from contactlab.laws.base import ELASTOPLASTIC, SLIP
from contactlab.laws.memory import EVEN

NUDGE = 1e-7
"""Relative difference for the derivatives of the law; it sets the pace of Newton, not its end."""

FELT = 1e-3
"""Relative difference of a variable that tells whether friction depends on it, far above round-off."""

LEAST_SLIP, LEAST_INTERNAL = 1e-4, 1e-9
"""Scales of these differences near zero: slip [m/s] and stretch [m]."""

DIGITS = 64.0 * np.finfo(np.float64).eps
"""Round-off of a sum over its largest term [1]."""

HELD_SLIP = 1e-9
"""Slip scale of the finite difference where steep friction keeps the slip near zero [m/s]."""


@inner_kernel
def friction_at(
    law: Law, at: tuple[float, float, float], end: float, normal: float
) -> tuple[float, float, float, float]:
    """Return the law's friction at gap, gap rate and slip and a normal force, of what is recalled.

    It is zero where there is no contact, from the gap `end` on [m].
    """
    gap, rate, slip = at
    if gap >= end:
        return 0.0, 0.0, 0.0, 0.0
    friction, internal_rate, stored, stiffness = law.friction(gap, rate, slip, normal, law.parameters)
    return friction, internal_rate, stored, stiffness


@inner_kernel
def friction_and_steepness(
    law: Law, at: tuple[float, float, float], end: float, normal: float
) -> tuple[float, float]:
    """Return friction [N], and how steeply it falls with the slip [N s/m], zero where it rises."""
    gap, rate, slip = at
    friction = friction_at(law, at, end, normal)[0]
    # -f_v by a difference, of a slip so small that the steep part of the law near zero is seen.
    dv = _nudge_of(slip, HELD_SLIP)
    steeper = friction_at(law, (gap, rate, slip + dv), end, normal)[0]
    return friction, max((friction - steeper) / dv, 0.0)


@inner_kernel
def slip_digits(run: Run, i: int) -> float:
    """Return what of the slip at node i is round-off [m/s]: it is a difference of what moves there freely.

    Forces that hold a slip far below that motion cancel it, so that they are as large.
    """
    step = run.step
    # Eq. 1.10 of the motion without contact: the largest terms that the forces cancel.
    moved = abs(step.t_u[i] * step.u_rate[i]) + abs(step.t_th[i] * step.th_rate[i]) + abs(step.rotor[i])
    return float(DIGITS * moved)


@inner_kernel
def missed_rate(run: Run, law: Law, normal: float, unfelt: bool) -> float:
    """Return what the polynomial of a coupled variable misses of its rate at the step's start, over the step.

    It is relative to the variable [1], as `contactlab.engine.memory.missed_flow` of the others. Where
    friction under the normal force [N] at the start depends on the variable, it is zero unless `unfelt`.
    """
    state, step = run.state, run.step
    if state.law.coupled == 0:
        return 0.0
    gap, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    recall_start(run, law)
    end = end_at(run, law, law.memory, rate)
    if gap >= end:
        # At the edge of the contact the law has no rate yet.
        return 0.0
    friction, first, _, _ = friction_at(law, (gap, rate, slip), end, normal)
    # Away from zero: a slider beyond its cone stays there, and a mirrored step has the mirrored numbers.
    z = state.memory[0]
    way = -1.0 if state.law.parity != EVEN and (z < 0.0 or (z == 0.0 and slip < 0.0)) else 1.0
    law.row[HEAD] += way * FELT * (abs(z) + LEAST_INTERNAL)
    if not unfelt and (normal == 0.0 or friction_at(law, (gap, rate, slip), end, normal)[0] != friction):
        return 0.0
    law.row[HEAD] = z
    # What round-off of the slip does to the rate is no error of the polynomial: shorter steps would not
    # lessen it.
    rounded = slip + (1.0 if slip >= 0.0 else -1.0) * slip_digits(run, 0)
    digits = abs(friction_at(law, (gap, rate, rounded), end, normal)[1] - first)
    size = max(abs(z), abs(state.length * first))
    for i in range(NODES):
        size = max(size, abs(step.memory[i, 0]))
    # The slip's round-off alone may be as much.
    missed = state.length * (abs(state.internal_rate.coefficient[0] - first) - SLIP_ROUND_OFF - digits)
    return float(missed / size if missed > 0.0 else 0.0)


@inner_kernel
def missed_past_limits(run: Run, law: Law, normal: float, error: float) -> float:
    """Return the largest error [N] by what a slider past its limit misses of its stretch, or one known.

    The friction under the normal force [N] at the step's start does not feel such a stretch, but will where
    the slip reverses: it counts as if it did, in proportion, as in `missed_between`.
    """
    state, most = run.state, error
    if state.law.variables == state.law.coupled or normal == 0.0:
        return most
    gap, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    recall_start(run, law)
    end = end_at(run, law, law.memory, rate)
    at, longest = (gap, rate, slip), step_length(run.propagator, run.propagator.rule.contact_level)
    friction = friction_at(law, at, end, normal)[0]
    for k in range(state.law.coupled, state.law.variables):
        z = law.row[HEAD + k]
        missed = missed_flow_of(run, k) * longest / state.length
        if z == 0.0 or missed * normal * state.law.friction_limit <= most:
            continue
        # Past its limit a slider that is stretched a little further has the same friction. It then counts in
        # proportion, |f(z) - f(0)| dz/z.
        law.row[HEAD + k] = z + copysign(FELT * abs(z), z)
        past = friction_at(law, at, end, normal)[0] == friction
        law.row[HEAD + k] = 0.0
        carried = abs(friction_at(law, at, end, normal)[0] - friction)
        law.row[HEAD + k] = z
        most = max(most, missed * carried) if past else most
    return most


@part_kernel
def _nudge_of(slip: float, least: float) -> float:
    """Return the difference of the slip for a derivative [m/s], its way: mirrors give mirrored numbers."""
    return (NUDGE if slip >= 0.0 else -NUDGE) * (abs(slip) + least)


@inner_kernel
def _internal_rate(run: Run, i: int) -> float:
    """Return the rate at node i of the polynomial through the coupled internal variable."""
    total = 0.0
    if run.state.law.coupled == 0:
        return total
    for m in range(NODES):
        difference = run.step.memory[m, 0] - run.state.memory[0]
        total += run.propagator.rule.derivative[i, m] * difference
    return float(total / run.state.length)


@inner_kernel
def _derivatives(run: Run, law: Law, i: int, least: float) -> tuple[float, float, float, float, float, float]:
    """Return friction f [N], rate g of the coupled variable, and f_v, f_z, g_v, g_z at node i."""
    state, step = run.state, run.step
    gap, rate, slip = step.gap[i], step.gap_rate[i], step.slip[i]
    z = step.memory[i, 0] if state.law.coupled != 0 else 0.0
    # The way of the slip, so that a mirrored step is the mirrored numbers; but for what a mirror leaves.
    way = NUDGE if slip >= 0.0 or state.law.parity == EVEN else -NUDGE
    dv = _nudge_of(slip, least)
    dz = way * (abs(z) + LEAST_INTERNAL)
    normal, end = state.normal.node[i], step.end[i]
    recall(run, law, i)
    # f and r of eq. 3.8 and the four derivatives of eq. 3.9, by one-sided differences: Newton's pace depends
    # on them, its end does not.
    f, g, _, _ = friction_at(law, (gap, rate, slip), end, normal)
    f_v, g_v, _, _ = friction_at(law, (gap, rate, slip + dv), end, normal)
    f_z, g_z = f, g
    if state.law.coupled != 0:
        law.row[HEAD] = z + dz
        f_z, g_z, _, _ = friction_at(law, (gap, rate, slip), end, normal)
    f_v, f_z, g_v, g_z = (f_v - f) / dv, (f_z - f) / dz, (g_v - g) / dv, (g_z - g) / dz
    if slip == 0.0 and state.law.parity == EVEN:
        # What a mirror leaves has no slope there, but at most a kink.
        g_v = 0.0
    return f, g, f_v, f_z, g_v, g_z


@inner_kernel
def correct_friction(
    run: Run, law: Law, level: int, holds: bool, kept: float, least: float
) -> tuple[float, float]:
    """Take one Newton step of friction and internal variable.

    Friction that `holds` alone changes, so that the slip is `kept` [m/s] at all nodes. Of the others the
    derivatives of f and g are differences, over a slip of at least about `least` [m/s].

    Returns:
        Largest correction of the friction [N], or difference of it from the law's where that is more: steep
        friction is met by a slip that is far from its own. And that of the variable [1], relative to its
        size; both beyond what round-off of the slip does to them. Without a normal force friction tells
        nothing of its variable.
    """
    state, step = run.state, run.step
    size, noise, flowed, most = abs(state.memory[0]), 0.0, 0.0, 0.0
    h, system, derivative = state.length, step.system, run.propagator.rule.derivative
    right, rests = NODES if holds else 2 * NODES, holds
    for m in range(NODES):
        column = mobilities(run, level, m)
        for i in range(NODES):
            system[i, m] = column[i]
    for i in range(NODES):
        if holds:
            # Eq. 3.7: friction that ends the slip at every node.
            system[i, right] = kept - step.slip[i]
            rests = rests and abs(system[i, right]) <= slip_digits(run, i)
            continue
        # Eq. 3.9: the law's friction and the rate of its variable, both at once.
        f, g, f_v, f_z, g_v, g_z = _derivatives(run, law, i, least)
        noise = max(noise, h * abs(g_v) * SLIP_ROUND_OFF)
        for m in range(NODES):
            s = system[i, m]
            same = 1.0 if m == i else 0.0
            system[i, m] = same - f_v * s
            system[i, NODES + m] = -f_z * same
            system[NODES + i, m] = -h * g_v * s
            system[NODES + i, NODES + m] = derivative[i, m] - h * g_z * same
        system[i, right] = f - state.friction.node[i]
        # What the slip's round-off does to f, directly and by the variable. Below that the residual f - F is
        # round-off.
        felt = (abs(f_v) + h * abs(g_v * f_z)) * slip_digits(run, i)
        most = max(most, abs(system[i, right]) - felt)
        system[NODES + i, right] = h * (g - _internal_rate(run, i))
    solve_linear(system, right)
    for i in range(NODES):
        change = system[i, right]
        state.friction.node[i] += change
        if state.law.coupled != 0 and not holds:
            moved = system[NODES + i, right]
            step.memory[i, 0] += moved
            # NaN fails every comparison, and is passed on.
            flowed = flowed if abs(moved) - noise <= flowed else abs(moved) - noise
            size = max(size, abs(step.memory[i, 0]))
        most = max(most, abs(change)) if holds or np.isfinite(change) else np.inf
    push_nodes(run)
    # What is left of the slip has no digits: a light load would not outweigh its round-off over the step.
    most = 0.0 if rests else most
    if not holds:
        for i in range(NODES):
            state.internal_rate.node[i] = _internal_rate(run, i)
    return float(most), 0.0 if flowed == 0.0 else float(flowed / size)


@inner_kernel
def follow_bound(run: Run, law: Law, sign: float) -> None:
    """Let the spring follow a slider that slips: its stretch from the bound, and what of the slip slides."""
    state, step = run.state, run.step
    for i in range(NODES):
        at = step.gap[i], step.gap_rate[i], step.slip[i]
        recall(run, law, i)
        law.row[HEAD] = 0.0
        beside, _, _, stiffness = friction_at(law, at, step.end[i], state.normal.node[i])
        # Friction on its bound (eq. 3.5) is the spring's, -k_t z, and what acts beside it: the stretch
        # follows by that, whatever its rate.
        bound = sign * state.bound.node[i] - state.bias.node[i] + beside
        step.memory[i, 0] = bound / stiffness if stiffness > 0.0 else 0.0
    for i in range(NODES):
        at = step.gap[i], step.gap_rate[i], step.slip[i]
        state.internal_rate.node[i] = _internal_rate(run, i)
        if step.gap[i] < step.end[i]:
            recall(run, law, i)
            # The slip is what stretches the spring and what slides: a slider stays at its bound as long as it
            # slides the same way.
            stretching = friction_at(law, at, step.end[i], state.normal.node[i])[1]
            step.sliding[i] = stretching - state.internal_rate.node[i]


@inner_kernel
def _spring_at_start(run: Run, law: Law) -> tuple[float, float]:
    """Return friction [N] and tangential stiffness [N/m] of an elastoplastic friction at the step's start."""
    state = run.state
    if state.law.friction_kind != ELASTOPLASTIC:
        return 0.0, 0.0
    recall_start(run, law)
    gap, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    end, normal = (
        end_at(run, law, law.memory, rate),
        value_at(state.normal, state.accepted_length / state.length),
    )
    friction, _, _, stiffness = friction_at(law, (gap, rate, slip), end, normal)
    return friction, stiffness


@inner_kernel
def jump_at_guard(run: Run, law: Law) -> bool:
    """Apply a guard's reset map; returns whether an elastoplastic friction that slid is held again.

    Where the reset changes the stiffness, the rate of the stretch is integrated over that jump (Elata and
    Berryman 1996): stiffness that the contact gains carries nothing, so that the force stays and the stretch
    shrinks; stiffness that it loses takes its share of the force along, which then lies below the bound.
    """
    state = run.state
    # Eq. 3.12, k^- before the reset map and k^+ after it.
    friction, before = _spring_at_start(run, law)
    jump(run, law, law.memory, state.guard)
    after = _spring_at_start(run, law)[1]
    if after > before:
        state.memory[0] *= before / after
    return bool(after < before and friction != 0.0 and state.mode == SLIP)


@inner_kernel
def _missed_stretch(
    run: Run, law: Law, at: tuple[float, float, float], end: float, normal: float, x: float
) -> float:
    """Return the error [N] of friction by what the variables miss of their rates, at x = s/h.

    The variables are recalled. Their error lasts for a step in contact at its longest, or until the variable
    forgets it.
    """
    rule, coupled = run.propagator.rule, run.state.law.coupled != 0
    longest = step_length(run.propagator, rule.contact_level)
    friction, flow, _, _ = friction_at(law, at, end, normal)
    if coupled:
        z = law.row[HEAD]
        dz = (NUDGE if at[2] >= 0.0 or run.state.law.parity == EVEN else -NUDGE) * (abs(z) + LEAST_INTERNAL)
        law.row[HEAD] = z + dz
        # Eq. 3.11 for the coupled variable, whose rate is friction's own.
        forgetting = max((flow - friction_at(law, at, end, normal)[1]) / dz, 0.0)
        missed = flow - value_at(run.state.internal_rate, x)
        law.row[HEAD] = z + missed * longest / (1.0 + longest * forgetting)
    add_missed_flow(run, law, law.memory, at, normal, x)
    return abs(friction_at(law, at, end, normal)[0] - friction)


@inner_kernel
def missed_between(run: Run, law: Law, flows: bool, yielding: float, error: float, enough: float) -> float:
    """Return the largest error [N] of friction's polynomial half-way between nodes, or one known, if larger.

    Where the variables flow freely their rates are judged as well; in slip a spring follows its slider.

    Friction with a state has kinks that the nodes alone do not see: where the slip changes its sign it is the
    rate of its variable that has one, and so the rates are judged too, at the step's start as well.
    Of a difference counts what is left once the slip gives way to it, by its mobility `yielding` [m/s/N]:
    steep friction is met by a slip that is hardly another. So errors of stiff equations are judged (Hairer
    and Wanner, Solving ODEs II, sec. IV.8). Above `enough` [N] the step is not accepted, whatever the rates.
    """
    state, nodes = run.state, run.propagator.rule.nodes
    most = error
    for i in range(NODES):
        # Between two nodes the polynomials are furthest from what the nodes hold them to. The first interval
        # has no node at its left end, so that its start is looked at.
        x = 0.5 * (nodes[i - 1] + nodes[i]) if i > 0 else 0.0
        gap, rate, slip, _, _, _, _ = contact_after(run, x * state.length)
        memory_at(run, law, law.memory, x * state.length)
        at, end = (gap, rate, slip), end_at(run, law, law.memory, rate)
        if gap < end:
            normal = max(value_at(state.normal, x), 0.0)
            friction, steepness = friction_and_steepness(law, at, end, normal)
            missed = abs(friction - value_at(state.friction, x))
            if flows and max(most, missed / (1.0 + steepness * yielding)) <= enough:
                missed = max(missed, _missed_stretch(run, law, at, end, normal, x))
            most = max(most, missed / (1.0 + steepness * yielding))
    return most
