"""Nodes of a collocated step in compliant and in rigid contact: motion, forces and linear equations.

Both families iterate the forces at the nodes of a step: from them follows the motion of the contact at every
node, and from that the next forces, until two iterations agree.
"""

from typing import Any, Final, cast

import numpy as np

from contactlab.arrays import Array
from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.compiler.lanes import WIDTH, Lanes, entry, load, load_all, set_entry, store
from contactlab.engine.kinematics import free_response, tip_motions
from contactlab.engine.propagator import build_level, step_length
from contactlab.engine.state import NODES, Run, fit
from contactlab.motor.geometry import contact_frames

FIRST: Final = cast(int, np.int64(0))
"""The first node, as a number that no kernel is copied for."""

MOST_ITERATIONS = 25
"""Iterations of the nodal forces of a step, after which it is shortened."""

AGREEMENT = 1e-10
"""Relative change of the nodal forces, in the last sweep or in the next one, at which the iteration ends; it
contracts by far more than ten a sweep."""


@part_kernel
def open_nodes(run: Run, level: int) -> float:
    """Set the tip's motion without contact at the nodes of a level; returns the step's length [s]."""
    step = run.step
    # Eqs. 2.3 and 2.4: what drive and free vibration do, exactly. It is independent of the nodal forces, so
    # that it is computed once and not in every iteration.
    build_level(run.plant, run.propagator, level)
    free_response(run, level)
    u, th, u_rate, th_rate, rotor = tip_motions(run.plant)
    store(step.u, u)
    store(step.th, th)
    store(step.u_rate, u_rate)
    store(step.th_rate, th_rate)
    store(step.rotor, rotor)
    return step_length(run.propagator, level)


@inner_kernel
def move_nodes(run: Run, level: int) -> None:
    """Set motion and directions of the contact at all nodes under the nodal forces."""
    step, results = run.step, run.propagator.levels[level]
    tip_q, tip_v = results.tip_q, results.tip_v
    u, th = load(step.u), load(step.th)
    # Eq. 3.4: the forces of all nodes act at each one, through the answers (3.3) to their polynomials. The
    # matrix is full: a polynomial through the nodes has the force of a later node act before it.
    for m in range(NODES):
        push_u, push_th = step.push_u.node[m], step.push_th.node[m]
        uu, mixed, thth = load_all(tip_q[0, m]), load_all(tip_q[1, m]), load_all(tip_q[2, m])
        u = u + (uu * push_u + mixed * push_th)
        th = th + (mixed * push_u + thth * push_th)
    # Eqs. 1.9 and 1.10: gap, its rate and slip are nonlinear in the tip's motion. The directions turn with
    # it, which is all that makes the equations of rigid contact nonlinear.
    of = run.plant.geometry
    gap, n_u, n_th, t_u, t_th = contact_frames(
        u, th, of.tip_length, of.radius, of.clearance, of.cosine, of.sine
    )
    u_rate, th_rate, rotor = load(step.u_rate), load(step.th_rate), load(step.rotor)
    for m in range(NODES):
        push_u, push_th = step.push_u.node[m], step.push_th.node[m]
        uu, mixed, thth = load_all(tip_v[0, m]), load_all(tip_v[1, m]), load_all(tip_v[2, m])
        u_rate = u_rate + (uu * push_u + mixed * push_th)
        th_rate = th_rate + (mixed * push_u + thth * push_th)
        rotor = rotor + load_all(tip_v[3, m]) * step.push_r.node[m]
    slip = t_u * u_rate + t_th * th_rate + rotor
    store(step.n_u, n_u)
    store(step.n_th, n_th)
    store(step.t_u, t_u)
    store(step.t_th, t_th)
    store(step.gap, gap)
    store(step.gap_rate, n_u * u_rate + n_th * th_rate)
    store(step.slip, slip)
    store(step.sliding, slip)


@part_kernel
def push_node(run: Run, i: int) -> None:
    """Set the generalised forces of node i from its normal force and friction (eq. 1.11)."""
    step, normal, friction = run.step, run.state.normal.node[i], run.state.friction.node[i]
    step.push_u.node[i] = normal * step.n_u[i] + friction * step.t_u[i]
    step.push_th.node[i] = normal * step.n_th[i] + friction * step.t_th[i]
    step.push_r.node[i] = friction


@part_kernel
def push_nodes(run: Run) -> None:
    """Set the generalised forces of all nodes, see `push_node`."""
    step, normal, friction = run.step, load(run.state.normal.node), load(run.state.friction.node)
    store(step.push_u.node, normal * load(step.n_u) + friction * load(step.t_u))
    store(step.push_th.node, normal * load(step.n_th) + friction * load(step.t_th))
    store(step.push_r.node, friction)


@inner_kernel
def mobilities(run: Run, level: int, m: int) -> Lanes:
    """Return d slip_i / d friction_m [m/s/N] of all nodes i (eq. 3.7)."""
    step, tip_v = run.step, run.propagator.levels[level].tip_v
    s_u, s_th = step.t_u[m], step.t_th[m]
    uu, mixed, thth = load_all(tip_v[0, m]), load_all(tip_v[1, m]), load_all(tip_v[2, m])
    by_u, by_th = uu * s_u + mixed * s_th, mixed * s_u + thth * s_th
    answered: Lanes = load(step.t_u) * by_u + load(step.t_th) * by_th + load_all(tip_v[3, m])
    return answered


@part_kernel
def agree(state: Any, change: float, most: float, flowed: float) -> bool:
    """Return whether an iteration leaves nothing to change.

    It has changed forces of up to `most` by `change` [N], and internal variables by `flowed` of them [1].
    """
    # Forces that are nothing to the contact's impulse need not agree in their digits: a graze would not end.
    small = AGREEMENT * max(most, 1e-3 * state.impulse_scale / state.length)
    return bool(flowed <= AGREEMENT and change <= small)


@part_kernel
def fit_nodes(run: Run) -> None:
    """Lay the polynomials (eq. 3.2) of all forces through their values at the nodes."""
    state, step, rule = run.state, run.step, run.propagator.rule
    fit(rule, state.normal)
    fit(rule, state.friction)
    fit(rule, state.bound)
    fit(rule, state.bias)
    fit(rule, step.push_u)
    fit(rule, step.push_th)
    fit(rule, step.push_r)


@inner_kernel
def solve_linear(system: Array, n: int) -> None:
    """Solve n linear equations in place, their right side in column n, with row pivots.

    A row has room for two registers.
    """
    registers = 2 if n >= WIDTH else 1
    # Downwards: the largest entry of a column is the pivot. A zero one leaves NaN or infinity, which the
    # callers' largest changes pass on, so that the step is shortened.
    for p in range(n):
        best = p
        for row in range(p + 1, n):
            if abs(system[row, p]) > abs(system[best, p]):
                best = row
        if best != p:
            for k in range(registers):
                kept = entry(system, 2 * p + k)
                set_entry(system, 2 * p + k, entry(system, 2 * best + k))
                set_entry(system, 2 * best + k, kept)
        # Whole rows: what stands below the diagonal and beyond the right side is not read again.
        share = 1.0 / system[p, p]
        for row in range(p + 1, n):
            ratio = system[row, p] * share
            for k in range(registers):
                less = ratio * entry(system, 2 * p + k)
                set_entry(system, 2 * row + k, entry(system, 2 * row + k) - less)
    # Upwards.
    for p in range(n - 1, -1, -1):
        left = system[p, n]
        for column in range(p + 1, n):
            left -= system[p, column] * system[column, n]
        system[p, n] = left / system[p, p]
