"""What every committed step does to a run: clock, state, ledger, records and contacts, and how it is read.

Each term of the energy ledger has its own quadrature along the flow:

    drive_work    int sum_j v_j Re sum_k force_jk exp(i omega_k t) dt
    damping_loss  int sum_j c_j v_j^2 dt            resonator and rotor
    friction_loss -int F slip dt                   less what a spring of the friction holds
    contact_loss  int normal loss dt                normal damping; for a rigid law -int N gdot dt
    load_work     -int sum_j a_j v_j dt = int tau Omega dt, and the work against a preload

None is the difference of the others, so that the residual of the ledger measures the solution. The motion of
a step without contact, or under a force that is held, is exact: what its terms miss of its energy is the
error of their quadrature, which is then refined. So it is where a waveform turns faster than every mode, and
where a fast transient is over within the step.
"""

from math import sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.compiler.lanes import fill, load, put, total_of
from contactlab.engine.kinematics import (
    contact_at,
    flow_on,
    flow_to,
    fly,
    rates_in_frame,
    tip_motion,
    wave_force,
)
from contactlab.engine.memory import end_at, memory_at, stored_apart, take_memory
from contactlab.engine.plant import Plant
from contactlab.engine.propagator import BY_RECORD, PART, build_level, lay_flight, step_length
from contactlab.engine.state import (
    BETWEEN,
    BY_FLOW,
    BY_INTERVAL,
    CALMS,
    CHATTERED,
    COLLOCATED,
    DIVERGED,
    FLIGHT,
    HELD,
    LAST,
    NODES,
    STALLED,
    START,
    WHOLE,
    Law,
    Records,
    Run,
    value_at,
)
from contactlab.laws.base import FREE, SET_VALUED, STICK
from contactlab.variables import BEARING, SERIES

IDLE_EVENTS = 100
"""Events in the window from which on such steps are those of chattering, and not of a law that stalls."""

PIECE_STEPS = 20
"""Steps that a piece of a waveform may take beside those of a window: its first and its last are short."""

CRAWL = 1e-9
"""Step over the longest one in contact that counts as none: at this pace no run reaches its end."""

ENDING = 1e-9
"""Share of a step before its end at which forces that have not ended still act."""

HALVINGS = 50
"""Of the part of a step in which the forces of a contact end."""

UNRESOLVED = 1e-6
"""Energy that the terms of an exact step may miss, over what they add up to; more is refined."""

NEGLIGIBLE = 1e-3
"""Share of the motor's energy below which the terms of a step are compared with this share instead: of less,
round-off decides."""

DEEP = 0.1
"""Depth over the rotor's radius at which a motion has diverged [1]."""

PIECES = 256
"""Pieces at most in which the terms of a step are summed."""

Terms = tuple[float, float, float, float, float, float, float]
"""What a stretch of a step adds to a `LEDGER`, in its order [J], [N s]."""

NOTHING_ADDED: Terms = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@part_kernel
def commit(run: Run, law: Law, records: Records) -> None:
    """Accept the taken part of a step: ledger, records, contact sums, clock and state."""
    state, plant = run.state, run.plant
    s = state.accepted_length
    # What has not moved has no motion at nodes: a rigid contact from the start on.
    whole = s == state.length and s > 0.0
    # Nodes of a whole step have their motion already; a part that an event cuts off has nodes of its own.
    if whole and run.step.kind == FLIGHT:
        flown = run.step
        added = flown.flown_drive, flown.flown_damping, 0.0, 0.0, flown.flown_load, 0.0, 0.0
    elif whole and run.step.kind != HELD:
        added = _terms_of_step(run)
    else:
        added = _terms(run, law, 0.0, s, WHOLE if whole else BY_FLOW)
    if not whole:
        # The records below leave another state there.
        for j in range(plant.mode_count):
            mode = plant.modes[j]
            mode.q[LAST], mode.v[LAST] = mode.q[BETWEEN], mode.v[BETWEEN]
    refined = not _is_resolved(run, s, added)
    if refined:
        added = _refined_terms(run, law, 0.0, s)
    start = state.time
    # The step that reaches the end of the run must land on it, whatever start + s rounds to.
    now = state.end if state.end - start <= s else start + s
    if state.piece_end - start == s:
        now = min(state.piece_end, state.end)
    _write_records(run, law, records, s, now, refined)
    _write_forces(run, records, s, now)
    drive, damping, friction, contact, load, p_n, p_t = added
    total = state.total
    total.drive_work += drive
    total.damping_loss += damping
    total.friction_loss += friction
    total.contact_loss += contact
    total.load_work += load
    total.normal_impulse += p_n
    total.friction_impulse += p_t
    if state.mode != FREE:
        _add_to_contact(run, law, s, p_n, p_t, friction + contact)
    state.time = now
    take_memory(run, law, law.memory, s)
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        mode.q[START], mode.v[START] = mode.q[LAST], mode.v[LAST]
    _watch(run, s)
    _note_balance(run)


@part_kernel
def _write_records(run: Run, law: Law, records: Records, s: float, now: float, refined: bool) -> None:
    """Write the records of a step up to its time s, at the time now, its quadrature refined or not."""
    state, start = run.state, run.state.time
    last, terms, index = -1.0, NOTHING_ADDED, state.first + state.record_count
    # A run that goes on repeats a step whose first records another has: it comes by them, to the same bits.
    while state.record_count == 0 and index > 0 and state.origin + (index - 1) * state.interval > start:
        index -= 1
    while state.record_count < records.series.size:
        on_grid = state.origin + index * state.interval
        new = index == state.first + state.record_count
        # The last record lies at the end of the run.
        ends = new and state.record_count == records.series.size - 1
        due = state.end if ends else on_grid
        if due > now:
            break
        at = max(min(due - start, s), 0.0)
        if refined:
            before, since = (NOTHING_ADDED, 0.0) if ends else (terms, max(last, 0.0))
            terms = _sum_of(before, _refined_terms(run, law, since, at))
        else:
            terms = _terms_until(run, law, last, at, due != on_grid, terms)
        if new:
            _write_record(run, law, records, at, terms)
        last = at
        index += 1


@part_kernel
def _write_forces(run: Run, records: Records, s: float, now: float) -> None:
    """Write the forces at the instants in a step up to its time s, at the time now.

    The force polynomial of a step is that of one mode and one sign of the slip. So it is the limit from the
    left at its end, and from the right at its start.
    """
    state, start, index = run.state, run.state.time, records.passed[0]
    # An instant at the boundary of two steps has a limit from each: the force may jump there.
    while start < now and index < records.instants.size and records.instants[index] <= now:
        due, normal, friction = records.instants[index], 0.0, 0.0
        if run.step.kind != FLIGHT:
            x = max(min(due - start, s), 0.0) / state.length
            normal, friction = value_at(state.normal, x), value_at(state.friction, x)
        for limit in range(0 if due > start else 1, 2 if due < now else 1):
            records.forces[index, limit, 0], records.forces[index, limit, 1] = normal, friction
        index += 1
        if due < now:
            records.passed[0] = index


@inner_kernel
def _add_to_contact(run: Run, law: Law, s: float, p_n: float, p_t: float, lost: float) -> None:
    """Add a time [s], impulses [N s] and a loss [J] to the contact; time stepping begins with an impact."""
    state, row = run.state, run.state.contact
    # Time stepping has its impact in the first step, whose force, impulse
    # over step, has no limit.
    if run.step.kind == HELD and row.duration == 0.0:
        row.largest_impact, row.impact_energy_gain = p_n, max(-lost, 0.0)
    acting = _acting_time(run, law, s) if state.law.compliant != 0 else s
    if acting > 0.0:
        state.acting_time = row.duration + acting
        state.acting_stick_time = row.stick_duration + (acting if state.mode == STICK else 0.0)
    row.duration += s
    row.stick_duration += s if state.mode == STICK else 0.0
    row.normal_impulse += p_n
    row.friction_impulse += p_t
    row.energy_loss += lost


@inner_kernel
def _terms_until(run: Run, law: Law, last: float, s: float, apart: bool, before: Terms) -> Terms:
    """Return the terms of a record at time s of the step, whose state is left BETWEEN.

    From the record before, at time `last`, if that lies in this step and has the terms `before`: every step
    begins anew, so that no round-off builds up. The last record of a run may lie `apart` from the grid.
    """
    # The first record in a step is read from its start. Those that follow lie one interval on, whose
    # responses are computed once for the run; a waveform's forces change with every step.
    # As few nodes resolve no longer interval than that.
    longer = run.state.interval > run.propagator.rule.resolved
    if last < 0.0 or apart or longer or run.plant.wave.electrodes > 0:
        return _terms(run, law, 0.0, s, BY_FLOW)
    results, interval = run.propagator.levels[BY_RECORD], run.state.interval
    if results.length != interval:
        results.length, results.built = interval, 0
        build_level(run.plant, run.propagator, BY_RECORD)
    flow_on(run, last)
    added = _terms(run, law, last, interval, BY_INTERVAL)
    return _sum_of(before, added)


@part_kernel
def _sum_of(first: Terms, second: Terms) -> Terms:
    """Return the sum of two stretches' terms."""
    return (
        first[0] + second[0],
        first[1] + second[1],
        first[2] + second[2],
        first[3] + second[3],
        first[4] + second[4],
        first[5] + second[5],
        first[6] + second[6],
    )


@inner_kernel
def _is_resolved(run: Run, s: float, terms: Terms) -> bool:
    """Return whether the terms of a step up to time s explain the change of energy of an exact motion.

    Of a force that is held it is the motion that the force brings, before a projection corrects it.
    """
    step = run.step
    if step.kind == COLLOCATED or s == 0.0:
        return True
    place = LAST
    if step.kind == HELD:
        flow_to(run, s)
        place = BETWEEN
    return _explains(terms, _energy(run.plant, START), _energy(run.plant, place))


@part_kernel
def _energy(plant: Plant, place: int) -> float:
    """Return kinetic and strain energy together [J] at a place."""
    kinetic, strain = _energies(plant, place)
    return kinetic + strain


@part_kernel
def _explains(terms: Terms, before: float, after: float) -> bool:
    """Return whether terms explain that an energy before has become one after [J]."""
    drive, damping, friction, contact, load, _, _ = terms
    # Eq. 6.2 over the step: for an exact motion the remainder is the error of the quadrature (6.3) alone.
    missing = after - before - drive + damping + friction + contact + load
    size = abs(drive) + damping + abs(friction) + abs(contact) + abs(load)
    return bool(abs(missing) <= UNRESOLVED * max(size, NEGLIGIBLE * max(before, after)))


@inner_kernel
def _refined_terms(run: Run, law: Law, start: float, end: float) -> Terms:
    """Sum the terms of an exact step between two times, in pieces halved until each explains its energy.

    The state at the end is left BETWEEN.
    """
    waiting_end, waiting_energy = run.step.wait_time, run.step.wait_gap
    total, waiting, pieces = NOTHING_ADDED, 0, 1
    left, right = start, end
    flow_to(run, left)
    before = _energy(run.plant, BETWEEN)
    flow_to(run, right)
    after = _energy(run.plant, BETWEEN)
    while True:
        added = _terms(run, law, left, right - left, BY_FLOW)
        if pieces < PIECES and waiting < waiting_end.size and not _explains(added, before, after):
            # Halved, the left part first: the right end waits with the energy that is known there.
            waiting_end[waiting], waiting_energy[waiting] = right, after
            waiting += 1
            pieces += 1
            right = 0.5 * (left + right)
            flow_to(run, right)
            after = _energy(run.plant, BETWEEN)
            continue
        total = _sum_of(total, added)
        if waiting == 0:
            break
        waiting -= 1
        left, before = right, after
        right, after = waiting_end[waiting], waiting_energy[waiting]
    flow_to(run, end)
    return total


@inner_kernel
def _write_record(run: Run, law: Law, records: Records, s: float, terms: Terms) -> None:
    """Write the next record, at time s of the step, from its terms and the state BETWEEN."""
    state, lengths, total = run.state, run.plant.geometry, run.state.total
    drive, damping, friction, contact, load, p_n, p_t = terms
    u, th, _, _, rotor = tip_motion(run.plant, BETWEEN)
    gap, rate, slip, _, _, _, _ = contact_at(run.plant, BETWEEN)
    memory_at(run, law, law.memory, s)
    stored, recovered = 0.0, 0.0
    if state.mode == FREE:
        stored = stored_apart(run, law, law.memory)
        contact += state.limits.stored_energy - stored
    if run.step.kind == COLLOCATED:
        # What is stored where the contact ends is lost after this record.
        closed = min(gap, end_at(run, law, law.memory, rate))
        normal, _, _, stored, _ = law.force(closed, rate, slip, state.impact_speed, law.parameters)
        if state.law.friction_kind != SET_VALUED:
            recovered = law.friction(closed, rate, slip, normal, law.parameters)[2]
    # The rotor's angle and its way on a bearing: coordinates beside the tip's.
    angle, lift = 0.0, 0.0
    for j in range(run.plant.mode_count):
        mode = run.plant.modes[j]
        angle -= mode.row_r * mode.q[BETWEEN] / lengths.radius
        lift += mode.row_w * mode.q[BETWEEN]
    row = records.series[state.record_count]
    row.tip_normal_displacement, row.rotor_normal_displacement = u + lift, lift
    row.tip_tangential_displacement = -lengths.tip_length * sin(th)
    row.tip_slope = th
    row.gap, row.slip_velocity = gap, slip
    row.rotor_velocity, row.rotor_angle = -rotor / lengths.radius, angle
    row.normal_force = total.normal_impulse + p_n
    row.friction_force = total.friction_impulse + p_t
    row.kinetic_energy, row.strain_energy = _energies(run.plant, BETWEEN)
    row.contact_energy = stored + recovered
    row.drive_work = total.drive_work + drive
    row.damping_loss = total.damping_loss + damping
    row.friction_loss = total.friction_loss + friction - recovered
    row.contact_loss = total.contact_loss + contact
    row.load_work = total.load_work + load
    row.contact_mode = state.mode
    state.spring_energy = recovered
    for k in range(state.law.variables):
        records.traces[state.record_count, k] = run.step.memory[BETWEEN, k]
    for i in range(len(records.rows)):
        displacement, velocity = 0.0, 0.0
        for j in range(records.rows.shape[1]):
            displacement += records.rows[i, j] * run.plant.modes[j].q[BETWEEN]
            velocity += records.rows[i, j] * run.plant.modes[j].v[BETWEEN]
        for k in range(run.plant.tone_count):
            cosine, sine = run.plant.tones[k].cosine[BETWEEN], run.plant.tones[k].sine[BETWEEN]
            first, second = records.phasors[i, 0, k], records.phasors[i, 1, k]
            displacement += first.real * cosine - first.imag * sine
            velocity += second.real * cosine - second.imag * sine
        records.outputs[state.record_count, i, 0] = displacement
        records.outputs[state.record_count, i, 1] = velocity
    state.record_count += 1


@part_kernel
def _powers(plant: Plant, place: int) -> tuple[float, float, float]:
    """Return the powers of drive, damping and load [W] at a place."""
    drive, damping, load = 0.0, 0.0, 0.0
    for k in range(plant.tone_count):
        # W_d of eq. 6.2: Re(f exp(i omega t)) v, cosine and sine of the tone once for all modes.
        in_phase, quadrature = 0.0, 0.0
        for j in range(plant.mode_count):
            if plant.modes[j].led != 0:
                continue
            v = plant.modes[j].v[place]
            in_phase += plant.phasors[j, k].force_re * v
            quadrature += plant.phasors[j, k].force_im * v
        drive += in_phase * plant.tones[k].cosine[place] - quadrature * plant.tones[k].sine[place]
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        damping += mode.damping * mode.v[place] * mode.v[place]
        load -= mode.constant * mode.v[place]
    return drive, damping, load


@inner_kernel
def _other_power(run: Run, place: int, s: float) -> float:
    """Return the power of the drive [W] but for tones that are forces, at time s of the step and its place.

    A led coordinate takes the power that it does against the contact.
    """
    plant, step, total, x = run.plant, run.step, 0.0, s / run.state.length
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        if mode.led == 0:
            total += wave_force(plant, j, s) * mode.v[place]
        elif step.kind != FLIGHT:
            u, th, r = value_at(step.push_u, x), value_at(step.push_th, x), value_at(step.push_r, x)
            # Its own force is what the contact pushes with, which moves it by nothing.
            total -= (mode.row_u * u + mode.row_th * th + mode.row_r * r) * mode.v[place]
    return total


@inner_kernel
def _terms_of_step(run: Run) -> Terms:
    """Sum the terms over a whole collocated step, see `_terms`."""
    plant, state, step, rule = run.plant, run.state, run.step, run.propagator.rule
    drive, damping, loading = fill(0.0), fill(0.0), fill(0.0)
    # As `_powers`, at all nodes.
    for k in range(plant.tone_count):
        in_phase, quadrature = fill(0.0), fill(0.0)
        for j in range(plant.mode_count):
            if plant.modes[j].led != 0:
                continue
            v = load(plant.modes[j].v)
            in_phase = in_phase + plant.phasors[j, k].force_re * v
            quadrature = quadrature + plant.phasors[j, k].force_im * v
        tone = plant.tones[k]
        drive = drive + (in_phase * load(tone.cosine) - quadrature * load(tone.sine))
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        v = load(mode.v)
        damping = damping + mode.damping * v * v
        loading = loading - mode.constant * v
    if plant.wave.electrodes > 0 or plant.wave.led != 0:
        for i in range(NODES):
            drive = put(drive, i, drive[i] + _other_power(run, i, rule.nodes[i] * state.length))
    weights = load(rule.weights) * state.length
    sums = total_of(weights * drive), total_of(weights * damping), total_of(weights * loading)
    normal, tangential = load(state.normal.node), load(state.friction.node)
    friction = total_of(weights * tangential * load(step.slip))
    contact, p_n, p_t = weights * load(step.loss), weights * normal, weights * tangential
    return sums[0], sums[1], -friction, total_of(contact), sums[2], total_of(p_n), total_of(p_t)


@inner_kernel
def _terms(run: Run, law: Law, start: float, length: float, motion: int) -> Terms:
    """Sum the terms over a length from a start in the step [s], its motion known as WHOLE and others say."""
    state, step, rule = run.state, run.step, run.propagator.rule
    drive, damping, friction, contact, load, p_n, p_t = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    if step.kind == FLIGHT and motion == BY_FLOW:
        lay_flight(run.plant, run.propagator, PART, start, length)
        drive, damping, load = fly(run, PART, BETWEEN)
        # To the same bits as where an event was found.
        flow_to(run, start + length)
        return drive, damping, 0.0, 0.0, load, 0.0, 0.0
    for i in range(NODES):
        # Eq. 6.3: weights b_i of the Radau nodes.
        at, place = start + rule.nodes[i] * length, i
        weight = rule.weights[i] * length
        if motion == BY_FLOW:
            flow_to(run, at)
        if motion == BY_FLOW or (motion == BY_INTERVAL and i == LAST):
            place = BETWEEN
        driving, damped, loading = _powers(run.plant, place)
        if run.plant.wave.electrodes > 0 or run.plant.wave.led != 0:
            driving += _other_power(run, place, at)
        drive += weight * driving
        damping += weight * damped
        load += weight * loading
        if step.kind == FLIGHT:
            continue
        x = at / state.length
        normal, tangential = value_at(state.normal, x), value_at(state.friction, x)
        if step.kind == HELD:
            rate, slip = rates_in_frame(run, place)
            loss = -normal * rate
        else:
            slip = contact_at(run.plant, place)[2]
            loss = _forces_at(run, law, place, at)[4]
        # Friction is the force on the tip: where it opposes the slip, its loss -F v is positive.
        friction -= weight * tangential * slip
        contact += weight * loss
        p_n += weight * normal
        p_t += weight * tangential
    return drive, damping, friction, contact, load, p_n, p_t


@inner_kernel
def _forces_at(run: Run, law: Law, place: int, s: float) -> tuple[float, float, float, float, float]:
    """Return what a compliant law's `force` returns at a place, at time s of the step, zeros without contact.

    Where the step was cut at the release, its last node may be clear of it by round-off.
    """
    state = run.state
    gap, rate, slip, _, _, _, _ = contact_at(run.plant, place)
    memory_at(run, law, law.memory, s)
    if gap >= end_at(run, law, law.memory, rate):
        return 0.0, 0.0, 0.0, 0.0, 0.0
    normal, least, most, stored, loss = law.force(gap, rate, slip, state.impact_speed, law.parameters)
    return normal, least, most, stored, loss


@part_kernel
def end_with_forces(state: Any) -> None:
    """Let the contact end where its forces did, if a damping let go before the gap opened."""
    if 0.0 < state.acting_time < state.contact.duration:
        state.contact.duration, state.contact.stick_duration = state.acting_time, state.acting_stick_time


@inner_kernel
def _acts(run: Run, law: Law, s: float) -> bool:
    """Return whether there are forces at time s of the step."""
    flow_to(run, s)
    normal, least, most, _, _ = _forces_at(run, law, BETWEEN, s)
    return bool(normal != 0.0 or least != 0.0 or most != 0.0)


@inner_kernel
def _acting_time(run: Run, law: Law, s: float) -> float:
    """Return the time in a step, up to s, until which forces act [s].

    A damping may end them while the gap is still closed; the gap rate there is noted.
    """
    state = run.state
    # Before the first node it is as it was.
    left, right = 0.0 if state.acting_time == state.contact.duration else -1.0, s
    for i in range(NODES):
        at = run.propagator.rule.nodes[i] * state.length
        if at > s:
            break
        if state.normal.node[i] != 0.0 or state.bound.node[i] != 0.0 or state.bias.node[i] != 0.0:
            left, right = at, s
        else:
            right = min(right, at)
    if left < 0.0 or left == s:
        return max(left, 0.0)
    if right == s and _acts(run, law, s - ENDING * (s - left)):
        return s
    # Forces act or do not, with nothing that tells how far they are from ending: bisection.
    for _ in range(HALVINGS):
        middle = 0.5 * (left + right)
        if _acts(run, law, middle):
            left = middle
        else:
            right = middle
    flow_to(run, left)
    # Depth and rate vanish together where a damping takes all speed: what is left has any sign.
    state.acting_end_rate = max(contact_at(run.plant, BETWEEN)[1], 0.0)
    return left


@part_kernel
def _energies(plant: Plant, place: int) -> tuple[float, float]:
    """Return kinetic and strain energy [J] at a place; a led coordinate has none."""
    kinetic, strain = 0.0, 0.0
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        if mode.led != 0:
            continue
        kinetic += 0.5 * mode.v[place] * mode.v[place]
        strain += 0.5 * mode.stiffness * mode.q[place] * mode.q[place]
    return kinetic, strain


@part_kernel
def _note_balance(run: Run) -> None:
    """Update the extremes of work and ledger residual after a step; the residual in free flight only."""
    state, total = run.state, run.state.total
    state.turnover = max(state.turnover, abs(total.drive_work), abs(total.load_work))
    if state.mode != FREE:
        return
    # Eq. 6.2 solved for r, less the energy at the start. In contact the law's stored energy is evaluated at
    # records alone.
    kinetic, strain = _energies(run.plant, START)
    left = total.load_work - total.drive_work + total.damping_loss
    left += total.friction_loss + total.contact_loss + kinetic + strain + state.limits.stored_energy
    state.least_remainder = min(state.least_remainder, left)
    state.most_remainder = max(state.most_remainder, left)


@part_kernel
def _watch(run: Run, s: float) -> None:
    """End a run that hardly moves the clock, by a step of s, or is not finite, or deep inside the rotor."""
    state = run.state
    step = step_length(run.propagator, run.propagator.rule.contact_level)
    # Where nothing vibrates the step of a rigid law is the whole run.
    usual = step
    if state.law.compliant == 0 and state.watchdog.longest_quiet > 0.0:
        usual = min(step, state.watchdog.longest_quiet)
    state.watchdog.idle_steps = state.watchdog.idle_steps + 1 if s <= CRAWL * usual else 0
    # A healthy contact takes some hundred steps in a window; one whose steps shrink without end takes them
    # all.
    steps = state.contact_steps + state.rejected_steps
    if state.time == state.piece_end:
        state.watchdog.steps_before = min(steps, state.watchdog.steps_before + PIECE_STEPS)
    # The window of time stepping hangs on the step alone; else intervals shrink where a contact chatters, and
    # the window is at most some times the longest of them.
    calm = max(state.watchdog.longest_quiet, state.time - state.watchdog.last_event, step)
    window = state.watchdog.window
    window = window if state.law.stepped != 0 else min(window, CALMS * calm)
    if state.watchdog.idle_steps > state.watchdog.most_idle:
        state.ending = CHATTERED if state.watchdog.events > IDLE_EVENTS else STALLED
    elif state.time - state.watchdog.start > window:
        state.watchdog.start, state.watchdog.events, state.watchdog.steps_before = state.time, 0, steps
    elif steps - state.watchdog.steps_before > state.watchdog.most_steps:
        state.ending = STALLED
    tip, lengths = tip_motion(run.plant, START), run.plant.geometry
    # No equation here is meant for a motion that overflows, a tip that leans by a radian, as it may between
    # the ends of a step, or one deep inside of the rotor, from which it is as far as it has come from its
    # place at rest.
    finite = np.isfinite(tip[2]) and np.isfinite(tip[3]) and np.isfinite(tip[4])
    deepest = DEEP * lengths.radius
    near = abs(tip[0]) + lengths.tip_length * abs(tip[1]) < deepest + lengths.clearance
    leans = abs(tip[1]) + 0.5 * s * abs(tip[3]) >= 1.0
    if not (finite and not leans and (near or contact_at(run.plant, START)[0] > -deepest)):
        state.ending = DIVERGED


def take_series(run: Run, records: Any) -> tuple[Array, dict[str, Array], NDArray[np.int8]]:
    """Take times [s], series and contact modes out of the records' own memory: a long run has no second one.

    Impulses become mean forces, of which a run that goes on begins with those of its start; the ledger gets
    its residual, since t = 0.
    """
    state, table = run.state, records[: run.state["record_count"]]
    steps = state["first"] + np.arange(table.size, dtype=np.float64)
    time = state["origin"] + steps * state["interval"]
    if table.size == records.size:
        time[-1] = state["end"]
    series: dict[str, Array] = {v.name: table[v.name] for v in (*SERIES, BEARING)}
    lengths = time[1:] - time[:-1]
    for name in ("normal_force", "friction_force"):
        impulse = series[name]
        impulse[1:] = (impulse[1:] - impulse[:-1]) / lengths
        impulse[:1] = state[name]
    energy = series["kinetic_energy"] + series["strain_energy"] + series["contact_energy"]
    losses = sum(series[name] for name in ("damping_loss", "friction_loss", "contact_loss", "load_work"))
    # Eq. 6.2: what has come in, less what is lost or done on the load.
    received = series["drive_work"] - losses
    if np.isnan(state["initial_energy"]) and energy.size:
        # What another motor or law stores where it takes over was there from the start.
        state["initial_energy"] = energy[0] - received[0] - state["energy_residual"]
    series["energy_residual"][:] = energy - state["initial_energy"] - received
    return time, series, table["contact_mode"]
