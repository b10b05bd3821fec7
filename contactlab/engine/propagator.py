"""Exact step responses at the nodes of one quadrature rule, for a ladder of step lengths.

All steps of the engine live on one ladder h = longest / 2^level. Over a step the contact force is a
polynomial through its values at the Radau nodes c_i h (the last one is the step's end), and the
oscillators answer it exactly. What the nodes see of it is a few small matrices that do not depend on
the state, built once per level that is used.
"""

from functools import cache
from math import ceil, cos, floor, log2, sin
from typing import Any, final

import numpy as np
from numpy.polynomial import Legendre, Polynomial

from contactlab.arrays import Array
from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.compiler.lanes import WIDTH, entry, set_entry
from contactlab.engine.oscillator import impulse_integrals, integrals_of_several, response_from_rest
from contactlab.engine.plant import ORDERS, Plant, fastest_rate, resolved_rate
from contactlab.engine.state import NODES, new_record, record

RESOLUTION = 0.5
"""Longest step in contact times the fastest rate that persists: of a power that turns twice as fast the
quadrature of the ledger misses at most 1.7e-11, see docs/theory/flight.md."""

FLIGHT_DOUBLINGS = 2
"""How often that step is doubled in flight: the quadrature there, of more nodes, misses 1.2e-12."""

LEVELS, MOST_LEVELS = 46, 86
"""Levels of a ladder, if its contact step leaves the room below, and the most: OUTLASTING over the smallest
step takes 60."""

ROOM = 24
"""Levels below that of the contact step: a contact begins six finer, and its error halves steps further."""

BY_RECORD = MOST_LEVELS
"""Level beside the ladder whose step is the record interval."""

PART = BY_RECORD + 1
"""Level of a part of a flight, whose responses are anew every time."""

OUTLASTING = 2.0**20
"""Longest step in contact over the duration of the run."""

RULE = record(
    *((name, float, NODES) for name in ("nodes", "weights")),
    ("lagrange", float, (NODES, WIDTH)),
    ("derivative", float, (NODES, NODES)),
    ("integrals", float, ORDERS + 2),
    ("integrals_of_several", float, (ORDERS + 2, WIDTH)),
    ("flight", float, (2, WIDTH)),
    real="longest resolved",
    whole="contact_level fresh_level level_count",
)
LEVEL = record(
    ("tip_q", float, (3, NODES, WIDTH)),
    ("tip_v", float, (4, NODES, WIDTH)),
    ("flight", float, (2, WIDTH)),
    real="length",
    whole="built flown",
)
RESPONSE = record(
    ("flow", float, (4, WIDTH)),
    ("hold", float, (2, WIDTH)),
    ("answer_q", float, (NODES, WIDTH)),
    ("answer_v", float, (NODES, WIDTH)),
    ("powers", float, (ORDERS + 1, WIDTH)),
)
TURN = record(("cosine", float, WIDTH), ("sine", float, WIDTH))
ANSWER = record(("part", float, (4, NODES)))
INTEGRALS = record(("flight", float, (ORDERS + 2, WIDTH)))
TURN_IN_FLIGHT = record(("flight", float, (2, WIDTH)))
ANSWER_IN_FLIGHT = record(("flight", float, (4, WIDTH)))

Propagator = Any
"""Step responses, a record; i node of evaluation, m node of force, j coordinate, k tone. Where there
are nodes of evaluation, they are the last axis, in what is read as lanes with room for a register.

rule: nodes c_i and weights b_i on (0, 1]; lagrange, basis polynomials l_m(x) = sum_d lagrange[m, d] x^d;
derivative, rates at the nodes, in 1/h, of the polynomial that is zero at 0 and given at the nodes; flight,
nodes and weights in flight; longest, length of level 0 [s]; resolved, the longest that the nodes resolve [s];
contact_level, of the longest step in contact; fresh_level, of the first step after a release; level_count;
integrals and integrals_of_several, scratch of the oscillator.
levels[level]: length h [s]; whether it is built, and for flights; tip_q, u and th from f_u and f_th: uu, uth,
thth; tip_v, their rates, and the rotor's row: uu, uth, thth, rr; flight, times of the nodes and weights [s].
responses[level, j]: flow, q from q0, q from v0, v from q0, v from v0; hold, q and v from a unit constant
force; answer_q and answer_v, q and v from l_m; powers, under a waveform: v from s^m / m!, and from one place
further on q.
turns[level, k]: cosine and sine of omega_k c_i h.
driven[level, j, k]: answers from rest of the nearly resonant pairs, see `response_from_rest`.
flights[level, j]: integrals I_-1, I_0, ... of `impulse_integrals` at the nodes in flight.
turns_in_flight[level, k], driven_in_flight[level, j, k]: cosine and sine, and answers from rest, there.
"""


@cache
def propagator_record(modes: int, tones: int) -> np.dtype[Any]:
    """Declare the record of a propagator with room for so many coordinates and tones."""
    return record(
        ("rule", RULE),
        ("levels", LEVEL, PART + 1),
        ("responses", RESPONSE, (BY_RECORD + 1, modes)),
        ("turns", TURN, (BY_RECORD + 1, tones)),
        ("driven", ANSWER, (BY_RECORD + 1, modes, tones)),
        ("flights", INTEGRALS, (PART + 1, modes)),
        ("turns_in_flight", TURN_IN_FLIGHT, (PART + 1, tones)),
        ("driven_in_flight", ANSWER_IN_FLIGHT, (PART + 1, modes, tones)),
    )


@cache
def radau_rule(count: int) -> tuple[Array, Array, Array, Array]:
    """Return nodes, weights and Lagrange coefficients of the right Radau rule on (0, 1], and its derivative.

    The derivative is the inverse of the collocation matrix a_im = int_0^c_i l_m dx.
    """
    difference = Legendre.basis(count) - Legendre.basis(count - 1)
    nodes = np.sort(0.5 * (difference.roots().real + 1.0))
    nodes[-1] = 1.0
    lagrange = np.zeros((count, count))
    # l_m of eq. 3.2: one at its own node and zero at the others.
    for m in range(count):
        others = np.delete(nodes, m)
        lagrange[m] = (Polynomial.fromroots(others) / np.prod(nodes[m] - others)).coef
    # delta = A^-1 of eq. 3.8, from values at the nodes to rates there, of a polynomial that is zero at the
    # start.
    powers = np.arange(1, count + 1)
    derivative = np.linalg.inv((nodes[:, None] ** powers) @ (lagrange / powers).T)
    return nodes, lagrange @ (1.0 / powers), lagrange, np.asarray(derivative, np.float64)


def resolving_step(rate: float, duration: float) -> float:
    """Return the longest step in contact [s] that resolves a rate [rad/s]; without one it is the duration."""
    return min(RESOLUTION / rate, OUTLASTING * duration) if rate > 0.0 else duration


@final
class Workspace:
    """Keeps the step responses of the last motor for a next one that has the same.

    A response is a function of the plant and the length of the step, whoever asks first, so that a run
    is the same to the last bit with a workspace and without. Runs that share one follow each other: it
    is also their scratch memory.
    """

    def __init__(self) -> None:
        self._key: tuple[object, ...] = ()
        self._propagator: Propagator = None

    def propagator(
        self, plant: Plant, contact_step: float, duration: float, exact: bool, rate: float | None = None
    ) -> Propagator:
        """Return a ladder for a plant that has the contact step [s] as one of its levels.

        The longest step in flight is `FLIGHT_DOUBLINGS` above that which resolves what persists, the duration
        [s] where nothing vibrates; after a release the steps start short enough for the fastest transient and
        double from there. Steps in contact have the length that resolves at most, or `exact`ly the contact
        step. The rate is that of `resolved_rate`, where it is known.
        """
        rate = resolved_rate(plant) if rate is None else rate
        # Steps may outlast a run, so that a longer one begins like it, but not for ever.
        # All lengths are one length halved: the responses to each are computed once, however often a contact
        # refines its steps.
        doublings = floor(log2(resolving_step(rate, duration) / contact_step)) + FLIGHT_DOUBLINGS
        longest = contact_step * 2.0 ** max(doublings, 0 if exact else doublings)
        coordinates, names = plant.modes, ["stiffness", "damping", "row_u", "row_th", "row_r", "led"]
        modes = [coordinates[name].tobytes() for name in names]
        waves = bool(plant.wave["electrodes"])
        # All that a response depends on. The amplitudes of the tones are none of it, so that a sweep of
        # voltages shares them.
        key = (*modes, plant.tones["omega"].tobytes(), longest, doublings, waves)
        if key == self._key:
            return self._propagator
        turns = max(longest * fastest_rate(plant), 1.0)
        propagator = new_record(propagator_record(*plant.phasors.shape))
        propagator.levels["length"][:BY_RECORD] = longest * 0.5 ** np.arange(BY_RECORD)
        rule = propagator.rule
        rule.nodes, rule.weights, rule.lagrange[:, :NODES], rule.derivative = radau_rule(NODES)
        nodes, weights, _, _ = radau_rule(WIDTH)
        rule.flight[:] = nodes, weights
        rule.longest, rule.contact_level = longest, max(doublings, 0 if exact else FLIGHT_DOUBLINGS)
        rule.resolved = longest * 0.5 ** min(int(rule.contact_level), FLIGHT_DOUBLINGS)
        rule.level_count = max(LEVELS, rule.contact_level + ROOM)
        # A release leaves transients of all modes: the first step turns the fastest by a radian at most, and
        # later ones double.
        rule.fresh_level = min(max(6, ceil(log2(turns))), rule.level_count - 8 - FLIGHT_DOUBLINGS)
        self._key, self._propagator = key, propagator
        return propagator


@part_kernel
def step_length(propagator: Propagator, level: int) -> float:
    """Return the length of a level's step [s]."""
    return float(propagator.levels[level].length)


@inner_kernel
def build_level(plant: Plant, propagator: Propagator, level: int) -> None:
    """Fill one level: what every coordinate answers, and what the contact sees of all; once."""
    results, rule = propagator.levels[level], propagator.rule
    if results.built == 1:
        return
    results.built = 1
    for i in range(NODES):
        s = rule.nodes[i] * results.length
        for k in range(plant.tone_count):
            turn = propagator.turns[level, k]
            turn.cosine[i] = cos(plant.tones[k].omega * s)
            turn.sine[i] = sin(plant.tones[k].omega * s)
        for j in range(plant.mode_count):
            mode, response = plant.modes[j], propagator.responses[level, j]
            top = ORDERS if plant.wave.electrodes > 0 else NODES
            impulse_integrals(mode.stiffness, mode.damping, s, top, rule.integrals)
            _fill(rule, mode, response, results, i)
            if plant.wave.electrodes > 0:
                for m in range(ORDERS + 1):
                    response.powers[m, i] = rule.integrals[m + 1]
            for k in range(plant.tone_count):
                if plant.phasors[j, k].near != 0:
                    omega = plant.tones[k].omega
                    result = response_from_rest(mode.stiffness, mode.damping, omega, s)
                    for part in range(4):
                        propagator.driven[level, j, k].part[part, i] = result[part]


@inner_kernel
def lay_flight(plant: Plant, propagator: Propagator, level: int, start: float, length: float) -> None:
    """Fill what every coordinate answers at the nodes of a flight, from a time in its step on [s]."""
    results, rule = propagator.levels[level], propagator.rule
    times = start + entry(rule.flight, 0) * length
    set_entry(results.flight, 0, times)
    set_entry(results.flight, 1, entry(rule.flight, 1) * length)
    for k in range(plant.tone_count):
        turn, omega = propagator.turns_in_flight[level, k].flight, plant.tones[k].omega
        for i in range(WIDTH):
            turn[0, i], turn[1, i] = cos(omega * times[i]), sin(omega * times[i])
    top = ORDERS if plant.wave.electrodes > 0 else 1
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        integrals_of_several(mode.stiffness, mode.damping, times, top, propagator.flights[level, j].flight)
        for k in range(plant.tone_count):
            if plant.phasors[j, k].near != 0:
                driven = propagator.driven_in_flight[level, j, k].flight
                for i in range(WIDTH):
                    result = response_from_rest(mode.stiffness, mode.damping, plant.tones[k].omega, times[i])
                    for part in range(4):
                        driven[part, i] = result[part]


@part_kernel
def build_flight(plant: Plant, propagator: Propagator, level: int) -> None:
    """Fill one level for flights, once."""
    results = propagator.levels[level]
    if results.flown == 0:
        results.flown = 1
        lay_flight(plant, propagator, level, 0.0, results.length)


@inner_kernel
def _fill(rule: Any, mode: Any, response: Any, results: Any, i: int) -> None:
    """Fill the responses of one coordinate at one node, and add what the contact sees of them."""
    integrals, tip_q, tip_v = rule.integrals, results.tip_q, results.tip_v
    w = integrals[1]
    # Eqs. 2.3 and 2.4: what the free part of the state becomes, and what a constant force does.
    response.flow[0, i] = integrals[0] + mode.damping * w
    response.flow[1, i] = w
    response.flow[2, i] = -mode.stiffness * w
    response.flow[3, i] = integrals[0]
    response.hold[0, i] = integrals[2]
    response.hold[1, i] = w
    # Eq. 3.3, the answers to the Lagrange polynomials. Summed with the rows over all coordinates they are the
    # matrices T of eqs. 3.4 and 3.7, so that an iteration costs as much with fifty modes as with two.
    u, th, r = mode.row_u, mode.row_th, mode.row_r
    for m in range(NODES):
        q, v, scale = 0.0, 0.0, 1.0
        for d in range(NODES):
            # (s/h)^d = d!/h^d times s^d/d!, whose results are I_(d+1) and I_d.
            if d > 0:
                scale *= d / results.length
            q += rule.lagrange[m, d] * scale * integrals[d + 2]
            v += rule.lagrange[m, d] * scale * integrals[d + 1]
        response.answer_q[m, i], response.answer_v[m, i] = q, v
        if mode.led != 0:
            # Whatever force acts, it is where its path is.
            continue
        tip_q[0, m, i] += u * u * q
        tip_q[1, m, i] += u * th * q
        tip_q[2, m, i] += th * th * q
        tip_v[0, m, i] += u * u * v
        tip_v[1, m, i] += u * th * v
        tip_v[2, m, i] += th * th * v
        tip_v[3, m, i] += r * r * v
