"""Rigid contact in the limit of no step: an impact at the located touch-down, then the constrained motion.

An impact is the law's, with the Delassus matrix D of the contact as it stands. While the contact lasts, the
multipliers N and F of a collocated step hold at every node

    gdot = 0,   and in stick v = 0, |F| <= bound(N, 0), in slip F = -bound(N, v) sign(v) = r N

(docs/theory/rigid.md, eq. 4.12), so that the step has the order of compliant contact and no error of the
law's. A law that always slips holds the slip at zero as well, inside its bound: it is what its chattering in
time stepping tends to (Filippov 1988, Differential Equations with Discontinuous Righthand Sides, sec. 4).

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

from math import inf, sqrt
from typing import Any

import numpy as np

from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.engine.collocation import MOST_ITERATIONS, agree, pushed_tip
from contactlab.engine.compliant import ROUND_OFF as IMPULSE_ROUND_OFF, impulse_scale, lengthen
from contactlab.engine.flight import CLEAR, coarseness
from contactlab.engine.friction import FIRST, push_node
from contactlab.engine.kinematics import (
    Contact,
    add_collocated,
    checked,
    contact_after,
    contact_at,
    contact_of,
    free_accelerations,
    free_response,
    modal_force,
    tip_motion,
)
from contactlab.engine.memory import (
    SLIP_ROUND_OFF,
    correct_memory,
    guess_memory,
    jump,
    memory_at,
    missed_flow,
    open_step,
    recall,
    recall_start,
    solve_linear,
)
from contactlab.engine.plant import delassus
from contactlab.engine.propagator import build_level, step_length
from contactlab.engine.rigid import ROUND_OFF, friction_ratio, sliding_ratio, step_in_time, wedges
from contactlab.engine.rootfinding import CONE_ROUND_OFF, TIME_DIGIT, locate
from contactlab.engine.state import (
    BETWEEN,
    COLLOCATED,
    CONE,
    FLIGHT,
    INCONSISTENT,
    NODES,
    NOT_FINITE,
    NOTHING,
    PEAK,
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
from contactlab.laws.lagrange import stick_impulse
from contactlab.laws.memory import AT_SLIP, AT_STICK

LASTING = 1e-6
"""Approach over slip of the impact that ends a sliding contact which presses itself together (Painleve)."""

POLISHES = 3
"""Secants to the least margin between two nodes: what is left of the way to it is negligible squared."""

MOST_HALVINGS = 100
"""Of the bracket around the instant of an event."""

NEARLY_ELASTIC = 0.01
"""Share of the speed, 1 - e, that impacts lose whose rebounds never end."""

LEAST_HEIGHT = 10.0 * CLEAR
"""Height [m] of a rebound whose flight the digits of the gap still resolve."""

Matrix = tuple[float, float, float]
"""D_nn, D_nt, D_tt [1/kg]."""

Known = tuple[float, float]
"""Normal force and friction [N] where a step begins."""


@inner_kernel
def step_rigid(run: Run, law: Law) -> int:
    """Take a step through a rigid contact, in its limit of no step or in time stepping; returns the event."""
    return step_in_time(run, law) if run.state.law.stepped != 0 else _step_constrained(run, law)


@inner_kernel
def _step_constrained(run: Run, law: Law) -> int:
    """Take a step that `begin` made ready through a rigid contact; returns the event that ends it.

    A contact that approaches has its impact first, which takes no time; under a prescribed load it has none.
    RELEASE is a normal force that falls
    through zero, or a rebound.
    """
    state, step, contact = run.state, run.step, run.state.contact
    step.kind, state.accepted_length = COLLOCATED, 0.0
    state.length = step_length(run.propagator, state.level)
    _, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    begins = contact.duration == 0.0 and contact.normal_impulse == 0.0 and run.plant.wave.led_slip == 0
    if begins and rate < 0.0:
        if _impact(run, law, rate, slip):
            return _at_once(run, RELEASE)
        if state.ending != RUNNING:
            return _at_once(run, NOTHING)
    normal, friction = _start(run, law)
    if state.ending != RUNNING:
        return _at_once(run, NOTHING)
    if normal <= 0.0:
        return _at_once(run, RELEASE)
    if contact.duration == 0.0 or state.impulse_scale == 0.0:
        state.impulse_scale = _momentum(run, law, normal)
    level, error = _solve(run, law, (normal, friction))
    if state.ending != RUNNING:
        return _at_once(run, NOTHING)
    remaining = min(state.end, state.piece_end) - state.time
    event, s = _first_event(run, law)
    _note_sign(run, event, s)
    if s > remaining:
        event, s = NOTHING, remaining
    state.accepted_length = s
    _note_peaks(run, law, normal)
    if s == state.length:
        add_collocated(run, level)
    state.contact_steps += 1
    lengthen(run, level, error)
    return checked(run, event)


@inner_kernel
def _momentum(run: Run, law: Law, normal: float) -> float:
    """Return the impulse [N s] that scales errors in a contact that begins with a normal force [N].

    It is at least what round-off of the rates does to the forces of a stick, which no prescribed slip has.
    """
    state = run.state
    d_nn, d_nt, d_tt = _matrix_of(run, contact_at(run.plant, START))
    scale = impulse_scale(run, law, state.impact_speed, normal, d_nn)
    if run.plant.wave.led_slip != 0:
        return scale
    magnified = d_nn * (d_nn + d_tt) / (d_nn * d_tt - d_nt * d_nt)
    return float(scale * max(1.0, IMPULSE_ROUND_OFF / state.tolerance * magnified))


@inner_kernel
def _note_peaks(run: Run, law: Law, normal: float) -> None:
    """Note the largest normal force of the contact, and of its part in a run that goes on."""
    state = run.state
    _note_peak(run, law, state.contact, 0.0, normal)
    if state.contact.start_time < state.run_start:
        # The first step of a run that goes on is that of the run before.
        first = max(state.run_start - state.time, 0.0)
        _note_peak(run, law, state.contact_of_run, first, value_at(state.normal, first / state.length))


@inner_kernel
def _note_peak(run: Run, law: Law, contact: Any, first: float, normal: float) -> None:
    """Note the largest normal force in a row of contacts, between the nodes as well.

    What was taken counts from a time in the step on [s], with the normal force there [N].
    """
    state = run.state
    peak, left, s = normal, first, state.accepted_length
    for i in range(NODES):
        right = min(run.propagator.rule.nodes[i] * state.length, s)
        if right <= first:
            continue
        peak = max(peak, value_at(state.normal, right / state.length))
        if slope_at(state.normal, left / state.length) > 0.0 > slope_at(state.normal, right / state.length):
            at = locate(run, law, PEAK, left, right, 0.0)
            peak = max(peak, value_at(state.normal, at / state.length))
        if right == s:
            break
        left = right
    contact.peak_lasting_force = max(contact.peak_lasting_force, peak)
    contact.peak_normal_force = max(contact.peak_normal_force, peak)


@part_kernel
def _at_once(run: Run, event: int) -> int:
    """Let the step take no time; returns the event that ends it."""
    run.step.kind, run.state.accepted_length = FLIGHT, 0.0
    return event


@inner_kernel
def _jumps(law: Law, side: float, normal: float, d: Matrix) -> bool:
    """Return whether the forces jump where a stick leaves its bound with friction of the sign `side`.

    They do where static friction is not kinetic friction at a normal force [N], and where the contact cannot
    slide that way and opens (Painleve).
    """
    normal = normal if normal > 0.0 else 1.0
    static = law.bound(normal, 0.0, law.parameters)
    kinetic = law.bound(normal, -side * SLIP_ROUND_OFF, law.parameters)
    opens = d[0] + side * kinetic / normal * d[1] <= 0.0
    return bool(opens or abs(static - kinetic) > CONE_ROUND_OFF * static)


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
        change = modal_force(mode, n_u * p_n + t_u * p_t, n_th * p_n + t_th * p_t, p_t)
        mode.v[START] += change
        mode.free_v += change


@inner_kernel
def _account(run: Run, before: Contact, after: Contact, p_n: float, p_t: float) -> float:
    """Add impulses [N s] to the sums of contact and run, with their loss [J], which is returned."""
    state, contact = run.state, run.state.contact
    lost = -0.5 * p_n * (before[1] + after[1])
    rubbed = -0.5 * p_t * (before[2] + after[2])
    state.total.contact_loss += lost
    state.total.friction_loss += rubbed
    state.total.normal_impulse += p_n
    state.total.friction_impulse += p_t
    contact.energy_loss += lost + rubbed
    contact.normal_impulse += p_n
    contact.friction_impulse += p_t
    return float(lost + rubbed)


@inner_kernel
def _push(run: Run, frame: Contact, p_n: float, p_t: float) -> None:
    """Let the impulses of an impact act [N s], and account for what they do."""
    state, contact = run.state, run.state.contact
    _move(run, frame, p_n, p_t)
    lost = _account(run, frame, contact_at(run.plant, START), p_n, p_t)
    contact.impact_energy_gain += max(-lost, 0.0)
    _note_impact(contact, p_n)
    if contact.start_time < state.run_start <= state.time:
        _note_impact(state.contact_of_run, p_n)


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
    if lost < NEARLY_ELASTIC and longest <= state.watchdog.longest_quiet:
        lost = 1.0
    high = coarseness(run, tip_motion(run.plant, START)[1]) * LEAST_HEIGHT * pressing
    long = sqrt(state.tolerance) * min(longest, state.watchdog.longest_quiet) * pressing * lost
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
    p_n, p_t = law.impact(rate, slip, d_nn, d_nt, d_tt, law.parameters)
    state.critical_friction = d_nn / abs(d_nt) if d_nt != 0.0 else inf
    if not p_n > 0.0 or not np.isfinite(p_n + p_t):
        state.ending = INCONSISTENT if np.isfinite(p_n + p_t) else NOT_FINITE
        return False
    _push(run, frame, p_n, p_t)
    after = contact_at(run.plant, START)
    rebound, left = after[1], after[2]
    if abs(left) <= ROUND_OFF * max(abs(rate), abs(slip), abs(d_tt * p_t)):
        left = 0.0
    _become(run, law, STICK if left == 0.0 else SLIP, left)
    if rebound <= ROUND_OFF * abs(rate):
        return False
    # The flights that follow the rebound are taken one by one, unless they are short enough to count as none
    # (docs/theory/rigid.md, "Rebounds").
    if not _ends(run, rebound, 1.0 - rebound / abs(rate)):
        return True
    # One impulse takes the rebound back, in stick or with the friction of the slip.
    if left == 0.0:
        p_n, p_t = stick_impulse(rebound, 0.0, d_nn, d_nt, d_tt)
    else:
        pressing = free_accelerations(run, START, 0.0)[0]
        ratio = sliding_ratio(law, pressing, left, (d_nn, d_nt, d_tt))
        ratio = ratio if np.isfinite(ratio) else 0.0
        p_n = -rebound / (d_nn + ratio * d_nt)
        p_t = ratio * p_n
    _push(run, after, p_n, p_t)
    return False


@inner_kernel
def settle(run: Run) -> Contact:
    """Take from the step's start what location and collocation left of gap and gap rate, in stick of slip.

    It is along the gradient, by the masses, as the paper's corrector (eq. 57). What changes the rates are
    impulses of the contact: a slip that is located up to SLIP_ROUND_OFF turns the rotor as it ends. A contact
    without impulse so far may be a touch by round-off, which has none. Returns the contact.
    """
    contact = run.state.contact
    frame = contact_at(run.plant, START)
    _, _, _, n_u, n_th, _, _ = frame
    shift = frame[0] / _matrix_of(run, frame)[0]
    for j in range(run.plant.mode_count):
        mode = run.plant.modes[j]
        change = modal_force(mode, shift * n_u, shift * n_th, 0.0)
        mode.q[START] -= change
        mode.free_q -= change
    # The displacement has turned the directions.
    frame = contact_at(run.plant, START)
    d_nn, d_nt, d_tt = _matrix_of(run, frame)
    p_n, p_t = -frame[1] / d_nn, 0.0
    if run.state.mode == STICK and run.plant.wave.led_slip == 0:
        p_n, p_t = stick_impulse(frame[1], frame[2], d_nn, d_nt, d_tt)
    _move(run, frame, p_n, p_t)
    after = contact_at(run.plant, START)
    if contact.duration > 0.0 or contact.normal_impulse != 0.0:
        _account(run, frame, after, p_n, p_t)
    return after


@inner_kernel
def _sticks(run: Run, law: Law, normal: float, friction: float, d: Matrix) -> bool:
    """Return whether the law holds the slip at zero with these forces [N].

    An excess over the cone counts by its impulse over the step: friction may be on its way back inside. Where
    the forces jump at the edge, it counts at once.
    """
    state, side = run.state, 1.0 if friction > 0.0 else -1.0
    bound = law.bound(normal, 0.0, law.parameters)
    if _jumps(law, side, normal, d):
        return bool(normal > 0.0 and abs(friction) <= bound * (1.0 + ROUND_OFF))
    excess = abs(friction) - bound * (1.0 + CONE_ROUND_OFF)
    return bool(normal > 0.0 and excess * state.length <= state.tolerance * state.impulse_scale)


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
        # Eq. 4.13: the multipliers where the step starts are those of the accelerations without contact.
        a_n, a_t = free_accelerations(run, START, 0.0)
        recall_start(run, law)
        state.critical_friction = d_nn / abs(d_nt) if d_nt != 0.0 else inf
        if wedges(a_n, a_t, d_nn, d_nt, d_tt, state.law.friction_limit):
            state.wedged_steps += 1
        slip = frame[2]
        if state.mode == STICK and abs(slip) > SLIP_ROUND_OFF:
            # `settle` leaves a slip that is prescribed.
            _become(run, law, SLIP, slip)
        if state.mode == STICK:
            normal, friction = stick_impulse(a_n, a_t, d_nn, d_nt, d_tt)
            if _sticks(run, law, normal, friction, d):
                return normal, friction
            # Stick outside of its bound opens by itself or slides, against the friction that it would need.
            if normal <= 0.0 <= a_n:
                return 0.0, 0.0
            _become(run, law, SLIP, -friction)
        elif state.sign * slip < -SLIP_ROUND_OFF:
            state.sign = -state.sign
        ratio = sliding_ratio(law, a_n, state.sign * max(abs(slip), SLIP_ROUND_OFF), d)
        if np.isfinite(ratio):
            normal = -a_n / (d_nn + ratio * d_nt)
            return max(normal, 0.0), ratio * max(normal, 0.0)
        # Slip that presses the bodies together parts where it opens by itself; else an impact without
        # approach stops it (Painleve), and the contact is looked at once more.
        if a_n >= 0.0 or _impact(run, law, -LASTING * abs(slip), slip) or state.ending != RUNNING:
            return 0.0, 0.0
    state.ending = INCONSISTENT
    return 0.0, 0.0


@inner_kernel
def _solve(run: Run, law: Law, known: Known) -> tuple[int, float]:
    """Shorten a step until it is accepted; returns its level and its error over the tolerance."""
    state, rule = run.state, run.propagator.rule
    gap, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    # A slip that begins at zero has the rates of slip, as at the nodes: those of stick are of another flow,
    # and no step is short enough to go on from them.
    sliding = 0.0 if state.mode == STICK else state.sign * max(abs(slip), SLIP_ROUND_OFF)
    open_step(run, law, law.memory, gap, rate, sliding, known[0])
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
    impulse, and those of the internal variables of their rates.
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
        # The iteration starts from the forces known at the step's start, held over the step.
        step.n_u[i], step.n_th[i], step.t_u[i], step.t_th[i] = n_u, n_th, t_u, t_th
        state.normal.node[i], state.friction.node[i] = known
        state.bias.node[i] = known[1] / known[0]
        step.loss[i], step.end[i] = 0.0, 0.0
        push_node(run, i)
    guess_memory(run, law.memory)
    sweeps = _collocate(run, law, level)
    state.accepted_length = 0.0
    state.sweeps += sweeps
    if sweeps == 0:
        return inf
    error = max(abs(state.normal.coefficient[0] - known[0]), abs(state.friction.coefficient[0] - known[1]))
    # The multipliers may not depend on the internal variables, as at rest: these have an error of their own.
    flowed = missed_flow(run, law.memory) / state.tolerance
    return float(max(error * h / (state.tolerance * state.impulse_scale), flowed))


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
                slides = state.sign * max(state.sign * slip, SLIP_ROUND_OFF)
                state.bias.node[i] = friction_ratio(law, abs(state.normal.node[i]), slides)
        # Eq. 4.12 at all nodes: gap rates, and in stick slips, to zero by the multipliers.
        change = _correct(run, level, sticks, size)
        flowed = correct_memory(run, law, law.memory, state.length)
        if not np.isfinite(change):
            return 0
        if agree(state, change, most, flowed):
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
        bound = law.bound(max(state.normal.node[i], 0.0), 0.0, law.parameters)
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
    # What the multipliers change in the rates is exact (eq. 3.3), so one solution would do but for the
    # turning of the directions.
    solve_linear(system, size)
    most = 0.0
    for i in range(NODES):
        before_normal, before_friction = state.normal.node[i], state.friction.node[i]
        state.normal.node[i] += system[i, size]
        if sticks:
            state.friction.node[i] += system[NODES + i, size]
        else:
            state.friction.node[i] = state.bias.node[i] * state.normal.node[i]
        push_node(run, i)
        change = abs(state.normal.node[i] - before_normal) + abs(state.friction.node[i] - before_friction)
        # NaN fails every comparison, and is passed on.
        most = change if not change <= most else most
    return most


@inner_kernel
def _multipliers(run: Run, s: float) -> tuple[float, float, Matrix]:
    """Return the forces that hold gap and slip at time s of the step [N], and the Delassus matrix there."""
    d = _matrix_of(run, contact_after(run, s))
    a_n, a_t = free_accelerations(run, BETWEEN, s)
    normal, friction = stick_impulse(a_n, a_t, d[0], d[1], d[2])
    return normal, friction, d


@inner_kernel
def _margin(run: Run, law: Law, event: int, s: float) -> float:
    """Return the normal force at time s of the step, or what friction may still grow by in stick [N].

    They are the multipliers of the accelerations at that time.
    """
    state = run.state
    normal, friction, d = _multipliers(run, s)
    memory_at(run, law, law.memory, s)
    if state.mode != STICK:
        slip = contact_at(run.plant, BETWEEN)[2]
        a_n = free_accelerations(run, BETWEEN, s)[0]
        ratio = sliding_ratio(law, a_n, state.sign * max(abs(slip), SLIP_ROUND_OFF), d)
        return -a_n / (d[0] + ratio * d[1])
    if event == RELEASE:
        return float(normal)
    return float(law.bound(max(normal, 0.0), 0.0, law.parameters) - abs(friction))


@inner_kernel
def _edge(run: Run, law: Law, event: int, left: float, right: float) -> float:
    """Locate where the margin of a release or of the end of a stick falls through zero, left ... right [s].

    Regula falsi by the Illinois rule; without a change of sign it is the end with the smaller margin.
    """
    at_left, at_right, s = _margin(run, law, event, left), _margin(run, law, event, right), right
    if not at_left > 0.0 > at_right:
        return left if abs(at_left) <= abs(at_right) else right
    stayed = 0
    for _ in range(MOST_HALVINGS):
        before, s = s, (at_left * right - at_right * left) / (at_left - at_right)
        margin = _margin(run, law, event, s)
        if margin == 0.0 or abs(s - before) <= TIME_DIGIT * run.state.length:
            break
        if margin < 0.0:
            at_left, stayed = at_left * (0.5 if stayed < 0 else 1.0), -1
            right, at_right = s, margin
        else:
            at_right, stayed = at_right * (0.5 if stayed > 0 else 1.0), 1
            left, at_left = s, margin
    return s


@inner_kernel
def _least_margin(run: Run, left: float, right: float) -> float:
    """Return where a margin of stick that falls at left and grows at right is least, else right [s]."""
    state, side = run.state, 1.0 if value_at(run.state.friction, right / run.state.length) > 0.0 else -1.0
    low, high = left / state.length, right / state.length
    before = slope_at(state.bound, low) - side * slope_at(state.friction, low)
    after = slope_at(state.bound, high) - side * slope_at(state.friction, high)
    if not before < 0.0 < after:
        return right
    x = high
    for _ in range(POLISHES):
        x = (after * low - before * high) / (after - before)
        slope = slope_at(state.bound, x) - side * slope_at(state.friction, x)
        if slope < 0.0:
            low, before = x, slope
        else:
            high, after = x, slope
    return float(x * state.length)


@inner_kernel
def _note_sign(run: Run, event: int, s: float) -> None:
    """Note the sign of the slip that begins where a stick leaves its cone at time s of the step.

    The polynomials may have another one where the normal force is about to vanish.
    """
    if event == CONE:
        run.state.sign = 1 if _multipliers(run, s)[1] < 0.0 else -1


@inner_kernel
def _first_event(run: Run, law: Law) -> tuple[int, float]:
    """Find the earliest event in the step and its time, or NOTHING and the step's length."""
    state, step = run.state, run.step
    sticks, left = state.mode == STICK, 0.0
    exact = False
    if sticks:
        recall_start(run, law)
        d = _matrix_of(run, contact_at(run.plant, START))
        normal = value_at(state.normal, 0.0)
        exact = _jumps(law, 1.0, normal, d) or _jumps(law, -1.0, normal, d)
    # From node to node: the first interval in which a margin changes its sign has the earliest event.
    for i in range(NODES):
        right = run.propagator.rule.nodes[i] * state.length
        first, s = NOTHING, right
        if state.normal.node[i] < 0.0:
            first, s = RELEASE, _edge(run, law, RELEASE, left, right)
        until, leaves = right, abs(state.friction.node[i]) > state.bound.node[i] * (1.0 + CONE_ROUND_OFF)
        if exact:
            # An excess between the nodes counts as well.
            until = _least_margin(run, left, right)
            if until < right and _margin(run, law, CONE, until) >= 0.0:
                until = right
            leaves = _margin(run, law, CONE, until) < -ROUND_OFF * state.bound.node[i]
        if sticks and leaves:
            at = _edge(run, law, CONE, left, until)
            first, s = (CONE, at) if first == NOTHING or at < s else (first, s)
        elif not sticks and state.sign * step.slip[i] < -SLIP_ROUND_OFF:
            at = locate(run, law, REVERSAL, left, right, 0.0)
            first, s = (REVERSAL, at) if first == NOTHING or at < s else (first, s)
        if first != NOTHING:
            return first, s
        left = right
    return NOTHING, state.length
