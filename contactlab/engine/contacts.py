"""A contact begins and ends: its row, its scales, and the count of events that tells chattering."""

from math import pi, sqrt
from typing import Any

import numpy as np

from contactlab.compiled import inner_kernel
from contactlab.engine.kinematics import Law, Run, contact_at
from contactlab.engine.plant import delassus
from contactlab.engine.propagator import step_length
from contactlab.engine.state import CHATTERED, RELEASED, START, TOUCHING
from contactlab.laws.base import FREE, RATE_DEPENDENT, SLIP, STICK

EVENT_LIMIT = 1000
"""Touch-downs and friction switches within one window that count as chattering."""

ROUND_OFF = 1e-13
"""Impulse over that of the tip that the forces which hold its slip cannot be told apart by."""


@inner_kernel
def count_event(state: Any) -> None:
    """Count a touch-down or friction switch; too many in one window is chattering."""
    state.events += 1
    if state.events > EVENT_LIMIT:
        state.ending = CHATTERED


@inner_kernel
def open_contact(run: Run, refinement: int) -> None:
    """Start a contact at the present state, some levels below that of the contact step."""
    state, contact = run.state, run.state.contact
    _, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    contact.start_time, contact.approach_velocity = state.time, rate
    contact.duration, contact.stick_duration, contact.energy_loss = 0.0, 0.0, 0.0
    contact.normal_impulse, contact.friction_impulse = 0.0, 0.0
    contact.peak_normal_force, contact.max_penetration = 0.0, 0.0
    contact.separation_velocity = 0.0
    state.normal_before = 0.0
    state.friction_before = 0.0
    state.phase = TOUCHING
    state.impact_speed = max(-rate, 0.0)
    state.internal = 0.0
    state.mode = SLIP if slip != 0.0 or state.friction_kind == RATE_DEPENDENT else STICK
    state.sign = 1 if slip > 0.0 else -1
    state.level = run.propagator.rule.contact_level + refinement
    state.touchdowns += 1
    count_event(state)


@inner_kernel
def impulse_scale(run: Run, law: Law, rate: float, normal: float) -> float:
    """Give the impulse [N s] that an error in a contact which begins now is measured by.

    That is what the tip brings: its approach, what vibrates in its modes, and what drive and weight add
    in one step. A contact so soft that it cannot take as much has what its force at the end of the
    tip's reach gives in half a swing, down to where an error is round-off of the tip's own motion. A
    start that is pressed in has at least its force's impulse in one step, be there motion or not.

    Args:
        run, law: where the contact begins.
        rate, normal: gap rate [m/s] and normal force [N] there.
    """
    state = run.state
    _, _, _, n_u, n_th, t_u, t_th = contact_at(run.plant, START)
    h = step_length(run.propagator, run.propagator.rule.contact_level)
    speed, reach = _vibration(run, h)
    speed += abs(rate)
    scale = speed / delassus(run.plant, n_u, n_th, t_u, t_th)[0]
    if 0.0 < reach < np.inf:
        deep = law.force(-reach, -speed, 0.0, state.impact_speed, law.parameters)[0]
        taken = max(abs(deep) * pi * reach / speed, ROUND_OFF / state.tolerance * scale)
        # A law that has no force so deep has no say.
        if deep != 0.0 and taken < scale:
            scale = taken
    return max(scale, abs(normal) * h)


@inner_kernel
def _vibration(run: Run, h: float) -> tuple[float, float]:
    """Give scales of the tip's normal speed [m/s] and way [m]: what vibrates now and what a step h adds.

    Not the steady state's: that of a lightly damped resonance is far from where the motor is. The way
    of a free mass has no end.
    """
    speed = 0.0
    reach = 0.0
    for j in range(run.plant.mode_count):
        mode = run.plant.modes[j]
        swing = sqrt(mode.v[START] ** 2 + mode.stiffness * mode.q[START] ** 2)
        for k in range(run.plant.tone_count):
            phasor = run.plant.phasors[j, k]
            swing += h * sqrt(phasor.force_re**2 + phasor.force_im**2)
        swing += h * abs(mode.constant)
        part = abs(mode.row_u) * swing
        speed += part
        if part > 0.0:
            reach += part / sqrt(mode.stiffness) if mode.stiffness > 0.0 else np.inf
    return speed, reach


@inner_kernel
def close_contact(run: Run) -> None:
    """Store the contact that opens at the present state, and begin to separate."""
    state = run.state
    state.contact.separation_velocity = contact_at(run.plant, START)[1]
    if state.contact.duration > 0.0:
        run.step.contacts[state.stored] = state.contact
        state.stored += 1
    else:
        # What has no length is no contact: here round-off alone tells a graze from a miss.
        state.touchdowns -= 1
    state.mode = FREE
    state.phase = RELEASED
    state.level = run.propagator.rule.fresh_level
