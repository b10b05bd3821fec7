"""An attempt at a step of a compliant contact: the forces where it begins, its solution and its error."""

import numpy as np

from contactlab.arrays import Array
from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.collocation import collocate, prepare, sound_normal
from contactlab.engine.compliant_events import SLIP_ROUND_OFF
from contactlab.engine.plant import Plant
from contactlab.engine.run import MOMENTUM, SIGN, SWEEPS, TOLERANCE, Run
from contactlab.engine.state_friction import missed_between, mobility, push_node, steepness_of
from contactlab.engine.step import (
    BOUND,
    CLOSING,
    FRICTION,
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
from contactlab.engine.tables import NODES, Tables, build_level, step_length
from contactlab.laws.base import (
    RATE_DEPENDENT,
    SET_VALUED,
    SLIP,
    STICK,
    FrictionKernel,
    PenaltyKernel,
)
from contactlab.motor.geometry import contact_frame

TOUCHED = -1e-22
"""Gap [m] that stands for one just closed: of a force that jumps there, a step begins with the far side."""

KINK = 1e3
"""Error over the tolerance of a step that cannot be judged: it has a kink that is not negligible."""


@part_kernel
def start_motion(plant: Plant, step: Step) -> tuple[float, float, float]:
    """Gap, gap rate and slip where the step begins; its directions stand for those of the nodes."""
    u, th, u_rate, th_rate, rotor = tip_motion(plant, step.q, step.v)
    gap, n_u, n_th, t_u, t_th = contact_frame(
        u, th, plant.tip_length, plant.radius, plant.clearance
    )
    for i in range(NODES):
        step.rows[i, 0], step.rows[i, 1], step.rows[i, 2], step.rows[i, 3] = n_u, n_th, t_u, t_th
    return gap, n_u * u_rate + n_th * th_rate, t_u * u_rate + t_th * th_rate + rotor


@inner_kernel
def start_forces(
    step: Step,
    run: Run,
    gap: float,
    rate: float,
    slip: float,
    force: PenaltyKernel,
    rub: FrictionKernel,
    parameters: Array,
) -> tuple[float, float, float, float]:
    """Normal force, bound in the step's friction mode, friction that is not set-valued and its steepness.

    All of them where the step begins.
    """
    if gap >= 0.0:
        if rate >= 0.0:
            return 0.0, 0.0, 0.0, 0.0
        gap = TOUCHED
    seen = slip
    if step.whole[MODE] == STICK:
        seen = 0.0
    elif step.whole[RUBBING] == SET_VALUED and run.whole[SIGN] * slip < SLIP_ROUND_OFF:
        # Slip that only begins: the law must not take it for stick.
        seen = run.whole[SIGN] * SLIP_ROUND_OFF
    normal, bound, _, _ = force(gap, rate, seen, step.real[CLOSING], parameters)
    normal = sound_normal(normal, bound)
    rubbed, steepness = 0.0, 0.0
    if step.whole[RUBBING] != SET_VALUED:
        rubbed = rub(gap, rate, slip, normal, step.real[MEMORY], parameters)[0]
    if step.whole[RUBBING] == RATE_DEPENDENT:
        steepness = steepness_of(
            gap, rate, slip, normal, step.real[MEMORY], rubbed, rub, parameters
        )
    return normal, bound, rubbed, steepness


@part_kernel
def attempt(
    plant: Plant,
    tables: Tables,
    step: Step,
    run: Run,
    level: int,
    normal: float,
    bound: float,
    rubbed: float,
    steepness: float,
    force: PenaltyKernel,
    rub: FrictionKernel,
    parameters: Array,
) -> float:
    """Solve a step at a level; returns its error over the tolerance, infinite where it has no solution.

    The error is what the polynomials of normal force, bound and friction miss of their known values
    at the step's start, as an impulse; friction that sticks has no known start and is judged by its
    highest coefficient, and of creeping friction counts what no change of the slip makes good. A step
    in which the gap opens, or the force ends or begins before it, carries a kink, and stands only
    when the whole force left is negligible.
    """
    build_level(plant, tables, level)
    prepare(plant, tables, step, level)
    mode, sign = step.whole[MODE], float(run.whole[SIGN])
    stretch = step_length(tables, level) / step.real[LENGTH]
    step.real[LENGTH] = step_length(tables, level)
    momentum = run.real[MOMENTUM]
    stiffness = steepness * mobility(tables, step, level, 0, 0)
    sweeps = 0
    for held in range(
        1 if stiffness > 1.0 else 0, 2 if step.whole[RUBBING] == RATE_DEPENDENT else 1
    ):
        if sweeps == 0:
            _first_forces(tables, step, stretch, mode, sign)
            sweeps = collocate(
                plant, tables, step, level, mode, sign, held == 1, force, rub, parameters, momentum
            )
    step.real[TAKEN] = 0.0
    run.whole[SWEEPS] += sweeps
    if sweeps == 0:
        return np.inf
    h = step.real[LENGTH]
    allowed = run.real[TOLERANCE] * momentum
    if largest(step.gap) >= 0.0 or _lifts(step, normal):
        most = max(abs(normal), abs(rubbed), _most_force(step))
        return 0.5 if most * h <= allowed else KINK
    error = abs(step.shape[NORMAL, 0] - normal)
    if step.whole[RUBBING] != RATE_DEPENDENT:
        error = max(error, abs(step.shape[BOUND, 0] - bound))
    if step.whole[RUBBING] != SET_VALUED:
        error = max(error, abs(step.shape[FRICTION, 0] - rubbed) / (1.0 + stiffness))
        if step.whole[RUBBING] == RATE_DEPENDENT:
            error = max(error, missed_between(plant, tables, step, level, rub, parameters))
    if mode == STICK:
        error = max(error, 0.1 * abs(step.shape[FRICTION, NODES - 1]))
    return float(error * h / allowed)


@inner_kernel
def _first_forces(tables: Tables, step: Step, stretch: float, mode: int, sign: float) -> None:
    """Forces and memory at the nodes from the polynomials that stand, to begin the iteration with."""
    for i in range(NODES):
        x = step.real[TAKEN] + tables.nodes[i] * stretch
        step.force[NORMAL, i] = max(force_at(step, NORMAL, x), 0.0)
        step.force[BOUND, i] = max(force_at(step, BOUND, x), 0.0)
        step.force[FRICTION, i] = force_at(step, FRICTION, x)
        if mode == SLIP and step.whole[RUBBING] != RATE_DEPENDENT:
            step.force[FRICTION, i] = -sign * step.force[BOUND, i]
        # Only friction with a memory reads these.
        step.force[MEMORY_RATE, i] = force_at(step, MEMORY_RATE, x)
        climb = tables.nodes[i] * step.real[LENGTH]
        step.memory[i] = step.real[MEMORY] + climb * step.force[MEMORY_RATE, i]
        push_node(step, i)


@inner_kernel
def _most_force(step: Step) -> float:
    """Largest normal force at a node [N], or friction that no bound ties to it."""
    most = 0.0
    for i in range(NODES):
        most = max(most, abs(step.force[NORMAL, i]))
        if step.whole[RUBBING] == RATE_DEPENDENT:
            most = max(most, abs(step.force[FRICTION, i]))
    return float(most)


@inner_kernel
def _lifts(step: Step, normal: float) -> bool:
    """Whether a force that only pushes ends or begins within the step, from its value at the start."""
    ends, begins = False, False
    for i in range(NODES):
        ends = ends or (normal > 0.0 and step.force[NORMAL, i] == 0.0)
        begins = begins or (normal == 0.0 and step.force[NORMAL, i] > 0.0)
    return ends or (begins and step.force[NORMAL, 0] == 0.0)
