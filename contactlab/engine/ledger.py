"""The energy ledger and the impulses: each term its own quadrature along the flow.

    drive_work    int sum_j v_j Re sum_k force_jk exp(i omega_k t) dt
    damping_loss  int sum_j c_j v_j^2 dt            resonator and rotor
    friction_loss -int F slip dt                   less what a spring of the friction holds
    contact_loss  int normal loss dt                normal damping; for a rigid law -int N gdot dt
    load_work     -int sum_j a_j v_j dt = int tau Omega dt, and the work against a preload

None is the difference of the others, so that the residual of the ledger measures the solution.
"""

from typing import Final

from contactlab.arrays import Array
from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.plant import Plant
from contactlab.engine.step import (
    CLOSING,
    COLLOCATED,
    FLIGHT,
    FRICTION,
    HELD,
    KIND,
    LENGTH,
    NORMAL,
    Step,
    flow_to,
    force_at,
    tip_motion,
)
from contactlab.engine.tables import NODES, Tables
from contactlab.laws.base import PenaltyKernel
from contactlab.motor.geometry import contact_frame

TERMS: Final = (
    "drive_work",
    "damping_loss",
    "friction_loss",
    "contact_loss",
    "load_work",
    "normal_impulse",
    "friction_impulse",
)
DRIVE, DAMPING, FRICTIONAL, NORMAL_LOSS, LOAD, NORMAL_IMPULSE, FRICTION_IMPULSE = range(len(TERMS))


@part_kernel
def add_node(plant: Plant, phase: Array, v: Array, weight: float, out: Array) -> None:
    """Add the powers of drive, damping and load at phases and rates v, times a weight [s], to `out`."""
    drive = 0.0
    for k in range(plant.omega.size):
        in_phase = 0.0
        quadrature = 0.0
        for j in range(v.size):
            in_phase += plant.force_re[j, k] * v[j]
            quadrature += plant.force_im[j, k] * v[j]
        drive += in_phase * phase[0, k] - quadrature * phase[1, k]
    damping = 0.0
    load = 0.0
    for j in range(v.size):
        damping += plant.damping[j] * v[j] * v[j]
        load -= plant.constant[j] * v[j]
    out[DRIVE] += weight * drive
    out[DAMPING] += weight * damping
    out[LOAD] += weight * load


@part_kernel
def add_contact(
    normal: float, friction: float, slip: float, loss: float, weight: float, out: Array
) -> None:
    """Add the contact's powers and forces at one node, times its weight [s], to `out`."""
    out[FRICTIONAL] -= weight * friction * slip
    out[NORMAL_LOSS] += weight * loss
    out[NORMAL_IMPULSE] += weight * normal
    out[FRICTION_IMPULSE] += weight * friction


@inner_kernel
def held_rates(plant: Plant, step: Step, v: Array) -> tuple[float, float]:
    """Gap rate and slip [m/s] of rates v in the directions that a HELD step keeps."""
    _, _, u_rate, th_rate, rotor = tip_motion(plant, v, v)
    normal_rate = step.frame[0] * u_rate + step.frame[1] * th_rate
    return normal_rate, step.frame[2] * u_rate + step.frame[3] * th_rate + rotor


@part_kernel
def increments_of_step(plant: Plant, tables: Tables, step: Step, out: Array) -> None:
    """Terms over a whole step of a level, from what is known at its nodes, into `out`."""
    h = step.real[LENGTH]
    degree = step.whole[KIND]
    for term in range(out.size):
        out[term] = 0.0
    for i in range(NODES):
        weight = tables.weights[i] * h
        add_node(plant, step.node_phase[i], step.node_v[i], weight, out)
        if degree == COLLOCATED:
            add_contact(
                step.force[NORMAL, i],
                step.force[FRICTION, i],
                step.slip[i],
                step.loss[i],
                weight,
                out,
            )
        elif degree == HELD:
            normal, friction = step.force[NORMAL, 0], step.force[FRICTION, 0]
            rate, slip = held_rates(plant, step, step.node_v[i])
            add_contact(normal, friction, slip, -normal * rate, weight, out)


@inner_kernel
def increments_until(
    plant: Plant,
    tables: Tables,
    step: Step,
    s: float,
    force: PenaltyKernel,
    parameters: Array,
    out: Array,
) -> None:
    """Terms over [0, s] of a step, into `out`; the last node leaves the state at s in other_q, other_v."""
    h = step.real[LENGTH]
    degree = step.whole[KIND]
    for term in range(out.size):
        out[term] = 0.0
    for i in range(NODES):
        at = tables.nodes[i] * s
        weight = tables.weights[i] * s
        flow_to(plant, step, at)
        add_node(plant, step.other_phase, step.other_v, weight, out)
        if degree == FLIGHT:
            continue
        normal, friction = force_at(step, NORMAL, at / h), force_at(step, FRICTION, at / h)
        if degree == HELD:
            rate, slip = held_rates(plant, step, step.other_v)
            loss = -normal * rate
        else:
            u, th, u_rate, th_rate, rotor = tip_motion(plant, step.other_q, step.other_v)
            gap, n_u, n_th, t_u, t_th = contact_frame(
                u, th, plant.tip_length, plant.radius, plant.clearance
            )
            slip = t_u * u_rate + t_th * th_rate + rotor
            rate = n_u * u_rate + n_th * th_rate
            loss = force(gap, rate, slip, step.real[CLOSING], parameters)[3]
        add_contact(normal, friction, slip, loss, weight, out)
