"""What every committed step does to a run, time, state, ledger, records and contacts, and how it is read."""

from math import ceil, pi, sin
from typing import Any, Final, cast

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.compiled import inner_kernel, merged_kernel, part_kernel
from contactlab.engine.kinematics import Law, Run, contact_at, contact_of, tip_motion
from contactlab.engine.ledger import (
    add,
    energy_of_motion,
    increments,
    weigh,
)
from contactlab.engine.plant import Plant, motion_rate
from contactlab.engine.propagator import step_length
from contactlab.engine.state import (
    BETWEEN,
    CHATTERED,
    COLLOCATED,
    DIVERGED,
    EVENT_LIMIT,
    LAST,
    STALLED,
    START,
    internal_at,
)
from contactlab.laws.base import FREE, SET_VALUED, STICK
from contactlab.variables import SERIES

PART: Final = cast(bool, np.bool_(False))
"""That a step is not whole, as a flag that no kernel is copied for."""

IDLE_LIMIT = 1000
"""Steps in a row that hardly move the clock."""

IDLE_EVENTS = 100
"""Events in the window from which on such steps are those of chattering, and not of a law that stalls."""

CRAWL = 1e-9
"""Step over the longest one in contact that counts as none: at this pace no run reaches its end."""

STEP_LIMIT = 20_000
"""Steps in contact, rejected ones included, within the time that the pace of a run is watched over, on top
of twice those of the contact step, see `pace_of`; healthy runs take some 300, or 900 at tight tolerances."""


@merged_kernel
def commit(run: Run, law: Law, series: Any) -> None:
    """Accept the taken part of a step: ledger, records, contact sums, clock and state."""
    state, step, plant = run.state, run.step, run.plant
    s = state.taken
    whole = s == state.length
    increments(run, law, s, whole, step.step_terms)
    if not whole:
        # The records below leave another state there.
        for j in range(plant.mode_count):
            mode = plant.modes[j]
            mode.q[LAST], mode.v[LAST] = mode.q[BETWEEN], mode.v[BETWEEN]
    start = state.time
    # The step that reaches the end of the run must land on it, whatever start + s rounds to.
    now = state.end if state.end - start <= s else start + s
    while state.recorded < series.size:
        # The last record lies at the end of the run.
        due = state.end
        if state.recorded < series.size - 1:
            due = state.origin + (state.first + state.recorded) * state.interval
        if due > now:
            break
        at = max(min(due - start, s), 0.0)
        increments(run, law, at, PART, step.record_terms)
        _write_record(run, law, series, at)
    add(state.total, step.step_terms)
    if state.mode != FREE:
        contact, terms = state.contact, step.step_terms
        contact.duration += s
        contact.stick_duration += s if state.mode == STICK else 0.0
        contact.normal_impulse += terms.normal_impulse
        contact.friction_impulse += terms.friction_impulse
        contact.energy_loss += terms.friction_loss + terms.contact_loss
    state.time = now
    _watch_pace(run, s)
    if step.kind == COLLOCATED and state.friction_kind != SET_VALUED:
        state.internal = internal_at(state, s / state.length)
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        mode.q[START], mode.v[START] = mode.q[LAST], mode.v[LAST]
    _watch(run)
    weigh(run)


@inner_kernel
def _write_record(run: Run, law: Law, series: Any, s: float) -> None:
    """Write the next record, at time s of the step.

    The state there is BETWEEN, the ledger terms since the step's start in record_terms.
    """
    state, lengths = run.state, run.plant.geometry
    total, part = state.total, run.step.record_terms
    tip = tip_motion(run.plant, BETWEEN)
    u, th, _, _, rotor = tip
    gap, rate, slip, _, _, _, _ = contact_of(run.plant, tip)
    stored = 0.0
    held = 0.0
    if run.step.kind == COLLOCATED and gap < 0.0:
        normal, _, stored, _ = law.force(gap, rate, slip, state.impact_speed, law.parameters)
        if state.friction_kind != SET_VALUED:
            internal = internal_at(state, s / state.length)
            held = law.friction(gap, rate, slip, normal, internal, law.parameters)[2]
    angle = 0.0
    for j in range(run.plant.mode_count):
        angle -= run.plant.modes[j].row_r * run.plant.modes[j].q[BETWEEN] / lengths.radius
    row = series[state.recorded]
    row.tip_normal_displacement = u
    row.tip_tangential_displacement = -lengths.tip_length * sin(th)
    row.tip_slope = th
    row.gap, row.slip_velocity = gap, slip
    row.rotor_velocity, row.rotor_angle = -rotor / lengths.radius, angle
    row.normal_force = total.normal_impulse + part.normal_impulse
    row.friction_force = total.friction_impulse + part.friction_impulse
    row.kinetic_energy, row.strain_energy = energy_of_motion(run.plant, BETWEEN)
    row.contact_energy = stored + held
    row.drive_work = total.drive_work + part.drive_work
    row.damping_loss = total.damping_loss + part.damping_loss
    row.friction_loss = total.friction_loss + part.friction_loss - held
    row.contact_loss = total.contact_loss + part.contact_loss
    row.load_work = total.load_work + part.load_work
    row.contact_mode = state.mode
    state.held_energy = held
    state.recorded += 1


@part_kernel
def _watch_pace(run: Run, s: float) -> None:
    """End a run that hardly moves the clock, after a step of s."""
    state = run.state
    crawls = s < CRAWL * step_length(run.propagator, run.propagator.rule.contact_level)
    state.idle = state.idle + 1 if crawls else 0
    steps = state.contact_steps + state.rejected_steps
    if state.idle > IDLE_LIMIT:
        state.ending = CHATTERED if state.events > IDLE_EVENTS else STALLED
    elif state.time - state.window_start > state.window:
        state.window_start = state.time
        state.events = 0
        state.steps_before = steps
    elif steps - state.steps_before > state.most_steps:
        state.ending = STALLED


@part_kernel
def _watch(run: Run) -> None:
    """End a run whose state is no longer a motor's: not finite, or deep inside the rotor."""
    tip = tip_motion(run.plant, START)
    gap = contact_at(run.plant, START)[0]
    finite = np.isfinite(tip[2]) and np.isfinite(tip[3]) and np.isfinite(tip[4])
    if not (finite and abs(tip[1]) < 1.0 and gap > -0.1 * run.plant.geometry.radius):
        run.state.ending = DIVERGED


def pace_of(plant: Plant, end: float, contact_step: float, compliant: bool) -> tuple[float, int]:
    """Give the time that a run is watched over [s], and the steps in contact beyond which it stalls there.

    The time is a period of what makes its contacts. A rigid contact lasts a step at least, and the flight
    after it longer: its window is long enough for an event every fifth step to be chatter, if that is far
    from what a few periods bring. Where nothing has a period, the step alone says what is often. No longer
    than the run: the slowest of modes may be one that hardly has a period.
    """
    rate = motion_rate(plant)
    window = (2.0 if compliant else 5.0) * EVENT_LIMIT * contact_step
    if rate > 0.0:
        period = 2.0 * pi / rate
        window = period if compliant else max(period, min(window, 5.0 * period))
    window = min(window, end)
    return window, STEP_LIMIT + 2 * ceil(window / contact_step)


def record_times(run: Run, series: Any) -> Array:
    """Give the times of the records [s], as the recorder took them."""
    state = run.state
    time = state.origin + (state.first + np.arange(state.recorded)) * state.interval
    if state.recorded == series.size:
        time[-1] = state.end
    return np.asarray(time, dtype=np.float64)


def energy_of(series: dict[str, Array]) -> Array:
    """Give the energy of motor and contact [J] at every record."""
    return series["kinetic_energy"] + series["strain_energy"] + series["contact_energy"]


def take_series(run: Run, table: Any, time: Array) -> tuple[dict[str, Array], NDArray[np.int8]]:
    """Take the records out of a run, by name: its memory, of which a long run has no second one.

    Impulses become mean forces, and the ledger has its residual. A run that goes on from a state begins
    with that state's mean forces, and its residual is that since t = 0.
    """
    state, table = run.state, table[: time.size]
    series: dict[str, Array] = {v.name: table[v.name] for v in SERIES}
    interval = np.diff(time)
    for name in ("normal_force", "friction_force"):
        impulse = series[name]
        impulse[1:] = np.diff(impulse) / interval
        impulse[:1] = state[name]
    energy = energy_of(series)
    if np.isnan(state.initial_energy) and energy.size:
        state.initial_energy = energy[0]
    losses = sum(
        series[name] for name in ("damping_loss", "friction_loss", "contact_loss", "load_work")
    )
    series["energy_residual"][:] = energy - state.initial_energy - (series["drive_work"] - losses)
    return series, table["contact_mode"]
