"""Exact step responses at the nodes of one quadrature rule, for a ladder of step lengths.

All steps of the engine live on one ladder h = longest / 2^level. Over a step the contact force is a
polynomial through its values at the Radau nodes c_i h (the last one is the step's end), and the
oscillators answer it exactly. What the nodes see of it is a few small matrices that do not depend on
the state, built once per level that is used.
"""

from functools import cache
from math import ceil, cos, floor, log2, sin
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Legendre, Polynomial
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.compiled import inner_kernel, kernel
from contactlab.engine.oscillator import impulse_integrals
from contactlab.engine.plant import Plant, fastest_rate, resolved_rate
from contactlab.engine.resonance import answer_from_rest

NODES = 5
"""Radau IIA nodes a step: quadrature of order 9, collocation of order 9 for a smooth force."""

RESOLUTION = 0.5
"""Longest step times the fastest rate that persists in flight."""

LEVELS = 44
"""Levels of a ladder, if its contact step leaves the room below."""

ROOM = 24
"""Levels below that of the contact step: a contact begins six finer, and its error halves steps further."""


OUTLASTING = 2.0**20
"""Longest step over the duration of the run."""


class Tables(NamedTuple):
    """Step responses; l level, i node of evaluation, m node of force, j coordinate, k tone.

    Args:
        nodes, weights: c_i and b_i on (0, 1].
        lagrange: basis polynomials, l_m(x) = sum_d lagrange[m, d] x^d.
        derivative: rates at the nodes, in 1/h, of the polynomial that is zero at 0 and given at the nodes.
        longest: length of level 0 [s].
        contact_level: level of the longest step in contact.
        fresh_level: level of the first step after a release.
        built: 1 where the level is filled, shape (l,).
        flow: free flow, q from q0, q from v0, v from q0, v from v0, shape (l, i, 4, j).
        hold: q and v from a unit constant force, shape (l, i, 2, j).
        answer_q, answer_v: q and v from l_m, shape (l, i, m, j).
        turn_cos, turn_sin: of omega_k c_i h, shape (l, i, k).
        driven: answers from rest of the nearly resonant pairs p, see `answer_from_rest`, shape (l, i, p, 4).
        tip_q: u and th from f_u and f_th: uu, uth, thth, shape (l, 3, i, m).
        tip_v: their rates, and the rotor's row: uu, uth, thth, rr, shape (l, 4, i, m).
        integrals: scratch of the oscillator, shape (i + 2,).
    """

    nodes: Array
    weights: Array
    lagrange: Array
    derivative: Array
    longest: float
    contact_level: int
    fresh_level: int
    built: NDArray[np.int64]
    flow: Array
    hold: Array
    answer_q: Array
    answer_v: Array
    turn_cos: Array
    turn_sin: Array
    driven: Array
    tip_q: Array
    tip_v: Array
    integrals: Array


@cache
def radau_rule(count: int) -> tuple[Array, Array, Array]:
    """Nodes, weights and Lagrange coefficients of the right Radau rule on (0, 1]."""
    difference = Legendre.basis(count) - Legendre.basis(count - 1)
    nodes = np.sort(0.5 * (difference.roots().real + 1.0))
    nodes[-1] = 1.0
    lagrange = np.zeros((count, count))
    for m in range(count):
        others = np.delete(nodes, m)
        lagrange[m] = (Polynomial.fromroots(others) / np.prod(nodes[m] - others)).coef
    weights = lagrange @ (1.0 / np.arange(1, count + 1))
    return nodes, weights, lagrange


@cache
def derivative_rule(count: int) -> Array:
    """The inverse of the collocation matrix a_im = int_0^c_i l_m dx."""
    nodes, _, lagrange = radau_rule(count)
    powers = np.arange(1, count + 1)
    return np.asarray(np.linalg.inv((nodes[:, None] ** powers) @ (lagrange / powers).T), np.float64)


def tables_for(plant: Plant, contact_step: float, duration: float, exact: bool) -> Tables:
    """An empty ladder that has the contact step as one of its levels.

    The longest step resolves what persists in flight; after a release the steps start short
    enough for the fastest transient and double from there.

    Args:
        plant: the motor.
        contact_step: step in contact [s].
        duration: of the run [s], the longest step where nothing vibrates.
        exact: whether steps in contact must have this length, not only at most this length.
    """
    nodes, weights, lagrange = radau_rule(NODES)
    # Steps may outlast a run, so that a longer one begins like it, but not for ever.
    rate = max(resolved_rate(plant), RESOLUTION / (OUTLASTING * duration))
    rate = rate if resolved_rate(plant) > 0.0 else RESOLUTION / duration
    doublings = floor(log2(RESOLUTION / rate / contact_step))
    if exact:
        doublings = max(doublings, 0)
    contact_level = max(doublings, 0)
    longest = contact_step * 2.0**doublings
    turns = max(longest * fastest_rate(plant), 1.0)
    levels = max(LEVELS, contact_level + ROOM)
    fresh_level = min(max(6, ceil(log2(turns)) + 2), levels - 8)
    count, tones = plant.stiffness.size, plant.omega.size
    return Tables(
        nodes=nodes,
        weights=weights,
        lagrange=lagrange,
        derivative=derivative_rule(NODES),
        longest=longest,
        contact_level=contact_level,
        fresh_level=fresh_level,
        built=np.zeros(levels, dtype=np.int64),
        flow=np.empty((levels, NODES, 4, count)),
        hold=np.empty((levels, NODES, 2, count)),
        answer_q=np.empty((levels, NODES, NODES, count)),
        answer_v=np.empty((levels, NODES, NODES, count)),
        turn_cos=np.empty((levels, NODES, tones)),
        turn_sin=np.empty((levels, NODES, tones)),
        driven=np.empty((levels, NODES, len(plant.near), 4)),
        tip_q=np.empty((levels, 3, NODES, NODES)),
        tip_v=np.empty((levels, 4, NODES, NODES)),
        integrals=np.empty(NODES + 2),
    )


@inner_kernel
def level_count(tables: Tables) -> int:
    """Levels of the ladder."""
    return tables.built.size


@inner_kernel
def step_length(tables: Tables, level: int) -> float:
    """Length of a level's step [s]."""
    return tables.longest * 0.5**level


@kernel
def build_level(plant: Plant, tables: Tables, level: int) -> None:
    """Fill one level; a second call does nothing."""
    if tables.built[level] == 1:
        return
    tables.built[level] = 1
    h = step_length(tables, level)
    count = tables.nodes.size
    integrals = tables.integrals
    for i in range(count):
        s = tables.nodes[i] * h
        for k in range(plant.omega.size):
            tables.turn_cos[level, i, k] = cos(plant.omega[k] * s)
            tables.turn_sin[level, i, k] = sin(plant.omega[k] * s)
        for p in range(plant.near.shape[0]):
            j, k = plant.near[p, 0], plant.near[p, 1]
            answer = answer_from_rest(plant.stiffness[j], plant.damping[j], plant.omega[k], s)
            for part in range(4):
                tables.driven[level, i, p, part] = answer[part]
        for j in range(plant.stiffness.size):
            impulse_integrals(plant.stiffness[j], plant.damping[j], s, count, integrals)
            _fill(plant, tables, level, i, j, h, integrals)
    _reduce(plant, tables, level)


@inner_kernel
def _fill(
    plant: Plant, tables: Tables, level: int, i: int, j: int, h: float, integrals: Array
) -> None:
    """Responses of one coordinate at one node."""
    w = integrals[1]
    tables.flow[level, i, 0, j] = integrals[0] + plant.damping[j] * w
    tables.flow[level, i, 1, j] = w
    tables.flow[level, i, 2, j] = -plant.stiffness[j] * w
    tables.flow[level, i, 3, j] = integrals[0]
    tables.hold[level, i, 0, j] = integrals[2]
    tables.hold[level, i, 1, j] = w
    count = tables.nodes.size
    for m in range(count):
        q = 0.0
        v = 0.0
        scale = 1.0
        for d in range(count):
            # (s/h)^d = d!/h^d times s^d/d!, whose answers are I_(d+1) and I_d.
            if d > 0:
                scale *= d / h
            q += tables.lagrange[m, d] * scale * integrals[d + 2]
            v += tables.lagrange[m, d] * scale * integrals[d + 1]
        tables.answer_q[level, i, m, j] = q
        tables.answer_v[level, i, m, j] = v


@inner_kernel
def _reduce(plant: Plant, tables: Tables, level: int) -> None:
    """What the contact sees of the responses: sums over the coordinates."""
    count = tables.nodes.size
    for i in range(count):
        for m in range(count):
            for row in range(3):
                tables.tip_q[level, row, i, m] = 0.0
            for row in range(4):
                tables.tip_v[level, row, i, m] = 0.0
            for j in range(plant.stiffness.size):
                u, th, r = plant.row_u[j], plant.row_th[j], plant.row_r[j]
                q = tables.answer_q[level, i, m, j]
                v = tables.answer_v[level, i, m, j]
                tables.tip_q[level, 0, i, m] += u * u * q
                tables.tip_q[level, 1, i, m] += u * th * q
                tables.tip_q[level, 2, i, m] += th * th * q
                tables.tip_v[level, 0, i, m] += u * u * v
                tables.tip_v[level, 1, i, m] += u * th * v
                tables.tip_v[level, 2, i, m] += th * th * v
                tables.tip_v[level, 3, i, m] += r * r * v
