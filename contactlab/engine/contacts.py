"""A contact begins and ends: its row, its scales, and the count of events that tells chattering."""

from math import pi, sqrt

import numpy as np

from contactlab.arrays import Array
from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.plant import Plant, delassus
from contactlab.engine.run import (
    APPROACH,
    CHATTERED,
    DURATION,
    ENDING,
    EVENT_LIMIT,
    EVENTS,
    FRICTION_BEFORE,
    LEVEL,
    NORMAL_BEFORE,
    PHASE,
    RELEASED,
    SEPARATION,
    SIGN,
    START,
    STORED,
    TIME,
    TOLERANCE,
    TOUCHDOWNS,
    TOUCHING,
    Run,
)
from contactlab.engine.step import CLOSING, MEMORY, MODE, RUBBING, Step, tip_motion
from contactlab.engine.tables import Tables, step_length
from contactlab.laws.base import FREE, RATE_DEPENDENT, SLIP, STICK, PenaltyKernel
from contactlab.motor.geometry import contact_frame

ROUND_OFF = 1e-13
"""Impulse over that of the tip that the forces which hold its slip cannot be told apart by."""


@inner_kernel
def count_event(run: Run) -> None:
    """Count a touch-down or friction switch; too many in one window is chattering."""
    run.whole[EVENTS] += 1
    if run.whole[EVENTS] > EVENT_LIMIT:
        run.whole[ENDING] = CHATTERED


@inner_kernel
def open_contact(plant: Plant, step: Step, run: Run, level: int) -> None:
    """A touch-down at the present state: start a contact at a level of the ladder."""
    u, th, u_rate, th_rate, rotor = tip_motion(plant, step.q, step.v)
    _, n_u, n_th, t_u, t_th = contact_frame(u, th, plant.tip_length, plant.radius, plant.clearance)
    rate = n_u * u_rate + n_th * th_rate
    slip = t_u * u_rate + t_th * th_rate + rotor
    for column in range(run.contact.size):
        run.contact[column] = 0.0
    run.contact[START] = run.real[TIME]
    run.contact[APPROACH] = rate
    run.real[NORMAL_BEFORE] = 0.0
    run.real[FRICTION_BEFORE] = 0.0
    run.whole[PHASE] = TOUCHING
    step.real[CLOSING] = max(-rate, 0.0)
    step.real[MEMORY] = 0.0
    step.whole[MODE] = SLIP if slip != 0.0 or step.whole[RUBBING] == RATE_DEPENDENT else STICK
    run.whole[SIGN] = 1 if slip > 0.0 else -1
    run.whole[LEVEL] = level
    run.whole[TOUCHDOWNS] += 1
    count_event(run)


@part_kernel
def impulse_scale(
    plant: Plant,
    tables: Tables,
    step: Step,
    run: Run,
    rate: float,
    normal: float,
    force: PenaltyKernel,
    parameters: Array,
) -> float:
    """Impulse [N s] that an error in a contact which begins now is measured by.

    That is what the tip brings: its approach, what vibrates in its modes, and what drive and weight add
    in one step. A contact so soft that it cannot take as much has what its force at the end of the
    tip's reach gives in half a swing, down to where an error is round-off of the tip's own motion. A
    start that is pressed in has at least its force's impulse in one step, be there motion or not.

    Args:
        plant, tables, step, run: where the contact begins.
        rate, normal: gap rate [m/s] and normal force [N] there.
        force, parameters: the law.
    """
    u, th, _, _, _ = tip_motion(plant, step.q, step.v)
    _, n_u, n_th, t_u, t_th = contact_frame(u, th, plant.tip_length, plant.radius, plant.clearance)
    speed, reach = _vibration(plant, tables, step)
    speed += abs(rate)
    scale = speed / delassus(plant, n_u, n_th, t_u, t_th)[0]
    if 0.0 < reach < np.inf:
        deep = force(-reach, -speed, 0.0, step.real[CLOSING], parameters)[0]
        taken = max(abs(deep) * pi * reach / speed, ROUND_OFF / run.real[TOLERANCE] * scale)
        # A law that has no force so deep has no say.
        if deep != 0.0 and taken < scale:
            scale = taken
    return max(scale, abs(normal) * step_length(tables, tables.contact_level))


@inner_kernel
def _vibration(plant: Plant, tables: Tables, step: Step) -> tuple[float, float]:
    """Scales of the tip's normal speed [m/s] and way [m]: what vibrates now and what one step adds.

    Not the steady state's: that of a lightly damped resonance is far from where the motor is. The way
    of a free mass has no end.
    """
    h = step_length(tables, tables.contact_level)
    speed = 0.0
    reach = 0.0
    for j in range(plant.row_u.size):
        mode = sqrt(step.v[j] ** 2 + plant.stiffness[j] * step.q[j] ** 2)
        for k in range(plant.omega.size):
            mode += h * sqrt(plant.force_re[j, k] ** 2 + plant.force_im[j, k] ** 2)
        mode += h * abs(plant.constant[j])
        part = abs(plant.row_u[j]) * mode
        speed += part
        if part > 0.0:
            reach += part / sqrt(plant.stiffness[j]) if plant.stiffness[j] > 0.0 else np.inf
    return speed, reach


@inner_kernel
def close_contact(plant: Plant, tables: Tables, step: Step, run: Run) -> None:
    """A release at the present state: store the contact and begin to separate."""
    u, th, u_rate, th_rate, _ = tip_motion(plant, step.q, step.v)
    _, n_u, n_th, _, _ = contact_frame(u, th, plant.tip_length, plant.radius, plant.clearance)
    run.contact[SEPARATION] = n_u * u_rate + n_th * th_rate
    if run.contact[DURATION] > 0.0:
        for column in range(run.contact.size):
            run.contacts[run.whole[STORED], column] = run.contact[column]
        run.whole[STORED] += 1
    else:
        # What has no length is no contact: here round-off alone tells a graze from a miss.
        run.whole[TOUCHDOWNS] -= 1
    step.whole[MODE] = FREE
    run.whole[PHASE] = RELEASED
    run.whole[LEVEL] = tables.fresh_level
