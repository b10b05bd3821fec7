"""A compliant contact step by step: accuracy, release, and the switches between slip and stick."""

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.collocation import (
    collocate,
    prepare,
)
from contactlab.engine.compliant_events import contradicted, first_event, track_extremes
from contactlab.engine.events import NOTHING
from contactlab.engine.nodes import add_collocated
from contactlab.engine.plant import Plant
from contactlab.engine.run import (
    CONTACT_STEPS,
    DURATION,
    END,
    ENDING,
    LEVEL,
    LEVEL_BEFORE,
    MOMENTUM,
    REJECTED_STEPS,
    SIGN,
    SWEEPS,
    TIME,
    TOLERANCE,
    UNSOLVED,
    Run,
)
from contactlab.engine.state_friction import missed_between, push_node
from contactlab.engine.step import (
    BOUND,
    CLOSING,
    COLLOCATED,
    FRICTION,
    KIND,
    LENGTH,
    MEMORY,
    MEMORY_RATE,
    MODE,
    NORMAL,
    RUBBING,
    TAKEN,
    Step,
    force_at,
    largest,
    tip_motion,
)
from contactlab.engine.tables import FINEST, NODES, Tables, build_level, step_length
from contactlab.geometry import contact_frame
from contactlab.laws.base import CREEPING, SET_VALUED, SLIP, STICK, FrictionKernel, PenaltyKernel

Array = NDArray[np.float64]


@part_kernel
def press(
    plant: Plant,
    tables: Tables,
    step: Step,
    run: Run,
    force: PenaltyKernel,
    rub: FrictionKernel,
    parameters: Array,
) -> int:
    """Take a step that `begin` made ready through compliant contact; returns the event that ends it.

    The mode of the step that follows is set by `switch_friction` once the step is committed.
    """
    step.whole[KIND] = COLLOCATED
    gap, rate, slip, normal, bound, rubbed = _start(plant, step, force, rub, parameters)
    level = _separation_level(tables, run, gap, rate, normal)
    flips = 0
    _guess(step, run, normal, bound, rubbed)
    while True:
        if level >= FINEST:
            run.whole[ENDING] = UNSOLVED
            step.real[TAKEN] = 0.0
            return NOTHING
        error = _attempt(plant, tables, step, run, level, normal, rubbed, force, rub, parameters)
        # A dip that ends before the first node would be left where it begins, still approaching.
        hidden = rate < 0.0 <= step.gap[0] and level < FINEST - 9
        if error > 1.0 or hidden:
            run.whole[REJECTED_STEPS] += 1
            level += 2 if error > 500.0 or hidden else 1
            continue
        if not contradicted(plant, step, run, slip, rub, parameters):
            break
        # Neither slipping nor sticking fits at this length: look closer before trying again.
        flips += 1
        level += 2 * (flips // 2)
    remaining = run.real[END] - run.real[TIME]
    event, s = first_event(plant, tables, step, run, rate, rub, parameters)
    if s > remaining:
        event, s = NOTHING, remaining
    step.real[TAKEN] = s
    track_extremes(plant, tables, step, run, rate)
    if s == step.real[LENGTH]:
        add_collocated(plant, tables, step, level)
    run.whole[CONTACT_STEPS] += 1
    run.whole[LEVEL_BEFORE] = level
    run.whole[LEVEL] = _following_level(tables, level, error)
    return event


@inner_kernel
def _guess(step: Step, run: Run, normal: float, bound: float, rubbed: float) -> None:
    """Make TAKEN the place x = s/h of the step's start on the force polynomial that stands.

    The first attempt continues the step before; every further one starts on its own forerunner, at
    x = 0. Where there is no such step, or a coarser one is to follow, the forces start constant.
    """
    if run.contact[DURATION] > 0.0 and run.whole[LEVEL] >= run.whole[LEVEL_BEFORE]:
        step.real[TAKEN] /= step.real[LENGTH]
        return
    step.real[TAKEN] = 0.0
    for d in range(NODES):
        step.shape[NORMAL, d] = normal if d == 0 else 0.0
        step.shape[BOUND, d] = bound if d == 0 else 0.0
        step.shape[FRICTION, d] = rubbed if d == 0 else 0.0
        step.shape[MEMORY_RATE, d] = 0.0


@part_kernel
def _start(
    plant: Plant,
    step: Step,
    force: PenaltyKernel,
    rub: FrictionKernel,
    parameters: Array,
) -> tuple[float, float, float, float, float, float]:
    """Gap, gap rate, slip, normal force, bound and friction by its memory where the step begins."""
    u, th, u_rate, th_rate, rotor = tip_motion(plant, step.q, step.v)
    gap, n_u, n_th, t_u, t_th = contact_frame(
        u, th, plant.tip_length, plant.radius, plant.clearance
    )
    rate = n_u * u_rate + n_th * th_rate
    slip = t_u * u_rate + t_th * th_rate + rotor
    normal, bound, rubbed = 0.0, 0.0, 0.0
    if gap < 0.0:
        normal, bound, _, _ = force(gap, rate, slip, step.real[CLOSING], parameters)
        if step.whole[RUBBING] != SET_VALUED:
            rubbed = rub(gap, rate, slip, normal, step.real[MEMORY], parameters)[0]
    for i in range(NODES):
        step.rows[i, 0], step.rows[i, 1], step.rows[i, 2], step.rows[i, 3] = n_u, n_th, t_u, t_th
    return gap, rate, slip, normal, bound, rubbed


@part_kernel
def _separation_level(tables: Tables, run: Run, gap: float, rate: float, normal: float) -> int:
    """Level that walks up to a release instead of stepping over it while the force still matters."""
    level = run.whole[LEVEL]
    if rate > 0.0 and gap < 0.0:
        h = step_length(tables, level)
        small = run.real[TOLERANCE] * run.real[MOMENTUM]
        while h * rate > -0.7 * gap and abs(normal) * h > small and level < FINEST - 1:
            level += 1
            h *= 0.5
    return int(level)


@part_kernel
def _attempt(
    plant: Plant,
    tables: Tables,
    step: Step,
    run: Run,
    level: int,
    normal: float,
    rubbed: float,
    force: PenaltyKernel,
    rub: FrictionKernel,
    parameters: Array,
) -> float:
    """Solve a step at a level; returns its error over the tolerance, infinite where it cannot stand.

    The error is what the force polynomial misses of the known force at the step's start, as an
    impulse; friction that sticks has no known start and is judged by its highest coefficient. A step
    in which the gap opens, or the force ends or begins before it, carries a kink, and stands only
    when the whole force left is negligible.
    """
    build_level(plant, tables, level)
    prepare(plant, tables, step, level)
    mode, sign = step.whole[MODE], float(run.whole[SIGN])
    stretch = step_length(tables, level) / step.real[LENGTH]
    step.real[LENGTH] = step_length(tables, level)
    for i in range(NODES):
        x = step.real[TAKEN] + tables.nodes[i] * stretch
        step.force[NORMAL, i] = max(force_at(step, NORMAL, x), 0.0)
        step.force[BOUND, i] = max(force_at(step, BOUND, x), 0.0)
        step.force[FRICTION, i] = force_at(step, FRICTION, x)
        if mode == SLIP:
            step.force[FRICTION, i] = -sign * step.force[BOUND, i]
        # Only friction with a memory reads these.
        step.force[MEMORY_RATE, i] = force_at(step, MEMORY_RATE, x)
        climb = tables.nodes[i] * step.real[LENGTH]
        step.memory[i] = step.real[MEMORY] + climb * step.force[MEMORY_RATE, i]
        push_node(step, i)
    step.real[TAKEN] = 0.0
    momentum = run.real[MOMENTUM]
    sweeps = collocate(plant, tables, step, level, mode, sign, force, rub, parameters, momentum)
    run.whole[SWEEPS] += sweeps
    if sweeps == 0:
        return np.inf
    h = step.real[LENGTH]
    allowed = run.real[TOLERANCE] * momentum
    if largest(step.gap) >= 0.0 or _lifts(step, normal):
        most = max(abs(normal), largest(step.force[NORMAL]))
        return 0.5 if most * h <= allowed else np.inf
    error = abs(step.shape[NORMAL, 0] - normal)
    if step.whole[RUBBING] != SET_VALUED:
        error = max(error, abs(step.shape[FRICTION, 0] - rubbed))
        if step.whole[RUBBING] == CREEPING:
            error = max(error, missed_between(plant, tables, step, rub, parameters))
    if mode == STICK:
        error = max(error, 0.1 * abs(step.shape[FRICTION, NODES - 1]))
    return float(error * h / allowed)


@inner_kernel
def _lifts(step: Step, normal: float) -> bool:
    """Whether a force that only pushes ends or begins within the step, from its value at the start."""
    ends, begins = False, False
    for i in range(NODES):
        ends = ends or (normal > 0.0 and step.force[NORMAL, i] == 0.0)
        begins = begins or (normal == 0.0 and step.force[NORMAL, i] > 0.0)
    return ends or (begins and step.force[NORMAL, 0] == 0.0)


@part_kernel
def _following_level(tables: Tables, level: int, error: float) -> int:
    """Level of the next step: the error falls as h^(NODES + 1)."""
    growth = 2.0 ** (NODES + 1)
    for _ in range(2):
        if level > tables.contact_level and 2.0 * error * growth < 1.0:
            level -= 1
            error *= growth
    return level
