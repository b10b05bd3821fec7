"""A contact begins and ends: its row, its scales, and the count of events that tells chattering."""

from math import sqrt

from contactlab.compiled import inner_kernel
from contactlab.engine.plant import Plant, delassus
from contactlab.engine.run import (
    APPROACH,
    CHATTERED,
    ENDING,
    EVENT_LIMIT,
    EVENTS,
    FRICTION_BEFORE,
    LEVEL,
    MOMENTUM,
    NORMAL_BEFORE,
    PHASE,
    RELEASED,
    SEPARATION,
    SIGN,
    START,
    STORED,
    TIME,
    TOUCHDOWNS,
    TOUCHING,
    Run,
)
from contactlab.engine.step import CLOSING, MEMORY, MODE, RUBBING, Step, tip_motion
from contactlab.engine.tables import Tables, step_length
from contactlab.geometry import contact_frame
from contactlab.laws.base import CREEPING, FREE, SLIP, STICK


@inner_kernel
def count_event(run: Run) -> None:
    """Count a touch-down or friction switch; too many in one window is chattering."""
    run.whole[EVENTS] += 1
    if run.whole[EVENTS] > EVENT_LIMIT:
        run.whole[ENDING] = CHATTERED


@inner_kernel
def open_contact(plant: Plant, tables: Tables, step: Step, run: Run, level: int) -> None:
    """A touch-down at the present state: start a contact at a level of the ladder."""
    u, th, u_rate, th_rate, rotor = tip_motion(plant, step.q, step.v)
    _, n_u, n_th, t_u, t_th = contact_frame(u, th, plant.tip_length, plant.radius, plant.clearance)
    rate = n_u * u_rate + n_th * th_rate
    slip = t_u * u_rate + t_th * th_rate + rotor
    for column in range(run.contact.size):
        run.contact[column] = 0.0
    run.contact[START] = run.real[TIME]
    run.contact[APPROACH] = rate
    d_nn = delassus(plant, n_u, n_th, t_u, t_th)[0]
    run.real[MOMENTUM] = (abs(rate) + _vibration(plant, tables, step)) / d_nn
    run.real[NORMAL_BEFORE] = 0.0
    run.real[FRICTION_BEFORE] = 0.0
    run.whole[PHASE] = TOUCHING
    step.real[CLOSING] = max(-rate, 0.0)
    step.real[MEMORY] = 0.0
    step.whole[MODE] = SLIP if slip != 0.0 or step.whole[RUBBING] == CREEPING else STICK
    run.whole[SIGN] = 1 if slip > 0.0 else -1
    run.whole[LEVEL] = level
    run.whole[TOUCHDOWNS] += 1
    count_event(run)


@inner_kernel
def _vibration(plant: Plant, tables: Tables, step: Step) -> float:
    """Scale of the tip's normal speed [m/s]: what vibrates now and what the drive adds in one step.

    Not the steady state's: that of a lightly damped resonance is far from where the motor is.
    """
    h = step_length(tables, tables.contact_level)
    speed = 0.0
    for j in range(plant.row_u.size):
        mode = sqrt(step.v[j] ** 2 + plant.stiffness[j] * step.q[j] ** 2)
        for k in range(plant.omega.size):
            mode += h * sqrt(plant.force_re[j, k] ** 2 + plant.force_im[j, k] ** 2)
        mode += h * abs(plant.constant[j])
        speed += abs(plant.row_u[j]) * mode
    return speed


@inner_kernel
def close_contact(plant: Plant, tables: Tables, step: Step, run: Run) -> None:
    """A release at the present state: store the contact and begin to separate."""
    u, th, u_rate, th_rate, _ = tip_motion(plant, step.q, step.v)
    _, n_u, n_th, _, _ = contact_frame(u, th, plant.tip_length, plant.radius, plant.clearance)
    run.contact[SEPARATION] = n_u * u_rate + n_th * th_rate
    for column in range(run.contact.size):
        run.contacts[run.whole[STORED], column] = run.contact[column]
    run.whole[STORED] += 1
    step.whole[MODE] = FREE
    run.whole[PHASE] = RELEASED
    run.whole[LEVEL] = tables.fresh_level
