"""The nodal forces of a step in compliant contact: how their iteration begins, and how it goes on.

All nodes take the law's answers to the motion under the forces of the sweep before or, where a damping
relaxes the force within the step, Newton steps. It begins with the forces of the last step; friction that
depends on the slip has other ways beside, `AT_SLIP_BEFORE` and `AT_REST`: the first that contracts is taken.
"""

from math import nan
from typing import NamedTuple

import numpy as np

from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.compiler.lanes import (
    Lanes,
    fill,
    larger,
    largest,
    load,
    load_all,
    put,
    smaller,
    store,
    where_less,
)
from contactlab.engine.friction import HELD_SLIP, LEAST_SLIP, correct_friction, follow_bound, friction_at
from contactlab.engine.kinematics import contact_at
from contactlab.engine.memory import correct_memory, end_at, guess_memory, recall
from contactlab.engine.nodes import MOST_ITERATIONS, agree, fit_nodes, move_nodes, push_nodes, solve_linear
from contactlab.engine.plant import delassus
from contactlab.engine.state import HEAD, LAST, NODES, START, Law, Run, fit, values_at
from contactlab.laws.base import ELASTOPLASTIC, RATE_DEPENDENT, SET_VALUED, SLIP, STICK

CAUTION = 10.0
"""Ratio of two sweeps' changes over that of the two before, at most [1]."""

BOUND_ROUND_OFF = 1e-9
"""Of a friction bound, relative to the normal force."""

AT_SLIP_BEFORE, AT_REST = 1, 2
"""Ways to begin an iteration, with a slip and what keeps it; zero is with the forces of the last step."""

LEAST_DAMPED = 0.1
"""Answer of a damping to the normal force in a step [1] below which the law's answers in turn contract."""

MOST_ELASTIC = 10.0
"""Answer of a spring to the normal force in a step, k h^2 D_nn/2 [1], from which on a sweep contracts by less
than two: the squared matrix A of the Radau rule has the spectral radius 0.0253."""

TOUCHED = -1e-22
"""Gap [m] that stands for one just closed: of a force that jumps there, a step begins with the far side."""


class Known(NamedTuple):
    """What is known of the forces where a step begins.

    Args:
        normal: normal force [N].
        bound, bias: half the width, and the middle, of the interval that bounds friction in the step's mode
            [N].
        friction: friction that is not set-valued [N].
        steepness: by how much it falls as the slip rises [N s/m].
        stiffness, damping: by how much the normal force rises as gap [N/m] and gap rate [N s/m] fall.
    """

    normal: float
    bound: float
    bias: float
    friction: float
    steepness: float
    stiffness: float
    damping: float


@part_kernel
def iterate(run: Run, law: Law, level: int, known: Known, stretch: float, stiffness: float) -> int:
    """Iterate the forces of a step in the ways that may contract; returns the number of sweeps, 0 for none.

    A damping that relaxes the normal force within the step takes Newton steps, and one that hardly does takes
    them where the law's answers in turn do not contract; a spring too stiff for them has none. Friction
    that is steep in the slip, by a `stiffness` above one, begins with the slip before the step, and from rest
    where that does not contract; other friction does so where its law's answers do not.
    """
    lean, sweeps = _lean(run, known, stiffness), 0
    # By how much the normal force at the last node falls as that of all nodes rises: k_n D_nn h^2/2 by its
    # spring, c_n D_nn h by its damping.
    elastic = _answered_by_all(run, level, known.stiffness, 0.0, lean)
    damped = _answered_by_all(run, level, 0.0, known.damping, lean) if known.damping != 0.0 else 0.0
    # A step that does not resolve an elastic swing must not be solved, by Newton's method neither: the
    # polynomial may agree with the law at all nodes and miss the swing between them, and no error shows it.
    if elastic > max(MOST_ELASTIC, damped):
        return 0
    # Only a damping that outweighs its spring relaxes the force monotonically, which the nodes do resolve.
    damped = damped if damped > elastic else 0.0
    ways = AT_REST + 1 if run.state.law.friction_kind == RATE_DEPENDENT else 1
    for stiff in range(1 if damped > 1.0 else 0, 2 if damped > LEAST_DAMPED else 1):
        for way in range(AT_SLIP_BEFORE if stiffness > 1.0 else 0, ways):
            if sweeps == 0:
                # Every way begins with the same forces: a diverged iteration leaves nothing to begin with.
                _first_forces(run, law, stretch)
                sweeps = _collocate(run, law, level, way, known, lean, stiff == 1)
    return sweeps


@inner_kernel
def _lean(run: Run, known: Known, stiffness: float) -> float:
    """Return how much of a change of the normal force its friction follows [1], at the step's start.

    Friction that holds the slip, or is steep in it, answers by what keeps the slip: -D_nt/D_tt.
    """
    state, step = run.state, run.step
    friction, kept = known.friction, 0.0
    if state.mode == STICK or stiffness > 0.0:
        directions = step.n_u[0], step.n_th[0], step.t_u[0], step.t_th[0]
        _, crossed, along = delassus(run.plant, *directions)
        kept = -crossed / along
    # Stick: what a normal force adds to the slip, D_nt, friction takes back by D_tt. The friction of a spring
    # follows its stretch and not the normal force.
    if state.mode == STICK:
        return kept if state.law.friction_kind == SET_VALUED else 0.0
    # Slip: the ratio F/N. Steep friction lies between that and the friction which keeps the slip, weighed by
    # its `stiffness`, -f_v dv/dF of eq. 3.9.
    if state.law.friction_kind == SET_VALUED:
        friction = known.bias - state.sign * known.bound
    ratio = friction / known.normal if known.normal > 0.0 else 0.0
    return (ratio + stiffness * kept) / (1.0 + stiffness)


@inner_kernel
def _answered(run: Run, level: int, stiffness: float, damping: float, lean: float, m: int) -> Lanes:
    """Return by how much the normal force of each node falls as that of node m rises, with its friction [1].

    Stiffness [N/m] and damping [N s/m] are how it falls with gap and gap rate.
    """
    step, results = run.step, run.propagator.levels[level]
    tip_q, tip_v = results.tip_q, results.tip_v
    # Eq. 3.4 differentiated: node m presses along n + lean t, all nodes move along n. Positive: a force opens
    # the gap, which lets the force fall.
    push_u, push_th = step.n_u[m] + lean * step.t_u[m], step.n_th[m] + lean * step.t_th[m]
    u = stiffness * load_all(tip_q[0, m]) + damping * load_all(tip_v[0, m])
    mixed = stiffness * load_all(tip_q[1, m]) + damping * load_all(tip_v[1, m])
    th = stiffness * load_all(tip_q[2, m]) + damping * load_all(tip_v[2, m])
    by_u, by_th = u * push_u + mixed * push_th, mixed * push_u + th * push_th
    falls: Lanes = load(step.n_u) * by_u + load(step.n_th) * by_th
    return falls


@inner_kernel
def _answered_by_all(run: Run, level: int, stiffness: float, damping: float, lean: float) -> float:
    """Return by how much the normal force of the last node falls as those of all rise, see `_answered`."""
    falls = fill(0.0)
    for m in range(NODES):
        falls = falls + _answered(run, level, stiffness, damping, lean, m)
    return float(falls[LAST])


@inner_kernel
def _first_forces(run: Run, law: Law, stretch: float) -> None:
    """Set forces and internal variable at the nodes from the polynomials that stand, to iterate from."""
    state, nodes = run.state, run.propagator.rule.nodes
    # x = s/h on the last step's polynomial, beyond its end where no event cut it. An extrapolation may
    # overshoot: no first guess of the normal force or of the bound is negative.
    x = state.accepted_length + load(nodes) * stretch
    bound, bias = larger(values_at(state.bound, x), 0.0), values_at(state.bias, x)
    if state.mode == SLIP and state.law.friction_kind != RATE_DEPENDENT:
        friction = bias - state.sign * bound
    else:
        friction = values_at(state.friction, x)
    store(state.normal.node, larger(values_at(state.normal, x), 0.0))
    store(state.bound.node, bound)
    store(state.bias.node, bias)
    store(state.friction.node, friction)
    if state.law.coupled != 0:
        store(state.internal_rate.node, values_at(state.internal_rate, x))
    push_nodes(run)
    guess_memory(run, law.memory)


@inner_kernel
def _collocate(run: Run, law: Law, level: int, way: int, known: Known, lean: float, stiff: bool) -> int:
    """Iterate the nodal forces of a step; returns the number of sweeps, 0 where it does not contract.

    Rate-dependent friction may begin AT_SLIP_BEFORE, with what keeps the slip before the step: where friction
    is steep, a force tells nothing of its slip. Or AT_REST, from where Newton's method converges on the steep
    part of the law, where from the level part it would alternate. A normal force that is `stiff` takes Newton
    steps too.
    """
    state = run.state
    kind, sticks = state.law.friction_kind, state.mode == STICK
    follows = kind == RATE_DEPENDENT or (kind != SET_VALUED and sticks)
    least_slip, before = HELD_SLIP if way > 0 else LEAST_SLIP, 0.0
    kept = contact_at(run.plant, START)[2] if way == AT_SLIP_BEFORE else 0.0
    for sweep in range(1, MOST_ITERATIONS + 1):
        # Eq. 3.4: the law's answers to the motion that the nodal forces cause; then friction by eq. 3.7 or
        # 3.9, and the internal variables by eq. 5.2. Each takes what those before it have left: their mutual
        # influence is what further sweeps are for.
        change, most = _sweep_normal(run, law, level, known, lean, stiff)
        holds = way > 0 or (sticks and not follows)
        coupled = 0.0
        if holds or follows:
            corrected, coupled = correct_friction(run, law, level, holds, kept, least_slip)
            change = max(change, corrected)
        flowed = max(coupled, correct_memory(run, law, law.memory, state.length))
        # A law that returns no number here may return one over a shorter step, whose motion is nearer to its
        # start.
        if not np.isfinite(change):
            return 0
        if way > 0 and (way == AT_SLIP_BEFORE or agree(state, change, most, flowed)):
            # The friction that holds the slip is the start of Newton's method on the law's own.
            way, before = 0, 0.0
            continue
        # The iteration is linear near its end, so that the ratio of two sweeps' changes foretells the next
        # one (Hairer and Wanner, Solving ODEs II, IV.8): it need not be done only to see that it is small.
        # What is held at zero drifts by whatever a sweep leaves of it: there it must be done.
        moved = max(flowed, change / most if most > 0.0 else 0.0)
        share = min(CAUTION * moved / before, 1.0) if not holds and before > 0.0 else 1.0
        before = min(moved, 1.0)
        if not agree(state, share * change, most, share * flowed):
            continue
        if kind != SET_VALUED and not follows:
            follow_bound(run, law, float(state.sign))
        fit_nodes(run)
        if state.law.coupled != 0:
            fit(run.propagator.rule, state.internal_rate)
        return sweep
    return 0


@inner_kernel
def _sweep_normal(
    run: Run, law: Law, level: int, known: Known, lean: float, stiff: bool
) -> tuple[float, float]:
    """Take the law's answers at all nodes, as they are or by a Newton step where they are `stiff`.

    Returns the largest change of a force and the largest force [N].
    """
    state = run.state
    slides = state.mode != STICK and state.law.friction_kind != RATE_DEPENDENT
    old_normal, old_friction = load(state.normal.node), load(state.friction.node)
    # As Jacobi, all answers are to one motion, that of all nodes at once.
    move_nodes(run, level)
    _take_forces(run, law)
    normal = load(state.normal.node)
    # Friction that would have to hold far more than the law lets it has the round-off of its size.
    most = largest(larger(larger(abs(old_friction), normal), 0.0))
    if stiff:
        change = _correct_normal(run, level, known, lean, slides, old_normal)
    else:
        friction = old_friction
        if slides:
            # Eq. 3.5, about the middle of the bounds where a law has a lower one and an upper one.
            friction = load(state.bias.node) - state.sign * load(state.bound.node)
            store(state.friction.node, friction)
        change = largest(larger(abs(normal - old_normal), abs(friction - old_friction)))
    push_nodes(run)
    return change, most


@inner_kernel
def _correct_normal(run: Run, level: int, known: Known, lean: float, slides: bool, before: Lanes) -> float:
    """Take a Newton step of the normal forces `before` [N] from the law's answers.

    Returns the largest correction [N].

    The law's slopes are those at the step's start. Friction and what bounds it follow the normal force.
    """
    state, system = run.state, run.step.system
    for m in range(NODES):
        falls = _answered(run, level, known.stiffness, known.damping, lean, m)
        for i in range(NODES):
            # Row i of N - N(motion of N) = 0, linearised: the law's force falls as that of node m rises.
            # Where the law has no force it has no slope.
            falls_i = falls[i] if state.normal.node[i] != 0.0 else 0.0
            system[i, m] = (1.0 if m == i else 0.0) + falls_i
    for i in range(NODES):
        system[i, NODES] = state.normal.node[i] - before[i]
    solve_linear(system, NODES)
    most = 0.0
    for i in range(NODES):
        of_law, change = state.normal.node[i], system[i, NODES]
        state.normal.node[i] = before[i] + change
        # The law is not evaluated again for the corrected force: its bounds are taken as proportional to it,
        # which the next sweep makes good.
        if slides:
            share = state.normal.node[i] / of_law if of_law != 0.0 else 1.0
            state.bound.node[i] *= share
            state.bias.node[i] *= share
            state.friction.node[i] = state.bias.node[i] - state.sign * state.bound.node[i]
        else:
            state.friction.node[i] += lean * change
        # NaN fails every comparison, and is passed on.
        most = abs(change) if not abs(change) <= most else most
    return float(most)


@inner_kernel
def _take_forces(run: Run, law: Law) -> None:
    """Set the law's forces at all nodes, whose motion is set."""
    state, step = run.state, run.step
    gap, end = load(step.gap), fill(0.0)
    if state.law.has_limits != 0:
        for i in range(NODES):
            recall(run, law, i)
            end = put(end, i, end_at(run, law, law.memory, step.gap_rate[i]))
    store(step.end, end)
    # Friction without a normal force goes on beyond the release, which cuts the step: it has no jump there.
    store(step.closed, smaller(gap, end + TOUCHED))
    # What is left of the slip in stick is an error of the iteration: the law receives zero.
    store(step.seen, fill(0.0) if state.mode == STICK else load(step.slip))
    law.at_nodes(step, state.impact_speed, law.row, law.parameters)
    least, most = load(step.least), load(step.most)
    bound, bias = 0.5 * (most - least), 0.5 * (most + least)
    normal = load(step.normal)
    # No number where the law says a negative friction bound with it.
    normal = where_less(bound, -BOUND_ROUND_OFF * abs(normal), nan, normal)
    normal = where_less(gap, end, normal, 0.0)
    if state.mode == STICK and state.law.friction_kind == ELASTOPLASTIC:
        for i in range(NODES):
            if gap[i] < end[i]:
                recall(run, law, i)
                contact = gap[i], step.gap_rate[i], step.slip[i]
                bias = put(bias, i, bias[i] + beside_spring(run, law, contact, end[i], normal[i]))
    store(state.normal.node, normal)
    store(state.bound.node, bound)
    store(state.bias.node, bias)
    store(step.loss, where_less(gap, end, load(step.loss), 0.0))


@inner_kernel
def beside_spring(run: Run, law: Law, at: tuple[float, float, float], end: float, normal: float) -> float:
    """Return the friction beside the spring of an elastoplastic contact that sticks, which no bound holds.

    The recalled stretch is zero afterwards. In slip it is the middle of the bounds, in rigid stick zero.
    """
    if run.state.mode != STICK or run.state.law.friction_kind != ELASTOPLASTIC:
        return 0.0
    law.row[HEAD] = 0.0
    return friction_at(law, at, end, normal)[0]


@part_kernel
def sound_normal(normal: float, bound: float) -> float:
    """Return the normal force [N]; no number where the law says a negative friction bound with it."""
    return nan if bound < -BOUND_ROUND_OFF * abs(normal) else normal
