"""A compliant contact step by step: accuracy, release, and the switches between slip and stick."""

from math import pi, sqrt
from typing import Any

import numpy as np

from contactlab.compiled import inner_kernel
from contactlab.engine.collocation import Known, attempt, sound_normal
from contactlab.engine.friction import sliding_at, steepness_of
from contactlab.engine.kinematics import Law, Run, add_collocated, checked, contact_at
from contactlab.engine.plant import delassus
from contactlab.engine.propagator import step_length
from contactlab.engine.rootfinding import CONE_ROUND_OFF, first_event, track_extremes
from contactlab.engine.state import (
    CHATTERED,
    COLLOCATED,
    EVENT_LIMIT,
    NODES,
    NOTHING,
    REVERSAL,
    START,
    UNSOLVED,
    largest,
    value_at,
)
from contactlab.laws.base import RATE_DEPENDENT, SET_VALUED, SLIP, STICK

CLOCK = 64.0 * np.finfo(np.float64).eps
"""Shortest step over the time at which it begins: below it the clock decides, and no force."""

TOUCHED = -1e-22
"""Gap [m] that stands for one just closed: of a force that jumps there, a step begins with the far side."""

SLIP_ROUND_OFF = 1e-13
"""Slip velocity [m/s] that a located reversal may leave."""

ROUND_OFF = 1e-13
"""Impulse over that of the tip that the forces which hold its slip cannot be told apart by."""


@inner_kernel
def step_compliant(run: Run, law: Law) -> int:
    """Take a step that `begin` made ready through compliant contact; returns the event that ends it.

    The mode of the step that follows is set by `switch_friction` once the step is committed.
    """
    state, step = run.state, run.step
    step.kind = COLLOCATED
    gap, rate, slip = _face_start(run)
    known = _start_forces(run, law, gap, rate, slip)
    if state.contact.duration == 0.0:
        state.momentum = _impulse_scale(run, law, rate, known[0])
    if known[1] == 0.0 and state.mode == SLIP and slip != 0.0:
        # What has no say in the slip cannot have followed its sign.
        state.sign = 1 if slip > 0.0 else -1
    level = _separation_level(run, gap, rate, known[0])
    finest = _finest_level(run)
    flips = 0
    _guess(run, known)
    while True:
        if level >= run.propagator.rule.level_count:
            state.ending = UNSOLVED
            return checked(run, NOTHING)
        error = attempt(run, law, level, known)
        # A dip that ends before the first node would be left where it begins, still approaching,
        # unless nothing of it could be seen.
        hidden = step.gap[0] >= 0.0 and rate * state.length < TOUCHED
        if (error > 1.0 or hidden) and (level < finest or error == np.inf):
            state.rejected_steps += 1
            level += 2 if error > 500.0 or hidden else 1
            if error < np.inf:
                level = min(level, finest)
            continue
        if not _contradicted(run, law, slip):
            break
        # Neither slipping nor sticking fits at this length: look closer before trying again.
        flips += 1
        level += 2 * (flips // 2)
        known = _start_forces(run, law, gap, rate, slip)
    remaining = state.end - state.time
    event, s = first_event(run, law, rate)
    if s > remaining:
        event, s = NOTHING, remaining
    state.taken = s
    track_extremes(run, law, gap, rate, known[0])
    if s == state.length:
        add_collocated(run, level)
    state.contact_steps += 1
    state.level_before = level
    state.level = _following_level(run, level, error)
    return checked(run, event)


@inner_kernel
def _finest_level(run: Run) -> int:
    """Give the level of the shortest step that a run takes at its time."""
    rule = run.propagator.rule
    level = rule.level_count - 9
    while (
        level > rule.contact_level and step_length(run.propagator, level) < CLOCK * run.state.time
    ):
        level -= 1
    return int(level)


@inner_kernel
def _following_level(run: Run, level: int, error: float) -> int:
    """Give the level of the next step: the error falls as h^(NODES + 1)."""
    growth = 2.0 ** (NODES + 1)
    for _ in range(2):
        if level > run.propagator.rule.contact_level and 2.0 * error * growth < 1.0:
            level -= 1
            error *= growth
    return level


@inner_kernel
def _face_start(run: Run) -> tuple[float, float, float]:
    """Give gap, gap rate and slip where the step begins; its directions stand for those of the nodes."""
    step = run.step
    gap, rate, slip, n_u, n_th, t_u, t_th = contact_at(run.plant, START)
    for i in range(NODES):
        step.n_u[i], step.n_th[i], step.t_u[i], step.t_th[i] = n_u, n_th, t_u, t_th
    return gap, rate, slip


@inner_kernel
def _start_forces(run: Run, law: Law, gap: float, rate: float, slip: float) -> Known:
    """Give what is known of the forces where the step begins."""
    state, parameters = run.state, law.parameters
    if gap >= 0.0:
        if rate >= 0.0:
            return 0.0, 0.0, 0.0, 0.0
        gap = TOUCHED
    seen = slip
    if state.mode == STICK:
        seen = 0.0
    elif state.friction_kind == SET_VALUED and state.sign * slip < SLIP_ROUND_OFF:
        # Slip that only begins: the law must not take it for stick.
        seen = state.sign * SLIP_ROUND_OFF
    normal, bound, _, _ = law.force(gap, rate, seen, state.impact_speed, parameters)
    normal = sound_normal(normal, bound)
    friction, steepness = 0.0, 0.0
    if state.friction_kind != SET_VALUED:
        friction = law.friction(gap, rate, slip, normal, state.internal, parameters)[0]
    if state.friction_kind == RATE_DEPENDENT:
        steepness = steepness_of(law, (gap, rate, slip), normal, state.internal, friction)
    return normal, bound, friction, steepness


@inner_kernel
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
    for d in range(NODES):
        state.normal.coefficient[d] = known[0] if d == 0 else 0.0
        state.bound.coefficient[d] = known[1] if d == 0 else 0.0
        state.friction.coefficient[d] = known[2] if d == 0 else 0.0
        state.internal_rate.coefficient[d] = 0.0


@inner_kernel
def _separation_level(run: Run, gap: float, rate: float, normal: float) -> int:
    """Give the level that walks up to a release instead of stepping over it while the force matters."""
    state = run.state
    level = state.level
    if rate > 0.0 and gap < 0.0:
        h = step_length(run.propagator, level)
        small = state.tolerance * state.momentum
        finest = run.propagator.rule.level_count - 1
        while h * rate > -0.7 * gap and abs(normal) * h > small and level < finest:
            level += 1
            h *= 0.5
    return int(level)


@inner_kernel
def _impulse_scale(run: Run, law: Law, rate: float, normal: float) -> float:
    """Give the impulse [N s] that an error in a contact which begins now is measured by.

    That is what the tip brings: its approach at a gap rate [m/s], what vibrates in its modes, and what drive
    and weight add in one step; not the steady state's motion, as that of a lightly damped resonance is far
    from where the motor is. A contact so soft that it cannot take as much has what its force at the end of
    the tip's reach gives in half a swing, down to where an error is round-off of the tip's own motion. A
    start that is pressed in has at least its normal force's impulse in one step, be there motion or not.
    """
    state, plant = run.state, run.plant
    _, _, _, n_u, n_th, t_u, t_th = contact_at(plant, START)
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
    scale = speed / delassus(plant, n_u, n_th, t_u, t_th)[0]
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
    friction = value_at(state.friction, state.taken / state.length)
    _switch_to(state, STICK if event == REVERSAL else SLIP, friction)


@inner_kernel
def _switch_to(state: Any, mode: int, friction: float) -> None:
    """Let the contact stick, or slip against the friction that it cannot hold [N]."""
    state.mode = mode
    if mode == SLIP:
        state.sign = -1 if friction > 0.0 else 1
    state.friction_switches += 1
    count_event(state)


@inner_kernel
def _contradicted(run: Run, law: Law, slip: float) -> bool:
    """Tell whether the step denies its own friction mode from its start; the other mode is then set.

    Stick whose friction leaves the cone at once must slip against it; slip that starts from
    zero into the wrong direction must stick. Rate-dependent friction has no modes.
    """
    state, step = run.state, run.step
    if state.friction_kind == RATE_DEPENDENT:
        return False
    friction = state.friction.node[0]
    if state.mode == STICK:
        leaves = abs(friction) > state.bound.node[0] * (1.0 + CONE_ROUND_OFF)
        denied = leaves and value_at(state.bound, 0.0) <= abs(value_at(state.friction, 0.0))
        other = SLIP
    else:
        denied = largest(state.bound.node) > 0.0 and state.sign * step.sliding[0] < 0.0
        other = STICK
        if denied and state.friction_kind != SET_VALUED:
            slip = sliding_at(run, law, 0.0) if state.contact.duration > 0.0 else 0.0
        denied = denied and not state.sign * slip > SLIP_ROUND_OFF
    if denied:
        _switch_to(state, other, friction)
    return denied
