"""One step of a compliant contact: collocation of the law at the nodes, for a given friction mode.

The oscillators answer a polynomial force exactly, so only the force itself is unknown: its values at
the nodes are iterated until the law agrees with the motion that they cause. In slip the friction is
the law's bound against the slip; in stick it is the friction that holds the slip at zero at every node.
Friction that is not set-valued is in `contactlab.engine.friction`.
"""

from math import nan

import numpy as np

from contactlab.compiled import inner_kernel, merged_kernel, part_kernel
from contactlab.engine.context import Law, Run
from contactlab.engine.friction import (
    FIRST,
    HELD_SLIP,
    LEAST_SLIP,
    correct_friction,
    follow_bound,
    missed_between,
    mobility,
    push_node,
)
from contactlab.engine.kinematics import contact_at, contact_of, free_response, tip_motion
from contactlab.engine.memory import correct_memory, end_at, guess_memory, note_turn, recall
from contactlab.engine.moments import fit_moments, missed_moments, set_moments
from contactlab.engine.propagator import build_level, step_length
from contactlab.engine.state import LAST, NODES, START, fit, largest, value_at
from contactlab.laws.base import RATE_DEPENDENT, SET_VALUED, SLIP, STICK

MOST_ITERATIONS = 25
AGREEMENT = 1e-10
"""Relative change of the nodal forces at which the iteration ends; it contracts by far more than ten a
sweep, so that what is left is round-off."""

ROUND_OFF = 1e-9
"""Of a friction bound, relative to the normal force."""

STICK_ERROR = 0.1
"""Error of sticking friction at the step's start over the highest coefficient of its polynomial [1]."""

NODE_PRODUCT = 126.0
"""Reciprocal product of the Radau nodes, (2 n - 1)!/(n! (n - 1)!) of n = 5 [1]."""

KINK = 1e3
"""Error over the tolerance of a step that cannot be judged: it has a kink that is not negligible."""

Known = tuple[float, float, float, float, float]
"""Normal force, half the width and the middle of the interval that bounds friction in the step's mode,
friction that is not set-valued [N] and its steepness [N s/m], where a step begins."""


@part_kernel
def sound_normal(normal: float, bound: float) -> float:
    """Give the normal force [N]; no number where the law says a negative friction bound with it."""
    return nan if bound < -ROUND_OFF * abs(normal) else normal


@inner_kernel
def attempt(run: Run, law: Law, level: int, known: Known) -> float:
    """Solve a step at a level; returns its error over the tolerance, infinite where it has no solution.

    The error is what the polynomials of normal force, bound and friction miss of their known values
    at the step's start, as an impulse; friction that sticks has no known start and is judged by its
    highest coefficient, and of rate-dependent friction counts what no change of the slip makes good. A step
    in which the gap opens, or the force ends or begins before it, carries a kink, and stands only
    when the whole force left is negligible.
    """
    state, step = run.state, run.step
    normal, bound, bias, friction, steepness = known
    build_level(run.plant, run.propagator, level)
    free_response(run, level, FIRST)
    for i in range(NODES):
        tip = tip_motion(run.plant, i)
        step.u[i], step.th[i], step.u_rate[i], step.th_rate[i], step.rotor[i] = tip
    depends = state.friction_kind == RATE_DEPENDENT
    h = step_length(run.propagator, level)
    stretch = h / state.length
    state.length = h
    stiffness = steepness * mobility(run, level, FIRST, FIRST)
    sweeps = 0
    for held in range(1 if stiffness > 1.0 else 0, 2 if depends else 1):
        if sweeps == 0:
            _first_forces(run, law, stretch)
            sweeps = _collocate(run, law, level, held == 1)
    state.taken = 0.0
    state.sweeps += sweeps
    if sweeps == 0:
        return np.inf
    allowed = state.tolerance * state.momentum
    kinked = _kinked_force(run, known)
    if kinked >= 0.0:
        return 0.5 if kinked * h <= allowed else KINK
    error = max(abs(state.normal.coefficient[0] - normal), missed_moments(run, law.memory))
    if not depends:
        error = max(error, abs(state.bound.coefficient[0] - bound), abs(state.bias.coefficient[0] - bias))
    if state.friction_kind != SET_VALUED:
        error = max(error, abs(state.friction.coefficient[0] - friction) / (1.0 + stiffness))
        if depends:
            error = max(error, missed_between(run, law, mobility(run, level, FIRST, FIRST)))
    if state.mode == STICK:
        error = max(error, STICK_ERROR * abs(_highest_coefficient(run, level)))
    return float(error * h / allowed)


@merged_kernel
def _highest_coefficient(run: Run, level: int) -> float:
    """Return the highest coefficient of the friction [N], in exact stick without that of the slip residue.

    Of the slip v_0 that the step before left, the nodes leave the share prod(1 - x/c_i), by an impulse
    v_0/D_tt that does not shrink with the step: no shorter step is more accurate.
    """
    highest = float(run.state.friction.coefficient[NODES - 1])
    if run.state.friction_kind != SET_VALUED:
        return highest
    slip, yielding = contact_at(run.plant, START)[2], 0.0
    for m in range(NODES):
        yielding += mobility(run, level, LAST, m)
    return highest + NODES * NODE_PRODUCT * slip / yielding


@merged_kernel
def _kinked_force(run: Run, known: Known) -> float:
    """Give the largest force [N] of a step in which the gap opens, or the force ends or begins; else -1."""
    normal, forces = known[0], run.state.normal.node
    most, ends = max(abs(normal), abs(known[3])), False
    for i in range(NODES):
        most = max(most, abs(forces[i]))
        if run.state.friction_kind == RATE_DEPENDENT:
            # Friction that no bound ties to the normal force.
            most = max(most, abs(run.state.friction.node[i]))
        ends = ends or (normal > 0.0 and forces[i] == 0.0) or run.step.gap[i] >= run.step.end[i]
    begins = normal == 0.0 == forces[0] and largest(forces) > 0.0
    return most if ends or begins else -1.0


@merged_kernel
def _first_forces(run: Run, law: Law, stretch: float) -> None:
    """Set forces and internal variable at the nodes from the polynomials that stand, to iterate from."""
    state, nodes = run.state, run.propagator.rule.nodes
    for i in range(NODES):
        x = state.taken + nodes[i] * stretch
        state.normal.node[i] = max(value_at(state.normal, x), 0.0)
        state.bound.node[i] = max(value_at(state.bound, x), 0.0)
        state.bias.node[i] = value_at(state.bias, x)
        state.friction.node[i] = value_at(state.friction, x)
        if state.mode == SLIP and state.friction_kind != RATE_DEPENDENT:
            state.friction.node[i] = state.bias.node[i] - state.sign * state.bound.node[i]
        # Only friction with an internal variable reads these.
        state.internal_rate.node[i] = value_at(state.internal_rate, x)
        push_node(run, law.memory, i)
    guess_memory(run, law.memory)


@inner_kernel
def _collocate(run: Run, law: Law, level: int, held: bool) -> int:
    """Iterate the nodal forces of a step, starting from those that stand.

    Rate-dependent friction may begin `held`, with what would hold the slip at zero: friction that rises
    steeply from there and then levels off is solved from its steep part, by steps that fall short; from its
    level part they would leap over it, to and fro. Returns the sweeps that were needed, or 0
    where the iteration does not contract.
    """
    state, step, rule = run.state, run.step, run.propagator.rule
    sign, kind, sticks = float(state.sign), state.friction_kind, state.mode == STICK
    follows = kind == RATE_DEPENDENT or (kind != SET_VALUED and sticks)
    slides = not sticks and not follows
    least_slip = HELD_SLIP if held else LEAST_SLIP
    for sweep in range(1, MOST_ITERATIONS + 1):
        change, most = 0.0, 0.0
        for i in range(NODES):
            old_normal, old_friction = state.normal.node[i], state.friction.node[i]
            turned = _law_at_node(run, law, level, i)
            if slides:
                state.friction.node[i] = state.bias.node[i] - sign * state.bound.node[i]
            push_node(run, law.memory, i)
            change = max(change, turned, abs(state.normal.node[i] - old_normal))
            change = max(change, abs(state.friction.node[i] - old_friction))
            # Friction that would have to hold far more than the law lets it has the round-off of its size.
            most = max(most, state.normal.node[i], abs(old_friction))
        holds = (held and sweep == 1) or (sticks and not follows)
        if holds or follows:
            change = max(change, correct_friction(run, law, level, holds, least_slip))
        flowed = correct_memory(run, law, law.memory, state.length)
        if not np.isfinite(change):
            return 0
        least = 1e-3 * AGREEMENT * state.momentum
        if flowed <= AGREEMENT and (change <= AGREEMENT * most or change * state.length <= least):
            if kind != SET_VALUED and not follows:
                follow_bound(run, law, sign)
            fit(rule, state.normal)
            fit(rule, state.friction)
            fit(rule, state.bound)
            fit(rule, state.bias)
            fit(rule, state.internal_rate)
            fit(rule, step.push_u)
            fit(rule, step.push_th)
            fit(rule, step.push_r)
            fit_moments(run, law.memory)
            return sweep
    return 0


@merged_kernel
def _law_at_node(run: Run, law: Law, level: int, i: int) -> float:
    """Set the motion of node i under the present forces, and the law's answer to it.

    Gives the change of its moments, as a force on the rotor [N].
    """
    state, step, answers = run.state, run.step, run.propagator.levels[level]
    tip_q, tip_v = answers.tip_q, answers.tip_v
    u, th = step.u[i], step.th[i]
    u_rate, th_rate, rotor = step.u_rate[i], step.th_rate[i], step.rotor[i]
    for m in range(NODES):
        push_u, push_th = step.push_u.node[m], step.push_th.node[m]
        u += tip_q[0, i, m] * push_u + tip_q[1, i, m] * push_th
        th += tip_q[1, i, m] * push_u + tip_q[2, i, m] * push_th
        u_rate += tip_v[0, i, m] * push_u + tip_v[1, i, m] * push_th
        th_rate += tip_v[1, i, m] * push_u + tip_v[2, i, m] * push_th
        rotor += tip_v[3, i, m] * step.push_r.node[m]
    gap, rate, slip, n_u, n_th, t_u, t_th = contact_of(run.plant, (u, th, u_rate, th_rate, rotor))
    normal, bound, bias, loss, turned = 0.0, 0.0, 0.0, 0.0, 0.0
    note_turn(run, i, th, t_u, th_rate, rotor)
    recall(run, law, i)
    step.end[i] = end_at(run, law, law.memory, rate)
    if gap < step.end[i]:
        seen = 0.0 if state.mode == STICK else slip
        normal, least, most, _, loss = law.force(gap, rate, seen, state.impact_speed, law.parameters)
        bound, bias = 0.5 * (most - least), 0.5 * (most + least)
        normal = sound_normal(normal, bound)
        turned = set_moments(run, law, law.memory, i, gap, normal)
    step.n_u[i], step.n_th[i], step.t_u[i], step.t_th[i] = n_u, n_th, t_u, t_th
    state.normal.node[i], state.bound.node[i], state.bias.node[i] = normal, bound, bias
    step.gap[i], step.gap_rate[i], step.slip[i], step.sliding[i] = gap, rate, slip, slip
    step.loss[i] = loss
    return turned
