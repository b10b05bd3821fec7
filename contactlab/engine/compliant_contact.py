"""A compliant contact step by step: accuracy, release, and the switches between slip and stick."""

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import inner_kernel
from contactlab.engine.compliant import (
    CONE,
    DEEPEST,
    RELEASE,
    REVERSAL,
    collocate,
    locate,
    prepare,
    push_node,
)
from contactlab.engine.plant import Plant
from contactlab.engine.run import (
    CONTACT_STEPS,
    DEPTH,
    DIVERGED,
    END,
    ENDING,
    LEVEL,
    MODE,
    MOMENTUM,
    PEAK,
    REJECTED_STEPS,
    SIGN,
    SWEEPS,
    SWITCHES,
    TIME,
    TOLERANCE,
    Run,
    close_contact,
    commit,
    count_event,
)
from contactlab.engine.step import (
    BOUND,
    COLLOCATED,
    FRICTION,
    NORMAL,
    Step,
    add_collocated,
    flow_to,
    force_at,
    largest,
    tip_motion,
)
from contactlab.engine.tables import FINEST, NODES, Tables, build_level, step_length
from contactlab.geometry import contact_frame
from contactlab.laws.base import SLIP, STICK, PenaltyKernel

Array = NDArray[np.float64]

NO_EVENT = -1
SLIP_ROUND_OFF = 1e-13
"""Slip velocity [m/s] that a located reversal may leave."""

CONE_ROUND_OFF = 1e-9
"""Relative excess of friction over its bound that still sticks: the bound is reached, not left."""


@inner_kernel
def press(
    plant: Plant,
    tables: Tables,
    step: Step,
    run: Run,
    force: PenaltyKernel,
    parameters: Array,
) -> None:
    """Advance a step that `begin` made ready through compliant contact."""
    gap, rate, normal, bound, slip = _start(plant, step, force, parameters)
    level = _separation_level(tables, run, gap, rate, normal)
    flips = 0
    while True:
        if level >= FINEST:
            run.whole[ENDING] = DIVERGED
            return
        error = _attempt(plant, tables, step, run, level, normal, bound, force, parameters)
        if error > 1.0:
            run.whole[REJECTED_STEPS] += 1
            level += 1 + (1 if error > 500.0 else 0)
            continue
        if not _contradicted(step, run, slip):
            break
        # Neither slipping nor sticking fits at this length: look closer before trying again.
        flips += 1
        level += 2 * (flips // 2)
    h = step_length(tables, level)
    event, s = _first_event(plant, tables, step, run, gap, slip, h)
    s = min(s, run.real[END] - run.real[TIME])
    _track_extremes(plant, tables, step, run, rate, s, h)
    if s == h:
        add_collocated(plant, tables, step, level)
    mode = run.whole[MODE]
    friction = force_at(step, FRICTION, s / h)
    commit(plant, tables, step, run, h, s, COLLOCATED, mode, force, parameters)
    run.whole[CONTACT_STEPS] += 1
    run.whole[LEVEL] = _following_level(tables, level, error)
    # An event that lies beyond the end of the run has not happened.
    if run.real[TIME] >= run.real[END] and event != NO_EVENT:
        return
    if event == RELEASE:
        close_contact(plant, tables, step, run)
    elif event == REVERSAL:
        run.whole[MODE] = STICK
        _count_switch(run)
    elif event == CONE:
        run.whole[MODE] = SLIP
        run.whole[SIGN] = -1 if friction > 0.0 else 1
        _count_switch(run)


@inner_kernel
def _count_switch(run: Run) -> None:
    run.whole[SWITCHES] += 1
    count_event(run)


@inner_kernel
def _start(
    plant: Plant, step: Step, force: PenaltyKernel, parameters: Array
) -> tuple[float, float, float, float, float]:
    """Gap, gap rate, normal force, friction bound and slip where the step begins."""
    u, th, u_rate, th_rate, rotor = tip_motion(plant, step.q, step.v)
    gap, n_u, n_th, t_u, t_th = contact_frame(
        u, th, plant.tip_length, plant.radius, plant.clearance
    )
    rate = n_u * u_rate + n_th * th_rate
    slip = t_u * u_rate + t_th * th_rate + rotor
    normal, bound = 0.0, 0.0
    if gap < 0.0:
        normal, bound, _, _ = force(gap, rate, slip, parameters)
    for i in range(NODES):
        step.rows[i, 0], step.rows[i, 1], step.rows[i, 2], step.rows[i, 3] = n_u, n_th, t_u, t_th
    return gap, rate, normal, bound, slip


@inner_kernel
def _separation_level(tables: Tables, run: Run, gap: float, rate: float, normal: float) -> int:
    """Level that walks up to a release instead of stepping over it while the force still matters."""
    level = run.whole[LEVEL]
    if rate > 0.0 and gap < 0.0:
        h = step_length(tables, level)
        small = run.real[TOLERANCE] * run.real[MOMENTUM]
        while h * rate > -0.7 * gap and normal * h > small and level < FINEST - 1:
            level += 1
            h *= 0.5
    return level


@inner_kernel
def _attempt(
    plant: Plant,
    tables: Tables,
    step: Step,
    run: Run,
    level: int,
    normal: float,
    bound: float,
    force: PenaltyKernel,
    parameters: Array,
) -> float:
    """Solve a step at a level; returns its error over the tolerance, infinite where it cannot stand.

    The error is what the force polynomial misses of the known force at the step's start, as an
    impulse; friction that sticks has no known start and is judged by its highest coefficient. A step
    in which the gap opens carries a kink, and stands only when the whole force left is negligible.
    """
    build_level(plant, tables, level)
    prepare(plant, tables, step, level)
    mode, sign = run.whole[MODE], float(run.whole[SIGN])
    for i in range(NODES):
        step.force[NORMAL, i] = normal
        step.force[FRICTION, i] = -sign * bound if mode == SLIP else step.force[FRICTION, i]
        push_node(step, i)
    momentum = run.real[MOMENTUM]
    sweeps = collocate(plant, tables, step, level, mode, sign, force, parameters, momentum)
    run.whole[SWEEPS] += sweeps
    if sweeps == 0:
        return np.inf
    h = step_length(tables, level)
    allowed = run.real[TOLERANCE] * momentum
    if largest(step.gap) >= 0.0:
        return 0.5 if normal * h <= allowed else np.inf
    error = abs(step.shape[NORMAL, 0] - normal)
    if mode == STICK:
        error = max(error, 0.1 * abs(step.shape[FRICTION, NODES - 1]))
    return error * h / allowed


@inner_kernel
def _following_level(tables: Tables, level: int, error: float) -> int:
    """Level of the next step: the error falls as h^(NODES + 1)."""
    growth = 2.0 ** (NODES + 1)
    for _ in range(2):
        if level > tables.contact_level and 2.0 * error * growth < 1.0:
            level -= 1
            error *= growth
    return level


@inner_kernel
def _contradicted(step: Step, run: Run, slip: float) -> bool:
    """Whether the step denies its own friction mode from its start; the other mode is then set.

    Stick whose friction leaves the cone at once must slip against it; slip that starts from
    zero into the wrong direction must stick.
    """
    if run.whole[MODE] == STICK:
        bound = step.force[BOUND, 0]
        friction = step.force[FRICTION, 0]
        if abs(friction) > bound * (1.0 + CONE_ROUND_OFF) and (
            force_at(step, BOUND, 0.0) <= abs(force_at(step, FRICTION, 0.0))
        ):
            run.whole[MODE] = SLIP
            run.whole[SIGN] = -1 if friction > 0.0 else 1
            _count_switch(run)
            return True
        return False
    sign = run.whole[SIGN]
    if largest(step.force[BOUND]) > 0.0 and sign * step.slip[0] < 0.0 and sign * slip <= SLIP_ROUND_OFF:
        run.whole[MODE] = STICK
        _count_switch(run)
        return True
    return False


@inner_kernel
def _first_event(
    plant: Plant, tables: Tables, step: Step, run: Run, gap: float, slip: float, h: float
) -> tuple[int, float]:
    """The earliest event in the step and its time, or NO_EVENT and the step's length."""
    first = NO_EVENT
    s = h
    left = 0.0
    sticks = run.whole[MODE] == STICK
    rubs = largest(step.force[BOUND]) > 0.0
    for i in range(NODES):
        right = tables.nodes[i] * h
        if step.gap[i] >= 0.0:
            at = locate(plant, step, h, RELEASE, left, right) if gap < 0.0 else 0.0
            first, s = (RELEASE, at) if at < s else (first, s)
        if rubs and not sticks and run.whole[SIGN] * step.slip[i] < 0.0:
            at = locate(plant, step, h, REVERSAL, left, right)
            first, s = (REVERSAL, at) if at < s else (first, s)
        excess = abs(step.force[FRICTION, i]) - step.force[BOUND, i] * (1.0 + CONE_ROUND_OFF)
        if sticks and excess > 0.0:
            at = locate(plant, step, h, CONE, left, right)
            first, s = (CONE, at) if at < s else (first, s)
        if first != NO_EVENT:
            break
        left = right
    return first, s


@inner_kernel
def _track_extremes(
    plant: Plant, tables: Tables, step: Step, run: Run, rate: float, s: float, h: float
) -> None:
    """Largest normal force and penetration of the contact so far, between the nodes as well."""
    closing = rate < 0.0
    left = 0.0
    for i in range(NODES):
        right = tables.nodes[i] * h
        if right > s:
            break
        run.contact[PEAK] = max(run.contact[PEAK], step.force[NORMAL, i])
        run.contact[DEPTH] = max(run.contact[DEPTH], -step.gap[i])
        if closing and step.gap_rate[i] >= 0.0:
            at = locate(plant, step, h, DEEPEST, left, right)
            flow_to(plant, step, at, h, COLLOCATED)
            u, th, _, _, _ = tip_motion(plant, step.other_q, step.other_v)
            gap = contact_frame(u, th, plant.tip_length, plant.radius, plant.clearance)[0]
            run.contact[DEPTH] = max(run.contact[DEPTH], -gap)
        closing = step.gap_rate[i] < 0.0
        left = right
    _track_peak(step, run, s / h)


@inner_kernel
def _track_peak(step: Step, run: Run, end: float) -> None:
    """Largest normal force from the zero of its polynomial's slope on [0, end], if it has one."""
    left, right = 0.0, end
    if not (_slope(step, left) > 0.0 > _slope(step, right)):
        return
    for _ in range(60):
        middle = 0.5 * (left + right)
        if _slope(step, middle) > 0.0:
            left = middle
        else:
            right = middle
    run.contact[PEAK] = max(run.contact[PEAK], force_at(step, NORMAL, left))


@inner_kernel
def _slope(step: Step, x: float) -> float:
    """Derivative of the normal force polynomial at x = s/h."""
    total = 0.0
    for d in range(NODES - 1, 0, -1):
        total = total * x + d * step.shape[NORMAL, d]
    return total
