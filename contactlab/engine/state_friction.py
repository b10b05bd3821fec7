"""Friction with a memory in a collocated step: a spring with a slider, or a force that creeps.

At every node friction and memory satisfy

    F_i = f(slip_i, z_i),   (dz/dt)_i = g(slip_i, z_i)

with the law's f and g, dz/dt the rate of the polynomial through the memory at the step's start and at the
nodes, and slip_i what the frictions at all nodes leave. Newton's method solves both at once, so that
stiff springs and steep creep are no matter of the step. What friction that creeps does cost are its
changes between creep and slip: each takes some tens of steps, down to the time in which the slip
crosses the creep velocity and up again. A slider keeps F on the bound; its memory follows.
"""

import numpy as np

from contactlab.arrays import Array
from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.plant import Plant
from contactlab.engine.step import (
    BOUND,
    FRICTION,
    LENGTH,
    MEMORY,
    MEMORY_RATE,
    NORMAL,
    PARITY,
    PUSH_TH,
    PUSH_U,
    RUBBING,
    Step,
    flow_to,
    force_at,
    memory_at,
    tip_motion,
)
from contactlab.engine.tables import NODES, Tables, step_length
from contactlab.laws.base import EVEN, SET_VALUED, FrictionKernel
from contactlab.motor.geometry import contact_frame

NUDGE = 1e-7
"""Relative difference for the derivatives of the law; it sets the pace of Newton, not its end."""

LEAST_SLIP, LEAST_MEMORY = 1e-4, 1e-9
"""What that is relative to near zero [m/s], and for a stretch [m]."""

HELD_SLIP = 1e-9
"""The same for slip that steep friction holds near zero [m/s]: its difference is the slip's round-off."""


@inner_kernel
def push_node(step: Step, i: int) -> None:
    """Generalised forces of node i from its normal force and friction."""
    normal, friction = step.force[NORMAL, i], step.force[FRICTION, i]
    step.force[PUSH_U, i] = normal * step.rows[i, 0] + friction * step.rows[i, 2]
    step.force[PUSH_TH, i] = normal * step.rows[i, 1] + friction * step.rows[i, 3]


@inner_kernel
def mobility(tables: Tables, step: Step, level: int, i: int, m: int) -> float:
    """D slip_i / d friction_m [m/s/N]."""
    t_u, t_th = step.rows[i, 2], step.rows[i, 3]
    s_u, s_th = step.rows[m, 2], step.rows[m, 3]
    return float(
        t_u * (tables.tip_v[level, 0, i, m] * s_u + tables.tip_v[level, 1, i, m] * s_th)
        + t_th * (tables.tip_v[level, 1, i, m] * s_u + tables.tip_v[level, 2, i, m] * s_th)
        + tables.tip_v[level, 3, i, m]
    )


@inner_kernel
def memory_rate(tables: Tables, step: Step, level: int, i: int) -> float:
    """Rate at node i of the polynomial through the memory."""
    total = 0.0
    for m in range(NODES):
        total += tables.derivative[i, m] * (step.memory[m] - step.real[MEMORY])
    return float(total / step_length(tables, level))


@part_kernel
def correct_state(
    tables: Tables, step: Step, level: int, least: float, rub: FrictionKernel, parameters: Array
) -> float:
    """One Newton step of friction and memory at all nodes; returns the largest correction [N]."""
    h = step_length(tables, level)
    system = step.coupled
    right = 2 * NODES
    for i in range(NODES):
        f, g, f_v, f_z, g_v, g_z = _law_and_slopes(step, i, least, rub, parameters)
        for m in range(NODES):
            s = mobility(tables, step, level, i, m)
            same = 1.0 if m == i else 0.0
            system[i, m] = same - f_v * s
            system[i, NODES + m] = -f_z * same
            system[NODES + i, m] = -h * g_v * s
            system[NODES + i, NODES + m] = tables.derivative[i, m] - h * g_z * same
        system[i, right] = f - step.force[FRICTION, i]
        system[NODES + i, right] = h * (g - memory_rate(tables, step, level, i))
    _eliminate(system)
    most = 0.0
    for i in range(NODES):
        change = system[i, right]
        step.force[FRICTION, i] += change
        step.memory[i] += system[NODES + i, right]
        push_node(step, i)
        most = max(most, abs(change)) if np.isfinite(change) else np.inf
    for i in range(NODES):
        step.force[MEMORY_RATE, i] = memory_rate(tables, step, level, i)
    return most


@inner_kernel
def _law_and_slopes(
    step: Step, i: int, least: float, rub: FrictionKernel, parameters: Array
) -> tuple[float, float, float, float, float, float]:
    """f, g and their derivatives to slip and memory at node i; zero where the gap is open."""
    gap, rate, slip, z = step.gap[i], step.gap_rate[i], step.slip[i], step.memory[i]
    if gap >= 0.0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    normal = step.force[NORMAL, i]
    f, g, _, _ = rub(gap, rate, slip, normal, z, parameters)
    # The way of the slip, so that a mirrored step is the mirrored numbers; but for what a mirror leaves.
    way = NUDGE if slip >= 0.0 or step.whole[PARITY] == EVEN else -NUDGE
    dv = nudge_of(slip, least)
    dz = way * (abs(z) + LEAST_MEMORY)
    f_v, g_v, _, _ = rub(gap, rate, slip + dv, normal, z, parameters)
    f_z, g_z, _, _ = rub(gap, rate, slip, normal, z + dz, parameters)
    return f, g, (f_v - f) / dv, (f_z - f) / dz, (g_v - g) / dv, (g_z - g) / dz


@inner_kernel
def nudge_of(slip: float, least: float) -> float:
    """Difference of the slip for a derivative [m/s], its way: a mirrored step is the mirrored numbers."""
    return (NUDGE if slip >= 0.0 else -NUDGE) * (abs(slip) + least)


@inner_kernel
def steepness_of(
    gap: float,
    rate: float,
    slip: float,
    normal: float,
    memory: float,
    friction: float,
    rub: FrictionKernel,
    parameters: Array,
) -> float:
    """How steeply friction falls with the slip where it has a value [N s/m], zero where it rises."""
    dv = nudge_of(slip, HELD_SLIP)
    steeper = rub(gap, rate, slip + dv, normal, memory, parameters)[0]
    return max((friction - steeper) / dv, 0.0)


@inner_kernel
def _eliminate(system: Array) -> None:
    """Solve a linear system in place, its right side in the last column, with row pivots."""
    n = system.shape[0]
    for p in range(n):
        best = p
        for row in range(p + 1, n):
            if abs(system[row, p]) > abs(system[best, p]):
                best = row
        for column in range(p, n + 1):
            held = system[p, column]
            system[p, column] = system[best, column]
            system[best, column] = held
        for row in range(p + 1, n):
            ratio = system[row, p] / system[p, p]
            for column in range(p, n + 1):
                system[row, column] -= ratio * system[p, column]
    for p in range(n - 1, -1, -1):
        for column in range(p + 1, n):
            system[p, n] -= system[p, column] * system[column, n]
        system[p, n] /= system[p, p]


@part_kernel
def follow_bound(
    tables: Tables,
    step: Step,
    level: int,
    sign: float,
    rub: FrictionKernel,
    parameters: Array,
) -> None:
    """A slider that slips: the spring's stretch from the bound, and what of the slip is sliding."""
    for i in range(NODES):
        step.memory[i] = 0.0
        if step.gap[i] < 0.0:
            normal, bound = step.force[NORMAL, i], step.force[BOUND, i]
            stiffness = rub(step.gap[i], step.gap_rate[i], step.slip[i], normal, 0.0, parameters)[3]
            step.memory[i] = sign * bound / stiffness if stiffness > 0.0 else 0.0
    for i in range(NODES):
        step.force[MEMORY_RATE, i] = memory_rate(tables, step, level, i)
        if step.gap[i] < 0.0:
            stretching = rub(
                step.gap[i],
                step.gap_rate[i],
                step.slip[i],
                step.force[NORMAL, i],
                step.memory[i],
                parameters,
            )[1]
            step.sliding[i] = stretching - step.force[MEMORY_RATE, i]


@inner_kernel
def missed_between(
    plant: Plant, tables: Tables, step: Step, level: int, rub: FrictionKernel, parameters: Array
) -> float:
    """Largest error [N] of friction's polynomial half-way between nodes, from its difference to the law.

    Friction that creeps has kinks where the slip changes its sign, which the nodes alone do not see.
    Of a difference counts what is left once the slip gives way to it: steep friction is met by a slip
    that is hardly another. So errors of stiff equations are judged (Hairer and Wanner, Solving ODEs II,
    sec. IV.8).
    """
    most = 0.0
    yielding = mobility(tables, step, level, 0, 0)
    for i in range(NODES - 1):
        x = 0.5 * (tables.nodes[i] + tables.nodes[i + 1])
        flow_to(plant, step, x * step.real[LENGTH])
        gap, rate, slip = contact_at(plant, step.other_q, step.other_v)
        if gap < 0.0:
            normal = max(force_at(step, NORMAL, x), 0.0)
            memory = memory_at(step, x)
            friction = rub(gap, rate, slip, normal, memory, parameters)[0]
            steepness = steepness_of(gap, rate, slip, normal, memory, friction, rub, parameters)
            missed = abs(friction - force_at(step, FRICTION, x))
            most = max(most, missed / (1.0 + steepness * yielding))
    return most


@inner_kernel
def contact_at(plant: Plant, q: Array, v: Array) -> tuple[float, float, float]:
    """Gap, gap rate and slip of a state."""
    u, th, u_rate, th_rate, rotor = tip_motion(plant, q, v)
    gap, n_u, n_th, t_u, t_th = contact_frame(
        u, th, plant.tip_length, plant.radius, plant.clearance
    )
    return gap, n_u * u_rate + n_th * th_rate, t_u * u_rate + t_th * th_rate + rotor


@inner_kernel
def sliding_at(plant: Plant, step: Step, s: float, rub: FrictionKernel, parameters: Array) -> float:
    """What must keep its sign in slip, at time s of a step [m/s]."""
    flow_to(plant, step, s)
    gap, rate, slip = contact_at(plant, step.other_q, step.other_v)
    if step.whole[RUBBING] == SET_VALUED or gap >= 0.0:
        return float(slip)
    x = s / step.real[LENGTH]
    normal = max(force_at(step, NORMAL, x), 0.0)
    stretching = rub(gap, rate, slip, normal, memory_at(step, x), parameters)[1]
    return float(stretching - force_at(step, MEMORY_RATE, x))
