"""Rigid contact in the limit of no step: an impact at the located touch-down, then the constrained motion.

An impact is the law's, with the Delassus matrix D of the contact as it stands. While the contact lasts, the
multipliers N and F of a collocated step hold at every node

    gdot = 0,   and in stick v = 0, in slip F = r N,

so that the step has the order of compliant contact and no error of the law's. What the law says of a contact
that lasts is read from its impulses: r is the ratio in which they slide, and friction holds the slip at
zero up to the largest ratio |F|/N that they stick with. Where they never stick, but drive a slip of either
sign back, the slip stays at zero as well: it is what chattering tends to (Filippov 1988, Differential
Equations with Discontinuous Righthand Sides, sec. 4).

After an impact with a rebound w the tip flies, as long as that matters: under a pressing
acceleration a the flight takes 2 w/|a|, and with the restitution e = w/|w_before| the infinitely many that
follow it T = 2 w/(|a| (1 - e)) in all. Where T is shorter than sqrt(tolerance) times the longest step,
they are taken as one impulse that leaves no rebound: what they change beyond that is of second order in T.
Nearly elastic rebounds, e > 0.99, never end; they count as none where a single flight is as short as that,
which takes the velocity w from the motion. In plants so slow that all flights are shorter than a step, T is
compared with the longest of them so far, whatever e is. A flight that is no digit of the gap high is none.

Where slip presses the bodies together more than the normal force parts them, D_nn + r D_nt <= 0 (Painleve),
a contact that opens by itself is released, and one that does not is stopped by an impact without approach.
"""

from math import cos, inf, sin, sqrt
from typing import Any

import numpy as np

from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.compliant import AGREEMENT, MOST_ITERATIONS, impulse_scale, lengthen, pushed_tip
from contactlab.engine.flight import CLEAR, coarseness
from contactlab.engine.friction import FIRST, push_node
from contactlab.engine.kinematics import (
    Contact,
    add_collocated,
    checked,
    contact_after,
    contact_at,
    contact_of,
    free_response,
    tip_motion,
    wave_force,
)
from contactlab.engine.memory import (
    SLIP_ROUND_OFF,
    correct_memory,
    guess_memory,
    jump,
    memory_at,
    open_step,
    recall,
    recall_start,
    solve_linear,
)
from contactlab.engine.plant import delassus
from contactlab.engine.propagator import build_level, step_length
from contactlab.engine.rigid import ROUND_OFF
from contactlab.engine.rootfinding import CONE_ROUND_OFF, locate
from contactlab.engine.state import (
    BETWEEN,
    COLLOCATED,
    CONE,
    FLIGHT,
    IMPACT,
    INCONSISTENT,
    NODES,
    NOT_FINITE,
    NOTHING,
    RELEASE,
    REVERSAL,
    RUNNING,
    START,
    UNSOLVED,
    Law,
    Run,
    fit,
    slope_at,
    value_at,
)
from contactlab.laws.base import SLIP, STICK
from contactlab.laws.lagrange import stick_impulse, wedges
from contactlab.laws.memory import AT_SLIP, AT_STICK

LASTING = 1e-6
"""Time of a contact that lasts, over that in which its friction could end the slip: short enough to slide."""

MOST_RATIO = 1e8
"""Ratio |F|/N from which on friction holds whatever there is."""

POLISHES = 2
"""Newton steps to the instant of an event; each leaves the relative error of the polynomial's slope."""

NEARLY_ELASTIC = 0.01
"""Share of the speed, 1 - e, that impacts lose whose rebounds never end."""

HALVINGS = 60
"""Of the bracket around the largest ratio that sticks."""

Matrix = tuple[float, float, float]
"""D_nn, D_nt, D_tt [1/kg]."""

Known = tuple[float, float]
"""Normal force and friction [N] where a step begins."""


@inner_kernel
def step_constrained(run: Run, law: Law) -> int:
    """Take a step that `begin` made ready through a rigid contact; returns the event that ends it.

    A contact that approaches has its impact first, which takes no time. RELEASE is a normal force that falls
    through zero, or a rebound.
    """
    state, step, contact = run.state, run.step, run.state.contact
    step.kind, state.taken = COLLOCATED, 0.0
    state.length = step_length(run.propagator, state.level)
    _, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    if contact.duration == 0.0 and contact.normal_impulse == 0.0 and rate < 0.0:
        if _impact(run, law, rate, slip):
            return _at_once(run, RELEASE)
        if state.ending != RUNNING:
            return _at_once(run, NOTHING)
    normal, friction = _start(run, law)
    if state.ending != RUNNING:
        return _at_once(run, NOTHING)
    if normal <= 0.0:
        return _at_once(run, RELEASE)
    if contact.duration == 0.0 or state.momentum == 0.0:
        _, rate, _, n_u, n_th, t_u, t_th = contact_at(run.plant, START)
        mobility = delassus(run.plant, n_u, n_th, t_u, t_th)[0]
        state.momentum = impulse_scale(run, law, state.impact_speed, normal, mobility)
    level, error = _solve(run, law, (normal, friction))
    if state.ending != RUNNING:
        return _at_once(run, NOTHING)
    remaining = min(state.end, state.piece_end) - state.time
    event, s = _first_event(run, law)
    if s > remaining:
        event, s = NOTHING, remaining
    state.taken = s
    _note_peaks(run, normal)
    if s == state.length:
        add_collocated(run, level)
    state.contact_steps += 1
    lengthen(run, level, error)
    return checked(run, event)


@inner_kernel
def _note_peaks(run: Run, normal: float) -> None:
    """Note the largest normal force of the contact, and of its part in a run that goes on."""
    state = run.state
    _note_peak(run, state.contact, 0.0, normal)
    if state.contact.start_time < state.run_start:
        # The first step of a run that goes on is that of the run before.
        first = max(state.run_start - state.time, 0.0)
        _note_peak(run, state.part, first, value_at(state.normal, first / state.length))


@inner_kernel
def _note_peak(run: Run, contact: Any, first: float, normal: float) -> None:
    """Note the largest normal force in a row of contacts, at the nodes and both ends of what was taken.

    That is from a time in the step on [s], with the normal force there [N].
    """
    state = run.state
    peak = max(normal, value_at(state.normal, state.taken / state.length))
    for i in range(NODES):
        if first < run.propagator.rule.nodes[i] * state.length < state.taken:
            peak = max(peak, state.normal.node[i])
    contact.peak_lasting_force = max(contact.peak_lasting_force, peak)
    contact.peak_normal_force = max(contact.peak_normal_force, peak)


@part_kernel
def _at_once(run: Run, event: int) -> int:
    """Let the step take no time; returns the event that ends it."""
    run.step.kind, run.state.taken = FLIGHT, 0.0
    return event


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
        acceleration = mode.constant - mode.damping * mode.v[place] - mode.stiffness * mode.q[place]
        for k in range(plant.tone_count):
            tone, phasor = plant.tones[k], plant.phasors[j, k]
            acceleration += phasor.force_re * tone.cosine[place] - phasor.force_im * tone.sine[place]
        if plant.wave.electrodes > 0:
            acceleration += wave_force(plant, j, s)
        u_acc += mode.row_u * acceleration
        th_acc += mode.row_th * acceleration
        rotor_acc += mode.row_r * acceleration
    _, th, _, th_rate, rotor = tip_motion(plant, place)
    gap, rate, slip, n_u, n_th, t_u, t_th = contact_at(plant, place)
    turning, passing = plant.geometry.tip_length * th_rate * th_rate, slip - rotor
    distance = plant.geometry.radius + gap
    normal = n_u * u_acc + n_th * th_acc + turning * (t_u * sin(th) - n_u * cos(th))
    tangential = t_u * u_acc + t_th * th_acc + rotor_acc - turning * (n_u * sin(th) + t_u * cos(th))
    return normal + passing * passing / distance, tangential - passing * rate / distance


@inner_kernel
def _sliding_ratio(law: Law, slip: float, d: Matrix) -> float:
    """Return r = F/N with which a contact that lasts slides at a slip [m/s]; none where it cannot (Painleve).

    It is that of the law's impulses over a time in which they cannot end the slip.
    """
    d_nn, d_nt, d_tt = d
    law.row[IMPACT] = 0.0
    pressing = LASTING * abs(slip) * d_nn / d_tt
    p_n, p_t, mode = law.solve(-pressing, slip, 0.0, slip, d_nn, d_nt, d_tt, law.parameters)
    if mode == STICK or not p_n > 0.0 or not d_nn * p_n + d_nt * p_t > 0.0:
        return np.nan
    return float(p_t / p_n)


@inner_kernel
def _holds(law: Law, ratio: float, d: Matrix) -> bool:
    """Return whether the law sticks, at rest, with F/N = ratio."""
    d_nn, d_nt, d_tt = d
    normal, tangential = -(d_nn + d_nt * ratio), -(d_nt + d_tt * ratio)
    _, _, mode = law.solve(LASTING * normal, LASTING * tangential, 0.0, 0.0, d_nn, d_nt, d_tt, law.parameters)
    return bool(mode == STICK)


@inner_kernel
def _holding_ratio(law: Law, side: float, d: Matrix) -> float:
    """Return the largest |F|/N that holds the slip at zero, with friction of the sign `side`."""
    most = side * _sliding_ratio(law, -side * SLIP_ROUND_OFF, d)
    least = most if most > 0.0 else 0.0
    law.row[IMPACT] = 0.0
    # As a rule friction at rest is that of slip.
    if not _holds(law, side * (least * (1.0 + CONE_ROUND_OFF) + ROUND_OFF), d):
        return least
    most = max(2.0 * least, 1.0)
    while _holds(law, side * most, d):
        if most > MOST_RATIO:
            return inf
        least, most = most, 2.0 * most
    for _ in range(HALVINGS):
        middle = 0.5 * (least + most)
        if _holds(law, side * middle, d):
            least = middle
        else:
            most = middle
    return least


@part_kernel
def _matrix_of(run: Run, frame: Contact) -> Matrix:
    """Return the Delassus matrix of a contact."""
    _, _, _, n_u, n_th, t_u, t_th = frame
    return delassus(run.plant, n_u, n_th, t_u, t_th)


@inner_kernel
def _move(run: Run, frame: Contact, p_n: float, p_t: float) -> None:
    """Change the rates at the step's start by impulses [N s]."""
    _, _, _, n_u, n_th, t_u, t_th = frame
    for j in range(run.plant.mode_count):
        mode = run.plant.modes[j]
        change = (n_u * mode.row_u + n_th * mode.row_th) * p_n
        change += (t_u * mode.row_u + t_th * mode.row_th + mode.row_r) * p_t
        mode.v[START] += change
        mode.free_v += change


@inner_kernel
def _push(run: Run, frame: Contact, p_n: float, p_t: float) -> None:
    """Let impulses act [N s], and account for what they do."""
    state, contact = run.state, run.state.contact
    _, rate, slip, _, _, _, _ = frame
    _move(run, frame, p_n, p_t)
    _, rate_after, slip_after, _, _, _, _ = contact_at(run.plant, START)
    lost = -0.5 * p_n * (rate + rate_after)
    rubbed = -0.5 * p_t * (slip + slip_after)
    state.total.contact_loss += lost
    state.total.friction_loss += rubbed
    state.total.normal_impulse += p_n
    state.total.friction_impulse += p_t
    contact.energy_loss += lost + rubbed
    contact.normal_impulse += p_n
    contact.friction_impulse += p_t
    contact.impact_energy_gain += max(-lost - rubbed, 0.0)
    _note_impact(contact, p_n)
    if contact.start_time < state.run_start <= state.time:
        _note_impact(state.part, p_n)


@inner_kernel
def _note_impact(contact: Any, p_n: float) -> None:
    """Note an impulse [N s] in a row of contacts; its force is the limit of impulse over step."""
    contact.largest_impact = max(contact.largest_impact, p_n)
    contact.peak_normal_force = inf


@inner_kernel
def _become(run: Run, law: Law, mode: int, slip: float) -> None:
    """Set the friction mode and the sign of the slip, with the reset map of a change."""
    state, before = run.state, run.state.mode
    state.mode, state.sign = mode, 1 if slip > 0.0 else -1
    if mode != before:
        state.friction_switches += 1
        jump(run, law, law.memory, AT_STICK if mode == STICK else AT_SLIP)


@inner_kernel
def _ends(run: Run, rebound: float, lost: float) -> bool:
    """Return whether the flights after a rebound [m/s], which lost a share of the speed, count as none."""
    state, longest = run.state, run.propagator.rule.longest
    pressing = -free_accelerations(run, START, 0.0)[0]
    if lost < NEARLY_ELASTIC and longest <= state.calm:
        lost = 1.0
    high = coarseness(run, tip_motion(run.plant, START)[1]) * CLEAR * pressing
    long = sqrt(state.tolerance) * min(longest, state.calm) * pressing * lost
    return bool(pressing > 0.0 and (2.0 * rebound <= long or 0.5 * rebound * rebound <= high))


@inner_kernel
def _impact(run: Run, law: Law, rate: float, slip: float) -> bool:
    """Let the law answer an approach [m/s], and return whether the tip flies off; sets mode and sign.

    An approach that it does not stop ends the run as INCONSISTENT.
    """
    state = run.state
    frame = contact_at(run.plant, START)
    d_nn, d_nt, d_tt = _matrix_of(run, frame)
    recall_start(run, law)
    law.row[IMPACT] = 1.0
    p_n, p_t, mode = law.solve(rate, slip, rate, slip, d_nn, d_nt, d_tt, law.parameters)
    state.critical_friction = d_nn / abs(d_nt) if d_nt != 0.0 else inf
    if not p_n > 0.0 or not np.isfinite(p_n + p_t):
        state.ending = INCONSISTENT if np.isfinite(p_n + p_t) else NOT_FINITE
        return False
    _push(run, frame, p_n, p_t)
    after = contact_at(run.plant, START)
    rebound, left = after[1], after[2]
    # A law may call stick what leaves a slip.
    if mode == STICK and abs(left) <= ROUND_OFF * max(abs(rate), abs(slip)):
        left = 0.0
    else:
        mode = SLIP
    _become(run, law, mode, left)
    if rebound <= ROUND_OFF * abs(rate):
        return False
    if not _ends(run, rebound, 1.0 - rebound / abs(rate)):
        return True
    if left == 0.0:
        p_n, p_t = stick_impulse(rebound, 0.0, d_nn, d_nt, d_tt)
    else:
        ratio = _sliding_ratio(law, left, (d_nn, d_nt, d_tt))
        ratio = ratio if np.isfinite(ratio) else 0.0
        p_n = -rebound / (d_nn + ratio * d_nt)
        p_t = ratio * p_n
    _push(run, after, p_n, p_t)
    return False


@inner_kernel
def settle(run: Run) -> Contact:
    """Take from the step's start what location and collocation left of gap and gap rate, in stick of slip.

    It is along the gradient, by the masses, as the paper's corrector (eq. 57); returns the contact.
    """
    gap, rate, slip, n_u, n_th, t_u, t_th = contact_at(run.plant, START)
    d_nn, d_nt, d_tt = delassus(run.plant, n_u, n_th, t_u, t_th)
    shift = gap / d_nn
    for j in range(run.plant.mode_count):
        mode = run.plant.modes[j]
        change = shift * (n_u * mode.row_u + n_th * mode.row_th)
        mode.q[START] -= change
        mode.free_q -= change
    p_n, p_t = -rate / d_nn, 0.0
    if run.state.mode == STICK:
        p_n, p_t = stick_impulse(rate, slip, d_nn, d_nt, d_tt)
    _move(run, (gap, rate, slip, n_u, n_th, t_u, t_th), p_n, p_t)
    return contact_at(run.plant, START)


@inner_kernel
def _sticks(run: Run, law: Law, normal: float, friction: float, d: Matrix) -> bool:
    """Return whether the law holds the slip at zero with these forces [N].

    An excess over the cone counts by its impulse over the step: friction may be on its way back inside.
    """
    state, side = run.state, 1.0 if friction > 0.0 else -1.0
    excess = abs(friction) - _holding_ratio(law, side, d) * normal * (1.0 + CONE_ROUND_OFF)
    return bool(normal > 0.0 and excess * state.length <= state.tolerance * state.momentum)


@inner_kernel
def _start(run: Run, law: Law) -> Known:
    """Return the forces where the step begins, a normal force of zero where the contact opens; sets mode.

    A slip that is at zero begins against the friction that stick would need.
    """
    state = run.state
    for _ in range(2):
        frame = settle(run)
        d = _matrix_of(run, frame)
        d_nn, d_nt, d_tt = d
        a_n, a_t = free_accelerations(run, START, 0.0)
        recall_start(run, law)
        state.critical_friction = d_nn / abs(d_nt) if d_nt != 0.0 else inf
        if wedges(a_n, a_t, d_nn, d_nt, d_tt, state.friction_limit):
            state.wedged_steps += 1
        slip = frame[2]
        if state.mode == STICK:
            normal, friction = stick_impulse(a_n, a_t, d_nn, d_nt, d_tt)
            if _sticks(run, law, normal, friction, d):
                return normal, friction
            if normal <= 0.0 <= a_n:
                return 0.0, 0.0
            _become(run, law, SLIP, -friction)
        elif state.sign * slip < -SLIP_ROUND_OFF:
            state.sign = -state.sign
        ratio = _sliding_ratio(law, state.sign * max(abs(slip), SLIP_ROUND_OFF), d)
        if np.isfinite(ratio):
            normal = -a_n / (d_nn + ratio * d_nt)
            return max(normal, 0.0), ratio * max(normal, 0.0)
        if a_n >= 0.0 or _impact(run, law, -LASTING * abs(slip), slip) or state.ending != RUNNING:
            return 0.0, 0.0
    state.ending = INCONSISTENT
    return 0.0, 0.0


@inner_kernel
def _solve(run: Run, law: Law, known: Known) -> tuple[int, float]:
    """Shorten a step until it is accepted; returns its level and its error over the tolerance."""
    state, rule = run.state, run.propagator.rule
    gap, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    open_step(run, law, law.memory, gap, rate, 0.0 if state.mode == STICK else slip, known[0])
    level, error = state.level, 0.0
    while level < rule.level_count:
        error = _attempt(run, law, level, known)
        # A slip that begins at rest and is over before the first node.
        hidden = state.mode == SLIP and abs(slip) <= SLIP_ROUND_OFF
        hidden = hidden and state.sign * run.step.slip[0] < -SLIP_ROUND_OFF
        if (error <= 1.0 and not hidden) or (error < inf and level >= rule.level_count - 9):
            break
        state.rejected_steps += 1
        level += 2 if error > 500.0 or hidden else 1
    else:
        state.ending = UNSOLVED
    return level, error


@inner_kernel
def _attempt(run: Run, law: Law, level: int, known: Known) -> float:
    """Solve a step at a level; returns its error over the tolerance, infinite where it has no solution.

    The error is what the polynomials of the multipliers miss of their values at the step's start, as an
    impulse.
    """
    state, step = run.state, run.step
    build_level(run.plant, run.propagator, level)
    free_response(run, level, FIRST)
    for i in range(NODES):
        tip = tip_motion(run.plant, i)
        step.u[i], step.th[i], step.u_rate[i], step.th_rate[i], step.rotor[i] = tip
    _, _, _, n_u, n_th, t_u, t_th = contact_at(run.plant, START)
    h = step_length(run.propagator, level)
    state.length = h
    for i in range(NODES):
        step.n_u[i], step.n_th[i], step.t_u[i], step.t_th[i] = n_u, n_th, t_u, t_th
        state.normal.node[i], state.friction.node[i] = known
        state.bias.node[i] = known[1] / known[0]
        step.loss[i], step.end[i] = 0.0, 0.0
        push_node(run, None, i)
    guess_memory(run, law.memory)
    sweeps = _collocate(run, law, level)
    state.taken = 0.0
    state.sweeps += sweeps
    if sweeps == 0:
        return inf
    error = max(abs(state.normal.coefficient[0] - known[0]), abs(state.friction.coefficient[0] - known[1]))
    return float(error * h / (state.tolerance * state.momentum))


@inner_kernel
def _collocate(run: Run, law: Law, level: int) -> int:
    """Iterate the multipliers of a step; returns the number of sweeps, 0 where it does not contract.

    The system is linear but for the directions of the contact, which hardly turn within a step.
    """
    state, step, rule = run.state, run.step, run.propagator.rule
    sticks = state.mode == STICK
    size = 2 * NODES if sticks else NODES
    for sweep in range(1, MOST_ITERATIONS + 1):
        most = 0.0
        for i in range(NODES):
            tip = pushed_tip(run, level, i)
            gap, rate, slip, n_u, n_th, t_u, t_th = contact_of(run.plant, tip)
            step.n_u[i], step.n_th[i], step.t_u[i], step.t_th[i] = n_u, n_th, t_u, t_th
            step.gap[i], step.gap_rate[i], step.slip[i], step.sliding[i] = gap, rate, slip, slip
            most = max(most, abs(state.normal.node[i]), abs(state.friction.node[i]))
            recall(run, law, i)
            if not sticks:
                d = delassus(run.plant, n_u, n_th, t_u, t_th)
                slides = state.sign * max(state.sign * slip, SLIP_ROUND_OFF)
                ratio = _sliding_ratio(law, slides, d)
                if np.isfinite(ratio):
                    state.bias.node[i] = ratio
        change = _correct(run, level, sticks, size)
        flowed = correct_memory(run, law, law.memory, state.length)
        if not np.isfinite(change):
            return 0
        least = 1e-3 * AGREEMENT * state.momentum
        if flowed <= AGREEMENT and (change <= AGREEMENT * most or change * state.length <= least):
            for i in range(NODES):
                _bound_node(run, law, i, sticks)
            fit(rule, state.normal)
            fit(rule, state.friction)
            fit(rule, state.bound)
            fit(rule, state.bias)
            fit(rule, step.push_u)
            fit(rule, step.push_th)
            fit(rule, step.push_r)
            return sweep
    return 0


@inner_kernel
def _bound_node(run: Run, law: Law, i: int, sticks: bool) -> None:
    """Set the bound of the friction at a node [N], and its middle to zero."""
    state, step = run.state, run.step
    bound = abs(state.friction.node[i])
    if sticks:
        recall(run, law, i)
        d = delassus(run.plant, step.n_u[i], step.n_th[i], step.t_u[i], step.t_th[i])
        side = 1.0 if state.friction.node[i] > 0.0 else -1.0
        bound = min(_holding_ratio(law, side, d), MOST_RATIO) * max(state.normal.node[i], 0.0)
        step.slip[i] = 0.0
    state.bound.node[i], state.bias.node[i] = bound, 0.0


@inner_kernel
def _correct(run: Run, level: int, sticks: bool, size: int) -> float:
    """Take one Newton step of the multipliers; returns the largest correction [N].

    Rows are gap rates and, in stick, slips; columns are normal forces, in slip with their friction, and in
    stick frictions.
    """
    state, step = run.state, run.step
    tip_v, system = run.propagator.levels[level].tip_v, step.system
    for i in range(NODES):
        n_u, n_th, t_u, t_th = step.n_u[i], step.n_th[i], step.t_u[i], step.t_th[i]
        for m in range(NODES):
            uu, mixed, thth = tip_v[0, i, m], tip_v[1, i, m], tip_v[2, i, m]
            m_u, m_th, s_u, s_th = step.n_u[m], step.n_th[m], step.t_u[m], step.t_th[m]
            # Answers of u and th to a unit normal force and to a unit friction.
            by_normal_u, by_normal_th = uu * m_u + mixed * m_th, mixed * m_u + thth * m_th
            by_friction_u, by_friction_th = uu * s_u + mixed * s_th, mixed * s_u + thth * s_th
            normal = n_u * by_normal_u + n_th * by_normal_th
            crossed = n_u * by_friction_u + n_th * by_friction_th
            if sticks:
                system[i, m], system[i, NODES + m] = normal, crossed
                system[NODES + i, m] = t_u * by_normal_u + t_th * by_normal_th
                system[NODES + i, NODES + m] = t_u * by_friction_u + t_th * by_friction_th + tip_v[3, i, m]
            else:
                system[i, m] = normal + crossed * state.bias.node[m]
        system[i, size] = -step.gap_rate[i]
        if sticks:
            system[NODES + i, size] = -step.slip[i]
        else:
            # Friction follows the normal force that there is.
            for m in range(NODES):
                missing = state.bias.node[m] * state.normal.node[m] - state.friction.node[m]
                uu, mixed, thth = tip_v[0, i, m], tip_v[1, i, m], tip_v[2, i, m]
                s_u, s_th = step.t_u[m], step.t_th[m]
                by_u, by_th = uu * s_u + mixed * s_th, mixed * s_u + thth * s_th
                system[i, size] -= missing * (n_u * by_u + n_th * by_th)
    solve_linear(system, size)
    most = 0.0
    for i in range(NODES):
        before_normal, before_friction = state.normal.node[i], state.friction.node[i]
        state.normal.node[i] += system[i, size]
        if sticks:
            state.friction.node[i] += system[NODES + i, size]
        else:
            state.friction.node[i] = state.bias.node[i] * state.normal.node[i]
        push_node(run, None, i)
        change = abs(state.normal.node[i] - before_normal) + abs(state.friction.node[i] - before_friction)
        # NaN fails every comparison, and is passed on.
        most = change if not change <= most else most
    return most


@inner_kernel
def _margin(run: Run, law: Law, event: int, s: float) -> float:
    """Return the normal force at time s of the step, or what friction may still grow by in stick [N].

    They are the multipliers of the accelerations at that time.
    """
    state = run.state
    frame = contact_after(run, s)
    d = _matrix_of(run, frame)
    a_n, a_t = free_accelerations(run, BETWEEN, s)
    memory_at(run, law, law.memory, s)
    if state.mode != STICK:
        ratio = _sliding_ratio(law, state.sign * max(abs(frame[2]), SLIP_ROUND_OFF), d)
        return -a_n / (d[0] + ratio * d[1])
    normal, friction = stick_impulse(a_n, a_t, d[0], d[1], d[2])
    if event == RELEASE:
        return float(normal)
    return float(_holding_ratio(law, 1.0 if friction > 0.0 else -1.0, d) * normal - abs(friction))


@inner_kernel
def _polished(run: Run, law: Law, event: int, s: float) -> float:
    """Return the time of a release or of the end of a stick from that of the polynomials [s].

    Newton's method with the slope of the polynomials, as long as it comes closer.
    """
    state = run.state
    margin = _margin(run, law, event, s)
    for _ in range(POLISHES):
        x = s / state.length
        slope = slope_at(state.normal, x)
        if event == CONE:
            side = 1.0 if value_at(state.friction, x) > 0.0 else -1.0
            slope = slope_at(state.bound, x) - side * slope_at(state.friction, x)
        tried = min(max(s - margin * state.length / slope, 0.0), state.length) if slope < 0.0 else s
        there = _margin(run, law, event, tried)
        if not abs(there) < abs(margin):
            break
        s, margin = tried, there
    return s


@inner_kernel
def _first_event(run: Run, law: Law) -> tuple[int, float]:
    """Find the earliest event in the step and its time, or NOTHING and the step's length."""
    state, step = run.state, run.step
    sticks, left = state.mode == STICK, 0.0
    for i in range(NODES):
        right = run.propagator.rule.nodes[i] * state.length
        first, s = NOTHING, right
        if state.normal.node[i] < 0.0:
            first, s = RELEASE, _polished(run, law, RELEASE, locate(run, law, RELEASE, left, right, 0.0))
        excess = abs(state.friction.node[i]) - state.bound.node[i] * (1.0 + CONE_ROUND_OFF)
        if sticks and excess > 0.0:
            at = _polished(run, law, CONE, locate(run, law, CONE, left, right, 0.0))
            first, s = (CONE, at) if first == NOTHING or at < s else (first, s)
        elif not sticks and state.sign * step.slip[i] < -SLIP_ROUND_OFF:
            at = locate(run, law, REVERSAL, left, right, 0.0)
            first, s = (REVERSAL, at) if first == NOTHING or at < s else (first, s)
        if first != NOTHING:
            return first, s
        left = right
    return NOTHING, state.length
