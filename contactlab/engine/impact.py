"""Impacts by themselves: a contact between two bodies of which nothing but a Delassus matrix is known.

A rigid law is evaluated once for each. Under a compliant law two bodies meet that this matrix joins: a free
body of two coordinates q with unit masses, whose contact rows are the Cholesky factor of D,

    gap rate = a qd_0,   slip = b qd_0 + c qd_1,   a = sqrt(D_nn),  b = D_nt / a,  c = sqrt(D_tt - b^2),

over a plate, and the loop of the engine takes it from the touch-down to the release. Each impact has a ladder
of steps of its own, in units of the time that the law's own force needs to stop the approach, so that its
numbers depend neither on the units nor on the other impacts.
"""

from math import sqrt
from typing import Any, Final, cast

import numpy as np

from contactlab.arrays import Array
from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.engine.loop import LoopData
from contactlab.engine.recorder import end_with_forces
from contactlab.engine.rigid import remaining_slip
from contactlab.engine.state import (
    BETWEEN,
    HEAD,
    INCONSISTENT,
    NOT_FINITE,
    RUNNING,
    TOUCHING,
    ImpactBatch,
    Law,
    Memory,
    Records,
    Run,
    record,
)
from contactlab.laws.base import RATE_DEPENDENT, SLIP, STICK
from contactlab.laws.memory import AT_TOUCH

WAY: Final = 1e12
"""Tip length and rotor radius [m] of a plate: a way x along it changes the gap by x^2 / WAY."""

LONGEST: Final = 100.0
"""Time that an impact is watched, in units of its own, see `_time_scale`; an elastic one takes two."""

STEP_SHARE: Final = 0.5
"""Longest step in the same unit."""

HALVINGS: Final = 70
"""Number of halvings, from 1 m, in the search for the penetration that stops the impact."""

NO_END: Final = cast(int, np.int64(2**62))
"""Steps that an impact may take: those of a pace are counted by the engine."""

OUTCOME: Final = record(
    real="normal_rate slip normal_impulse friction_impulse duration stick_duration peak_normal_force "
    "max_penetration",
    whole="mode ending released",
)
"""What became of an impact: gap rate and slip [m/s], impulses [N s], times [s], [N], [m]; how it ended."""

MOMENT: Final = record(real="time normal_force friction_force gap")
"""A record of a history [s], [N], [N], [m]; the forces are means since the one before."""


@inner_kernel
def evaluate_impacts(data: LoopData, impacts: ImpactBatch, law: Law) -> None:
    """Evaluate the kernel of a rigid law for every impact."""
    state = data.states[0]
    run = Run(data.plant[0], data.propagator[0], state, data.step[0])
    for i in range(impacts.outcomes.size):
        contact, outcome = impacts.contacts[i], impacts.outcomes[i]
        for k in range(state.law.variables):
            law.row[HEAD + k] = run.step.memory_first[k]
        _touch(run, state, law, law.memory, contact)
        rate, slip, nn, nt, tt = contact[0], contact[1], contact[2], contact[3], contact[4]
        p_n, p_t = law.impact(rate, slip, nn, nt, tt, law.parameters)
        # Eq. 4.2 with the D of an impulse that takes no time.
        outcome.normal_rate, outcome.slip = rate + nn * p_n + nt * p_t, slip + nt * p_n + tt * p_t
        outcome.normal_impulse, outcome.friction_impulse = p_n, p_t
        outcome.mode = STICK if remaining_slip(slip, p_n, p_t, nt, tt) == 0.0 else SLIP
        outcome.ending, outcome.released = RUNNING, 1
        outcome.peak_normal_force = np.nan
        if not np.isfinite(p_n + p_t):
            _give_up(outcome, NOT_FINITE)
        elif not p_n > 0.0:
            _give_up(outcome, INCONSISTENT)


@part_kernel
def _touch(run: Run, state: Any, law: Law, memory: Memory | None, contact: Array) -> None:
    """Apply the reset map of a touch-down to the internal variables that are recalled."""
    if memory is None:
        return
    for k in range(state.law.variables):
        run.step.memory[BETWEEN, k] = memory.jump(
            k, AT_TOUCH, 0.0, contact[0], contact[1], 0.0, law.parameters
        )
    for k in range(state.law.variables):
        law.row[HEAD + k] = run.step.memory[BETWEEN, k]


@inner_kernel
def _give_up(outcome: Any, ending: int) -> None:
    """Leave no number where there is none."""
    outcome.ending, outcome.mode, outcome.released = ending, 0, 0
    outcome.normal_rate, outcome.slip = np.nan, np.nan
    outcome.normal_impulse, outcome.friction_impulse = np.nan, np.nan
    outcome.duration, outcome.stick_duration = np.nan, np.nan
    outcome.peak_normal_force, outcome.max_penetration = np.nan, np.nan


@inner_kernel
def integrate_impacts(
    data: LoopData, impacts: ImpactBatch, law: Law, run_loop: Any, step: Any, kernels: Any
) -> None:
    """Integrate every impact of a compliant law by the loop and its step in contact.

    The states are a fresh one, and room for that of the impact. Histories may have no record; then `records`
    are not used, else they have two more, and `silent` none.
    """
    states, motions, records = data.states, data.motions, data.records
    run = Run(data.plant[0], data.propagator[0], states[0], data.step[0])
    count = impacts.histories.shape[1]
    for i in range(impacts.outcomes.size):
        contact, outcome, state = impacts.contacts[i], impacts.outcomes[i], states[1]
        # The rows of D's Cholesky factor: u falls with the gap, and the way is -WAY sin(theta).
        a, b, c = _rows(contact)
        first, second = run.plant.modes[0], run.plant.modes[1]
        first.row_u, first.row_th, second.row_th = -a, -b / WAY, -c / WAY
        # Steps in units of this impact's own time: the same law in other units, or a hundred times as slow,
        # has the same steps.
        unit = _time_scale(run, law, contact, states[0].limits.contact_gap)
        _set_ladder(run, STEP_SHARE * unit)
        # One pass tells how long the contact lasts, the other one records it.
        for k in range(2 if count > 0 else 1):
            states[1] = states[0]
            state.end = state.watchdog.window = LONGEST * unit
            # The touch-down, at the gap where contacts of the law begin, without a tangential displacement.
            begins = state.limits.contact_gap
            motions[0, 0, 0], motions[0, 1, 0] = begins / a, contact[0] / a
            motions[0, 0, 1] = -b * motions[0, 0, 0] / c
            motions[0, 1, 1] = (contact[1] - b * motions[0, 1, 0]) / c
            written = Records(impacts.silent, *records[1:])
            if k == 1:
                state.first, state.interval, written = 1, outcome.duration / count, records
            scratch = data.plant, data.propagator, data.step
            each = LoopData(
                *scratch, states[1:], motions, written, data.waves, data.parameters, data.row, NO_END
            )
            run_loop(step, each, *kernels)
            _read(motions, contact, state, outcome)
            if outcome.ending != RUNNING:
                break
        if count > 0:
            _keep(records.series, impacts.histories[i], outcome, contact, motions)


@inner_kernel
def _rows(contact: Array) -> tuple[float, float, float]:
    """Return a, b and c of the module."""
    a = sqrt(contact[2])
    b = contact[3] / a
    return a, b, sqrt(contact[4] - b * b)


@inner_kernel
def _time_scale(run: Run, law: Law, contact: Array, begins: float) -> float:
    """Return a unit of time for an impact [s], sqrt(2 d / (D_nn N)) with the largest force N down to d.

    At the depth d the force at the speed of the approach, times d, is its energy u_n^2 / (2 D_nn).
    """
    for k in range(run.state.law.variables):
        law.row[HEAD + k] = run.step.memory_first[k]
    rate, slip, mobility = contact[0], contact[1], contact[2]
    # Depths doubled from below any contact until the work N d, at the approach's speed, is the energy that
    # the normal impulse has to stop. The force is smaller on the way, which a unit of time may ignore.
    energy, most, before = 0.5 * rate * rate / mobility, 0.0, 0.0
    depth = 0.5**HALVINGS
    for _ in range(HALVINGS):
        normal = law.force(begins - depth, rate, slip, -rate, law.parameters)[0]
        work = normal * depth
        if work >= energy:
            if before > 0.0:
                # Between two depths the work goes as a power of it, so that the unit does not jump.
                back = np.log(work / energy) / np.log(work / before)
                depth, normal = depth * 0.5**back, energy / (depth * 0.5**back)
            most = max(most, normal)
            break
        most, before = max(most, abs(normal)), work
        depth *= 2.0
    return sqrt(2.0 * depth / (mobility * most)) if 0.0 < most < np.inf else -depth / rate


@inner_kernel
def _set_ladder(run: Run, longest: float) -> None:
    """Let the steps be halvings of the longest [s], none of them built yet."""
    rule = run.propagator.rule
    rule.longest = longest
    for k in range(rule.level_count):
        level = run.propagator.levels[k]
        level.length = longest
        longest *= 0.5
        # What the nodes see of all coordinates is summed up as a level is built, so that it begins at zero.
        if level.built == 1:
            level.built = 0
            level.tip_q[:] = 0.0
            level.tip_v[:] = 0.0


@inner_kernel
def _read(motions: Array, contact: Array, state: Any, outcome: Any) -> None:
    """Read what became of the impact."""
    a, b, c = _rows(contact)
    end_with_forces(state)
    v, met = motions[0, 1], state.contact
    # Eq. 1.10 by the rows of the module.
    outcome.normal_rate, outcome.slip = a * v[0], b * v[0] + c * v[1]
    outcome.normal_impulse, outcome.friction_impulse = met.normal_impulse, met.friction_impulse
    outcome.duration, outcome.stick_duration = met.duration, met.stick_duration
    outcome.peak_normal_force, outcome.max_penetration = met.peak_normal_force, met.max_penetration
    outcome.released = 0 if state.phase == TOUCHING else 1
    # It switches from one to the other.
    slips = contact[1] != 0.0 or state.law.friction_kind == RATE_DEPENDENT
    outcome.mode = SLIP if slips == (state.friction_switches % 2 == 0) else STICK
    outcome.ending = state.ending
    if state.ending != RUNNING:
        _give_up(outcome, state.ending)


@inner_kernel
def _keep(series: Any, history: Any, outcome: Any, contact: Array, motions: Array) -> None:
    """Keep a history: the impulses of the records, made mean forces."""
    count = history.size
    interval = outcome.duration / count
    normal, friction = 0.0, 0.0
    for r in range(count):
        moment = history[r]
        if outcome.ending != RUNNING:
            moment.time, moment.gap = np.nan, np.nan
            moment.normal_force, moment.friction_force = np.nan, np.nan
            continue
        p_n, p_t = outcome.normal_impulse, outcome.friction_impulse
        gap = _rows(contact)[0] * motions[0, 0, 0]
        if r < count - 1:
            row = series[r]
            p_n, p_t, gap = row.normal_force, row.friction_force, row.gap
        moment.time = (r + 1) * interval
        moment.normal_force, moment.friction_force = (p_n - normal) / interval, (p_t - friction) / interval
        moment.gap = gap
        normal, friction = p_n, p_t
