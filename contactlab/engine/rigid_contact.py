"""One step of a rigid contact: the paper's predictor and index-2 corrector around the exact flow.

    predict   the impulse that ends the step without gap rate (eqs. 50-51), and the displacement
              that the exact flow under drive and this constant force reaches (eq. 49)
    correct   the displacement onto the constraint along its gradient (eq. 57), and at the corrected
              place the impulse that leaves no gap rate (eqs. 58-59)

The paper takes backward Euler for the whole step; here the linear part is exact and only the contact
force is held over the step, which keeps the order (one) and any stiff or overdamped mode stable.

A law that does not project is stepped as by Moreau and Jean: no displacement is corrected, the impulse is
the law's at the place that the step would reach without contact, and a contact has steps without
impulse until the gap is open.
"""

from math import inf

from contactlab.arrays import Array
from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.events import NOTHING, RELEASE
from contactlab.engine.nodes import add_held, add_held_rates, free_response
from contactlab.engine.plant import Plant
from contactlab.engine.run import (
    CONTACT_STEPS,
    CRITICAL_FRICTION,
    DEPTH,
    DURATION,
    END,
    ENDING,
    FRICTION_BEFORE,
    FRICTION_LIMIT,
    INCONSISTENT,
    LEVEL,
    NORMAL_BEFORE,
    PEAK,
    PROJECTS,
    TIME,
    WEDGED,
    Run,
)
from contactlab.engine.step import (
    FRICTION,
    HELD,
    KIND,
    LENGTH,
    MODE,
    NORMAL,
    PUSH_TH,
    PUSH_U,
    TAKEN,
    Step,
    hold_forces,
    tip_motion,
)
from contactlab.engine.tables import NODES, Tables, build_level, level_count, step_length
from contactlab.laws.base import SLIP, MultiplierKernel
from contactlab.laws.lagrange_stick import wedges
from contactlab.motor.geometry import contact_frame

NONE, ONE, SEVERAL = range(3)
"""How many answers the step of a law has; what is none and what are several see `wedges`."""

ROUND_OFF = 1e-12
"""Of a gap rate, relative to the rates at the contact."""


@part_kernel
def hold_contact(
    plant: Plant,
    tables: Tables,
    step: Step,
    run: Run,
    solve: MultiplierKernel,
    parameters: Array,
) -> int:
    """Take a step that `begin` made ready through rigid contact; returns RELEASE or NOTHING.

    A contact that approaches and for which the law has no impulse ends the run as INCONSISTENT.
    """
    level = run.whole[LEVEL]
    projects = run.whole[PROJECTS] != 0
    step.whole[KIND] = HELD
    gap, gap_rate, slip = _turn_frame(plant, step, step.q, step.v)
    run.contact[DEPTH] = max(run.contact[DEPTH], -gap)
    impact = run.contact[DURATION] == 0.0
    rates = (gap_rate, slip)
    p_n, p_t, mode, count = _attempt(plant, tables, step, run, level, rates, solve, parameters)
    # Over a long step a graze seems to open by itself; the approach it began with must still be met.
    while impact and gap_rate < 0.0 and p_n <= 0.0 and level < level_count(tables) - 1:
        level += 1
        p_n, p_t, mode, count = _attempt(plant, tables, step, run, level, rates, solve, parameters)
    if count == NONE:
        run.whole[ENDING] = INCONSISTENT
        _hold(step, 0.0, 0.0)
        step.real[TAKEN] = 0.0
        return NOTHING
    run.whole[WEDGED] += 1 if count == SEVERAL else 0
    h = step.real[LENGTH]
    if p_n <= 0.0 and (projects or gap > 0.0):
        _shorten_to_release(step, run, p_n / h)
        return RELEASE
    if p_n <= 0.0:
        # The gap is closed still and opens by itself.
        p_n, p_t, mode = 0.0, 0.0, SLIP
    _hold(step, p_n / h, p_t / h)
    if not projects:
        add_held(plant, tables, step, level, NODES - 1)
    add_held_rates(plant, tables, step, level)
    step.real[TAKEN] = min(h, run.real[END] - run.real[TIME])
    step.whole[MODE] = mode
    run.contact[PEAK] = max(run.contact[PEAK], p_n / h)
    # An impact's force says nothing about the one at which the contact will open. A release that finds
    # the gap open is not looked for at all: no force before means at once.
    lasts = projects and not impact
    run.real[NORMAL_BEFORE] = p_n / h if lasts else 0.0
    run.real[FRICTION_BEFORE] = p_t / h if lasts else 0.0
    run.whole[CONTACT_STEPS] += 1
    return NOTHING


@part_kernel
def _attempt(
    plant: Plant,
    tables: Tables,
    step: Step,
    run: Run,
    level: int,
    start: tuple[float, float],
    solve: MultiplierKernel,
    parameters: Array,
) -> tuple[float, float, int, int]:
    """Predict and correct a step of a level; impulses, mode and how many there are at the corrected place.

    Args:
        plant, tables, step, run, level: the step; its displacements end corrected, where the law
            projects, its rates without contact.
        start: gap rate and slip of its start [m/s].
        solve, parameters: the law.
    """
    build_level(plant, tables, level)
    h = step_length(tables, level)
    step.real[LENGTH] = h
    last = NODES - 1
    _turn_frame(plant, step, step.q, step.v)
    free_response(plant, tables, step, level, last)
    _, _, u_rate, th_rate, rotor = tip_motion(plant, step.node_q[last], step.node_v[last])
    rates = (u_rate, th_rate, rotor, start[0], start[1])
    if run.whole[PROJECTS] == 0:
        _turn_frame(plant, step, step.node_q[last], step.v)
        return _impulse(plant, tables, step, run, level, rates, solve, parameters)
    p_n, p_t, _, _ = _impulse(plant, tables, step, run, level, rates, solve, parameters)
    _hold(step, max(p_n, 0.0) / h, p_t / h if p_n > 0.0 else 0.0)
    add_held(plant, tables, step, level, last)
    _project(plant, step, step.node_q[last])
    _turn_frame(plant, step, step.node_q[last], step.v)
    return _impulse(plant, tables, step, run, level, rates, solve, parameters)


@inner_kernel
def _turn_frame(plant: Plant, step: Step, q: Array, v: Array) -> tuple[float, float, float]:
    """Set the directions of the step's contact from displacements q.

    Returns:
        gap [m], gap rate and slip of rates v [m/s].
    """
    u, th, u_rate, th_rate, rotor = tip_motion(plant, q, v)
    gap, n_u, n_th, t_u, t_th = contact_frame(
        u, th, plant.tip_length, plant.radius, plant.clearance
    )
    step.frame[0], step.frame[1], step.frame[2], step.frame[3] = n_u, n_th, t_u, t_th
    return gap, n_u * u_rate + n_th * th_rate, t_u * u_rate + t_th * th_rate + rotor


@inner_kernel
def _impulse(
    plant: Plant,
    tables: Tables,
    step: Step,
    run: Run,
    level: int,
    rates: tuple[float, float, float, float, float],
    solve: MultiplierKernel,
    parameters: Array,
) -> tuple[float, float, int, int]:
    """The law's impulses in the step's directions, their mode, and whether they are the only ones.

    Args:
        plant, tables, step, run, level: the step.
        rates: those of u, th and the rotor at its end without contact, gap rate and slip at its start.
        solve, parameters: the law.

    The Delassus matrix is that of a force held over the step: int w(s) ds / h in place of 1/m.
    """
    n_u, n_th, t_u, t_th = step.frame[0], step.frame[1], step.frame[2], step.frame[3]
    u_rate, th_rate, rotor, gap_rate, slip = rates
    h = step_length(tables, level)
    nn, nt, tt = 0.0, 0.0, 0.0
    for j in range(plant.stiffness.size):
        normal = n_u * plant.row_u[j] + n_th * plant.row_th[j]
        tangential = t_u * plant.row_u[j] + t_th * plant.row_th[j] + plant.row_r[j]
        mobility = tables.hold[level, NODES - 1, 1, j] / h
        nn += mobility * normal * normal
        nt += mobility * normal * tangential
        tt += mobility * tangential * tangential
    normal_rate = n_u * u_rate + n_th * th_rate
    tangential_rate = t_u * u_rate + t_th * th_rate + rotor
    p_n, p_t, mode = solve(normal_rate, tangential_rate, gap_rate, slip, nn, nt, tt, parameters)
    limit = run.real[FRICTION_LIMIT]
    run.real[CRITICAL_FRICTION] = nn / abs(nt) if nt != 0.0 else inf
    round_off = ROUND_OFF * max(abs(gap_rate), abs(slip), abs(tangential_rate))
    count = ONE
    if p_n <= 0.0 and normal_rate < -round_off:
        count = NONE
    elif wedges(normal_rate, tangential_rate, nn, nt, tt, limit):
        count = SEVERAL
    return p_n, p_t, mode, count


@inner_kernel
def _hold(step: Step, normal: float, friction: float) -> None:
    """Hold forces [N] along the step's directions."""
    step.force[NORMAL, 0] = normal
    step.force[FRICTION, 0] = friction
    step.force[PUSH_U, 0] = normal * step.frame[0] + friction * step.frame[2]
    step.force[PUSH_TH, 0] = normal * step.frame[1] + friction * step.frame[3]
    hold_forces(step)


@inner_kernel
def _project(plant: Plant, step: Step, q: Array) -> None:
    """Move displacements onto the closed gap along its gradient, in the metric of the masses (eq. 57)."""
    gap, _, _ = _turn_frame(plant, step, q, step.v)
    gradient = 0.0
    for j in range(q.size):
        gradient += (step.frame[0] * plant.row_u[j] + step.frame[1] * plant.row_th[j]) ** 2
    for j in range(q.size):
        q[j] -= gap / gradient * (step.frame[0] * plant.row_u[j] + step.frame[1] * plant.row_th[j])


@part_kernel
def _shorten_to_release(step: Step, run: Run, normal: float) -> None:
    """Shorten a step to where the normal force, linear from the step before, reaches zero.

    Args:
        step, run: the step that would have to pull.
        normal: the force it would pull with [N], not positive.
    """
    before = run.real[NORMAL_BEFORE]
    s = step.real[LENGTH] * before / (before - normal) if before > 0.0 else 0.0
    step.real[TAKEN] = min(s, run.real[END] - run.real[TIME])
    step.whole[MODE] = SLIP
    _hold(step, 0.5 * before, 0.5 * run.real[FRICTION_BEFORE])
