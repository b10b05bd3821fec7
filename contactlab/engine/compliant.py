"""A compliant contact step by step: accuracy, release, and the switches between slip and stick."""

from math import pi, sqrt
from typing import Any

import numpy as np

from contactlab.compiled import inner_kernel, merged_kernel, part_kernel
from contactlab.engine.collocation import STICK_ERROR, Known, attempt, sound_normal
from contactlab.engine.context import Law, Run
from contactlab.engine.friction import friction_and_steepness
from contactlab.engine.kinematics import add_collocated, checked, contact_at
from contactlab.engine.memory import SLIP_ROUND_OFF, end_at, jump, open_step, recall_start
from contactlab.engine.moments import first_moments
from contactlab.engine.plant import delassus
from contactlab.engine.propagator import step_length
from contactlab.engine.rootfinding import (
    CONE_ROUND_OFF,
    event_value,
    first_event,
    first_guard,
    track_extremes,
)
from contactlab.engine.state import (
    CHATTERED,
    COLLOCATED,
    CONE,
    EVENT_LIMIT,
    NODES,
    NOTHING,
    REVERSAL,
    START,
    UNSOLVED,
    hold,
    largest,
    value_at,
)
from contactlab.laws.base import RATE_DEPENDENT, SET_VALUED, SLIP, STICK
from contactlab.laws.memory import AT_SLIP, AT_STICK

CLOCK = 64.0 * np.finfo(np.float64).eps
"""Shortest step over the time at which it begins: below it the clock decides, and no force."""

TOUCHED = -1e-22
"""Gap [m] that stands for one just closed: of a force that jumps there, a step begins with the far side."""

GROWTH = 2.0**6
"""What the error of a step grows by where it doubles: it goes as h^(NODES + 1)."""

REMEMBERED = 1e-2
"""Share of the negligible impulse down to which a contact that remembers walks up to its release."""

ROUND_OFF = 1e-13
"""Impulse over that of the tip that the forces which hold its slip cannot be told apart by."""


@merged_kernel
def step_compliant(run: Run, law: Law) -> int:
    """Take a step that `begin` made ready through compliant contact; returns the event that ends it.

    The mode of the step that follows is set by `switch_friction` once the step is committed.
    """
    state, step = run.state, run.step
    step.kind = COLLOCATED
    gap, rate, slip, n_u, n_th, t_u, t_th = contact_at(run.plant, START)
    for i in range(NODES):
        step.n_u[i], step.n_th[i], step.t_u[i], step.t_th[i] = n_u, n_th, t_u, t_th
    known = _start_forces(run, law, gap, rate, slip)
    open_step(run, law, law.memory, gap, rate, 0.0 if state.mode == STICK else slip, known[0])
    first_moments(run, law, law.memory, gap, known[0])
    if state.contact.duration == 0.0:
        mobility = delassus(run.plant, n_u, n_th, t_u, t_th)[0]
        state.momentum = _impulse_scale(run, law, rate, known[0], mobility)
    if known[1] == 0.0 and state.mode == SLIP and slip != 0.0:
        # What has no say in the slip cannot have followed its sign.
        state.sign = 1 if slip > 0.0 else -1
    _guess(run, known)
    level, error, normal = _solve(run, law, gap, rate, slip, known)
    if state.ending == UNSOLVED:
        return checked(run, NOTHING)
    remaining = state.end - state.time
    event, s = first_event(run, law, rate)
    event, s = first_guard(run, law, law.memory, event, s)
    if s > remaining:
        event, s = NOTHING, remaining
    state.taken = s
    track_extremes(run, law, gap, rate, normal)
    if s == state.length:
        add_collocated(run, level)
    state.contact_steps += 1
    state.level = state.level_before = level
    for _ in range(2):
        if state.level > run.propagator.rule.contact_level and 2.0 * error * GROWTH < 1.0:
            state.level -= 1
            error *= GROWTH
    return checked(run, event)


@merged_kernel
def _solve(
    run: Run, law: Law, gap: float, rate: float, slip: float, known: Known
) -> tuple[int, float, float]:
    """Shorten a step until it is right; gives its level, error over the tolerance and first normal force.

    UNSOLVED where no step, however short, satisfies the law.
    """
    state, step, rule = run.state, run.step, run.propagator.rule
    level = _separation_level(
        run, gap - end_at(run, law, law.memory, rate), rate, max(abs(known[0]), known[1])
    )
    # The shortest step at this time.
    finest = rule.level_count - 9
    while finest > rule.contact_level and step_length(run.propagator, finest) < CLOCK * state.time:
        finest -= 1
    flips, error = 0, 0.0
    while level < rule.level_count:
        error = attempt(run, law, level, known)
        # A dip that ends before the first node would be left where it begins, still approaching,
        # unless nothing of it could be seen.
        hidden = step.gap[0] >= step.end[0] and rate * state.length < TOUCHED
        if (error > 1.0 or hidden) and (level < finest or error == np.inf):
            state.rejected_steps += 1
            level += 2 if error > 500.0 or hidden else 1
            if error < np.inf:
                level = min(level, finest)
        elif _contradicted(run, law, slip, known[1], known[2]):
            # Neither slipping nor sticking fits at this length: look closer before trying again.
            flips += 1
            level += 2 * (flips // 2)
            jump(run, law, law.memory, AT_STICK if state.mode == STICK else AT_SLIP)
            known = _start_forces(run, law, gap, rate, slip)
            open_step(run, law, law.memory, gap, rate, 0.0 if state.mode == STICK else slip, known[0])
            first_moments(run, law, law.memory, gap, known[0])
        else:
            break
    else:
        state.ending = UNSOLVED
    return level, error, known[0]


@part_kernel
def _guess(run: Run, known: Known) -> None:
    """Make `taken` the place x = s/h of the step's start on the force polynomial that stands.

    The first attempt continues the step before; every further one starts on its own forerunner, at
    x = 0. Where there is no such step, or a coarser one is to follow, the forces start constant.
    """
    state = run.state
    if state.contact.duration > 0.0 and state.level >= state.level_before:
        state.taken /= state.length
        return
    state.taken = 0.0
    hold(state.normal, known[0])
    hold(state.bound, known[1])
    hold(state.bias, known[2])
    hold(state.friction, known[3])
    hold(state.internal_rate, 0.0)


@inner_kernel
def _start_forces(run: Run, law: Law, gap: float, rate: float, slip: float) -> Known:
    """Give what is known of the forces where the step begins."""
    state = run.state
    recall_start(run, law)
    end = end_at(run, law, law.memory, rate)
    if gap >= end:
        if rate >= 0.0:
            return 0.0, 0.0, 0.0, 0.0, 0.0
        gap = end + TOUCHED
    seen = slip
    if state.mode == STICK:
        seen = 0.0
    elif state.friction_kind == SET_VALUED and state.sign * slip < SLIP_ROUND_OFF:
        # Slip that only begins: the law must not take it for stick.
        seen = state.sign * SLIP_ROUND_OFF
    normal, least, most, _, _ = law.force(gap, rate, seen, state.impact_speed, law.parameters)
    bound = 0.5 * (most - least)
    normal = sound_normal(normal, bound)
    friction, steepness = 0.0, 0.0
    if state.friction_kind != SET_VALUED:
        at = gap, rate, slip
        friction, steepness = friction_and_steepness(law, at, end, normal)
    steepness = steepness if state.friction_kind == RATE_DEPENDENT else 0.0
    return normal, bound, 0.5 * (most + least), friction, steepness


@merged_kernel
def _separation_level(run: Run, gap: float, rate: float, normal: float) -> int:
    """Give the level that walks up to a release instead of stepping over it while the force matters.

    The gap is that over the one at which the contact ends [m].
    """
    state, level = run.state, run.state.level
    if rate > 0.0 and gap < 0.0:
        h = step_length(run.propagator, level)
        # What is remembered flows on past the release at another rate, whatever the force is by then.
        small = state.tolerance * state.momentum * (REMEMBERED if state.variables > state.coupled else 1.0)
        finest = run.propagator.rule.level_count - 1
        while h * rate > -0.7 * gap and abs(normal) * h > small and level < finest:
            level += 1
            h *= 0.5
    return int(level)


@merged_kernel
def _impulse_scale(run: Run, law: Law, rate: float, normal: float, mobility: float) -> float:
    """Give the impulse [N s] that an error in a contact which begins now is measured by.

    That is what the tip brings, over its mobility D_nn [1/kg]: its approach at a gap rate [m/s], what
    vibrates in its modes, and what drive and weight add in one step; not the steady state's motion, as that
    of a lightly damped resonance is far from where the motor is. A contact so soft that it cannot take as
    much has what its force at the end of the tip's reach gives in half a swing, down to where an error is
    round-off of the tip's own motion. A start that is pressed in has at least its normal force's impulse in
    one step, be there motion or not.
    """
    state, plant = run.state, run.plant
    h = step_length(run.propagator, run.propagator.rule.contact_level)
    speed, reach = 0.0, 0.0
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        swing = sqrt(mode.v[START] ** 2 + mode.stiffness * mode.q[START] ** 2)
        for k in range(plant.tone_count):
            phasor = plant.phasors[j, k]
            swing += h * sqrt(phasor.force_re**2 + phasor.force_im**2)
        swing += h * abs(mode.constant)
        part = abs(mode.row_u) * swing
        speed += part
        if part > 0.0:
            # The way of a free mass has no end.
            reach += part / sqrt(mode.stiffness) if mode.stiffness > 0.0 else np.inf
    speed += abs(rate)
    scale = speed / mobility
    if 0.0 < reach < np.inf:
        deep = law.force(-reach, -speed, 0.0, state.impact_speed, law.parameters)[0]
        taken = max(abs(deep) * pi * reach / speed, ROUND_OFF / state.tolerance * scale)
        # A law that has no force so deep has no say.
        if deep != 0.0 and taken < scale:
            scale = taken
    return max(scale, abs(normal) * h)


@inner_kernel
def count_event(state: Any) -> None:
    """Count a touch-down or friction switch; too many in one window is chattering."""
    state.events += 1
    if state.events > EVENT_LIMIT:
        state.ending = CHATTERED


@inner_kernel
def switch_friction(state: Any, event: int) -> None:
    """Set the friction mode after a step that ended in REVERSAL or CONE."""
    x = state.taken / state.length
    _switch(state, event, value_at(state.friction, x) - value_at(state.bias, x))


@inner_kernel
def _switch(state: Any, event: int, friction: float) -> None:
    """Let the contact stick, or slip against a friction [N] that it cannot hold, less the bound's middle."""
    state.mode = STICK
    if event == CONE:
        state.mode, state.sign = SLIP, -1 if friction > 0.0 else 1
    state.friction_switches += 1
    count_event(state)


@merged_kernel
def _contradicted(run: Run, law: Law, slip: float, bound: float, bias: float) -> bool:
    """Return whether the step contradicts its own friction mode at its start; the other mode is then set.

    Stick stands where the friction that it demands at that instant lies within `bound` of `bias` [N] at that
    instant; outside it the contact slips against the demand. The first node alone does not decide: by then a
    growing normal force may have closed the cone over the demand. An excess counts by the impulse that it
    has over the step, beyond the error of the demand. Slip that starts from zero into the wrong direction
    must stick. Rate-dependent friction has no modes.
    """
    state, step = run.state, run.step
    friction, sticks = state.friction.node[0] - state.bias.node[0], state.mode == STICK
    if state.friction_kind == RATE_DEPENDENT:
        return False
    if sticks:
        denied = abs(friction) > state.bound.node[0] * (1.0 + CONE_ROUND_OFF)
        demanded = value_at(state.friction, 0.0) - value_at(state.bias, 0.0)
        denied = denied and value_at(state.bound, 0.0) <= abs(demanded)
        if not denied and bound > 0.0 and state.friction_kind == SET_VALUED:
            friction = value_at(state.friction, 0.0) - bias
            excess = abs(friction) - bound * (1.0 + CONE_ROUND_OFF)
            excess -= STICK_ERROR * abs(state.friction.coefficient[NODES - 1])
            denied = excess * state.length > state.tolerance * state.momentum
    else:
        denied = largest(state.bound.node) > 0.0 and state.sign * step.sliding[0] < 0.0
        if denied and state.friction_kind != SET_VALUED:
            slip = event_value(run, law, 0.0, REVERSAL) if state.contact.duration > 0.0 else 0.0
        denied = denied and not state.sign * slip > SLIP_ROUND_OFF
    if denied:
        _switch(state, CONE if sticks else REVERSAL, friction)
    return bool(denied)
