"""Rigid contact in the limit of no step: an impact at the located touch-down, then the constrained motion.

While the contact lasts, the
multipliers N and F of a collocated step hold at every node

    gdot = 0,   and in stick v = 0, |F| <= bound(N, 0), in slip F = -bound(N, v) sign(v) = r N

(docs/theory/rigid.md, eq. 4.12), so that the step has the order of compliant contact and no error of the
law's. A law that always slips holds the slip at zero as well, inside its bound: it is what its chattering in
time stepping tends to (Filippov 1988, Differential Equations with Discontinuous Righthand Sides, sec. 4).

Where slip presses the bodies together more than the normal force parts them, D_nn + r D_nt <= 0 (Painleve),
a contact that opens by itself is released, and one that does not is stopped by an impact without approach.
"""

from math import inf
from typing import Any, NamedTuple

import numpy as np

from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.engine.error_control import IMPULSE_ROUND_OFF, impulse_scale, lengthen
from contactlab.engine.impulses import apply_impact, become, matrix_of, settle
from contactlab.engine.kinematics import (
    add_collocated,
    checked,
    contact_after,
    contact_at,
    free_accelerations,
)
from contactlab.engine.memory import (
    SLIP_ROUND_OFF,
    correct_memory,
    guess_memory,
    memory_at,
    missed_flow,
    open_step,
    recall,
    recall_start,
)
from contactlab.engine.nodes import (
    MOST_ITERATIONS,
    agree,
    fit_nodes,
    move_nodes,
    open_nodes,
    push_nodes,
    solve_linear,
)
from contactlab.engine.plant import Matrix
from contactlab.engine.propagator import step_length
from contactlab.engine.rigid import ROUND_OFF, friction_ratio, sliding_ratio, step_in_time, wedges
from contactlab.engine.rootfinding import CONE_ROUND_OFF, TIME_DIGIT, locate
from contactlab.engine.state import (
    BETWEEN,
    COLLOCATED,
    CONE,
    FLIGHT,
    INCONSISTENT,
    NODES,
    NOTHING,
    PEAK,
    RELEASE,
    REVERSAL,
    RUNNING,
    START,
    UNSOLVED,
    Law,
    Run,
    slope_at,
    value_at,
)
from contactlab.laws.base import SLIP, STICK
from contactlab.laws.lagrange import stick_impulse

LASTING = 1e-6
"""Approach over slip of the impact that ends a sliding contact which presses itself together (Painleve)."""

POLISHES = 3
"""Secants to the least margin between two nodes: what is left of the way to it is negligible squared."""

MOST_HALVINGS = 100
"""Of the bracket around the instant of an event."""


class Multipliers(NamedTuple):
    """Normal force and friction [N] that hold gap and, in stick, slip."""

    normal: float
    friction: float


@inner_kernel
def step_rigid(run: Run, law: Law) -> int:
    """Take a step that `begin` made ready through a rigid contact; returns the event that ends it.

    A contact that approaches has its impact first, which takes no time; under a prescribed load it has none.
    RELEASE is a normal force that falls through zero, or a rebound. A law with a contact step is stepped in
    time.
    """
    if run.state.law.stepped != 0:
        return step_in_time(run, law)
    state, step, contact = run.state, run.step, run.state.contact
    step.kind, state.accepted_length = COLLOCATED, 0.0
    state.length = step_length(run.propagator, state.level)
    _, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    # An approach at the start of a contact is an impact; later, gap rates are what collocation leaves.
    begins = contact.duration == 0.0 and contact.normal_impulse == 0.0 and run.plant.wave.led_slip == 0
    if begins and rate < 0.0:
        flies = apply_impact(run, law, rate, slip)
        if flies or state.ending != RUNNING:
            return _at_once(run, RELEASE if flies else NOTHING)
    _part_from_stick(run, law, slip)
    known = _start(run, law)
    if state.ending != RUNNING or known.normal <= 0.0:
        return _at_once(run, RELEASE if state.ending == RUNNING else NOTHING)
    if contact.duration == 0.0 or state.impulse_scale == 0.0:
        state.impulse_scale = _momentum(run, law, known.normal)
    level, error = _solve(run, law, known)
    if state.ending != RUNNING:
        return _at_once(run, NOTHING)
    # The step is solved whole and then cut.
    remaining = min(state.end, state.piece_end) - state.time
    event, s = _first_event(run, law)
    if event == CONE:
        # The slip that begins opposes the friction that stick would need there. The polynomials may give it
        # another sign where the normal force is about to vanish.
        state.sign = 1 if _multipliers(run, s)[1] < 0.0 else -1
    event, s = (NOTHING, remaining) if s > remaining else (event, s)
    state.accepted_length = s
    _note_peak(run, law, contact, 0.0, known.normal)
    if contact.start_time < state.run_start:
        # The first step of a run that goes on is that of the run before.
        first = max(state.run_start - state.time, 0.0)
        _note_peak(run, law, state.contact_of_run, first, value_at(state.normal, first / state.length))
    if s == state.length:
        add_collocated(run, level)
    state.contact_steps += 1
    lengthen(run, level, error)
    return checked(run, event)


@inner_kernel
def _momentum(run: Run, law: Law, normal: float) -> float:
    """Return the impulse [N s] that scales errors in a contact that begins with a normal force [N]."""
    state = run.state
    d_nn, d_nt, d_tt = matrix_of(run, contact_at(run.plant, START))
    scale = impulse_scale(run, law, state.impact_speed, normal, d_nn)
    # A prescribed slip has no forces of stick, and may have no mobility to divide by.
    if run.plant.wave.led_slip != 0:
        return scale
    # At least what round-off of the rates does to the forces of a stick: D^-1 magnifies it the more, the
    # closer normal and tangential answers are to the same one.
    magnified = d_nn * (d_nn + d_tt) / (d_nn * d_tt - d_nt * d_nt)
    return float(scale * max(1.0, IMPULSE_ROUND_OFF / state.tolerance * magnified))


@inner_kernel
def _part_from_stick(run: Run, law: Law, slip: float) -> None:
    """Let a contact that goes on in stick slide where it has more slip [m/s] than steps leave.

    Another run has begun in it, or a prescribed velocity has jumped. Nothing approaches, so that there is no
    normal impulse to bound one of friction, and none that stops the slip (eq. 4.5).
    """
    state = run.state
    # Nothing scales the errors yet of a contact that has begun elsewhere.
    if state.mode != STICK or state.impulse_scale != 0.0 or state.contact.duration == 0.0:
        return
    d_nn, d_nt, d_tt = matrix_of(run, contact_at(run.plant, START))
    a_n, a_t = free_accelerations(run, START, 0.0)
    normal, _ = stick_impulse(a_n, a_t, d_nn, d_nt, d_tt)
    left = d_tt * state.tolerance * _momentum(run, law, max(normal, 0.0))
    if abs(slip) > max(left, SLIP_ROUND_OFF):
        become(run, law, SLIP, slip)


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
    # Slip against the friction `side`, r = side kinetic/N: D_nn + r D_nt <= 0 leaves no normal force to slide
    # with.
    opens = d[0] + side * kinetic / normal * d[1] <= 0.0
    return bool(opens or abs(static - kinetic) > CONE_ROUND_OFF * static)


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
    # Where friction merely leaves its bound, slip begins with the forces of stick: a small excess for a step
    # is an error as any other.
    excess = abs(friction) - bound * (1.0 + CONE_ROUND_OFF)
    return bool(normal > 0.0 and excess * state.length <= state.tolerance * state.impulse_scale)


@inner_kernel
def _passes_zero(run: Run, law: Law) -> bool:
    """Return whether a slip that is located at zero goes on beyond it, as friction cannot hold it there.

    What location has left of it is then no impulse: on a heavy rotor it would be one far outside of the cone.
    """
    frame = contact_at(run.plant, START)
    if abs(frame[2]) > SLIP_ROUND_OFF:
        return False
    d = matrix_of(run, frame)
    a_n, a_t = free_accelerations(run, START, 0.0)
    recall_start(run, law)
    normal, friction = stick_impulse(a_n, a_t, d[0], d[1], d[2])
    return not _sticks(run, law, normal, friction, d)


@inner_kernel
def _start(run: Run, law: Law) -> Multipliers:
    """Return the forces where the step begins, a normal force of zero where the contact opens; sets mode.

    A slip that is at zero begins against the friction that stick would need.
    """
    state = run.state
    # Twice at most: an impact that stops a slip (Painleve) leaves a contact that sticks or slides the other
    # way.
    for _ in range(2):
        frame = settle(run, state.mode == STICK and not _passes_zero(run, law))
        d = matrix_of(run, frame)
        d_nn, d_nt, d_tt = d
        # Eq. 4.13: the multipliers where the step starts are those of the accelerations without contact.
        a_n, a_t = free_accelerations(run, START, 0.0)
        recall_start(run, law)
        state.critical_friction = d_nn / abs(d_nt) if d_nt != 0.0 else inf
        # Eq. 4.7, counted as a statistic: what slides is released and what sticks is held, as before.
        if wedges(a_n, a_t, d_nn, d_nt, d_tt, state.law.friction_limit):
            state.wedged_steps += 1
        slip = frame[2]
        if state.mode == STICK and abs(slip) > SLIP_ROUND_OFF:
            # `settle` leaves a slip that is prescribed.
            become(run, law, SLIP, slip)
        if state.mode == STICK:
            normal, friction = stick_impulse(a_n, a_t, d_nn, d_nt, d_tt)
            if _sticks(run, law, normal, friction, d):
                return Multipliers(normal, friction)
            # Stick outside of its bound opens by itself or slides, against the friction that it would need.
            if normal <= 0.0 <= a_n:
                return Multipliers(0.0, 0.0)
            become(run, law, SLIP, -friction)
        elif state.sign * slip < -SLIP_ROUND_OFF:
            state.sign = -state.sign
        # Eq. 4.13 in slip: a_n + (D_nn + r D_nt) N = 0, the ratio r itself a function of N.
        ratio = sliding_ratio(law, a_n, state.sign * max(abs(slip), SLIP_ROUND_OFF), d)
        if np.isfinite(ratio):
            normal = max(-a_n / (d_nn + ratio * d_nt), 0.0)
            return Multipliers(normal, ratio * normal)
        # Slip that presses the bodies together parts where it opens by itself; else an impact without
        # approach stops it (Painleve), and the contact is looked at once more.
        if a_n >= 0.0 or apply_impact(run, law, -LASTING * abs(slip), slip) or state.ending != RUNNING:
            return Multipliers(0.0, 0.0)
    state.ending = INCONSISTENT
    return Multipliers(0.0, 0.0)


@inner_kernel
def _solve(run: Run, law: Law, known: Multipliers) -> tuple[int, float]:
    """Shorten a step until it is accepted; returns its level and its error over the tolerance."""
    state, rule = run.state, run.propagator.rule
    gap, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    # A slip that begins at zero has the rates of slip, as at the nodes: those of stick are of another flow,
    # and no step is short enough to go on from them.
    sliding = 0.0 if state.mode == STICK else state.sign * max(abs(slip), SLIP_ROUND_OFF)
    open_step(run, law, law.memory, gap, rate, sliding, known.normal)
    level, error = state.level, 0.0
    # Where no step is good, the shortest eight levels are accepted with any finite error, which the ledger
    # then contains.
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
def _attempt(run: Run, law: Law, level: int, known: Multipliers) -> float:
    """Solve a step at a level; returns its error over the tolerance, infinite where it has no solution.

    The error is what the polynomials of the multipliers miss of their values at the step's start, as an
    impulse, and those of the internal variables of their rates.
    """
    state, step = run.state, run.step
    h = open_nodes(run, level)
    state.length = h
    _, _, _, n_u, n_th, t_u, t_th = contact_at(run.plant, START)
    for i in range(NODES):
        # The iteration starts from the forces known at the step's start, held over the step.
        step.n_u[i], step.n_th[i], step.t_u[i], step.t_th[i] = n_u, n_th, t_u, t_th
        state.normal.node[i], state.friction.node[i] = known.normal, known.friction
        state.bias.node[i] = known.friction / known.normal
        step.loss[i], step.end[i] = 0.0, 0.0
    push_nodes(run)
    guess_memory(run, law.memory)
    sweeps = _collocate(run, law, level)
    state.accepted_length = 0.0
    state.sweeps += sweeps
    if sweeps == 0:
        return inf
    # As eq. 3.10, with the multipliers of eq. 4.13 as what is known. No node is at the start of the step, so
    # that they are independent of what the collocation has solved.
    missed_normal = abs(state.normal.coefficient[0] - known.normal)
    error = max(missed_normal, abs(state.friction.coefficient[0] - known.friction))
    # The multipliers may not depend on the internal variables, as at rest: these have an error of their own.
    flowed = missed_flow(run, law.memory) / state.tolerance
    return float(max(error * h / (state.tolerance * state.impulse_scale), flowed))


@inner_kernel
def _collocate(run: Run, law: Law, level: int) -> int:
    """Iterate the multipliers of a step; returns the number of sweeps, 0 where it does not contract.

    The system is linear but for the directions of the contact, which hardly turn within a step.
    """
    state, step = run.state, run.step
    sticks = state.mode == STICK
    size = 2 * NODES if sticks else NODES
    for sweep in range(1, MOST_ITERATIONS + 1):
        most = 0.0
        move_nodes(run, level)
        for i in range(NODES):
            slip = step.slip[i]
            most = max(most, abs(state.normal.node[i]), abs(state.friction.node[i]))
            recall(run, law, i)
            if not sticks:
                # `bias` has r = F/N in a rigid slip; as N changes with every sweep, so does r.
                slides = state.sign * max(state.sign * slip, SLIP_ROUND_OFF)
                state.bias.node[i] = friction_ratio(law, abs(state.normal.node[i]), slides)
        # Eq. 4.12 at all nodes: gap rates, and in stick slips, to zero by the multipliers.
        change = _correct(run, level, sticks, size)
        flowed = correct_memory(run, law, law.memory, state.length)
        if not np.isfinite(change):
            return 0
        if agree(state, change, most, flowed):
            # The cone is a matter of events: the bound and its middle, zero, are noted for them. In slip the
            # friction is its own bound.
            for i in range(NODES):
                bound = abs(state.friction.node[i])
                if sticks:
                    recall(run, law, i)
                    bound = law.bound(max(state.normal.node[i], 0.0), 0.0, law.parameters)
                    step.slip[i] = 0.0
                state.bound.node[i], state.bias.node[i] = bound, 0.0
            fit_nodes(run)
            return sweep
    return 0


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
        # Rates at node i by unit multipliers at node m: eq. 3.7 with both directions, the counterpart of D.
        for m in range(NODES):
            uu, mixed, thth = tip_v[0, m, i], tip_v[1, m, i], tip_v[2, m, i]
            m_u, m_th, s_u, s_th = step.n_u[m], step.n_th[m], step.t_u[m], step.t_th[m]
            # Answers of u and th to a unit normal force and to a unit friction.
            by_normal_u, by_normal_th = uu * m_u + mixed * m_th, mixed * m_u + thth * m_th
            by_friction_u, by_friction_th = uu * s_u + mixed * s_th, mixed * s_u + thth * s_th
            normal = n_u * by_normal_u + n_th * by_normal_th
            crossed = n_u * by_friction_u + n_th * by_friction_th
            if sticks:
                system[i, m], system[i, NODES + m] = normal, crossed
                system[NODES + i, m] = t_u * by_normal_u + t_th * by_normal_th
                system[NODES + i, NODES + m] = t_u * by_friction_u + t_th * by_friction_th + tip_v[3, m, i]
            else:
                system[i, m] = normal + crossed * state.bias.node[m]
        system[i, size] = -step.gap_rate[i]
        if sticks:
            system[NODES + i, size] = -step.slip[i]
        else:
            # Friction follows the normal force that there is.
            for m in range(NODES):
                missing = state.bias.node[m] * state.normal.node[m] - state.friction.node[m]
                uu, mixed, thth = tip_v[0, m, i], tip_v[1, m, i], tip_v[2, m, i]
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
        change = abs(state.normal.node[i] - before_normal) + abs(state.friction.node[i] - before_friction)
        # NaN fails every comparison, and is passed on.
        most = change if not change <= most else most
    push_nodes(run)
    return most


@inner_kernel
def _multipliers(run: Run, s: float) -> tuple[float, float, Matrix]:
    """Return the forces that hold gap and slip at time s of the step [N], and the Delassus matrix there."""
    # Eq. 4.13 in stick at any time of the step: the flow to it is exact, where the polynomials of N and F
    # have an error of their own.
    d = matrix_of(run, contact_after(run, s))
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
    # Room in the cone. The bound is that of the multiplier's own N, and not of the polynomial's.
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
    # An end that stays twice has its value halved, or the secant would creep along a curved margin.
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
    # A zero of the margin's derivative, by secants that keep the bracket: bound and friction are polynomials,
    # and their difference is smooth as long as friction keeps its sign.
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
def _first_event(run: Run, law: Law) -> tuple[int, float]:
    """Find the earliest event in the step and its time, or NOTHING and the step's length."""
    state, step = run.state, run.step
    sticks, left = state.mode == STICK, 0.0
    exact = False
    if sticks:
        recall_start(run, law)
        d = matrix_of(run, contact_at(run.plant, START))
        normal = value_at(state.normal, 0.0)
        # Where the forces jump as the cone is left, no excess over it is negligible.
        exact = _jumps(law, 1.0, normal, d) or _jumps(law, -1.0, normal, d)
    # From node to node: the first interval in which a margin changes its sign has the earliest event.
    for i in range(NODES):
        right = run.propagator.rule.nodes[i] * state.length
        first, s = NOTHING, right
        # A pull at a node: the normal force has fallen through zero before it.
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
