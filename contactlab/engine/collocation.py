"""One step of a compliant contact: collocation of the law at the nodes, for a given friction mode.

The oscillators answer a polynomial force exactly, so only the force itself is unknown: its values at
the nodes are iterated until the law agrees with the motion that they cause. In slip the friction is
the law's bound against the slip; in stick it is the friction that holds the slip at zero at every node.
Friction that is not set-valued is in `contactlab.engine.state_friction`.
"""

from math import nan

import numpy as np

from contactlab.arrays import Array
from contactlab.compiled import part_kernel
from contactlab.engine.nodes import free_response
from contactlab.engine.plant import Plant
from contactlab.engine.state_friction import (
    HELD_SLIP,
    LEAST_SLIP,
    correct_state,
    follow_bound,
    mobility,
    push_node,
)
from contactlab.engine.step import (
    BOUND,
    CLOSING,
    FRICTION,
    NORMAL,
    PUSH_TH,
    PUSH_U,
    RUBBING,
    TIP_ROTOR,
    TIP_TH,
    TIP_TH_RATE,
    TIP_U,
    TIP_U_RATE,
    Step,
    shape_forces,
    tip_motion,
)
from contactlab.engine.tables import NODES, Tables, step_length
from contactlab.laws.base import RATE_DEPENDENT, SET_VALUED, STICK, FrictionKernel, PenaltyKernel
from contactlab.motor.geometry import contact_frame

MOST_ITERATIONS = 25
AGREEMENT = 1e-10
"""Relative change of the nodal forces at which the iteration ends; it contracts by far more than ten a
sweep, so that what is left is round-off."""


ROUND_OFF = 1e-9
"""Of a friction bound, relative to the normal force."""


@part_kernel
def sound_normal(normal: float, bound: float) -> float:
    """The normal force [N]; no number where the law says a negative friction bound with it."""
    return nan if bound < -ROUND_OFF * abs(normal) else normal


@part_kernel
def prepare(plant: Plant, tables: Tables, step: Step, level: int) -> None:
    """Contact-free tip motion at the nodes of a level."""
    free_response(plant, tables, step, level, 0)
    for i in range(NODES):
        u, th, u_rate, th_rate, rotor = tip_motion(plant, step.node_q[i], step.node_v[i])
        step.tip[i, TIP_U] = u
        step.tip[i, TIP_TH] = th
        step.tip[i, TIP_U_RATE] = u_rate
        step.tip[i, TIP_TH_RATE] = th_rate
        step.tip[i, TIP_ROTOR] = rotor


@part_kernel
def collocate(
    plant: Plant,
    tables: Tables,
    step: Step,
    level: int,
    mode: int,
    sign: float,
    held: bool,
    force: PenaltyKernel,
    rub: FrictionKernel,
    parameters: Array,
    momentum: float,
) -> int:
    """Iterate the nodal forces of a step that `prepare` made ready, starting from those that stand.

    Args:
        plant, tables, step, level: the step.
        mode: SLIP or STICK.
        sign: direction of the slip in SLIP.
        held: whether creeping friction begins with what would hold the slip at zero. Friction that
            rises steeply from there and then levels off is solved from its steep part, by steps that
            fall short; from its level part they would leap over it, to and fro.
        force, rub, parameters: the law.
        momentum: impulse scale of the contact [N s].

    Returns:
        Sweeps that were needed, or 0 where the iteration does not contract.
    """
    h = step_length(tables, level)
    rubbing = step.whole[RUBBING]
    follows = rubbing == RATE_DEPENDENT or (rubbing != SET_VALUED and mode == STICK)
    factored = False
    for sweep in range(1, MOST_ITERATIONS + 1):
        change = 0.0
        largest = 0.0
        for i in range(NODES):
            old_normal, old_friction = step.force[NORMAL, i], step.force[FRICTION, i]
            _law_at_node(plant, tables, step, level, i, mode, force, parameters)
            if mode != STICK and not follows:
                step.force[FRICTION, i] = -sign * step.force[BOUND, i]
            push_node(step, i)
            change = max(change, abs(step.force[NORMAL, i] - old_normal))
            change = max(change, abs(step.force[FRICTION, i] - old_friction))
            # Friction that would have to hold far more than the law lets it has the round-off of its size.
            largest = max(largest, step.force[NORMAL, i], abs(old_friction))
        holds = (held and sweep == 1) or (mode == STICK and not follows)
        if follows and not holds:
            least = HELD_SLIP if held else LEAST_SLIP
            change = max(change, correct_state(tables, step, level, least, rub, parameters))
        if holds:
            if not factored:
                _factor_stick(tables, step, level)
                factored = True
            change = max(change, _hold_slip(step))
        if not np.isfinite(change):
            return 0
        if change <= AGREEMENT * largest or change * h <= 1e-3 * AGREEMENT * momentum:
            if rubbing != SET_VALUED and not follows:
                follow_bound(tables, step, level, sign, rub, parameters)
            shape_forces(tables, step)
            return sweep
    return 0


@part_kernel
def _law_at_node(
    plant: Plant,
    tables: Tables,
    step: Step,
    level: int,
    i: int,
    mode: int,
    force: PenaltyKernel,
    parameters: Array,
) -> None:
    """Motion of node i under the present forces, and the law's answer to it."""
    u, th = step.tip[i, TIP_U], step.tip[i, TIP_TH]
    u_rate, th_rate = step.tip[i, TIP_U_RATE], step.tip[i, TIP_TH_RATE]
    rotor = step.tip[i, TIP_ROTOR]
    for m in range(NODES):
        push_u, push_th = step.force[PUSH_U, m], step.force[PUSH_TH, m]
        u += tables.tip_q[level, 0, i, m] * push_u + tables.tip_q[level, 1, i, m] * push_th
        th += tables.tip_q[level, 1, i, m] * push_u + tables.tip_q[level, 2, i, m] * push_th
        u_rate += tables.tip_v[level, 0, i, m] * push_u + tables.tip_v[level, 1, i, m] * push_th
        th_rate += tables.tip_v[level, 1, i, m] * push_u + tables.tip_v[level, 2, i, m] * push_th
        rotor += tables.tip_v[level, 3, i, m] * step.force[FRICTION, m]
    gap, n_u, n_th, t_u, t_th = contact_frame(
        u, th, plant.tip_length, plant.radius, plant.clearance
    )
    rate = n_u * u_rate + n_th * th_rate
    slip = t_u * u_rate + t_th * th_rate + rotor
    normal, bound, loss = 0.0, 0.0, 0.0
    if gap < 0.0:
        seen = 0.0 if mode == STICK else slip
        normal, bound, _, loss = force(gap, rate, seen, step.real[CLOSING], parameters)
        normal = sound_normal(normal, bound)
    step.rows[i, 0], step.rows[i, 1], step.rows[i, 2], step.rows[i, 3] = n_u, n_th, t_u, t_th
    step.force[NORMAL, i] = normal
    step.force[BOUND, i] = bound
    step.loss[i] = loss
    step.gap[i] = gap
    step.gap_rate[i] = rate
    step.slip[i] = slip
    step.sliding[i] = slip


@part_kernel
def _factor_stick(tables: Tables, step: Step, level: int) -> None:
    """Factor d slip_i / d friction_m (LU without pivoting: the matrix is h a_im D_tt nearly)."""
    for i in range(NODES):
        for m in range(NODES):
            step.stick[i, m] = mobility(tables, step, level, i, m)
    for p in range(NODES):
        for i in range(p + 1, NODES):
            step.stick[i, p] /= step.stick[p, p]
            for m in range(p + 1, NODES):
                step.stick[i, m] -= step.stick[i, p] * step.stick[p, m]


@part_kernel
def _hold_slip(step: Step) -> float:
    """Correct the friction at all nodes so that the slip vanishes; returns the largest correction [N]."""
    right = NODES
    for i in range(NODES):
        step.stick[i, right] = -step.slip[i]
        for m in range(i):
            step.stick[i, right] -= step.stick[i, m] * step.stick[m, right]
    largest = 0.0
    for i in range(NODES - 1, -1, -1):
        for m in range(i + 1, NODES):
            step.stick[i, right] -= step.stick[i, m] * step.stick[m, right]
        step.stick[i, right] /= step.stick[i, i]
        step.force[FRICTION, i] += step.stick[i, right]
        push_node(step, i)
        largest = max(largest, abs(step.stick[i, right]))
    return largest
