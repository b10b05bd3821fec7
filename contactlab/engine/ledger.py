"""The energy ledger and the impulses: each term its own quadrature along the flow.

    drive_work    int sum_j v_j Re sum_k force_jk exp(i omega_k t) dt
    damping_loss  int sum_j c_j v_j^2 dt            resonator and rotor
    friction_loss -int F slip dt                   less what a spring of the friction holds
    contact_loss  int normal loss dt                normal damping; for a rigid law -int N gdot dt
    load_work     -int sum_j a_j v_j dt = int tau Omega dt, and the work against a preload

None is the difference of the others, so that the residual of the ledger measures the solution.
"""

from typing import Any

import numpy as np

from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.kinematics import Law, Run, contact_at, flow_to, rates_in_frame
from contactlab.engine.plant import Plant
from contactlab.engine.state import BETWEEN, COLLOCATED, FLIGHT, HELD, NODES, START, value_at
from contactlab.laws.base import FREE
from contactlab.trajectory import openness


@part_kernel
def add(out: Any, part: Any) -> None:
    """Add the terms of a part to others."""
    out.drive_work += part.drive_work
    out.damping_loss += part.damping_loss
    out.friction_loss += part.friction_loss
    out.contact_loss += part.contact_loss
    out.load_work += part.load_work
    out.normal_impulse += part.normal_impulse
    out.friction_impulse += part.friction_impulse


@part_kernel
def _powers(plant: Plant, place: int) -> tuple[float, float, float]:
    """Give the powers of drive, damping and load [W] at a place."""
    drive, damping, load = 0.0, 0.0, 0.0
    for k in range(plant.tone_count):
        in_phase, quadrature = 0.0, 0.0
        for j in range(plant.mode_count):
            v = plant.modes[j].v[place]
            in_phase += plant.phasors[j, k].force_re * v
            quadrature += plant.phasors[j, k].force_im * v
        drive += in_phase * plant.tones[k].cosine[place] - quadrature * plant.tones[k].sine[place]
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        damping += mode.damping * mode.v[place] * mode.v[place]
        load -= mode.constant * mode.v[place]
    return drive, damping, load


@inner_kernel
def increments(run: Run, law: Law, s: float, whole: bool, out: Any) -> None:
    """Sum the terms over [0, s] of a step; those over the whole of it from what is known at its nodes.

    Where it is not whole, the last node leaves the state at s BETWEEN.
    """
    state, step, rule = run.state, run.step, run.propagator.rule
    drive_work, damping_loss, load_work = 0.0, 0.0, 0.0
    friction_loss, contact_loss, normal_impulse, friction_impulse = 0.0, 0.0, 0.0, 0.0
    for i in range(NODES):
        at, place = rule.nodes[i] * s, i
        weight = rule.weights[i] * s
        if not whole:
            flow_to(run, at)
            place = BETWEEN
        drive, damping, load = _powers(run.plant, place)
        drive_work += weight * drive
        damping_loss += weight * damping
        load_work += weight * load
        if step.kind == FLIGHT:
            continue
        if whole and step.kind == COLLOCATED:
            normal, friction = state.normal.node[i], state.friction.node[i]
            slip, loss = step.slip[i], step.loss[i]
        else:
            x = at / state.length
            normal, friction = value_at(state.normal, x), value_at(state.friction, x)
            if step.kind == HELD:
                rate, slip = rates_in_frame(run, place)
                loss = -normal * rate
            else:
                gap, rate, slip, _, _, _, _ = contact_at(run.plant, place)
                loss = law.force(gap, rate, slip, state.impact_speed, law.parameters)[3]
        friction_loss -= weight * friction * slip
        contact_loss += weight * loss
        normal_impulse += weight * normal
        friction_impulse += weight * friction
    out.drive_work, out.damping_loss, out.load_work = drive_work, damping_loss, load_work
    out.friction_loss, out.contact_loss = friction_loss, contact_loss
    out.normal_impulse, out.friction_impulse = normal_impulse, friction_impulse


@part_kernel
def energy_of_motion(plant: Plant, place: int) -> tuple[float, float]:
    """Give kinetic and strain energy [J] at a place."""
    kinetic, strain = 0.0, 0.0
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        kinetic += 0.5 * mode.v[place] * mode.v[place]
        strain += 0.5 * mode.stiffness * mode.q[place] * mode.q[place]
    return kinetic, strain


@part_kernel
def weigh(run: Run) -> None:
    """Note the work of drive and load after a step, and what the ledger leaves where nothing touches.

    So it is looked at after every step, however coarse the records are. In contact what the law stores is
    not known without asking it; it is back, or lost, at the release.
    """
    state, total = run.state, run.state.total
    state.turned_over = max(state.turned_over, abs(total.drive_work), abs(total.load_work))
    if state.mode != FREE:
        return
    kinetic, strain = energy_of_motion(run.plant, START)
    left = total.load_work - total.drive_work + total.damping_loss
    left += total.friction_loss + total.contact_loss + kinetic + strain
    state.least_open = min(state.least_open, left)
    state.most_open = max(state.most_open, left)


def openness_of(state: Any, recorded: float) -> float:
    """Give the energy that a run's ledger cannot account for, over the energy turned over [1].

    `recorded` is the largest residual of the records [J], which knows of contacts as well.
    """
    seen = np.array([state.least_open, state.most_open])
    start = float(state.initial_energy)
    # Without any flight there is neither a least nor a most.
    residual = np.abs(np.append(seen[np.isfinite(seen)] - start, recorded)).max()
    return openness(float(residual), float(state.turned_over), 0.0, start)
