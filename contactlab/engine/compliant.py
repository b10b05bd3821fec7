"""One step of a compliant contact: its error, its length and its events, for a given friction mode.

The oscillators answer a polynomial force exactly, so only the force itself is unknown: its values at the
nodes are iterated until the law agrees with the motion that they cause (`contactlab.engine.collocation`). In
slip the friction is the law's bound against the slip; in stick it is the friction that holds the slip at zero
at every node. Friction that is not set-valued is in `contactlab.engine.friction`.
"""

from typing import Any

import numpy as np

from contactlab.compiler.kernels import inner_kernel
from contactlab.compiler.lanes import larger, largest, load
from contactlab.engine.collocation import TOUCHED, Known, beside_spring, iterate, sound_normal
from contactlab.engine.error_control import impulse_scale, lengthen
from contactlab.engine.friction import (
    LEAST_SLIP,
    NUDGE,
    friction_and_steepness,
    missed_between,
    missed_past_limits,
    missed_rate,
)
from contactlab.engine.kinematics import add_collocated, checked, contact_at
from contactlab.engine.memory import SLIP_ROUND_OFF, end_at, jump, missed_flow, open_step, recall_start
from contactlab.engine.nodes import FIRST, mobilities, open_nodes
from contactlab.engine.plant import delassus
from contactlab.engine.propagator import step_length
from contactlab.engine.rootfinding import (
    CONE_ROUND_OFF,
    event_value,
    first_event,
    first_guard,
    keeps_slip,
    track_extremes,
)
from contactlab.engine.state import (
    CHATTERED,
    COLLOCATED,
    CONE,
    EVENT_LIMIT,
    LAST,
    NODES,
    NOTHING,
    REVERSAL,
    START,
    UNSOLVED,
    Law,
    Run,
    hold,
    value_at,
)
from contactlab.laws.base import RATE_DEPENDENT, SET_VALUED, SLIP, STICK
from contactlab.laws.memory import AT_SLIP, AT_STICK

HIGHEST_SHARE = 0.1
"""Error of a polynomial at the step's start over its highest coefficient, where no value is known [1]."""

NODE_PRODUCT = 126.0
"""Reciprocal product of the Radau nodes, (2 n - 1)!/(n! (n - 1)!) of n = 5 [1]."""

KINK = 1e3
"""Error over the tolerance of a step that cannot be judged: it has a kink that is not negligible."""

LEAST_DEPTH = 1e-8
"""Scale of the difference of the gap for the normal stiffness near zero [m]."""

CLOCK = 64.0 * np.finfo(np.float64).eps
"""Shortest step over the time at which it begins: below it the clock decides, and no force."""

FAR = 1e3
"""Friction that a stick would need over its bound [1], beyond which a shorter step is not asked."""

YIELDED = 1e-30
"""Slip velocity [m/s] that no force leaves to a prescribed one, whose body is as heavy as can be."""

REMEMBERED = 1e-2
"""Share of the negligible impulse down to which a contact that remembers walks up to its release."""


@inner_kernel
def attempt(run: Run, law: Law, level: int, known: Known) -> float:
    """Solve a step at a level; returns its error over the tolerance, infinite where it has no solution.

    The error is what the polynomials of normal force, bound and friction miss of their known values
    at the step's start, as an impulse; friction that sticks has no known start and is judged by its
    highest coefficient, as is an elastic force that a damping outweighs, and of rate-dependent friction
    counts what no change of the slip makes good; internal variables have one where nothing else tells of
    them. A step in which the gap opens, or the force ends or begins before it, carries a kink, and stands
    only when the whole normal force left is negligible; friction that goes on without it is judged as ever.
    """
    state = run.state
    depends = state.law.friction_kind == RATE_DEPENDENT
    h = open_nodes(run, level)
    stretch = h / state.length
    state.length = h
    # -f_v dv/dF of eq. 3.9: above one sweeps diverge, and a small error of the force is a large one of the
    # slip.
    stiffness = known.steepness * mobilities(run, level, FIRST)[FIRST]
    sweeps = iterate(run, law, level, known, stretch, stiffness)
    state.accepted_length = 0.0
    state.sweeps += sweeps
    if sweeps == 0:
        return np.inf
    allowed = state.tolerance * state.impulse_scale
    kinked, beside = _kinked_force(run, known), _outweighed_error(run)
    if not depends:
        beside = max(beside, abs(state.bias.coefficient[0] - known.bias))
    # With a kink in it a step's error goes with no high power of h. It stands only where the whole force is
    # negligible, and then counts as half of what is allowed.
    if kinked >= 0.0:
        return max(0.5, beside * h / allowed) if kinked * h <= allowed else KINK
    # Eq. 3.10: a polynomial through the nodes misses what is known at the step's start.
    error = max(abs(state.normal.coefficient[0] - known.normal), beside)
    if not depends:
        error = max(error, abs(state.bound.coefficient[0] - known.bound))
    if state.law.friction_kind != SET_VALUED:
        # Of steep friction counts what no change of the slip makes good.
        error = max(error, abs(state.friction.coefficient[0] - known.friction) / (1.0 + stiffness))
        # Eq. 3.11: the law is evaluated half-way between the nodes too, where a kink of a variable's rate
        # shows.
        flows, yielding = depends or state.mode == STICK, mobilities(run, level, FIRST)[FIRST]
        error = missed_between(run, law, flows, yielding, error, allowed / h)
        if depends and error <= allowed / h:
            error = missed_past_limits(run, law, known.normal, error)
    # In stick nothing is known of the friction at the start: its highest coefficient stands for the error.
    if state.mode == STICK:
        error = max(error, HIGHEST_SHARE * abs(_highest_coefficient(run, level)))
    return float(max(error * h / allowed, _flow_error(run, law, known, h) / state.tolerance))


@inner_kernel
def _flow_error(run: Run, law: Law, known: Known, h: float) -> float:
    """Return what internal variables miss over a step of length h [1], where no force tells of them.

    None does without a normal force, nor where the longest step in contact would not feel the friction, or
    that does not depend on the coupled variable, as of a dashpot's spring while it slides. Else,
    and in a step that is too short to feel the normal force, it is zero.
    """
    state, propagator, normal = run.state, run.propagator, known.normal
    allowed = state.tolerance * state.impulse_scale
    depends, pressed, missed = (
        state.law.friction_kind == RATE_DEPENDENT,
        largest(load(state.normal.node)),
        0.0,
    )
    # Without a normal force friction is zero whatever its variables are, and eq. 3.11 is zero.
    idle = normal == 0.0 == pressed
    if idle:
        missed = missed_flow(run, law.memory)
    if depends and (idle or max(normal, pressed) * h > allowed):
        most = abs(known.friction)
        for i in range(NODES):
            most = max(most, abs(state.friction.node[i]))
        # A slider without a force keeps its spring, whatever rate the law has for it.
        unfelt = most * step_length(propagator, propagator.rule.contact_level) <= allowed
        missed = max(missed, missed_rate(run, law, normal, unfelt))
    return float(missed)


@inner_kernel
def _highest_coefficient(run: Run, level: int) -> float:
    """Return the highest coefficient of the friction [N], in rigid stick without that of the slip residue.

    The residue v_0 of the step before takes the impulse v_0/D_tt, whatever the length of the step.
    """
    highest = float(run.state.friction.coefficient[NODES - 1])
    # A spring has no residue: it does not hold the slip at zero.
    if run.state.law.friction_kind != SET_VALUED:
        return highest
    # The slip that begins at v_0 and is zero at all nodes is v_0 prod_i (1 - x/c_i). The friction behind it
    # is its derivative over the mobility, with the highest coefficient -NODES v_0/prod_i c_i.
    slip, yielding = contact_at(run.plant, START)[2], 0.0
    for m in range(NODES):
        yielding += mobilities(run, level, m)[LAST]
    return highest + NODES * NODE_PRODUCT * slip / yielding


@inner_kernel
def _kinked_force(run: Run, known: Known) -> float:
    """Return the largest force [N] of a step in which the gap opens, or the force ends or begins; else -1."""
    state, step, normal = run.state, run.step, known.normal
    # The force ends at a node, or a node is beyond the release: somewhere before it lies a kink.
    kinked = largest(load(step.gap) - load(step.end)) >= 0.0
    for i in range(NODES):
        kinked = kinked or (normal > 0.0 and state.normal.node[i] == 0.0)
    forces = load(state.normal.node)
    if not kinked and (normal != 0.0 or forces[0] != 0.0 or largest(forces) <= 0.0):
        return -1.0
    sizes = abs(forces)
    if state.law.friction_kind == RATE_DEPENDENT:
        # Friction that no bound ties to the normal force.
        sizes = larger(sizes, abs(load(state.friction.node)))
    return max(abs(normal), abs(known.friction), largest(sizes))


@inner_kernel
def _outweighed_error(run: Run) -> float:
    """Return the error [N] of an elastic force in a closed gap that a damping outweighs; zero without.

    It moves nothing and so is no part of the normal force, but its loss is one of the ledger.
    """
    step, rule = run.step, run.propagator.rule
    outweighed = False
    for i in range(NODES):
        outweighed = outweighed or run.state.normal.node[i] == 0.0
    if not outweighed or largest(load(step.gap) - load(step.end)) >= 0.0:
        return 0.0
    highest, fastest = 0.0, largest(abs(load(step.gap_rate)))
    for i in range(NODES):
        # Highest coefficient of the loss's polynomial (eq. 3.2): over the fastest gap rate it is a force.
        highest += rule.lagrange[i, NODES - 1] * step.loss[i]
    return HIGHEST_SHARE * abs(highest) / fastest if fastest > 0.0 else 0.0


@inner_kernel
def step_compliant(run: Run, law: Law) -> int:
    """Take a step that `begin` made ready through compliant contact; returns the event that ends it.

    The mode of the step that follows is set by `switch_friction` once the step is committed.
    """
    state, step = run.state, run.step
    step.kind = COLLOCATED
    # The directions where the step starts serve as first guess of those at its nodes.
    gap, rate, slip, n_u, n_th, t_u, t_th = contact_at(run.plant, START)
    for i in range(NODES):
        step.n_u[i], step.n_th[i], step.t_u[i], step.t_th[i] = n_u, n_th, t_u, t_th
    known = _start_forces(run, law, gap, rate, slip)
    open_step(run, law, law.memory, gap, rate, 0.0 if state.mode == STICK else slip, known.normal)
    # The impulse P of eq. 3.10, once for the whole contact: relative to forces that vanish as it ends, its
    # last steps would have to be as exact as its peak.
    if state.contact.duration == 0.0 or state.impulse_scale == 0.0:
        mobility = delassus(run.plant, n_u, n_th, t_u, t_th)[0]
        # Where adhesion balances the elastic force there is friction, and a normal force on the way in.
        inward = law.force(0.5 * gap, rate, slip, state.impact_speed, law.parameters)[0]
        load = max(abs(known.normal), abs(inward), known.bound + abs(known.bias), abs(known.friction))
        state.impulse_scale = impulse_scale(run, law, rate, load, mobility)
    if known.bound == 0.0 and state.mode == SLIP and slip != 0.0:
        # What has no say in the slip cannot have followed its sign.
        state.sign = 1 if slip > 0.0 else -1
    # The iteration begins with the last step's polynomials, on which this one starts at x = s/h. Where there
    # is no such step, or a coarser one is to follow, it begins with constant forces.
    if state.contact.duration > 0.0 and state.level >= state.level_before:
        state.accepted_length /= state.length
    else:
        state.accepted_length = 0.0
        hold(state.normal, known.normal)
        hold(state.bound, known.bound)
        hold(state.bias, known.bias)
        hold(state.friction, known.friction)
        hold(state.internal_rate, 0.0)
    level, error, normal = _solve(run, law, gap, rate, slip, known)
    if state.ending == UNSOLVED:
        return checked(run, NOTHING)
    # The step is solved whole and then cut: an event at its zero, and what is left of run and waveform.
    remaining = min(state.end, state.piece_end) - state.time
    event, s = first_event(run, law, rate)
    event, s = first_guard(run, law, law.memory, event, s)
    if s > remaining:
        event, s = NOTHING, remaining
    state.accepted_length = s
    track_extremes(run, law, gap, rate, normal)
    # The motion at the nodes of a whole step; of a cut one the recorder goes to nodes of its own.
    if s == state.length:
        add_collocated(run, level)
    state.contact_steps += 1
    lengthen(run, level, error)
    return checked(run, event)


@inner_kernel
def _solve(
    run: Run, law: Law, gap: float, rate: float, slip: float, known: Known
) -> tuple[int, float, float]:
    """Shorten a step until it is accepted; returns its level, relative error and first normal force."""
    state, step, rule = run.state, run.step, run.propagator.rule
    largest_force = max(abs(known.normal), known.bound)
    level = _separation_level(run, gap - end_at(run, law, law.memory, rate), rate, largest_force)
    # The shortest step at this time.
    # The end of a step below some digits of the clock is round-off.
    finest = rule.level_count - 9
    while finest > rule.contact_level and step_length(run.propagator, finest) < CLOCK * state.time:
        finest -= 1
    flips, error = 0, 0.0
    while level < rule.level_count:
        error = attempt(run, law, level, known)
        # A dip that ends before the first node would be left where it begins, still approaching,
        # unless nothing of it could be seen.
        overlong = step.gap[0] >= step.end[0] and rate * state.length < TOUCHED
        # A prescribed slip reverses where a piece of its path ends, and friction may have a kink there.
        overlong = overlong or (run.plant.wave.led_slip != 0 and step.slip[0] * step.slip[NODES - 1] < 0.0)
        # At the shortest step a large error is accepted, which the ledger and the error of the run then
        # contain; a step without a solution is not.
        refined = (error > 1.0 or overlong) and (level < finest or error == np.inf)
        if refined and not _denied_by_far(run):
            state.rejected_steps += 1
            # Half the length has a sixty-fourth of the error: with more than 500 times what is allowed a
            # quarter is surely needed.
            level += 2 if error > 500.0 or overlong else 1
            if error < np.inf:
                level = min(level, finest)
        elif _contradicted(run, law, slip, known.bound, known.bias) and not (
            flips > 1 and largest_force * state.length <= state.tolerance * state.impulse_scale
        ):
            # Neither slipping nor sticking fits at this length: look closer before trying again. Where the
            # contact has no force any more that counts, the last one tried is as good as the other.
            flips += 1
            level += 2 * (flips // 2)
            jump(run, law, law.memory, AT_STICK if state.mode == STICK else AT_SLIP)
            known = _start_forces(run, law, gap, rate, slip)
            open_step(run, law, law.memory, gap, rate, 0.0 if state.mode == STICK else slip, known.normal)
        else:
            break
    else:
        state.ending = UNSOLVED
    return level, error, known.normal


@inner_kernel
def _denied_by_far(run: Run) -> bool:
    """Return whether a stick would need a friction far beyond its bound, at every node.

    It would have to hold what is too heavy, in steps of any length; a short one leaves the round-off of its
    slip over its length.
    """
    state = run.state
    if state.mode != STICK or state.law.friction_kind != SET_VALUED or largest(load(state.bound.node)) == 0.0:
        return False
    for i in range(NODES):
        if not abs(state.friction.node[i] - state.bias.node[i]) > FAR * state.bound.node[i]:
            return False
    return True


@inner_kernel
def _start_forces(run: Run, law: Law, gap: float, rate: float, slip: float) -> Known:
    """Return what is known of the forces where the step begins."""
    state = run.state
    recall_start(run, law)
    end = end_at(run, law, law.memory, rate)
    if gap >= end:
        if rate >= 0.0:
            return Known(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        gap = end + TOUCHED
    # The slip that the law receives has the sign of the mode: for zero it would return the static bound, and
    # for a residue of the wrong sign the friction of slip the other way.
    seen = slip
    if state.mode == STICK:
        seen = 0.0
    elif state.law.friction_kind == SET_VALUED and state.sign * slip < SLIP_ROUND_OFF:
        seen = state.sign * SLIP_ROUND_OFF
    normal, least, most, _, _ = law.force(gap, rate, seen, state.impact_speed, law.parameters)
    if least == most:
        # Without a bound the slip reverses within a step, and the sign is that of the slip before.
        normal, least, most, _, _ = law.force(gap, rate, slip, state.impact_speed, law.parameters)
    bound = 0.5 * (most - least)
    normal, bias = sound_normal(normal, bound), 0.5 * (most + least)
    friction, steepness = 0.0, 0.0
    if state.law.friction_kind != SET_VALUED:
        at = gap, rate, slip
        friction, steepness = friction_and_steepness(law, at, end, normal)
    steepness = steepness if state.law.friction_kind == RATE_DEPENDENT else 0.0
    # On the way of the gap, whose other side may be another branch of the law.
    way = -NUDGE if rate < 0.0 else NUDGE
    # -dN/dg and -dN/dgdot by one-sided differences, for the choice between sweeps and Newton steps.
    dg, dr = way * (abs(gap) + LEAST_DEPTH), way * (abs(rate) + LEAST_SLIP)
    stiffness = (normal - law.force(gap + dg, rate, seen, state.impact_speed, law.parameters)[0]) / dg
    damping = (normal - law.force(gap, rate + dr, seen, state.impact_speed, law.parameters)[0]) / dr
    bias += beside_spring(run, law, (gap, rate, slip), end, normal)
    return Known(normal, bound, bias, friction, steepness, stiffness, damping)


@inner_kernel
def _separation_level(run: Run, gap: float, rate: float, normal: float) -> int:
    """Return the level that approaches a release at a gap [m] below its own while the force matters."""
    state, level = run.state, run.state.level
    if rate > 0.0 and gap < 0.0:
        h = step_length(run.propagator, level)
        # At most 0.7 of the way to the release at the present rate, geometrically: a step across it has a
        # kink, and would be rejected. That ends once the force left is below tolerance as an impulse. What is
        # remembered flows on past the release at another rate, whatever the force is by then.
        flows = state.law.variables > state.law.coupled
        small = state.tolerance * state.impulse_scale * (REMEMBERED if flows else 1.0)
        finest = run.propagator.rule.level_count - 1
        while h * rate > -0.7 * gap and abs(normal) * h > small and level < finest:
            level += 1
            h *= 0.5
    return int(level)


@inner_kernel
def most_events(state: Any) -> int:
    """Return how many events a window may have."""
    return int(EVENT_LIMIT * kinked_variables(state))


@inner_kernel
def kinked_variables(state: Any) -> int:
    """Return the number of variables by which a window has events, and steps that shrink to a kink.

    Each internal variable of a law with guards has its own.
    """
    return int(max(state.law.variables, 1) if state.law.guards > 0 else 1)


@inner_kernel
def count_event(state: Any) -> None:
    """Count a touch-down, friction switch or guard; too many in one window is chattering."""
    state.watchdog.longest_quiet = max(state.watchdog.longest_quiet, state.time - state.watchdog.last_event)
    state.watchdog.last_event = state.time
    state.watchdog.events += 1
    if state.watchdog.events > most_events(state):
        state.ending = CHATTERED


@inner_kernel
def switch_friction(state: Any, event: int) -> None:
    """Set the friction mode after a step that ended in REVERSAL or CONE; a rigid one has noted its sign."""
    # The polynomials of a step are those of its mode: the friction at the event is the last that stick
    # needed.
    x = state.accepted_length / state.length
    friction = value_at(state.friction, x) - value_at(state.bias, x)
    _switch(state, event, friction if state.law.constrained == 0 else -state.sign)


@inner_kernel
def _switch(state: Any, event: int, friction: float) -> None:
    """Let the contact stick, or slip against a friction [N] that it cannot hold, less the bound's middle."""
    state.mode = STICK
    # Friction opposes the slip that it could not hold (eq. 3.5): at a positive one slip begins backwards.
    if event == CONE:
        state.mode, state.sign = SLIP, -1 if friction > 0.0 else 1
    state.friction_switches += 1
    count_event(state)


@inner_kernel
def _contradicted(run: Run, law: Law, slip: float, bound: float, bias: float) -> bool:
    """Return whether the step contradicts its own friction mode at its start; the other mode is then set.

    Stick is valid if its friction lies within `bound` of `bias` [N] at the start, not only at the first node;
    an excess counts by its impulse over the step, beyond the error of the friction. Slip that starts from
    zero into the wrong direction must stick, or turn if it is prescribed. Rate-dependent friction has no
    modes.
    """
    state, step = run.state, run.step
    # Friction less the middle of its bounds, which is zero for most laws.
    friction, sticks = state.friction.node[0] - state.bias.node[0], state.mode == STICK
    if state.law.friction_kind == RATE_DEPENDENT:
        return False
    if keeps_slip(run):
        turned = state.sign * step.slip[0] < -YIELDED
        state.sign = -state.sign if turned else state.sign
        return bool(turned)
    if sticks:
        # The friction that stick demands lies outside of its bound at the first node and, by the polynomials,
        # at the start.
        denied = abs(friction) > state.bound.node[0] * (1.0 + CONE_ROUND_OFF)
        demanded = value_at(state.friction, 0.0) - value_at(state.bias, 0.0)
        denied = denied and value_at(state.bound, 0.0) <= abs(demanded)
        # A growing normal force may close the cone over the demand within the step: the law's static bound at
        # the start decides. An excess counts as the impulse that it is, beyond the error of the friction.
        if not denied and bound > 0.0 and state.law.friction_kind == SET_VALUED:
            friction = value_at(state.friction, 0.0) - bias
            excess = abs(friction) - bound * (1.0 + CONE_ROUND_OFF)
            excess -= HIGHEST_SHARE * abs(state.friction.coefficient[NODES - 1])
            denied = excess * state.length > state.tolerance * state.impulse_scale
    else:
        # The slip has turned by the first node. If it began with the sign of the mode, this is a reversal
        # within the step, which is located as an event; if it began at zero, the mode was wrong.
        denied = largest(load(state.bound.node)) > 0.0 and state.sign * step.sliding[0] < 0.0
        if denied and state.law.friction_kind != SET_VALUED:
            slip = event_value(run, law, 0.0, REVERSAL) if state.contact.duration > 0.0 else 0.0
        denied = denied and not state.sign * slip > SLIP_ROUND_OFF
    if denied:
        _switch(state, CONE if sticks else REVERSAL, friction)
    return bool(denied)
