"""A law on a prescribed path, or behind a frame without inertia whose far end goes along it.

    x' = v,   e = x_L - x,   k e + c (x_L' - v) + F(g, g', v, z) = 0,   z' = r(g, g', v, z)

The load point x_L and the gap g, or the normal force, are splines of time; k and c are stiffness and damping
of the frame, F the friction that the law answers with and z its internal variables. A path is the frame of
infinite stiffness: v = x_L'. A step is collocated at the Radau nodes, as one in contact of a run is: z and e
are polynomials through their values at the start and at the nodes, where the equations hold. Newton's method
takes friction, variables and slip velocity at once. Steps end where the path has a kink, and where a guard
falls through zero, a slider begins or ends to slide, or the slip reverses.

Source: Hairer and Wanner (1996), Solving Ordinary Differential Equations II, ch. IV.8 and VI.1, of stiff and
of differential-algebraic equations by Radau IIA.
"""

from math import copysign
from typing import Any, Final, NamedTuple, final

import numpy as np
from numpy.polynomial import Polynomial

from contactlab.arrays import Array
from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.engine.friction import DIGITS
from contactlab.engine.memory import NUDGE, SLIP_ROUND_OFF
from contactlab.engine.propagator import radau_rule
from contactlab.engine.state import (
    CHATTERED,
    HEAD,
    INCONSISTENT,
    NODES,
    NOT_FINITE,
    RUNNING,
    SPEED,
    UNSOLVED,
    Law,
    Memory,
    record,
)
from contactlab.laws.base import ELASTOPLASTIC, RATE_DEPENDENT, SET_VALUED, SLIP, STICK
from contactlab.laws.memory import AT_SLIP, AT_STICK, AT_TOUCH, MOST_VARIABLES

BY_GAP, BY_LOAD, RIGID = range(3)
"""What the first row of a path prescribes: a gap, or the normal force of a compliant or of a rigid law."""

PIECES = 5
"""Pieces of a path that a step may span: as many as it has nodes, so that no sample goes unseen."""

ERROR_ORDER = NODES + 1
"""Order of the error of a step between its nodes."""

SAFETY, LEAST_FACTOR, MOST_FACTOR = 0.9, 0.1, 5.0
"""Of the next step: share of the length whose error is the tolerance, and bounds of the change."""

FRESH = 0.1
"""First step after an event over the one before it."""

FIRST = 1e-3
"""First step of all over the longest one."""

AGREEMENT, ROUNDED = 1e-2, 1e-11
"""Last correction of Newton's method over the tolerance of a step, and its round-off [1]."""

MOST_SWEEPS = 12
"""Newton's corrections of a step, after which it is shortened."""

SLOW = 0.1
"""Ratio of two corrections beyond which derivatives are taken anew."""

SHORTEST = 1e-14
"""Shortest step over the duration."""

FELT = 1e-12
"""Relative difference of the friction that is no round-off."""

AT_ONCE = 1e-10
"""Share of a step within which an event lies at its start."""

AT_END = 1e-9
"""Share of a step within which an event lies at its end."""

WATCHED, LEAST_WAY = 1000, 1e-6
"""Number of steps and events in which a path must go on by this share of it."""

MOST_AT_ONCE = 100
"""Events without a step between them."""

DEEPEST, HALVINGS = 1e-3, 60
"""Largest penetration at which a normal force is looked for [m], and halvings of it."""

CONTINUOUS = 1e-6
"""Relative jump of the friction at the end of stick that is round-off [1]."""

NODE, _WEIGHT, LAGRANGE, DERIVATIVE = radau_rule(NODES)
INTEGRAL = np.linalg.inv(DERIVATIVE)
"""Integrals from the start to the nodes of the basis polynomials."""


def _dense() -> tuple[Array, float]:
    """Return the basis polynomials through start and nodes, and the largest integral of a missed rate."""
    points = np.append(0.0, NODE)
    basis = np.zeros((NODES + 1, NODES + 1))
    for m in range(NODES + 1):
        others = np.delete(points, m)
        basis[m] = (Polynomial.fromroots(others) / np.prod(points[m] - others)).coef
    # The polynomial that is one at the start and zero at the nodes: what a rate misses at the start.
    missed = Polynomial(basis[0]).integ()
    return basis, float(np.abs(missed(np.linspace(0.0, 1.0, 1001))).max())


DENSE, MISSED = _dense()

MOTION: Final = record(
    ("memory", float, MOST_VARIABLES),  # internal variables
    # Largest size so far of all of a unit, at the place of the first; of pure numbers, which may be
    # logarithms, one at least.
    ("largest", float, MOST_VARIABLES),
    ("alike", int, MOST_VARIABLES),  # place of the first of their unit
    real="time end extension first_force compliance relaxation tolerance length before force force_scale "
    "fastest slip load depth reached normal_impulse friction_impulse drive_work damping_loss friction_work "
    "normal_work contact_loss stick_time most_normal last_gap last_normal last_speed watched_from",
    whole="ending prescribed friction_kind variables coupled guards framed mode sign goes_on piece "
    "next_break next_instant next_record event at_once watched steps rejected",
)
"""State of a law on a path: extension of the frame [m], 1/k [m/N], c/k [s], impulses and energies so far."""

PLACES: Final = NODES + 1
"""Nodes, and a time in between."""

NODAL: Final = record(
    ("memory", float, (PLACES, MOST_VARIABLES)),
    *((name, float, (NODES, MOST_VARIABLES)) for name in ("rate", "by_memory", "by_slip", "push", "left")),
    ("start_rate", float, MOST_VARIABLES),
    ("inverse", float, (MOST_VARIABLES, NODES, NODES)),
    *((n, float, NODES) for n in ("gap", "gap_rate", "load", "speed", "slip", "normal", "least", "most")),
    *((n, float, NODES) for n in ("friction", "steepness", "extension", "stiffness", "flow")),
    ("system", float, (NODES, 2 * NODES + 1)),
    ("coefficient", float, (MOST_VARIABLES, NODES + 1)),
    ("extended", float, NODES + 1),
    ("before", float, NODES),
)
"""Scratch of one step."""

COLUMNS: Final = record(
    real="way slip_velocity gap gap_rate normal_impulse friction_impulse strain_energy contact_energy "
    "drive_work damping_loss friction_work normal_work contact_loss mode"
)
"""A record of a path: displacements [m], impulses [N s] and energies [J] since the start."""


@final
class Path(NamedTuple):
    """A path and what is written of it.

    Args:
        edges: of the pieces of the spline [s], shape (piece + 1,).
        pieces: gap [m] or normal force [N], and load point [m], ascending powers of the time since the edge,
            shape (piece, 2, power).
        breaks: times that no step goes across [s], increasing; the last one is the end.
        instants, forces: times [s], increasing, and the normal force and friction there [N], from the left.
        records, series, traces: times [s], and records of `COLUMNS` and internal variables there.
        states, steps: one record each.
        parameters, row: of the law, one memory.
    """

    edges: Array
    pieces: Array
    breaks: Array
    instants: Array
    forces: Array
    records: Array
    series: Any
    traces: Array
    states: Any
    steps: Any
    parameters: Array
    row: Array


@part_kernel
def _recall(path: Path, place: int) -> None:
    for k in range(path.states[0].variables):
        path.row[HEAD + k] = path.steps[0].memory[place, k]


@part_kernel
def _lead(path: Path, time: float, left: bool) -> tuple[float, float, float, float]:
    """Return the first row of the path, its rate, and way [m] and velocity [m/s] of the load point."""
    state, last = path.states[0], path.edges.size - 2
    piece = state.piece
    while piece < last and (time > path.edges[piece + 1] or (not left and time == path.edges[piece + 1])):
        piece += 1
    while piece > 0 and (time < path.edges[piece] or (left and time == path.edges[piece])):
        piece -= 1
    state.piece = piece
    s, of = time - path.edges[piece], path.pieces[piece]
    first, first_rate, way, speed = 0.0, 0.0, 0.0, 0.0
    for d in range(of.shape[1] - 1, -1, -1):
        first_rate, speed = first_rate * s + first, speed * s + way
        first, way = first * s + of[0, d], way * s + of[1, d]
    return first, first_rate, way, speed


@inner_kernel
def _depth_under(path: Path, law: Law, load: float) -> float:
    """Return the penetration at which the law's normal force at rest is a load [N]; NaN where none is."""
    state, most = path.states[0], DEEPEST
    least = DEEPEST * 0.5**HALVINGS
    depth = state.depth
    for _ in range(200):
        if not least < depth < most:
            # Between ends that may differ by powers of ten.
            depth = np.sqrt(least * most)
        missed = law.force(-depth, 0.0, 0.0, 0.0, law.parameters)[0] - load
        nudged = depth * (1.0 + NUDGE)
        slope = (law.force(-nudged, 0.0, 0.0, 0.0, law.parameters)[0] - load - missed) / (nudged - depth)
        if missed > 0.0:
            most = depth
        else:
            least = depth
        change = missed / slope if slope > 0.0 else np.inf
        depth -= change
        if abs(change) <= 1e-14 * abs(depth) or most - least <= 1e-15 * most:
            break
    reached = law.force(-depth, 0.0, 0.0, 0.0, law.parameters)[0]
    return depth if abs(reached - load) <= 1e-9 * load else np.nan


@part_kernel
def _press(path: Path, law: Law, time: float, left: bool) -> tuple[float, float, float, float, float]:
    """Return gap [m], its rate, the normal force if it is prescribed [N], way and velocity of the load."""
    state = path.states[0]
    first, rate, way, speed = _lead(path, time, left)
    if state.prescribed == BY_GAP:
        return first, rate, 0.0, way, speed
    if state.prescribed == RIGID:
        return 0.0, 0.0, first, way, speed
    # A load that stays needs no other depth.
    if first != state.load:
        state.load, state.depth = first, _depth_under(path, law, first)
    depth = state.depth
    if rate == 0.0:
        return -depth, 0.0, first, way, speed
    nudged = depth * (1.0 + NUDGE)
    at_rest = law.force(-depth, 0.0, 0.0, 0.0, law.parameters)[0]
    slope = (law.force(-nudged, 0.0, 0.0, 0.0, law.parameters)[0] - at_rest) / (nudged - depth)
    return -depth, -rate / slope, first, way, speed


@part_kernel
def _bounds(
    path: Path, law: Law, gap: float, rate: float, load: float, slip: float
) -> tuple[float, float, float, float, float]:
    """Return normal force, least and largest friction [N], stored energy [J] and normal loss [W]."""
    if path.states[0].prescribed == RIGID:
        bound = law.bound(load, slip, law.parameters)
        return load, -bound, bound, 0.0, 0.0
    normal, least, most, stored, loss = law.force(gap, rate, slip, path.row[SPEED], law.parameters)
    return normal, least, most, stored, loss


@part_kernel
def _sticks(path: Path) -> bool:
    """Return whether the contact has no slip: set-valued friction holds it."""
    return bool(path.states[0].mode == STICK and path.states[0].friction_kind == SET_VALUED)


@part_kernel
def _slides(path: Path) -> bool:
    """Return whether friction is on its bound."""
    return bool(path.states[0].mode == SLIP and path.states[0].friction_kind != RATE_DEPENDENT)


@part_kernel
def _moves(path: Path) -> bool:
    """Return whether the slip velocity is unknown."""
    return path.states[0].framed == 1 and not _sticks(path)


@part_kernel
def _seen(path: Path, slip: float) -> float:
    """Return the slip that the law receives: exactly zero in stick alone [m/s]."""
    if _sticks(path):
        return 0.0
    slides = _slides(path) and path.states[0].friction_kind == SET_VALUED
    if slides and slip * path.states[0].sign <= 0.0:
        return float(path.states[0].sign * SLIP_ROUND_OFF)
    return slip


@part_kernel
def _flowing(path: Path) -> int:
    """Return the number of the first internal variable that flows by its rate, and not with the bound."""
    return 1 if path.states[0].coupled == 1 and _slides(path) else 0


@part_kernel
def _friction(
    path: Path, law: Law, gap: float, rate: float, seen: float, normal: float, least: float, most: float
) -> tuple[float, float, float]:
    """Return the friction [N], the flow of its variable and its stiffness, of what is recalled."""
    state = path.states[0]
    friction, flow, stiffness = state.force, 0.0, 0.0
    if state.friction_kind != SET_VALUED:
        friction, flow, _, stiffness = law.friction(gap, rate, seen, normal, law.parameters)
    if _slides(path):
        friction = least if state.sign > 0 else most
    return friction, flow, stiffness


@part_kernel
def _forces(
    path: Path, law: Law, gap: float, rate: float, load: float, slip: float
) -> tuple[float, float, float, float, float, float]:
    """Return normal force, least and largest friction, friction [N], its flow and stiffness, recalled."""
    seen = _seen(path, slip)
    normal, least, most, _, _ = _bounds(path, law, gap, rate, load, seen)
    friction, flow, stiffness = _friction(path, law, gap, rate, seen, normal, least, most)
    return normal, least, most, friction, flow, stiffness


@inner_kernel
def _memory_rate(
    law: Law, memory: Memory | None, k: int, gap: float, rate: float, slip: float, normal: float
) -> float:
    if memory is None:
        return 0.0
    return float(memory.rate(k, gap, rate, slip, normal, law.parameters))


@inner_kernel
def _stretch_on_bound(
    path: Path, law: Law, gap: float, rate: float, slip: float, normal: float, force: float
) -> float:
    """Return the stretch of a slider's spring whose friction is on its bound [m]."""
    kept = path.row[HEAD]
    path.row[HEAD] = 0.0
    beside, _, _, stiffness = law.friction(gap, rate, slip, normal, law.parameters)
    path.row[HEAD] = kept
    return (beside - force) / stiffness if stiffness > 0.0 else 0.0


@part_kernel
def _solve(system: Array, n: int, columns: int) -> None:
    """Solve n linear equations in place for right sides in the columns from n on, with row pivots."""
    for p in range(n):
        best = p
        for row in range(p + 1, n):
            if abs(system[row, p]) > abs(system[best, p]):
                best = row
        if best != p:
            for column in range(p, n + columns):
                system[p, column], system[best, column] = system[best, column], system[p, column]
        # Of the pivots only the reciprocals are read again.
        system[p, p] = 1.0 / system[p, p]
        for row in range(p + 1, n):
            ratio = system[row, p] * system[p, p]
            for column in range(p + 1, n + columns):
                system[row, column] -= ratio * system[p, column]
    for p in range(n - 1, -1, -1):
        for column in range(n, n + columns):
            total = system[p, column]
            for q in range(p + 1, n):
                total -= system[p, q] * system[q, column]
            system[p, column] = total * system[p, p]


@part_kernel
def _evaluate(path: Path, law: Law, memory: Memory | None, fresh: bool, begins: bool) -> None:
    """Take the law's answers at all nodes, and if `fresh` their derivatives by differences.

    The normal force of a motion that is known and that no variable changes is that of the first sweep.
    """
    state, step = path.states[0], path.steps[0]
    moves, first, h = _moves(path), _flowing(path), state.length
    for i in range(NODES):
        gap, rate, load, slip = step.gap[i], step.gap_rate[i], step.load[i], step.slip[i]
        if state.variables > 0:
            _recall(path, i)
        seen = _seen(path, slip)
        if begins or moves or state.variables > state.coupled:
            bounds = _bounds(path, law, gap, rate, load, seen)
            step.normal[i], step.least[i], step.most[i] = bounds[0], bounds[1], bounds[2]
        normal = step.normal[i]
        friction, flow, stiffness = _friction(path, law, gap, rate, seen, normal, step.least[i], step.most[i])
        step.friction[i], step.stiffness[i], step.flow[i] = friction, stiffness, flow
        for k in range(first, state.variables):
            g = flow if k < state.coupled else _memory_rate(law, memory, k, gap, rate, seen, normal)
            step.rate[i, k] = g
        if not fresh:
            continue
        for k in range(first, state.variables):
            z, g = step.memory[i, k], step.rate[i, k]
            # Towards zero: past a limit that it may be at, a force feels it no more.
            dz = NUDGE * (abs(z) + abs(h * g) + 1e-3 * state.largest[state.alike[k]])
            dz = copysign(dz, -z if z != 0.0 else -g)
            step.by_memory[i, k], step.push[i, k] = 0.0, 0.0
            if dz == 0.0:
                continue
            path.row[HEAD + k] = z + dz
            if k < state.coupled:
                pushed, flowed, _, _ = law.friction(gap, rate, seen, normal, law.parameters)
                step.by_memory[i, k] = (flowed - g) / dz
                step.push[i, k] = (pushed - friction) / dz
            else:
                step.by_memory[i, k] = (_memory_rate(law, memory, k, gap, rate, seen, normal) - g) / dz
                if moves:
                    step.push[i, k] = (_forces(path, law, gap, rate, load, slip)[3] - friction) / dz
            path.row[HEAD + k] = z
        if moves:
            way = 1.0 if slip >= 0.0 else -1.0
            dv, most = way * NUDGE * max(abs(slip), 1e-18), NUDGE * max(state.fastest, abs(step.speed[i]))
            _, _, _, pushed, flowed, _ = _forces(path, law, gap, rate, load, slip + dv)
            # Steep friction near rest is seen by a small difference, a dashpot by a large one.
            while abs(pushed - friction) < FELT * abs(friction) and abs(dv) < most:
                dv *= 1e3
                _, _, _, pushed, flowed, _ = _forces(path, law, gap, rate, load, slip + dv)
            step.steepness[i] = (pushed - friction) / dv
            for k in range(first, state.variables):
                g = flowed
                if k >= state.coupled:
                    g = _memory_rate(law, memory, k, gap, rate, _seen(path, slip + dv), normal)
                step.by_slip[i, k] = (g - step.rate[i, k]) / dv


@part_kernel
def _size(path: Path, k: int) -> float:
    """Return the size that errors of variable k are relative to, see `MOTION`."""
    state = path.states[0]
    return float(max(state.largest[state.alike[k]], abs(state.memory[k])))


@part_kernel
def _correct_variable(path: Path, k: int, fresh: bool, moves: bool, negligible: float) -> None:
    """Set what variable k at the nodes is `left` to change by: its polynomial and its rates differ.

    Where the slip is unknown, too, that is by the inverse of the variable's own equations, which is kept.
    """
    state, step, system = path.states[0], path.steps[0], path.steps[0].system
    h, z, straight, count, most = state.length, state.memory[k], True, NODES if moves else 1, 0.0
    for i in range(NODES):
        straight = straight and step.by_memory[i, k] == 0.0
        missed = h * step.rate[i, k]
        for m in range(NODES):
            missed -= DERIVATIVE[i, m] * (step.memory[m, k] - z)
        step.before[i] = missed
        most = max(most, abs(missed))
    if most <= negligible and not moves:
        for i in range(NODES):
            step.left[i, k] = 0.0
        return
    if not straight and (fresh or not moves):
        for i in range(NODES):
            for m in range(NODES):
                system[i, m] = DERIVATIVE[i, m] - (h * step.by_memory[i, k] if m == i else 0.0)
                system[i, NODES + m] = 1.0 if m == i else 0.0
            if not moves:
                system[i, NODES] = step.before[i]
        _solve(system, NODES, count)
    if not moves and not straight:
        for i in range(NODES):
            step.left[i, k] = system[i, NODES]
        return
    for i in range(NODES):
        change = 0.0
        for m in range(NODES):
            if fresh:
                step.inverse[k, i, m] = INTEGRAL[i, m] if straight else system[i, NODES + m]
            change += step.inverse[k, i, m] * step.before[m]
        step.left[i, k] = change


@part_kernel
def _sweep(path: Path, law: Law, memory: Memory | None, fresh: bool, begins: bool) -> float:
    """Correct internal variables and slip at the nodes by Newton's method; returns the largest change [1]."""
    state, step = path.states[0], path.steps[0]
    h, system = state.length, step.system
    moves, first, change = _moves(path), _flowing(path), 0.0
    _evaluate(path, law, memory, fresh, begins)
    for k in range(first, state.variables):
        # The answer to a rest is about as large as the rest.
        negligible = 0.0 if begins else max(AGREEMENT * state.tolerance, ROUNDED) * _size(path, k)
        _correct_variable(path, k, fresh, moves, negligible)
    if moves:
        s, tau, fastest, longest = state.compliance, state.relaxation, state.fastest, abs(state.extension)
        for i in range(NODES):
            extension, right = state.extension, 0.0
            for m in range(NODES):
                extension += h * INTEGRAL[i, m] * (step.speed[m] - step.slip[m])
                system[i, m] = -h * INTEGRAL[i, m]
            step.extension[i] = extension
            right = -(extension + tau * (step.speed[i] - step.slip[i]) + s * step.friction[i])
            system[i, i] += s * step.steepness[i] - tau
            for k in range(first, state.variables):
                push = s * step.push[i, k]
                if push != 0.0:
                    right -= push * step.left[i, k]
                    for m in range(NODES):
                        system[i, m] += push * step.inverse[k, i, m] * h * step.by_slip[m, k]
            system[i, NODES] = right
            fastest = max(fastest, abs(step.speed[i]), abs(step.slip[i]))
            longest = max(longest, abs(extension))
        _solve(system, NODES, 1)
        # Round-off of the extension in its rate, and velocities that the frame's force does not feel.
        digits, scale = DIGITS * longest / h, state.force_scale
        for i in range(NODES):
            scale = max(scale, abs(step.friction[i]))
        for i in range(NODES):
            moved = system[i, NODES]
            step.before[i] = moved
            step.slip[i] += moved
            felt = fastest
            if scale > 0.0:
                felt = max(felt, s * scale / max(h, tau, s * abs(step.steepness[i])))
            # NaN fails every comparison, and is passed on.
            most = abs(moved) - digits
            change = most / felt if not most <= change * felt else change
    for k in range(first, state.variables):
        size = _size(path, k)
        for i in range(NODES):
            moved = step.left[i, k]
            if moves:
                for m in range(NODES):
                    moved += step.inverse[k, i, m] * h * step.by_slip[m, k] * step.before[m]
            step.memory[i, k] += moved
            size = max(size, abs(step.memory[i, k]))
            step.left[i, k] = moved
        for i in range(NODES):
            moved = step.left[i, k]
            change = abs(moved) / size if not abs(moved) <= change * size else change
    return change


@inner_kernel
def _collocate(path: Path, law: Law, memory: Memory | None) -> bool:
    """Solve a step of the present length from a guess at the nodes; returns whether that converges."""
    state, step = path.states[0], path.steps[0]
    enough, before, fresh = max(AGREEMENT * state.tolerance, ROUNDED), np.inf, True
    for _ in range(MOST_SWEEPS):
        change = _sweep(path, law, memory, fresh, before == np.inf)
        if not change < np.inf or (change > 1e3 * before and before < 1.0):
            return False
        # As it contracts, the next change would be within the bound.
        if change <= enough or (change < 1.0 and before < np.inf and change * change <= enough * before):
            break
        # Where the slip is unknown it may come to the other side of a kink.
        fresh, before = _moves(path) or change > SLOW * before, change
    else:
        return False
    if state.framed == 1 and _sticks(path):
        for i in range(NODES):
            extension = state.extension
            for m in range(NODES):
                extension += state.length * INTEGRAL[i, m] * step.speed[m]
            step.extension[i] = extension
            step.friction[i] = -(extension + state.relaxation * step.speed[i]) / state.compliance
    elif state.framed == 1:
        for i in range(NODES):
            extension = state.extension
            for m in range(NODES):
                extension += state.length * INTEGRAL[i, m] * (step.speed[m] - step.slip[m])
            step.extension[i] = extension
    if _flowing(path) == 1:
        for i in range(NODES):
            _recall(path, i)
            seen = _seen(path, step.slip[i])
            step.memory[i, 0] = _stretch_on_bound(
                path, law, step.gap[i], step.gap_rate[i], seen, step.normal[i], step.friction[i]
            )
    return True


@part_kernel
def _open_step(path: Path, law: Law, length: float) -> None:
    """Set what the path prescribes at the nodes of a step of a length [s]."""
    state, step = path.states[0], path.steps[0]
    state.length = length
    for i in range(NODES):
        time = state.time + NODE[i] * length
        step.gap[i], step.gap_rate[i], step.load[i], _, step.speed[i] = _press(path, law, time, True)
        if state.framed == 0:
            step.slip[i] = step.speed[i]


@part_kernel
def _guess(path: Path, slip: float) -> None:
    """Set internal variables and slip at the nodes to iterate from: the last polynomials, or constants."""
    state, step = path.states[0], path.steps[0]
    stretch = state.length / state.before if state.goes_on == 1 else 0.0
    for k in range(state.variables):
        for i in range(NODES):
            step.memory[i, k] = state.memory[k]
            if stretch > 0.0:
                step.memory[i, k] = _variable_at(step, k, 1.0 + NODE[i] * stretch)
    for i in range(NODES):
        step.before[i] = step.slip[i]
    for i in range(NODES):
        if state.framed == 0:
            continue
        if _sticks(path):
            step.slip[i] = 0.0
        elif stretch > 0.0:
            step.slip[i] = _polynomial(step.before, 1.0 + NODE[i] * stretch)
        else:
            step.slip[i] = slip


@part_kernel
def _variable_at(step: Any, k: int, x: float) -> float:
    """Return variable k at a share x of the step whose polynomials are laid."""
    total = 0.0
    for d in range(NODES, -1, -1):
        total = total * x + step.coefficient[k, d]
    return total


@inner_kernel
def _fit(path: Path) -> None:
    """Lay the polynomials of variables and extension through start and nodes."""
    state, step = path.states[0], path.steps[0]
    # What does not change, such as a count, is exactly constant.
    for k in range(state.variables):
        step.coefficient[k, 0] = state.memory[k]
    step.extended[0] = state.extension
    for d in range(1, NODES + 1):
        for k in range(state.variables):
            total = 0.0
            for m in range(NODES):
                total += DENSE[m + 1, d] * (step.memory[m, k] - state.memory[k])
            step.coefficient[k, d] = total
        if state.framed == 1:
            total = 0.0
            for m in range(NODES):
                total += DENSE[m + 1, d] * (step.extension[m] - state.extension)
            step.extended[d] = total


@part_kernel
def _polynomial(values: Array, x: float) -> float:
    """Return the polynomial through values at the nodes, at a share x of a step."""
    result = 0.0
    for m in range(NODES):
        weight = 0.0
        for d in range(NODES - 1, -1, -1):
            weight = weight * x + LAGRANGE[m, d]
        result += weight * values[m]
    return result


@part_kernel
def _error(path: Path, law: Law, memory: Memory | None) -> float:
    """Return the error of a step between its nodes over its tolerance, from what is missed at its start."""
    state, step = path.states[0], path.steps[0]
    h, first, worst = state.length, _flowing(path), 0.0
    if state.variables == first and not _moves(path):
        return 0.0
    gap, rate, load, _, speed = _press(path, law, state.time, False)
    slip = speed
    if state.framed == 1:
        slip = 0.0 if _sticks(path) else _polynomial(step.slip, 0.0)
    for k in range(state.variables):
        path.row[HEAD + k] = state.memory[k]
    normal, _, _, friction, flow, _ = _forces(path, law, gap, rate, load, slip)
    seen = _seen(path, slip)
    for k in range(first, state.variables):
        g = flow if k < state.coupled else _memory_rate(law, memory, k, gap, rate, seen, normal)
        missed, size = g, _size(path, k)
        for m in range(NODES):
            missed -= LAGRANGE[m, 0] * step.rate[m, k]
            size = max(size, abs(step.memory[m, k]))
        if missed != 0.0:
            worst = max(worst, MISSED * h * abs(missed) / size)
    if _moves(path):
        # The slip that the polynomial has at the start, and the one that the frame's force asks for.
        left = state.extension + state.relaxation * (speed - slip) + state.compliance * friction
        falls = state.relaxation - state.compliance * step.steepness[0]
        scale = state.compliance * max(state.force_scale, abs(step.friction[NODES - 1]))
        missed = abs(left / falls) if falls > h * NODE[0] else 0.0
        if state.goes_on == 1:
            missed = max(missed, abs(slip - state.slip)) if missed == 0.0 else missed
        elif missed == 0.0:
            # Of a step that nothing precedes: without its first node the polynomial is of one degree less.
            other = 0.0
            for m in range(1, NODES):
                weight = 1.0
                for n in range(1, NODES):
                    weight *= -NODE[n] / (NODE[m] - NODE[n]) if n != m else 1.0
                other += weight * step.slip[m]
            missed = abs(other - slip)
        missed = max(missed - DIGITS * abs(state.extension) / h, 0.0)
        weight = max(h, state.relaxation, state.compliance * abs(step.steepness[0]))
        if scale > 0.0:
            worst = max(worst, MISSED * missed * weight / scale)
    return float(worst / state.tolerance)


@part_kernel
def _dense_at(path: Path, law: Law, x: float) -> tuple[float, float, float, float, float, float, float]:
    """Leave the internal variables at a share x of the step recalled, and return the contact there.

    Gap, its rate, prescribed load, slip velocity, extension of the frame, way and velocity of the load point.
    """
    state, step = path.states[0], path.steps[0]
    time = state.time + x * state.length
    gap, rate, load, way, speed = _press(path, law, time, x > 0.0)
    for k in range(state.variables):
        path.row[HEAD + k] = _variable_at(step, k, x)
    slip, extension = speed, 0.0
    if state.framed == 1:
        for d in range(NODES, -1, -1):
            extension = extension * x + step.extended[d]
        slip = 0.0 if _sticks(path) else _polynomial(step.slip, x)
    return gap, rate, load, slip, extension, way, speed


@inner_kernel
def _forces_at(path: Path, law: Law, x: float) -> tuple[float, float, float, float, float, float]:
    """Return normal force, friction [N], slip, gap rate [m/s], normal loss and the frame's loss [W], at x."""
    state = path.states[0]
    gap, rate, load, slip, extension, _, speed = _dense_at(path, law, x)
    normal, _, _, friction, _, _ = _forces(path, law, gap, rate, load, slip)
    lost = 0.0
    if state.framed == 1:
        friction = -(extension + state.relaxation * (speed - slip)) / state.compliance
        lost = state.relaxation / state.compliance * (speed - slip) ** 2
    loss = _bounds(path, law, gap, rate, load, _seen(path, slip))[4]
    return normal, friction, slip, rate, loss, lost


@inner_kernel
def _event_at(path: Path, law: Law, memory: Memory | None, which: int, x: float, node: int) -> float:
    """Return what falls through zero at an event, at a share x of the step, or at a node from zero on."""
    state, step = path.states[0], path.steps[0]
    if node >= 0:
        gap, rate, load, slip = step.gap[node], step.gap_rate[node], step.load[node], step.slip[node]
        extension, speed = step.extension[node], step.speed[node]
        _recall(path, node)
    else:
        gap, rate, load, slip, extension, _, speed = _dense_at(path, law, x)
    if which < state.guards:
        if memory is None:
            return 1.0
        normal, _, _, _, _, _ = _forces(path, law, gap, rate, load, slip)
        return float(memory.guard(which, gap, rate, _seen(path, slip), normal, law.parameters))
    if state.friction_kind == SET_VALUED:
        if state.framed == 0:
            return 1.0
        if state.mode == SLIP:
            return float(state.sign * slip)
        _, least, most, _, _ = _bounds(path, law, gap, rate, load, 0.0)
        friction = -(extension + state.relaxation * speed) / state.compliance
        return float(min(most - friction, friction - least))
    if state.friction_kind == ELASTOPLASTIC:
        normal, least, most, friction, flow, _ = _forces(path, law, gap, rate, load, slip)
        if state.mode == STICK:
            return min(most - friction, friction - least)
        stretched = 0.0
        for m in range(NODES):
            by = 0.0
            if node >= 0:
                by = DERIVATIVE[node, m]
            else:
                for d in range(NODES, 0, -1):
                    by = by * x + d * DENSE[m + 1, d]
            stretched += by * (step.memory[m, 0] - state.memory[0])
        return float(state.sign * (flow - stretched / state.length))
    if state.framed == 0 or state.sign == 0:
        return 1.0
    return float(state.sign * slip)


@inner_kernel
def _find_event(path: Path, law: Law, memory: Memory | None) -> float:
    """Return the share of the step at which the first event lies, beyond one for none, and note which."""
    state = path.states[0]
    earliest = 2.0
    state.event = -1
    if state.guards == 0 and state.framed == 0 and state.friction_kind != ELASTOPLASTIC:
        return earliest
    for which in range(state.guards + 1):
        begin, low = 0.0, 1.0
        last = NODES - 1
        reverses = which == state.guards and state.friction_kind == RATE_DEPENDENT
        # A reversal lasts: in short steps what Newton's method has left may change the sign in between.
        if reverses and _event_at(path, law, memory, which, NODE[last], last) > 0.0:
            continue
        for i in range(NODES):
            high = _event_at(path, law, memory, which, NODE[i], i)
            if high > 0.0:
                begin, low = NODE[i], high
                continue
            if begin >= earliest:
                break
            if i == 0:
                low = _event_at(path, law, memory, which, 0.0, -1)
            end = NODE[i]
            if not low > 0.0:
                end = 0.0
            # Illinois' method; the end stays where it has fallen.
            side = 0
            while end - begin > 1e-15 and end > 0.0:
                middle = begin + (end - begin) * low / (low - high)
                if not begin < middle < end:
                    middle = 0.5 * (begin + end)
                    if not begin < middle < end:
                        break
                value = _event_at(path, law, memory, which, middle, -1)
                if value > 0.0:
                    begin, low = middle, value
                    high = 0.5 * high if side == 1 else high
                    side = 1
                else:
                    end, high = middle, value
                    low = 0.5 * low if side == -1 else low
                    side = -1
                if value == 0.0:
                    break
            if end < earliest:
                earliest, state.event = end, which
            break
    return earliest


@inner_kernel
def _jump(path: Path, law: Law, memory: Memory | None, event: int, slip: float) -> None:
    """Apply the law's reset map at the present time."""
    if memory is None:
        return
    state, step = path.states[0], path.steps[0]
    for k in range(state.variables):
        path.row[HEAD + k] = state.memory[k]
    gap, rate, load, _, _ = _press(path, law, state.time, True)
    normal, _, _, _, _ = _bounds(path, law, gap, rate, load, slip)
    for k in range(state.coupled, state.variables):
        step.memory[NODES, k] = memory.jump(k, event, gap, rate, slip, normal, law.parameters)
    for k in range(state.coupled, state.variables):
        state.memory[k] = step.memory[NODES, k]
        path.row[HEAD + k] = state.memory[k]


@inner_kernel
def _slip_of_frame(path: Path, law: Law, sign: int) -> float:
    """Return the largest slip velocity of a sign that balances the frame now [m/s]; NaN where none does.

    Set-valued friction without damping has one, zero, where its slip goes on from its stick.
    """
    state = path.states[0]
    gap, rate, load, _, speed = _press(path, law, state.time, False)
    state.mode, state.sign = SLIP, sign
    damping = state.relaxation / state.compliance
    pull = sign * (state.extension / state.compliance + damping * speed)
    if state.relaxation == 0.0 and state.friction_kind == SET_VALUED:
        resistance = -sign * _forces(path, law, gap, rate, load, sign * SLIP_ROUND_OFF)[3]
        return 0.0 if abs(pull - resistance) <= CONTINUOUS * abs(pull) else np.nan
    above = max(pull / damping, 0.0) if damping > 0.0 else max(abs(speed), SLIP_ROUND_OFF)
    fast = above
    for _ in range(HALVINGS):
        if not pull - damping * above + sign * _forces(path, law, gap, rate, load, sign * above)[3] > 0.0:
            break
        above *= 4.0
    fast = above
    for _ in range(4 * HALVINGS):
        fast *= 0.5
        if pull - damping * fast + sign * _forces(path, law, gap, rate, load, sign * fast)[3] > 0.0:
            break
        above = fast
    else:
        return 0.0
    for _ in range(HALVINGS):
        middle = 0.5 * (fast + above)
        if pull - damping * middle + sign * _forces(path, law, gap, rate, load, sign * middle)[3] > 0.0:
            fast = middle
        else:
            above = middle
    return fast


@inner_kernel
def _switch(path: Path, law: Law, memory: Memory | None) -> None:
    """Let a slider begin or end to slide, or the slip reverse, at the present time."""
    state = path.states[0]
    if state.event < state.guards:
        _jump(path, law, memory, state.event, state.slip)
        return
    if state.friction_kind == RATE_DEPENDENT:
        state.sign = -state.sign
        return
    if state.mode == SLIP:
        state.mode = STICK
        _jump(path, law, memory, AT_STICK, 0.0)
        return
    gap, rate, load, _, _ = _press(path, law, state.time, True)
    for k in range(state.variables):
        path.row[HEAD + k] = state.memory[k]
    _, least, most, friction, _, _ = _forces(path, law, gap, rate, load, 0.0)
    if state.friction_kind == SET_VALUED:
        friction = state.force
    sign = 1 if friction - least < most - friction else -1
    if state.friction_kind == SET_VALUED:
        state.slip = _slip_of_frame(path, law, sign)
        if not state.slip >= 0.0:
            state.ending = UNSOLVED
            return
        state.slip *= sign
    state.mode, state.sign = SLIP, sign
    _jump(path, law, memory, AT_SLIP, sign * SLIP_ROUND_OFF)


@inner_kernel
def _record(path: Path, law: Law, x: float, last: float) -> float:
    """Integrate forces and powers from one share of the step to another, and return that."""
    state = path.states[0]
    h = (x - last) * state.length
    for i in range(NODES):
        normal, friction, slip, rate, loss, lost = _forces_at(path, law, last + NODE[i] * (x - last))
        weight = h * _WEIGHT[i]
        state.normal_impulse += weight * normal
        state.friction_impulse += weight * friction
        state.friction_work -= weight * friction * slip
        state.normal_work -= weight * normal * rate
        state.contact_loss += weight * loss
        state.damping_loss += weight * lost
        speed = _lead(path, state.time + (last + NODE[i] * (x - last)) * state.length, True)[3]
        state.drive_work -= weight * (friction * speed + normal * rate)
    return x


@inner_kernel
def _stored_at(path: Path, law: Law, gap: float, rate: float, load: float, slip: float) -> float:
    """Return the energy that the contact stores [J], of what is recalled."""
    seen = _seen(path, slip)
    normal, _, _, stored, _ = _bounds(path, law, gap, rate, load, seen)
    if path.states[0].friction_kind == SET_VALUED:
        return stored
    return float(stored + law.friction(gap, rate, seen, normal, law.parameters)[2])


@inner_kernel
def _write(path: Path, law: Law) -> None:
    """Write forces at the instants and records that a step has passed."""
    state, end = path.states[0], path.states[0].reached
    at_end = end >= state.end
    while state.next_instant < path.instants.size:
        time = path.instants[state.next_instant]
        if time > end and not at_end:
            break
        x = min(max((time - state.time) / state.length, 0.0), 1.0)
        gap, rate, load, slip, extension, _, speed = _dense_at(path, law, x)
        normal, _, _, friction, _, _ = _forces(path, law, gap, rate, load, slip)
        if state.framed == 1:
            friction = -(extension + state.relaxation * (speed - slip)) / state.compliance
        path.forces[state.next_instant, 0], path.forces[state.next_instant, 1] = normal, friction
        state.next_instant += 1
    if path.records.size == 0:
        return
    last = 0.0
    while state.next_record < path.records.size:
        time = path.records[state.next_record]
        if time > end and not at_end:
            break
        x = min(max((time - state.time) / state.length, 0.0), 1.0)
        if x > last:
            last = _record(path, law, x, last)
        _note(path, law, x)
    if last < 1.0:
        _record(path, law, 1.0, last)


@inner_kernel
def _note(path: Path, law: Law, x: float) -> None:
    """Write the next record, at a share x of the step."""
    state, row = path.states[0], path.series[path.states[0].next_record]
    gap, rate, load, slip, extension, way, _ = _dense_at(path, law, x)
    for k in range(state.variables):
        path.traces[state.next_record, k] = path.row[HEAD + k]
    row.way, row.slip_velocity, row.gap, row.gap_rate = way - extension, slip, gap, rate
    row.normal_impulse, row.friction_impulse = state.normal_impulse, state.friction_impulse
    row.strain_energy = 0.5 * extension * extension / state.compliance if state.framed == 1 else 0.0
    row.contact_energy = _stored_at(path, law, gap, rate, load, slip)
    row.drive_work, row.damping_loss = state.drive_work, state.damping_loss
    row.friction_work, row.normal_work = state.friction_work, state.normal_work
    row.contact_loss = state.contact_loss
    row.mode = state.mode
    state.next_record += 1


@inner_kernel
def _bring_back(path: Path, law: Law) -> None:
    """Bring a variable back to the limit beyond which friction does not feel it: the step's error."""
    state, step, last = path.states[0], path.steps[0], NODES - 1
    gap, rate, load, slip = step.gap[last], step.gap_rate[last], step.load[last], step.slip[last]
    felt, past = 0.0, state.memory[0]
    force = _forces(path, law, gap, rate, load, slip)[3]
    for _ in range(HALVINGS):
        path.row[HEAD] = 0.5 * (felt + past)
        if _forces(path, law, gap, rate, load, slip)[3] == force:
            past = path.row[HEAD]
        else:
            felt = path.row[HEAD]
    state.memory[0] = past
    path.row[HEAD] = past


@inner_kernel
def _take(path: Path, law: Law) -> None:
    """Move the state to the end of the step."""
    state, step = path.states[0], path.steps[0]
    last = NODES - 1
    _write(path, law)
    for k in range(state.variables):
        state.memory[k] = step.memory[last, k]
        for i in range(NODES):
            state.largest[state.alike[k]] = max(state.largest[state.alike[k]], abs(step.memory[i, k]))
    if state.framed == 1:
        state.extension = step.extension[last]
    state.force = step.friction[last]
    if _moves(path) and state.relaxation == 0.0 and step.steepness[last] == 0.0:
        # Friction that is no function of the slip velocity holds the extension: what Newton's method has left
        # of that would be a velocity in the next step, however short.
        _recall(path, last)
        if state.coupled == 1 and not _slides(path) and step.push[last, 0] == 0.0:
            _bring_back(path, law)
        gap, rate, load = step.gap[last], step.gap_rate[last], step.load[last]
        state.extension = -state.compliance * _forces(path, law, gap, rate, load, step.slip[last])[3]
    for i in range(NODES):
        state.force_scale = max(state.force_scale, abs(step.friction[i]))
        state.fastest = max(state.fastest, abs(step.slip[i]))
        state.most_normal = max(state.most_normal, step.normal[i])
    state.slip = step.slip[last]
    state.last_gap, state.last_normal, state.last_speed = step.gap[last], step.normal[last], step.speed[last]
    state.stick_time += state.length if state.mode == STICK else 0.0
    state.before, state.goes_on = state.length, 1
    state.steps += 1
    state.at_once = 0


@inner_kernel
def _begin(path: Path, law: Law, memory: Memory | None) -> None:
    """Touch down at the start of the path, with the frame's first force."""
    state = path.states[0]
    for k in range(state.variables):
        path.row[HEAD + k] = state.memory[k]
    gap, rate, load, _, speed = _press(path, law, state.time, False)
    path.row[SPEED] = max(-rate, 0.0)
    state.mode, state.sign = SLIP if state.friction_kind == RATE_DEPENDENT else STICK, 0
    _jump(path, law, memory, AT_TOUCH, speed)
    state.extension = state.compliance * state.first_force
    state.force = -state.first_force
    state.goes_on, state.slip = 0, speed
    _fit(path)
    if state.framed == 0:
        return
    if state.friction_kind == SET_VALUED:
        _, least, most, _, _ = _bounds(path, law, gap, rate, load, 0.0)
        state.force = -state.first_force - state.relaxation / state.compliance * speed
        if not least <= state.force <= most:
            state.ending, state.force = INCONSISTENT, min(max(state.force, least), most)
        return
    friction = _forces(path, law, gap, rate, load, speed)[3]
    other = _forces(path, law, gap, rate, load, 0.5 * speed + SLIP_ROUND_OFF)[3]
    if friction != other or state.relaxation > 0.0:
        pull = state.extension + state.relaxation * speed
        sign = 1 if pull > 0.0 else -1
        state.slip = 0.0 if pull == 0.0 else sign * _slip_of_frame(path, law, sign)
        state.sign = 0
    else:
        # Friction that is no function of the slip velocity has the force of its variables.
        if abs(friction + state.first_force) > CONTINUOUS * max(abs(friction), abs(state.first_force)):
            state.ending, state.force = INCONSISTENT, friction
        state.extension = -state.compliance * friction
    state.force_scale = max(abs(friction), abs(state.first_force))


@inner_kernel
def _turn(path: Path, law: Law, memory: Memory | None, middle: float) -> None:
    """Set slip or stick of a path that reverses or stands still, by the velocity in the middle of a step."""
    state = path.states[0]
    if state.framed == 1 or state.friction_kind != SET_VALUED:
        return
    speed = _lead(path, middle, True)[3]
    mode = STICK if speed == 0.0 else SLIP
    state.sign = 1 if speed > 0.0 else -1
    if mode != state.mode:
        state.mode = mode
        _jump(path, law, memory, AT_STICK if mode == STICK else AT_SLIP, 0.0 if mode == STICK else speed)


@inner_kernel
def _watch(state: Any) -> None:
    """End a motion whose steps and events come to no end."""
    state.watched += 1
    if state.watched < WATCHED:
        return
    if state.time - state.watched_from < LEAST_WAY * state.end:
        state.ending = CHATTERED
    state.watched, state.watched_from = 0, state.time


@inner_kernel
def run_path(path: Path, law: Law) -> None:
    """Take a law along a path from its start to its end, or to where it has no step."""
    state, step, memory = path.states[0], path.steps[0], law.memory
    _begin(path, law, memory)
    length, least = FIRST * (path.breaks[0] - state.time), SHORTEST * state.end
    if state.variables == 0 and state.framed == 0:
        length = np.inf
    if path.records.size > 0:
        _note(path, law, 0.0)
    while state.time < state.end and state.ending == RUNNING:
        while path.breaks[state.next_break] <= state.time:
            state.next_break += 1
            # Behind a kink nothing of the last polynomials goes on.
            state.goes_on, length = 0, max(FRESH * length, 4.0 * least)
        until = path.breaks[state.next_break]
        _lead(path, state.time, False)
        if state.piece + PIECES < path.edges.size - 1 and (state.variables > 0 or state.framed == 1):
            until = min(until, path.edges[state.piece + PIECES])
        left = until - state.time
        # Two equal steps in place of a long and a short one.
        h = left if length >= left else 0.5 * left if length > 0.5 * left else length
        _turn(path, law, memory, state.time + 0.5 * h)
        _open_step(path, law, h)
        _guess(path, state.slip)
        if not _collocate(path, law, memory):
            state.rejected += 1
            state.goes_on, length = 0, LEAST_FACTOR * h
            _restore(path)
            if not length > least:
                state.ending = UNSOLVED
            continue
        error = _error(path, law, memory)
        if not error < np.inf:
            state.ending = NOT_FINITE
            break
        factor = MOST_FACTOR
        if error > 0.0:
            factor = min(max(SAFETY * error ** (-1.0 / ERROR_ORDER), LEAST_FACTOR), MOST_FACTOR)
        if error > 1.0:
            state.rejected += 1
            length = factor * h
            _restore(path)
            if not length > least:
                state.ending = UNSOLVED
            continue
        if state.framed == 1 and state.sign == 0 and state.mode == SLIP:
            state.sign = 1 if step.slip[0] > 0.0 else -1
        _fit(path)
        share = _find_event(path, law, memory)
        if share > 1.0 - AT_END and h == left:
            # At a kink of the path but for round-off.
            share = max(share, 1.0)
        if share <= AT_ONCE:
            state.at_once += 1
            reverses = state.event == state.guards and state.friction_kind == RATE_DEPENDENT
            state.goes_on, length = 0, h if reverses else max(FRESH * h, 4.0 * least)
            _restore(path)
            if state.at_once > MOST_AT_ONCE:
                state.ending = CHATTERED
            _switch(path, law, memory)
            _watch(state)
            continue
        if share < 1.0:
            # Solved once more up to the event: what lies beyond it does not count.
            _open_step(path, law, share * h)
            if not _collocate(path, law, memory):
                state.rejected += 1
                state.goes_on, length = 0, 0.5 * share * h
                _restore(path)
                if not length > least:
                    state.ending = UNSOLVED
                continue
            _fit(path)
        # To the last digit of the clock.
        state.reached = until if share >= 1.0 and h == left else state.time + state.length
        _take(path, law)
        state.time = state.reached
        _watch(state)
        if share <= 1.0:
            state.goes_on = 0
            length = max(FRESH * h, 4.0 * least)
            _switch(path, law, memory)
        else:
            length = max(factor * h, length) if h < length else factor * h


@part_kernel
def _restore(path: Path) -> None:
    """Forget the nodes of a step that is not taken: there is no polynomial to go on from."""
    path.states[0].goes_on = 0
