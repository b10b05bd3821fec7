"""Where tip and rotor are: the exact flow under the drive and a polynomial contact force, and the contact.

A step starts at a state (q, v), lasts h and is of one of three kinds, named by the degree of its force
polynomial in s/h: FLIGHT has no force, HELD a constant one, and a COLLOCATED step passes through its
values at the nodes. Whatever its kind, its state can be read anywhere in [0, h].
"""

from math import cos, sin
from typing import Any

import numpy as np

from contactlab.arrays import Array
from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.compiler.lanes import (
    WIDTH,
    Lanes,
    entry,
    fill,
    load,
    load_all,
    put,
    set_entry,
    store,
    total_of,
    total_of_all,
)
from contactlab.engine.oscillator import integrals_of_several, response_from_rest
from contactlab.engine.plant import ORDERS, Plant, modes_of
from contactlab.engine.propagator import BY_RECORD
from contactlab.engine.state import (
    BETWEEN,
    COLLOCATED,
    FLIGHT,
    HELD,
    LAST,
    NODES,
    NOT_FINITE,
    NOTHING,
    RECORDED,
    RUNNING,
    START,
    UNSOLVED,
    Run,
    value_at,
)
from contactlab.motor.geometry import contact_frame

Tip = tuple[float, float, float, float, float]
"""u [m], th [rad], their rates, and -R Omega [m/s]."""

Contact = tuple[float, float, float, float, float, float, float]
"""Gap [m], gap rate, slip [m/s], and the directions n_u, n_th, t_u, t_th of `contact_frame`."""


@part_kernel
def tip_motion(plant: Plant, place: int) -> Tip:
    """Return the tip's motion at a place of the step."""
    # Eq. 1.7: the rows that apply the contact's force read the motion.
    u, th, u_rate, th_rate, rotor = 0.0, 0.0, 0.0, 0.0, 0.0
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        q, v = mode.q[place], mode.v[place]
        u += mode.row_u * q
        th += mode.row_th * q
        u_rate += mode.row_u * v
        th_rate += mode.row_th * v
        rotor += mode.row_r * v
    return u, th, u_rate, th_rate, rotor


@part_kernel
def contact_of(plant: Plant, tip: Tip) -> Contact:
    """Return the contact of a motion of the tip."""
    u, th, u_rate, th_rate, rotor = tip
    of = plant.geometry
    gap, n_u, n_th, t_u, t_th = contact_frame(
        u, th, of.tip_length, of.radius, of.clearance, of.cosine, of.sine
    )
    # Eq. 1.10; positive where the gap opens, and where the tip runs ahead of the rotor's surface.
    rate = n_u * u_rate + n_th * th_rate
    return gap, rate, t_u * u_rate + t_th * th_rate + rotor, n_u, n_th, t_u, t_th


@part_kernel
def tip_motions(plant: Plant) -> tuple[Lanes, Lanes, Lanes, Lanes, Lanes]:
    """Return the tip's motion at all nodes."""
    u, th, u_rate, th_rate, rotor = fill(0.0), fill(0.0), fill(0.0), fill(0.0), fill(0.0)
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        q, v = load(mode.q), load(mode.v)
        u = u + mode.row_u * q
        th = th + mode.row_th * q
        u_rate = u_rate + mode.row_u * v
        th_rate = th_rate + mode.row_th * v
        rotor = rotor + mode.row_r * v
    return u, th, u_rate, th_rate, rotor


@part_kernel
def contact_at(plant: Plant, place: int) -> Contact:
    """Return the contact at a place of the step."""
    return contact_of(plant, tip_motion(plant, place))


def contact_from(plant: Plant, q: Array, v: Array) -> tuple[float, float, float]:
    """Return gap [m], gap rate and slip [m/s] of displacements and rates."""
    return contacts_from(plant, q[None], v[None])[0]


def contacts_from(plant: Plant, q: Array, v: Array) -> list[tuple[float, float, float]]:
    """Return the contacts of many motions, shape (motion, coordinate), see `contact_from`."""
    modes, lengths = modes_of(plant), plant["geometry"].item()
    parts = np.empty((5, *q.shape))
    for part, row, of in zip(parts, ("u", "th", "u", "th", "r"), (q, q, v, v, v), strict=True):
        np.multiply(modes[f"row_{row}"], of, out=part)
    contacts = []
    # Of a row alone or among others, a sum over the last axis is the same to the bit.
    for u, th, u_rate, th_rate, rotor in parts.sum(axis=-1).T.tolist():
        gap, n_u, n_th, t_u, t_th = contact_frame(u, th, *lengths)
        contacts.append((gap, n_u * u_rate + n_th * th_rate, t_u * u_rate + t_th * th_rate + rotor))
    return contacts


@inner_kernel
def contact_after(run: Run, s: float) -> Contact:
    """Return the contact at time s after the start of the step, which `flow_to` leaves BETWEEN."""
    flow_to(run, s)
    return contact_at(run.plant, BETWEEN)


@part_kernel
def rates_in_frame(run: Run, place: int) -> tuple[float, float]:
    """Return gap rate and slip [m/s] at a place, in the directions of the step's first node."""
    step = run.step
    _, _, u_rate, th_rate, rotor = tip_motion(run.plant, place)
    rate = step.n_u[0] * u_rate + step.n_th[0] * th_rate
    return rate, step.t_u[0] * u_rate + step.t_th[0] * th_rate + rotor


@part_kernel
def _turn(tone: Any, origin: int, place: int, cosine: float, sine: float) -> None:
    """Leave at a place cosine and sine of omega t, from those at another and those of omega s in between."""
    # Addition theorems: a cosine of omega t itself, a large angle, is computed once a step.
    tone.cosine[place] = tone.cosine[origin] * cosine - tone.sine[origin] * sine
    tone.sine[place] = tone.cosine[origin] * sine + tone.sine[origin] * cosine


@part_kernel
def _add_steady(plant: Plant, j: int, place: int, q: float, v: float, sign: float) -> tuple[float, float]:
    """Return displacement and rate with a coordinate's steady state at a place, or, by sign -1, without."""
    for k in range(plant.tone_count):
        tone, phasor = plant.tones[k], plant.phasors[j, k]
        cosine, sine = tone.cosine[place], tone.sine[place]
        q += sign * (phasor.steady_re * cosine - phasor.steady_im * sine)
        v -= sign * (tone.omega * (phasor.steady_re * sine + phasor.steady_im * cosine))
    return q, v


@part_kernel
def modal_force(mode: Any, u: float, th: float, rotor: float) -> float:
    """Return what generalised forces along u and th and the rotor's row do to a coordinate that is free."""
    return float(mode.row_u * u + mode.row_th * th + mode.row_r * rotor) if mode.led == 0 else 0.0


@inner_kernel
def _piece_at(run: Run, waves: Array) -> tuple[int, float]:
    """Return the waveform's piece at the step's start and the time since it began [s], and note its end.

    Rows of the waves are those of `contactlab.motor.waveform.Waveform.table`, time first.
    """
    state, wave, count = run.state, run.plant.wave, len(waves)
    clock, turns = state.time + wave.offset, 0.0
    if wave.period > 0.0:
        turns = np.floor((clock - waves[0, 0]) / wave.period) * wave.period
    piece, beyond = 0, count
    # Bisection for the last piece that has begun. A periodic waveform is read within its period.
    while beyond - piece > 1:
        middle = (piece + beyond) // 2
        if waves[middle, 0] <= clock - turns:
            piece = middle
        else:
            beyond = middle
    while True:
        end = np.inf
        if piece + 1 < count:
            end = waves[piece + 1, 0] + turns
        elif wave.period > 0.0:
            end = waves[0, 0] + turns + wave.period
        # A step that ends with a piece comes to this time, which must be the next one's.
        state.piece_end = end - wave.offset
        if state.piece_end > state.time:
            # The silence before a waveform has no beginning.
            begin = waves[piece, 0] + turns
            return piece, max(clock - begin, 0.0) if begin > -np.inf else 0.0
        piece += 1
        if piece == count:
            piece, turns = 0, turns + wave.period


@inner_kernel
def _by_electrodes(plant: Plant, j: int, order: int) -> float:
    """Return the sum over electrodes of coupling times a derivative of the voltage, for a coordinate."""
    total = 0.0
    if order < ORDERS:
        for e in range(plant.wave.electrodes):
            total += plant.couplings[j, e] * plant.wave.derivatives[e, order]
    return total


@inner_kernel
def _follow_wave(run: Run, waves: Array) -> None:
    """Find what the waveform does to every coordinate from the step's start on, where a led one joins it."""
    plant, wave = run.plant, run.plant.wave
    piece, since = _piece_at(run, waves)
    for e in range(wave.electrodes):
        for m in range(ORDERS):
            total, power = 0.0, 1.0
            # Derivatives of the piece's polynomial at the step's start: its Taylor series about there.
            for d in range(m, ORDERS):
                total += waves[piece, 1 + e * ORDERS + d] * power
                power *= since / (d - m + 1)
            wave.derivatives[e, m] = total
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        for m in range(ORDERS):
            # A led coordinate is its path: the force that takes it along is the path's acceleration, two
            # orders on.
            plant.forces[j, m] = _by_electrodes(plant, j, m if mode.led == 0 else m + 2)
        if mode.led != 0:
            mode.free_q, mode.free_v = _by_electrodes(plant, j, 0), _by_electrodes(plant, j, 1)
            mode.q[START] += mode.free_q
            mode.v[START] += mode.free_v


@inner_kernel
def wave_force(plant: Plant, j: int, s: float) -> float:
    """Return the force of the waveform on a coordinate, a time s after the start of the step."""
    force, power = 0.0, 1.0
    for m in range(ORDERS):
        force += plant.forces[j, m] * power
        power *= s / (m + 1)
    return force


@part_kernel
def begin(run: Run, waves: Array) -> None:
    """Split the state at the step's start into steady state and free motion.

    A nearly resonant pair has no steady state here: its mode is free and answers its tone from rest, as every
    mode answers a waveform. A led coordinate is set to its path, so that no step leaves an error to the next.
    """
    plant, time = run.plant, run.state.time
    for k in range(plant.tone_count):
        tone = plant.tones[k]
        tone.cosine[START] = cos(tone.omega * time)
        tone.sine[START] = sin(tone.omega * time)
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        if mode.led != 0:
            mode.free_q = mode.free_v = 0.0
            mode.q[START], mode.v[START] = _add_steady(plant, j, START, 0.0, 0.0, 1.0)
            continue
        # Eq. 2.2: what is left of the state without the steady state vibrates freely.
        q, v = mode.q[START], mode.v[START]
        mode.free_q, mode.free_v = _add_steady(plant, j, START, q, v, -1.0)
    if plant.wave.electrodes > 0:
        _follow_wave(run, waves)
    else:
        run.state.piece_end = np.inf


@inner_kernel
def free_accelerations(run: Run, place: int, s: float) -> tuple[float, float]:
    """Return gddot and vdot [m/s^2] that there would be without contact, at a place and time s of the step.

    gddot = G_n qddot + n.(Jdot qdot) + v_T^2/|d|,   vdot = G_t qddot + t.(Jdot qdot) - v_T gdot/|d|,
    Jdot qdot = L_tip thdot^2 (sin th, -cos th), with n = (t_u, n_u) and t = (-n_u, t_u).
    """
    plant = run.plant
    u_acc, th_acc, rotor_acc = 0.0, 0.0, 0.0
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        # Eq. 1.6 without the contact's forces.
        acceleration = mode.constant - mode.damping * mode.v[place] - mode.stiffness * mode.q[place]
        for k in range(plant.tone_count):
            tone, phasor = plant.tones[k], plant.phasors[j, k]
            acceleration += phasor.force_re * tone.cosine[place] - phasor.force_im * tone.sine[place]
        if plant.wave.electrodes > 0:
            acceleration += wave_force(plant, j, s)
        u_acc += mode.row_u * acceleration
        th_acc += mode.row_th * acceleration
        rotor_acc += mode.row_r * acceleration
    tip = tip_motion(plant, place)
    _, th, _, th_rate, rotor = tip
    gap, rate, slip, n_u, n_th, t_u, t_th = contact_of(plant, tip)
    turning, passing = plant.geometry.tip_length * th_rate * th_rate, slip - rotor
    distance = plant.geometry.radius + gap
    # The directions turn with the tip: its centripetal acceleration, and that of its motion along the rotor's
    # rim, need no force.
    normal = n_u * u_acc + n_th * th_acc + turning * (t_u * sin(th) - n_u * cos(th))
    tangential = t_u * u_acc + t_th * th_acc + rotor_acc - turning * (n_u * sin(th) + t_u * cos(th))
    return normal + passing * passing / distance, tangential - passing * rate / distance


@part_kernel
def _phase(tone: Any, phasor: Any, origin: int) -> tuple[float, float]:
    """Return the force of a tone as a phasor at a place, where an answer from rest begins (eq. 2.7)."""
    cosine, sine = tone.cosine[origin], tone.sine[origin]
    re = phasor.force_re * cosine - phasor.force_im * sine
    return re, phasor.force_re * sine + phasor.force_im * cosine


@inner_kernel
def _add_driven(
    plant: Plant, j: int, k: int, origin: int, place: int, response: tuple[float, float, float, float]
) -> None:
    """Add what a tone did to a nearly resonant mode since another place, from `response_from_rest`."""
    mode, (re, im) = plant.modes[j], _phase(plant.tones[k], plant.phasors[j, k], origin)
    mode.q[place] += re * response[0] - im * response[1]
    mode.v[place] += re * response[2] - im * response[3]


@part_kernel
def _add_near(run: Run, level: int, j: int, i: int, origin: int, place: int) -> None:
    """Add what the tones did to a nearly resonant mode since the origin, at node i of a level."""
    plant = run.plant
    if plant.modes[j].near != 0:
        for k in range(plant.tone_count):
            if plant.phasors[j, k].near != 0:
                part = run.propagator.driven[level, j, k].part
                _add_driven(plant, j, k, origin, place, (part[0, i], part[1, i], part[2, i], part[3, i]))


@part_kernel
def _add_near_between(plant: Plant, j: int, s: float) -> None:
    """Add what the tones did to a nearly resonant mode up to time s of the step."""
    mode = plant.modes[j]
    if mode.near != 0:
        for k in range(plant.tone_count):
            if plant.phasors[j, k].near != 0:
                driven = response_from_rest(mode.stiffness, mode.damping, plant.tones[k].omega, s)
                _add_driven(plant, j, k, START, BETWEEN, driven)


@inner_kernel
def flow_to(run: Run, s: float) -> None:
    """Go to time s after the start, 0 <= s <= h: the state there is left BETWEEN."""
    plant, state, step = run.plant, run.state, run.step
    integrals = run.propagator.rule.integrals_of_several
    waves = plant.wave.electrodes > 0
    # A force s^m/m! has the answer I_(m+1) (eq. 2.1): as many integrals as its polynomial has powers.
    top = ORDERS if waves else max(step.kind + 1, 1)
    for k in range(plant.tone_count):
        tone = plant.tones[k]
        _turn(tone, START, BETWEEN, cos(tone.omega * s), sin(tone.omega * s))
    # As many coordinates at once as there are lanes.
    for first in range(0, plant.mode_count, WIDTH):
        stiffness, damping, constant = fill(0.0), fill(0.0), fill(0.0)
        free_q, free_v = fill(0.0), fill(0.0)
        row_u, row_th, row_r = fill(0.0), fill(0.0), fill(0.0)
        for i in range(min(plant.mode_count - first, WIDTH)):
            mode = plant.modes[first + i]
            stiffness, damping = put(stiffness, i, mode.stiffness), put(damping, i, mode.damping)
            constant = put(constant, i, mode.constant)
            free_q, free_v = put(free_q, i, mode.free_q), put(free_v, i, mode.free_v)
            # Whatever force acts, a led coordinate is where its path is.
            share = 1.0 if mode.led == 0 else 0.0
            row_u, row_th = put(row_u, i, share * mode.row_u), put(row_th, i, share * mode.row_th)
            row_r = put(row_r, i, share * mode.row_r)
        integrals_of_several(stiffness, damping, s, top, integrals)
        rate, w = entry(integrals, 0), entry(integrals, 1)
        # Eqs. 2.3 and 2.4, then the answer of the contact's polynomial, that of the waveform (2.7a), and the
        # steady state.
        q = (rate + damping * w) * free_q + w * free_v + constant * entry(integrals, 2)
        v = -stiffness * w * free_q + rate * free_v + constant * w
        if step.kind != FLIGHT:
            scale = 1.0
            for d in range(step.kind + 1):
                scale *= d / state.length if d > 0 else 1.0
                u, th = step.push_u.coefficient[d], step.push_th.coefficient[d]
                push = scale * (row_u * u + row_th * th + row_r * step.push_r.coefficient[d])
                q = q + push * entry(integrals, d + 2)
                v = v + push * entry(integrals, d + 1)
        for i in range(min(plant.mode_count - first, WIDTH)):
            j, mode, q_j, v_j = first + i, plant.modes[first + i], q[i], v[i]
            if waves:
                for m in range(ORDERS):
                    q_j += plant.forces[j, m] * integrals[m + 2, i]
                    v_j += plant.forces[j, m] * integrals[m + 1, i]
            mode.q[BETWEEN], mode.v[BETWEEN] = _add_steady(plant, j, BETWEEN, q_j, v_j, 1.0)
            _add_near_between(plant, j, s)


@inner_kernel
def fly(run: Run, level: int, place: int) -> tuple[float, float, float]:
    """Go through a flight whose responses are laid at a level, and leave the motion at its end at a place.

    Returns the drive's work, the loss by damping and the work against the load [J].
    """
    plant, propagator = run.plant, run.propagator
    times, waves, last = propagator.levels[level].flight, plant.wave.electrodes > 0, WIDTH - 1
    for k in range(plant.tone_count):
        tone, turn = plant.tones[k], propagator.turns_in_flight[level, k].flight
        cosine, sine = entry(turn, 0), entry(turn, 1)
        # Addition theorems, as in `_turn`.
        set_entry(tone.flight, 0, tone.cosine[START] * cosine - tone.sine[START] * sine)
        set_entry(tone.flight, 1, tone.cosine[START] * sine + tone.sine[START] * cosine)
    driving, damped, loading = fill(0.0), fill(0.0), fill(0.0)
    for j in range(plant.mode_count):
        mode, integrals = plant.modes[j], propagator.flights[level, j].flight
        rate, w = entry(integrals, 0), entry(integrals, 1)
        # Eqs. 2.3, of the end alone, and 2.4.
        q = (rate[last] + mode.damping * w[last]) * mode.free_q + w[last] * mode.free_v
        q += mode.constant * integrals[2, last]
        v = rate * mode.free_v + w * (mode.constant - mode.stiffness * mode.free_q)
        force = fill(0.0)
        if waves:
            power = fill(1.0)
            for m in range(ORDERS):
                derivative = plant.forces[j, m]
                q += derivative * integrals[m + 2, last]
                v = v + derivative * entry(integrals, m + 1)
                force = force + derivative * power
                power = power * entry(times, 0) / (m + 1)
        for k in range(plant.tone_count):
            tone, phasor = plant.tones[k], plant.phasors[j, k]
            cosine, sine = entry(tone.flight, 0), entry(tone.flight, 1)
            q += phasor.steady_re * cosine[last] - phasor.steady_im * sine[last]
            v = v - tone.omega * (phasor.steady_re * sine + phasor.steady_im * cosine)
            force = force + (phasor.force_re * cosine - phasor.force_im * sine)
            if phasor.near != 0:
                driven = propagator.driven_in_flight[level, j, k].flight
                re, im = _phase(tone, phasor, START)
                q += re * driven[0, last] - im * driven[1, last]
                v = v + (re * entry(driven, 2) - im * entry(driven, 3))
        mode.q[place], mode.v[place] = q, v[last]
        # W_d, W_c and W_l of eq. 6.2; what a led coordinate takes is the contact's.
        driving = driving + force * v if mode.led == 0 else driving
        damped = damped + mode.damping * v * v
        loading = loading - mode.constant * v
    weights = entry(times, 1)
    return total_of_all(weights * driving), total_of_all(weights * damped), total_of_all(weights * loading)


@inner_kernel
def _by_wave(plant: Plant, response: Any, j: int, integrated: int) -> Lanes:
    """Return what the waveform adds to the rates at the nodes, or, integrated once, to the displacements."""
    added = fill(0.0)
    if plant.wave.electrodes > 0:
        for m in range(ORDERS):
            added = added + load_all(response.powers[m + integrated]) * plant.forces[j, m]
    return added


@inner_kernel
def free_response(run: Run, level: int) -> None:
    """Go to the nodes of a level without contact."""
    plant, propagator = run.plant, run.propagator
    for k in range(plant.tone_count):
        tone, turn = plant.tones[k], propagator.turns[level, k]
        cosine, sine = load_all(turn.cosine), load_all(turn.sine)
        # Addition theorems, as in `_turn`.
        store(tone.cosine, tone.cosine[START] * cosine - tone.sine[START] * sine)
        store(tone.sine, tone.cosine[START] * sine + tone.sine[START] * cosine)
    for j in range(plant.mode_count):
        mode, response = plant.modes[j], propagator.responses[level, j]
        q0, v0 = mode.free_q, mode.free_v
        flow, hold = response.flow, response.hold
        q, v = fill(0.0), load_all(flow[2]) * q0 + load_all(flow[3]) * v0
        v = v + (load_all(hold[1]) * mode.constant + _by_wave(plant, response, j, 0))
        for k in range(plant.tone_count):
            tone, phasor = plant.tones[k], plant.phasors[j, k]
            cosine, sine = load(tone.cosine), load(tone.sine)
            q = q + (phasor.steady_re * cosine - phasor.steady_im * sine)
            v = v - tone.omega * (phasor.steady_re * sine + phasor.steady_im * cosine)
        q = q + (load_all(flow[0]) * q0 + load_all(flow[1]) * v0)
        q = q + load_all(hold[0]) * mode.constant
        store(mode.q, q + _by_wave(plant, response, j, 1))
        store(mode.v, v)
        if mode.near != 0:
            for i in range(NODES):
                _add_near(run, level, j, i, START, i)


@part_kernel
def _free_on(run: Run, i: int, place: int) -> None:
    """Set the motion at a node of a record interval by all forces but the tones'."""
    plant, step = run.plant, run.step
    forces = step.kind + 1
    for j in range(plant.mode_count):
        mode, response = plant.modes[j], run.propagator.responses[BY_RECORD, j]
        q0, v0, constant = mode.q[RECORDED], mode.v[RECORDED], mode.constant
        q = response.flow[0, i] * q0 + response.flow[1, i] * v0 + response.hold[0, i] * constant
        v = response.flow[2, i] * q0 + response.flow[3, i] * v0 + response.hold[1, i] * constant
        for m in range(forces):
            u, th, rotor = step.push_u.node[m], step.push_th.node[m], step.push_r.node[m]
            push = modal_force(mode, u, th, rotor)
            if step.kind == HELD:
                q += response.hold[0, i] * push
                v += response.hold[1, i] * push
            else:
                q += response.answer_q[m, i] * push
                v += response.answer_v[m, i] * push
        mode.q[place], mode.v[place] = q, v


@inner_kernel
def flow_on(run: Run, s: float) -> None:
    """Go on by a record interval from time s of the step, whose state is BETWEEN.

    The state at the nodes of the interval is left at theirs, the last of which is BETWEEN again. The force
    polynomial is that through its values at these nodes; there is no waveform.
    """
    plant, propagator, step = run.plant, run.propagator, run.step
    # What is free and what acts, where the interval begins: a step's start that is none of its own.
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        q, v = _add_steady(plant, j, BETWEEN, mode.q[BETWEEN], mode.v[BETWEEN], -1.0)
        mode.q[RECORDED], mode.v[RECORDED] = q, v
    for k in range(plant.tone_count):
        tone = plant.tones[k]
        tone.cosine[RECORDED], tone.sine[RECORDED] = tone.cosine[BETWEEN], tone.sine[BETWEEN]
    if step.kind == COLLOCATED:
        for m in range(NODES):
            x = (s + propagator.rule.nodes[m] * run.state.interval) / run.state.length
            step.push_u.node[m] = value_at(step.push_u, x)
            step.push_th.node[m] = value_at(step.push_th, x)
            step.push_r.node[m] = value_at(step.push_r, x)
    for i in range(NODES):
        place = i if i < LAST else BETWEEN
        for k in range(plant.tone_count):
            turn = propagator.turns[BY_RECORD, k]
            _turn(plant.tones[k], RECORDED, place, turn.cosine[i], turn.sine[i])
        _free_on(run, i, place)
        for j in range(plant.mode_count):
            mode = plant.modes[j]
            mode.q[place], mode.v[place] = _add_steady(plant, j, place, mode.q[place], mode.v[place], 1.0)
            _add_near(run, BY_RECORD, j, i, RECORDED, place)


@part_kernel
def add_collocated(run: Run, level: int) -> None:
    """Add the answer to the nodal forces: rates at all nodes, displacements at the last."""
    step = run.step
    for j in range(run.plant.mode_count):
        mode, response = run.plant.modes[j], run.propagator.responses[level, j]
        q, v = mode.q[LAST], load(mode.v)
        for m in range(NODES):
            u, th, rotor = step.push_u.node[m], step.push_th.node[m], step.push_r.node[m]
            push = modal_force(mode, u, th, rotor)
            q += response.answer_q[m, LAST] * push
            v = v + load_all(response.answer_v[m]) * push
        mode.q[LAST] = q
        store(mode.v, v)


@part_kernel
def add_constant(run: Run, level: int, displacement: bool, rates: bool) -> None:
    """Add the constant force's answer to the displacement at the end, the rates at all nodes, or both."""
    step = run.step
    u, th, rotor = step.push_u.node[0], step.push_th.node[0], step.push_r.node[0]
    for j in range(run.plant.mode_count):
        mode, response = run.plant.modes[j], run.propagator.responses[level, j]
        push = modal_force(mode, u, th, rotor)
        if displacement:
            mode.q[LAST] += response.hold[0, LAST] * push
        if rates:
            store(mode.v, load(mode.v) + load_all(response.hold[1]) * push)


@inner_kernel
def checked(run: Run, event: int) -> int:
    """Return the event of a step in contact; end the run, as it stands, where the law gave no numbers."""
    state, step = run.state, run.step
    if state.ending == RUNNING:
        size = abs(state.normal.node[0]) + abs(state.friction.node[0])
        if step.kind == COLLOCATED:
            # A force that is no number leaves a gap that is none, at which the law is not asked again.
            sizes = abs(load(state.normal.node)) + abs(load(state.friction.node))
            sizes = sizes + abs(load(state.bound.node)) + abs(load(state.internal_rate.node))
            size = total_of(sizes + abs(load(step.loss)) + abs(load(step.gap)) + abs(load(step.slip)))
        if not np.isfinite(size):
            state.ending = NOT_FINITE
    # The run ends where the step began, a state that has numbers.
    if state.ending == NOT_FINITE or state.ending == UNSOLVED:
        step.kind = FLIGHT
        state.accepted_length = 0.0
        return NOTHING
    return event
