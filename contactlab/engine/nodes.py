"""Nodes of a collocated step in compliant and in rigid contact: motion, forces and linear equations.

Both families iterate the forces at the nodes of a step: from them follows the motion of the contact at every
node, and from that the next forces, until two iterations agree.
"""

from typing import Any, Final, cast

import numpy as np

from contactlab.arrays import Array
from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.engine.kinematics import contact_of, free_response, tip_motion
from contactlab.engine.propagator import build_level, step_length
from contactlab.engine.state import NODES, Run, fit

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
    free_response(run, level, FIRST)
    for i in range(NODES):
        tip = tip_motion(run.plant, i)
        step.u[i], step.th[i], step.u_rate[i], step.th_rate[i], step.rotor[i] = tip
    return step_length(run.propagator, level)


@inner_kernel
def contact_at_node(run: Run, level: int, i: int) -> tuple[float, float, float]:
    """Set motion and directions of the contact at node i under the nodal forces; returns gap, rates.

    Returns gap [m], gap rate and slip [m/s].
    """
    step, results = run.step, run.propagator.levels[level]
    tip_q, tip_v = results.tip_q, results.tip_v
    u, th = step.u[i], step.th[i]
    u_rate, th_rate, rotor = step.u_rate[i], step.th_rate[i], step.rotor[i]
    # Eq. 3.4: the forces of all nodes act at each one, through the answers (3.3) to their polynomials. The
    # matrix is full: a polynomial through the nodes has the force of a later node act before it.
    for m in range(NODES):
        push_u, push_th = step.push_u.node[m], step.push_th.node[m]
        u += tip_q[0, i, m] * push_u + tip_q[1, i, m] * push_th
        th += tip_q[1, i, m] * push_u + tip_q[2, i, m] * push_th
        u_rate += tip_v[0, i, m] * push_u + tip_v[1, i, m] * push_th
        th_rate += tip_v[1, i, m] * push_u + tip_v[2, i, m] * push_th
        rotor += tip_v[3, i, m] * step.push_r.node[m]
    # Eqs. 1.9 and 1.10: gap, its rate and slip are nonlinear in the tip's motion. The directions turn with
    # it, which is all that makes the equations of rigid contact nonlinear.
    gap, rate, slip, n_u, n_th, t_u, t_th = contact_of(run.plant, (u, th, u_rate, th_rate, rotor))
    step.n_u[i], step.n_th[i], step.t_u[i], step.t_th[i] = n_u, n_th, t_u, t_th
    step.gap[i], step.gap_rate[i], step.slip[i], step.sliding[i] = gap, rate, slip, slip
    return gap, rate, slip


@part_kernel
def push_node(run: Run, i: int) -> None:
    """Set the generalised forces of node i from its normal force and friction (eq. 1.11)."""
    step, normal, friction = run.step, run.state.normal.node[i], run.state.friction.node[i]
    step.push_u.node[i] = normal * step.n_u[i] + friction * step.t_u[i]
    step.push_th.node[i] = normal * step.n_th[i] + friction * step.t_th[i]
    step.push_r.node[i] = friction


@inner_kernel
def mobility(run: Run, level: int, i: int, m: int) -> float:
    """Return d slip_i / d friction_m [m/s/N] (eq. 3.7)."""
    step, tip_v = run.step, run.propagator.levels[level].tip_v
    t_u, t_th = step.t_u[i], step.t_th[i]
    s_u, s_th = step.t_u[m], step.t_th[m]
    return float(
        t_u * (tip_v[0, i, m] * s_u + tip_v[1, i, m] * s_th)
        + t_th * (tip_v[1, i, m] * s_u + tip_v[2, i, m] * s_th)
        + tip_v[3, i, m]
    )


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
    """Solve n linear equations in place, their right side in column n, with row pivots."""
    # Downwards: the largest entry of a column is the pivot. A zero one leaves NaN or infinity, which the
    # callers' largest changes pass on, so that the step is shortened.
    for p in range(n):
        best = p
        for row in range(p + 1, n):
            if abs(system[row, p]) > abs(system[best, p]):
                best = row
        if best != p:
            for column in range(p, n + 1):
                system[p, column], system[best, column] = system[best, column], system[p, column]
        for row in range(p + 1, n):
            ratio = system[row, p] / system[p, p]
            for column in range(p + 1, n + 1):
                system[row, column] -= ratio * system[p, column]
    # Upwards: the entries below the diagonal are not cleared and not read again.
    for p in range(n - 1, -1, -1):
        for column in range(p + 1, n):
            system[p, n] -= system[p, column] * system[column, n]
        system[p, n] /= system[p, p]
