"""One step of the motor: exact flow under the drive and a polynomial contact force.

A step starts at a state (q, v), lasts h and is of one of three kinds, named by the degree of its force
polynomial in s/h: FLIGHT has no force, HELD a constant one, and a collocated step passes through its
values at the nodes. Whatever its kind, its state can be read anywhere in [0, h].
"""

from math import cos, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.oscillator import impulse_integrals
from contactlab.engine.plant import Plant
from contactlab.engine.resonance import answer_from_rest
from contactlab.engine.tables import NODES, Tables

FLIGHT, HELD, COLLOCATED = -1, 0, NODES - 1
"""Kinds of a step: the degree of its force polynomial."""

KIND, MODE, RUBBING, PARITY = range(4)
"""Places in `Step.whole`: the kind, the contact mode, the law's kind of friction, and the parity of what it
remembers."""

LENGTH, TAKEN, CLOSING, MEMORY = range(4)
"""Places in `Step.real`: the length h of the step and the part of it that is taken [s], the approach with
which the contact began [m/s], and the friction's memory where the step starts."""

PUSH_U, PUSH_TH, FRICTION, NORMAL, BOUND, MEMORY_RATE = range(6)
"""Rows of a step's force: generalised forces along u and th, friction, normal force, friction bound; and
the rate of the friction's memory."""

TIP_U, TIP_TH, TIP_U_RATE, TIP_TH_RATE, TIP_ROTOR = range(5)
"""Columns of the contact-free tip motion: u, th, their rates, and -R Omega."""


class Step(NamedTuple):
    """Working memory of one step; i node, j coordinate, k tone.

    Args:
        whole, real: scalars, see the places above.
        q, v: state at the start, shape (j,).
        free_q, free_v: the same without the steady state, shape (j,), see `begin`.
        phase: cosine and sine of omega_k t at the start, shape (2, k).
        force: values at the nodes, shape (6, i); rows PUSH_U ... MEMORY_RATE.
        shape: their polynomials in s/h, shape (6, i).
        gap, gap_rate, slip, loss: contact [m, m/s, m/s] and normal loss [W] at the nodes, shape (i,).
        sliding: what must keep its sign in slip at the nodes, shape (i,) [m/s]: the slip, less what a
            spring of the friction takes of it.
        memory: the friction's memory at the nodes, shape (i,).
        coupled: scratch of the friction with memory, shape (2 i, 2 i + 1).
        frame: directions of the contact that a HELD step keeps, shape (4,).
        node_q, node_v: state at the nodes; node_q is sure at the last one only, shape (i, j).
        node_phase: the phases at the nodes, shape (i, 2, k).
        tip: contact-free tip motion at the nodes, shape (i, 5).
        other_q, other_v, other_phase: state and phases at a time in between.
        integrals: scratch of the oscillator, shape (i + 2,).
        stick: scratch of the stick condition, shape (i, i + 1).
        rows: directions of the contact at the nodes, shape (i, 4).
    """

    whole: NDArray[np.int64]
    real: Array
    q: Array
    v: Array
    free_q: Array
    free_v: Array
    phase: Array
    force: Array
    shape: Array
    gap: Array
    gap_rate: Array
    slip: Array
    loss: Array
    sliding: Array
    memory: Array
    coupled: Array
    frame: Array
    node_q: Array
    node_v: Array
    node_phase: Array
    tip: Array
    other_q: Array
    other_v: Array
    other_phase: Array
    integrals: Array
    stick: Array
    rows: Array


def step_for(plant: Plant) -> Step:
    """Working memory for a plant at rest."""
    j, k = plant.stiffness.size, plant.omega.size
    return Step(
        whole=np.zeros(4, dtype=np.int64),
        # A first step continues a polynomial of zeros, of some length.
        real=np.array([1.0, 0.0, 0.0, 0.0]),
        q=np.zeros(j),
        v=np.zeros(j),
        free_q=np.zeros(j),
        free_v=np.zeros(j),
        phase=np.zeros((2, k)),
        force=np.zeros((6, NODES)),
        shape=np.zeros((6, NODES)),
        gap=np.zeros(NODES),
        gap_rate=np.zeros(NODES),
        slip=np.zeros(NODES),
        loss=np.zeros(NODES),
        sliding=np.zeros(NODES),
        memory=np.zeros(NODES),
        coupled=np.zeros((2 * NODES, 2 * NODES + 1)),
        frame=np.zeros(4),
        node_q=np.zeros((NODES, j)),
        node_v=np.zeros((NODES, j)),
        node_phase=np.zeros((NODES, 2, k)),
        tip=np.zeros((NODES, 5)),
        other_q=np.zeros(j),
        other_v=np.zeros(j),
        other_phase=np.zeros((2, k)),
        integrals=np.zeros(NODES + 2),
        stick=np.zeros((NODES, NODES + 1)),
        rows=np.zeros((NODES, 4)),
    )


@part_kernel
def begin(plant: Plant, step: Step, time: float) -> None:
    """Split the state at the step's start into steady state and free motion.

    A nearly resonant pair has no steady state here: its mode is free and answers its tone from rest.
    """
    for k in range(plant.omega.size):
        step.phase[0, k] = cos(plant.omega[k] * time)
        step.phase[1, k] = sin(plant.omega[k] * time)
    for j in range(plant.stiffness.size):
        q = step.q[j]
        v = step.v[j]
        for k in range(plant.omega.size):
            cosine, sine = step.phase[0, k], step.phase[1, k]
            q -= plant.steady_re[j, k] * cosine - plant.steady_im[j, k] * sine
            v += plant.omega[k] * (plant.steady_re[j, k] * sine + plant.steady_im[j, k] * cosine)
        step.free_q[j] = q
        step.free_v[j] = v


@inner_kernel
def driven(
    plant: Plant, step: Step, pair: int, answer: Array | tuple[float, float, float, float]
) -> tuple[float, float]:
    """What a tone adds to displacement and rate of its nearly resonant mode since the step's start.

    Args:
        plant, step: the step.
        pair: row of `Plant.near`.
        answer: to exp(i omega s) from rest, see `answer_from_rest`.
    """
    j, k = plant.near[pair, 0], plant.near[pair, 1]
    cosine, sine = step.phase[0, k], step.phase[1, k]
    re = plant.force_re[j, k] * cosine - plant.force_im[j, k] * sine
    im = plant.force_re[j, k] * sine + plant.force_im[j, k] * cosine
    return re * answer[0] - im * answer[1], re * answer[2] - im * answer[3]


@part_kernel
def shape_forces(tables: Tables, step: Step) -> None:
    """Polynomials through the forces at the nodes."""
    for row in range(6):
        for d in range(NODES):
            total = 0.0
            for m in range(NODES):
                total += step.force[row, m] * tables.lagrange[m, d]
            step.shape[row, d] = total


@inner_kernel
def largest(values: Array) -> float:
    """Largest of a few values."""
    most = values[0]
    for value in values:
        most = max(most, value)
    return float(most)


@inner_kernel
def hold_forces(step: Step) -> None:
    """Polynomials of a constant force that stands at the first node."""
    for row in range(6):
        step.shape[row, 0] = step.force[row, 0]
        for d in range(1, NODES):
            step.shape[row, d] = 0.0


@inner_kernel
def force_at(step: Step, row: int, x: float) -> float:
    """Value of one row of the force polynomial at x = s/h."""
    total = 0.0
    for d in range(NODES - 1, -1, -1):
        total = total * x + step.shape[row, d]
    return total


@inner_kernel
def memory_at(step: Step, x: float) -> float:
    """The friction's memory at x = s/h."""
    total = 0.0
    for d in range(NODES - 1, -1, -1):
        total = (total + step.shape[MEMORY_RATE, d] / (d + 1)) * x
    return float(step.real[MEMORY] + step.real[LENGTH] * total)


@inner_kernel
def flow_to(plant: Plant, step: Step, s: float) -> None:
    """State at time s after the start, 0 <= s <= h, into other_q, other_v and other_phase."""
    degree = step.whole[KIND]
    h = step.real[LENGTH]
    top = max(degree + 1, 1)
    for k in range(plant.omega.size):
        cosine, sine = cos(plant.omega[k] * s), sin(plant.omega[k] * s)
        step.other_phase[0, k] = step.phase[0, k] * cosine - step.phase[1, k] * sine
        step.other_phase[1, k] = step.phase[0, k] * sine + step.phase[1, k] * cosine
    for j in range(plant.stiffness.size):
        c = plant.damping[j]
        stiffness = plant.stiffness[j]
        impulse_integrals(stiffness, c, s, top, step.integrals)
        rate = step.integrals[0]
        w = step.integrals[1]
        q = (rate + c * w) * step.free_q[j] + w * step.free_v[j]
        v = -stiffness * w * step.free_q[j] + rate * step.free_v[j]
        q += plant.constant[j] * step.integrals[2]
        v += plant.constant[j] * w
        scale = 1.0
        for d in range(degree + 1):
            if d > 0:
                scale *= d / h
            push = scale * (
                plant.row_u[j] * step.shape[PUSH_U, d]
                + plant.row_th[j] * step.shape[PUSH_TH, d]
                + plant.row_r[j] * step.shape[FRICTION, d]
            )
            q += push * step.integrals[d + 2]
            v += push * step.integrals[d + 1]
        for k in range(plant.omega.size):
            cosine, sine = step.other_phase[0, k], step.other_phase[1, k]
            q += plant.steady_re[j, k] * cosine - plant.steady_im[j, k] * sine
            v -= plant.omega[k] * (plant.steady_re[j, k] * sine + plant.steady_im[j, k] * cosine)
        step.other_q[j] = q
        step.other_v[j] = v
    for p in range(plant.near.shape[0]):
        j, k = plant.near[p, 0], plant.near[p, 1]
        answer = answer_from_rest(plant.stiffness[j], plant.damping[j], plant.omega[k], s)
        q, v = driven(plant, step, p, answer)
        step.other_q[j] += q
        step.other_v[j] += v


@inner_kernel
def is_finite(step: Step) -> bool:
    """Whether all that the law has answered for a step are numbers, and so is the motion that answers it."""
    if step.whole[KIND] == FLIGHT:
        return True
    total = 0.0
    for i in range(1 if step.whole[KIND] == HELD else NODES):
        total += abs(step.force[NORMAL, i]) + abs(step.force[FRICTION, i])
        if step.whole[KIND] == COLLOCATED:
            total += abs(step.force[BOUND, i]) + abs(step.force[MEMORY_RATE, i]) + abs(step.loss[i])
            # A force that is no number leaves a gap that is none, at which the law is not asked again.
            total += abs(step.gap[i]) + abs(step.slip[i])
    return bool(np.isfinite(total))


@inner_kernel
def tip_motion(plant: Plant, q: Array, v: Array) -> tuple[float, float, float, float, float]:
    """U [m], th [rad], their rates, and -R Omega [m/s] of a state."""
    u = 0.0
    th = 0.0
    u_rate = 0.0
    th_rate = 0.0
    rotor = 0.0
    for j in range(q.size):
        u += plant.row_u[j] * q[j]
        th += plant.row_th[j] * q[j]
        u_rate += plant.row_u[j] * v[j]
        th_rate += plant.row_th[j] * v[j]
        rotor += plant.row_r[j] * v[j]
    return u, th, u_rate, th_rate, rotor
