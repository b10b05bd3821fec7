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

The impulses of a step are those of the law's impact, where the contact approaches, and of its friction bound
(docs/theory/rigid.md, "Stick or slip"). What forces bring within the step is no impact, or contact that lasts
would bounce in every step; and what they take away before its end need not be stopped. A rebound that forces
end within the step is none: the contact lasts, without restitution.
"""

from math import inf

import numpy as np

from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.engine.kinematics import (
    add_constant,
    checked,
    contact_at,
    free_response,
    modal_force,
    rates_in_frame,
)
from contactlab.engine.memory import SLIP_ROUND_OFF, recall_start
from contactlab.engine.nodes import push_node
from contactlab.engine.plant import Matrix, delassus
from contactlab.engine.propagator import build_level, step_length
from contactlab.engine.state import HELD, INCONSISTENT, LAST, NOTHING, RELEASE, START, Law, Run, hold
from contactlab.laws.base import SLIP, STICK
from contactlab.laws.lagrange import stick_impulse
from contactlab.laws.memory import AT_SLIP, AT_STICK

NONE, ONE, SEVERAL = range(3)
"""How many answers the step of a law has; what is none and what are several see `wedges`."""

ROUND_OFF = 1e-12
"""Of a gap rate, relative to the rates at the contact."""

MOST_ITERATIONS = 50
"""Iterations of the ratio of friction to the normal force that it depends on."""

Answer = tuple[float, float, int, int]
"""Normal and friction impulse [N s], the mode, and how many answers there are."""


@inner_kernel
def step_in_time(run: Run, law: Law) -> int:
    """Take a step that `begin` made ready through rigid contact; returns RELEASE or NOTHING.

    A contact that approaches and for which the law has no impulse ends the run as INCONSISTENT.
    """
    state, contact, level = run.state, run.state.contact, run.state.level
    projects = state.law.projects != 0
    run.step.kind = HELD
    gap, gap_rate, slip, _, _, _, _ = contact_at(run.plant, START)
    contact.max_penetration = max(contact.max_penetration, -gap)
    if contact.start_time < state.run_start <= state.time:
        state.contact_of_run.max_penetration = max(state.contact_of_run.max_penetration, -gap)
    impact = contact.duration == 0.0
    while True:
        p_n, p_t, mode, count = _attempt(run, law, level, gap_rate, slip)
        # Over a long step a graze seems to open by itself; the approach it began with must still be met.
        grazes = impact and gap_rate < 0.0 and p_n <= 0.0
        if not grazes or level >= run.propagator.rule.level_count - 1:
            break
        level += 1
    event, taken = NOTHING, state.length
    normal, friction = p_n / taken, p_t / taken
    if count == NONE:
        state.ending = INCONSISTENT
        normal, friction, taken, mode = 0.0, 0.0, 0.0, state.mode
    elif p_n <= 0.0 and (projects or gap > 0.0):
        # The normal force, linear from that of the step before, reaches zero within the step.
        before = state.normal_before
        taken = taken * before / (before - normal) if before > 0.0 else 0.0
        normal, friction = 0.5 * before, 0.5 * state.friction_before
        event, mode = RELEASE, SLIP
    elif p_n <= 0.0:
        # The gap is closed still and opens by itself.
        normal, friction, mode = 0.0, 0.0, SLIP
    state.accepted_length, before = min(taken, state.end - state.time), state.mode
    # An impact that the end of the run cuts is over there: its impulse acts in a shorter time.
    stretch = taken / state.accepted_length if impact and 0.0 < state.accepted_length < taken else 1.0
    normal, friction = normal * stretch, friction * stretch
    _hold_forces(run, normal, friction)
    state.due_event = 0
    if mode != before and count != NONE and event == NOTHING:
        state.due_event = AT_STICK if mode == STICK else AT_SLIP
    state.mode = mode
    state.wedged_steps += 1 if count == SEVERAL else 0
    if count != NONE and event == NOTHING:
        add_constant(run, level, not projects, True)
        lasting = 0.0 if impact else normal
        contact.peak_normal_force = max(contact.peak_normal_force, normal)
        contact.peak_lasting_force = max(contact.peak_lasting_force, lasting)
        if contact.start_time < state.run_start:
            # A force that is held over a step acts in all of its parts.
            part = state.contact_of_run
            part.peak_normal_force = max(part.peak_normal_force, normal)
            part.peak_lasting_force = max(part.peak_lasting_force, lasting)
        # An impact's force says nothing about the one at which the contact will open. A release that finds
        # the gap open is not looked for at all: no force before means at once.
        lasts = projects and not impact
        state.normal_before = normal if lasts else 0.0
        state.friction_before = friction if lasts else 0.0
        state.contact_steps += 1
    return checked(run, event)


@inner_kernel
def _attempt(run: Run, law: Law, level: int, gap_rate: float, slip: float) -> Answer:
    """Predict and correct a step of a level, with gap rate and slip of its start [m/s].

    Its displacements end corrected, where the law projects, its rates without contact.
    """
    state, step, plant = run.state, run.step, run.plant
    build_level(plant, run.propagator, level)
    h = step_length(run.propagator, level)
    state.length = h
    _turn_frame(run, START)
    free_response(run, level)
    if state.law.projects != 0:
        # Predict (eqs. 49 to 51 of the paper): a pull is no contact force, and nothing is predicted with it.
        p_n, p_t, _, _ = _impulses(run, law, level, gap_rate, slip)
        _hold_forces(run, max(p_n, 0.0) / h, p_t / h if p_n > 0.0 else 0.0)
        add_constant(run, level, True, False)
        # Onto the closed gap along its gradient, by the masses (eq. 57).
        gap = _turn_frame(run, LAST)
        n_u, n_th = step.n_u[0], step.n_th[0]
        shift = gap / delassus(plant, n_u, n_th, step.t_u[0], step.t_th[0])[0]
        for j in range(plant.mode_count):
            mode = plant.modes[j]
            mode.q[LAST] -= modal_force(mode, shift * n_u, shift * n_th, 0.0)
    _turn_frame(run, LAST)
    # Correct (eqs. 58-59): the impulses by the directions at the corrected place.
    return _impulses(run, law, level, gap_rate, slip)


@part_kernel
def _turn_frame(run: Run, place: int) -> float:
    """Set the directions of the step's contact from the displacements at a place; gives the gap [m]."""
    step = run.step
    gap, _, _, step.n_u[0], step.n_th[0], step.t_u[0], step.t_th[0] = contact_at(run.plant, place)
    return gap


@inner_kernel
def _impulses(run: Run, law: Law, level: int, gap_rate: float, slip: float) -> Answer:
    """Return the law's impulses in the step's directions, their mode, and whether they are the only ones.

    The step's end has the rates without contact. The Delassus matrix is that of a force held over the step:
    int w(s) ds / h in place of 1/m.
    """
    state, step = run.state, run.step
    n_u, n_th, t_u, t_th = step.n_u[0], step.n_th[0], step.t_u[0], step.t_th[0]
    nn, nt, tt = 0.0, 0.0, 0.0
    for j in range(run.plant.mode_count):
        mode = run.plant.modes[j]
        if mode.led != 0:
            continue
        normal = n_u * mode.row_u + n_th * mode.row_th
        tangential = t_u * mode.row_u + t_th * mode.row_th + mode.row_r
        # Eq. 4.1: w_j(h)/h in place of one over the mass. A mode that turns within the step yields less, an
        # overdamped one hardly at all.
        mobility = run.propagator.responses[level, j].hold[1, LAST] / state.length
        nn += mobility * normal * normal
        nt += mobility * normal * tangential
        tt += mobility * tangential * tangential
    normal_rate, tangential_rate = rates_in_frame(run, LAST)
    recall_start(run, law)
    rates, d = (normal_rate, tangential_rate), (nn, nt, tt)
    if state.contact.duration == 0.0 or state.law.projects == 0:
        p_n, p_t, friction_mode = impact_impulses(run, law, gap_rate, rates, slip, d)
    else:
        p_n, p_t, friction_mode = lasting_impulses(run, law, rates, slip, d)
    state.critical_friction = nn / abs(nt) if nt != 0.0 else inf
    # An approach that no positive impulse meets has no answer, and eq. 4.7 has several (both Painleve).
    round_off = ROUND_OFF * max(abs(gap_rate), abs(slip), abs(tangential_rate))
    count = ONE
    if p_n <= 0.0 and normal_rate < -round_off:
        count = NONE
    elif wedges(normal_rate, tangential_rate, nn, nt, tt, state.law.friction_limit):
        count = SEVERAL
    return p_n, p_t, friction_mode, count


@inner_kernel
def impact_impulses(
    run: Run, law: Law, gap_rate: float, rates: tuple[float, float], slip: float, d: Matrix
) -> tuple[float, float, int]:
    """Return impulses [N s] and mode of a step that may begin with an impact.

    Args:
        gap_rate: at the start of the step [m/s].
        rates: gap rate and slip that the step ends with without contact [m/s].
        slip: at the start of the step [m/s].
    """
    if run.state.law.projects == 0:
        # Moreau and Jean: 0 <= p _|_ gdot - w >= 0, w being the rebound of the impact at the step's start.
        rebound = 0.0
        if gap_rate < 0.0:
            p_n, p_t = law.impact(gap_rate, slip, d[0], d[1], d[2], law.parameters)
            rebound = max(gap_rate + d[0] * p_n + d[1] * p_t, 0.0)
        return lasting_impulses(run, law, (rates[0] - rebound, rates[1]), slip, d)
    # Eq. 4.8: the approach that the forces of the step have not taken away, without what they add.
    approach = min(max(gap_rate, rates[0]), 0.0)
    if approach == 0.0:
        return lasting_impulses(run, law, rates, slip, d)
    # A law without stick has the friction of the slip at the start all over the step.
    p_n, p_t = law.impact(
        approach, rates[1] if run.state.law.sticks != 0 else slip, d[0], d[1], d[2], law.parameters
    )
    left = remaining_slip(rates[1], p_n, p_t, d[1], d[2])
    rebound = rates[0] + d[0] * p_n + d[1] * p_t
    if rates[0] == approach or rebound >= 0.0:
        return p_n, p_t, STICK if left == 0.0 else SLIP
    # The forces end the rebound within the step.
    start = left if run.state.law.sticks != 0 else slip
    more_n, more_t, mode = lasting_impulses(run, law, (rebound, left), start, d)
    return p_n + more_n, p_t + more_t, mode


@inner_kernel
def lasting_impulses(
    run: Run, law: Law, rates: tuple[float, float], slip: float, d: Matrix
) -> tuple[float, float, int]:
    """Return impulses [N s] and mode that leave no gap rate; arguments as of `impact_impulses`.

    Stick (eq. 4.5) where the bound holds it, else slip against the friction of stick (eq. 4.6). What opens by
    itself is released, p_n <= 0, unless it has stuck and its own friction holds it, see `wedges`.
    """
    h = run.state.length
    p_n, p_t = stick_impulse(rates[0], rates[1], d[0], d[1], d[2])
    # Slip opposes the friction of stick (eq. 4.6); a law that always slips has the sign at the step's start.
    s = -1.0 if p_t > 0.0 else 1.0 if p_t < 0.0 else 0.0
    if run.state.law.sticks == 0:
        s = 1.0 if slip > 0.0 else -1.0 if slip < 0.0 else 0.0
    elif p_n > 0.0 and (rates[0] < 0.0 or abs(slip) <= abs(rates[1] - slip)):
        # Slip that would reverse has ended: it meets static friction.
        rests = run.state.mode == STICK or p_t * slip >= 0.0
        if abs(p_t) <= h * law.bound(p_n / h, 0.0 if rests else slip, law.parameters):
            return p_n, p_t, STICK
    for side in (s, -s):
        # The other sign only where slip of the first presses the bodies together (Painleve): then its
        # friction parts them.
        sliding = side * max(abs(slip), SLIP_ROUND_OFF)
        ratio = sliding_ratio(law, rates[0] / h, sliding, d) if s != 0.0 else 0.0
        if np.isfinite(ratio):
            p_n = -rates[0] / (d[0] + ratio * d[1])
            return p_n, ratio * p_n, SLIP
        if run.state.law.sticks == 0:
            break
    # No slip meets an approach; what opens by itself is released.
    return -abs(rates[0]) / d[0], 0.0, SLIP


@inner_kernel
def friction_ratio(law: Law, normal: float, slip: float) -> float:
    """Return r = F/N of a sliding contact at a normal force [N] and a slip [m/s]."""
    normal = normal if normal > 0.0 else 1.0
    bound = law.bound(normal, slip, law.parameters)
    return float(-bound / normal if slip > 0.0 else bound / normal)


@inner_kernel
def sliding_ratio(law: Law, acceleration: float, slip: float, d: Matrix) -> float:
    """Return r = F/N with which a contact slides, its gap held against an acceleration [m/s^2].

    N = -a/(D_nn + r D_nt) (eq. 4.13), where r may depend on N; no number where the friction of the slip
    presses the bodies together more than N parts them (Painleve).
    """
    normal, ratio = abs(acceleration) / d[0], 0.0
    for _ in range(MOST_ITERATIONS):
        before, ratio = ratio, friction_ratio(law, normal, slip)
        parting = d[0] + ratio * d[1]
        if not parting > 0.0:
            return np.nan
        if abs(ratio - before) <= ROUND_OFF * abs(ratio):
            break
        # The ratio depends on N and N on the ratio; of Coulomb's law the first answer stays.
        normal = abs(acceleration) / parting
    return ratio


@inner_kernel
def remaining_slip(slip: float, p_n: float, p_t: float, d_nt: float, d_tt: float) -> float:
    """Return the slip that impulses leave [m/s], exactly zero where it is round-off."""
    left = slip + d_nt * p_n + d_tt * p_t
    return 0.0 if abs(left) <= ROUND_OFF * max(abs(slip), abs(d_nt * p_n), abs(d_tt * p_t)) else left


@inner_kernel
def wedges(
    normal_rate: float, tangential_rate: float, d_nn: float, d_nt: float, d_tt: float, mu: float
) -> bool:
    """Return whether a contact that opens by itself is held by its own friction, if it once is (Painleve).

    Friction presses the bodies together more than the normal impulse parts them, mu |d_nt| > d_nn, and
    release, stick and a slip between the two all obey the law. None of them creates energy. The slip is no
    limit of a compliant contact: a little more force presses more, a little less releases. Release is the
    limit of one that slides, for it touches with no force; stick is that of one that stuck. Time stepping
    knows which by the slip of the step's start: what the forces of this one step outweigh is none.

    Source: Painleve (1895), C. R. Acad. Sci. 121, 112; Genot and Brogliato (1999), Eur. J. Mech. A 18, 653.
    """
    p_n, p_t = stick_impulse(normal_rate, tangential_rate, d_nn, d_nt, d_tt)
    return bool(normal_rate >= 0.0 and p_n > 0.0 and abs(p_t) <= mu * p_n)


@part_kernel
def _hold_forces(run: Run, normal: float, friction: float) -> None:
    """Hold forces [N] along the step's directions."""
    hold(run.state.normal, normal)
    hold(run.state.friction, friction)
    push_node(run, 0)
    hold(run.step.push_u, run.step.push_u.node[0])
    hold(run.step.push_th, run.step.push_th.node[0])
    hold(run.step.push_r, run.step.push_r.node[0])
