"""The memory of a run and what every committed step does to it: time, state, ledger, records, contacts."""

from math import sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.ledger import (
    FRICTION_IMPULSE,
    FRICTIONAL,
    NORMAL_IMPULSE,
    NORMAL_LOSS,
    TERMS,
    increments_of_step,
    increments_until,
)
from contactlab.engine.plant import Plant
from contactlab.engine.step import (
    CLOSING,
    COLLOCATED,
    KIND,
    LENGTH,
    MEMORY,
    MODE,
    RUBBING,
    TAKEN,
    Step,
    memory_at,
    tip_motion,
)
from contactlab.engine.tables import Tables, step_length
from contactlab.laws.base import FREE, SET_VALUED, STICK, FrictionKernel, PenaltyKernel
from contactlab.motor.geometry import contact_frame
from contactlab.variables import CONTACTS, SERIES

(
    TIME,
    END,
    INTERVAL,
    WINDOW,
    WINDOW_START,
    MOMENTUM,
    NORMAL_BEFORE,
    FRICTION_BEFORE,
    TOLERANCE,
    HELD_ENERGY,
    LEAST_OPEN,
    MOST_OPEN,
    TURNED_OVER,
    FRICTION_LIMIT,
    CRITICAL_FRICTION,
) = range(15)
"""Places in `Run.real`: time, its end, record interval, the window of the pace and its start [s], the
contact's impulse scale [N s], forces of the step before [N], tolerance of a compliant step [1], what a
spring of the friction holds at the last record [J], of the ledger, see `balance`, the least and the most
that its terms left so far and the largest work of drive or load [J], the largest |F|/N that the law allows
and the one from which on a rigid contact may have several solutions or none, d_nn/|d_nt| of the last
step [1]."""

(
    PHASE,
    SIGN,
    LEVEL,
    LEVEL_BEFORE,
    RECORDED,
    STORED,
    ENDING,
    EVENTS,
    IDLE,
    PROJECTS,
    MOST_STEPS,
    STEPS_BEFORE,
) = range(12)
"""Places in `Run.whole`: phase, slip direction, level of the next step and of the one before, records
and contacts written, ending, events in the window, steps without progress, whether a rigid law puts
displacements back onto the closed gap, the most steps in contact that a window may take and those taken
before it; the counts follow."""

FLIGHT_STEPS, CONTACT_STEPS, REJECTED_STEPS, SWEEPS, TOUCHDOWNS, SWITCHES, WEDGED = range(12, 19)
COUNTS = (
    "flight_steps",
    "contact_steps",
    "rejected_steps",
    "sweeps",
    "touchdowns",
    "friction_switches",
    "wedged_steps",
)

RELEASED, SEPARATING, OPEN, TOUCHING, PRESSED = range(5)
"""Phases. RELEASED is the instant after a contact, SEPARATING open but not yet clear of it; PRESSED is a
start in contact, or on the point of it."""

RUNNING, DIVERGED, UNSOLVED, CHATTERED, UNFOLLOWED, STALLED, NOT_FINITE, INCONSISTENT = range(8)
"""Endings as the kernels know them: no motor's state any more, no step that satisfies the law, too many
events, a touch-down that cannot be searched, too many steps, a law that answered with no number, and one
that has no impulse for a contact that closes."""

START, DURATION, STUCK, IMPULSE, FRICTIONAL_IMPULSE, PEAK, DEPTH, APPROACH, SEPARATION, LOSS = (
    range(len(CONTACTS))
)
"""Columns of a contact, in the order of `variables.CONTACTS`."""

EVENT_LIMIT = 1000
"""Touch-downs and friction switches within one window that count as chattering."""

IDLE_LIMIT = 1000
"""Steps in a row that hardly move the clock."""

IDLE_EVENTS = 100
"""Events in the window from which on such steps are those of chattering, and not of a law that stalls."""

CRAWL = 1e-9
"""Step over the longest one in contact that counts as none: at this pace no run reaches its end."""


class Run(NamedTuple):
    """Memory of a run.

    Args:
        real, whole: scalars, see the places above.
        total: ledger terms and impulses since the start, shape (term,).
        step_terms, part_terms: the same over one step and a part of one.
        contact: the contact that is going on, shape (column,).
        series: records, columns of `variables.SERIES`; the force columns hold impulses since the
            start until the run is read.
        modes: contact mode of each record.
        contacts: finished contacts that are not yet collected, shape (row, column).
        stack: scratch of the touch-down search.
    """

    real: Array
    whole: NDArray[np.int64]
    total: Array
    step_terms: Array
    part_terms: Array
    contact: Array
    series: Array
    modes: NDArray[np.int8]
    contacts: Array
    stack: Array


def run_for(records: int, contact_rows: int = 512) -> Run:
    """Zeroed memory for a number of records, and for the contacts between two calls of the loop."""
    return Run(
        real=np.zeros(15),
        whole=np.zeros(12 + len(COUNTS), dtype=np.int64),
        total=np.zeros(len(TERMS)),
        step_terms=np.zeros(len(TERMS)),
        part_terms=np.zeros(len(TERMS)),
        contact=np.zeros(len(CONTACTS)),
        # By columns, which leave the run one by one, without a copy.
        series=np.zeros((records, len(SERIES)), order="F"),
        modes=np.zeros(records, dtype=np.int8),
        contacts=np.zeros((contact_rows, len(CONTACTS))),
        stack=np.zeros((96, 3)),
    )


@part_kernel
def record_time(run: Run, index: int) -> float:
    """Time of a record [s]; the last one lies at the end of the run."""
    if index >= run.series.shape[0] - 1:
        return float(run.real[END])
    return float(index * run.real[INTERVAL])


@inner_kernel
def write_record(
    plant: Plant,
    step: Step,
    run: Run,
    s: float,
    force: PenaltyKernel,
    rub: FrictionKernel,
    parameters: Array,
) -> None:
    """Write the next record, at time s of the step.

    The state there is in other_q and other_v, the ledger terms since the step's start in part_terms.
    """
    q, v, part = step.other_q, step.other_v, run.part_terms
    index = run.whole[RECORDED]
    u, th, u_rate, th_rate, rotor = tip_motion(plant, q, v)
    gap, n_u, n_th, t_u, t_th = contact_frame(
        u, th, plant.tip_length, plant.radius, plant.clearance
    )
    slip = t_u * u_rate + t_th * th_rate + rotor
    stored = 0.0
    held = 0.0
    if step.whole[KIND] == COLLOCATED and gap < 0.0:
        rate = n_u * u_rate + n_th * th_rate
        normal, _, stored, _ = force(gap, rate, slip, step.real[CLOSING], parameters)
        if step.whole[RUBBING] != SET_VALUED:
            memory = memory_at(step, s / step.real[LENGTH])
            held = rub(gap, rate, slip, normal, memory, parameters)[2]
    kinetic = 0.0
    strain = 0.0
    angle = 0.0
    for j in range(q.size):
        kinetic += 0.5 * v[j] * v[j]
        strain += 0.5 * plant.stiffness[j] * q[j] * q[j]
        angle -= plant.row_r[j] * q[j] / plant.radius
    row = run.series[index]
    row[0], row[1], row[2] = u, -plant.tip_length * sin(th), th
    row[3], row[4], row[5], row[6] = gap, slip, -rotor / plant.radius, angle
    row[7] = run.total[NORMAL_IMPULSE] + part[NORMAL_IMPULSE]
    row[8] = run.total[FRICTION_IMPULSE] + part[FRICTION_IMPULSE]
    row[9], row[10], row[11] = kinetic, strain, stored + held
    for term in range(NORMAL_IMPULSE):
        row[12 + term] = run.total[term] + part[term]
    row[12 + FRICTIONAL] -= held
    run.real[HELD_ENERGY] = held
    run.modes[index] = step.whole[MODE]
    run.whole[RECORDED] = index + 1


@part_kernel
def commit(
    plant: Plant,
    tables: Tables,
    step: Step,
    run: Run,
    force: PenaltyKernel,
    rub: FrictionKernel,
    parameters: Array,
) -> None:
    """Accept the taken part of a step: ledger, records, contact sums, clock and state."""
    s = step.real[TAKEN]
    if s == step.real[LENGTH]:
        increments_of_step(plant, tables, step, run.step_terms)
    else:
        increments_until(plant, tables, step, s, force, parameters, run.step_terms)
        for j in range(step.q.size):
            step.node_q[-1, j] = step.other_q[j]
            step.node_v[-1, j] = step.other_v[j]
    start = run.real[TIME]
    # The step that reaches the end of the run must land on it, whatever start + s rounds to.
    now = run.real[END] if run.real[END] - start <= s else start + s
    while run.whole[RECORDED] < run.series.shape[0]:
        due = record_time(run, run.whole[RECORDED])
        if due > now:
            break
        at = min(due - start, s)
        increments_until(plant, tables, step, at, force, parameters, run.part_terms)
        write_record(plant, step, run, at, force, rub, parameters)
    for term in range(run.total.size):
        run.total[term] += run.step_terms[term]
    if step.whole[MODE] != FREE:
        run.contact[DURATION] += s
        run.contact[STUCK] += s if step.whole[MODE] == STICK else 0.0
        run.contact[IMPULSE] += run.step_terms[NORMAL_IMPULSE]
        run.contact[FRICTIONAL_IMPULSE] += run.step_terms[FRICTION_IMPULSE]
        run.contact[LOSS] += run.step_terms[FRICTIONAL] + run.step_terms[NORMAL_LOSS]
    run.real[TIME] = now
    _watch_pace(tables, run, s)
    if step.whole[KIND] == COLLOCATED and step.whole[RUBBING] != SET_VALUED:
        step.real[MEMORY] = memory_at(step, s / step.real[LENGTH])
    for j in range(step.q.size):
        step.q[j] = step.node_q[-1, j]
        step.v[j] = step.node_v[-1, j]
    _watch(plant, step, run)


@part_kernel
def _watch_pace(tables: Tables, run: Run, s: float) -> None:
    """End a run that hardly moves the clock, after a step of s."""
    crawls = s < CRAWL * step_length(tables, tables.contact_level)
    run.whole[IDLE] = run.whole[IDLE] + 1 if crawls else 0
    steps = run.whole[CONTACT_STEPS] + run.whole[REJECTED_STEPS]
    if run.whole[IDLE] > IDLE_LIMIT:
        run.whole[ENDING] = CHATTERED if run.whole[EVENTS] > IDLE_EVENTS else STALLED
    elif run.real[TIME] - run.real[WINDOW_START] > run.real[WINDOW]:
        run.real[WINDOW_START] = run.real[TIME]
        run.whole[EVENTS] = 0
        run.whole[STEPS_BEFORE] = steps
    elif steps - run.whole[STEPS_BEFORE] > run.whole[MOST_STEPS]:
        run.whole[ENDING] = STALLED


@part_kernel
def _watch(plant: Plant, step: Step, run: Run) -> None:
    """End a run whose state is no longer a motor's: not finite, or deep inside the rotor."""
    u, th, u_rate, th_rate, rotor = tip_motion(plant, step.q, step.v)
    gap = contact_frame(u, th, plant.tip_length, plant.radius, plant.clearance)[0]
    finite = np.isfinite(u_rate) and np.isfinite(th_rate) and np.isfinite(rotor)
    if not (finite and abs(th) < 1.0 and gap > -0.1 * plant.radius):
        run.whole[ENDING] = DIVERGED
