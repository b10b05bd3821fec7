"""A step on a path: motion and internal variables collocated at the Radau nodes, and their error.

Source: Hairer and Wanner (1996), Solving Ordinary Differential Equations II, ch. IV.8 and VI.1, of stiff and
of differential-algebraic equations by Radau IIA.
"""

from math import copysign
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial

from contactlab.arrays import Array
from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.engine.friction import DIGITS
from contactlab.engine.memory import NUDGE
from contactlab.engine.path_contact import (
    Path,
    bounds_of,
    first_flowing,
    forces_of,
    friction_of,
    load_point,
    moves_freely,
    press,
    rate_of,
    recall,
    seen_slip,
    size_of,
    sticks,
)
from contactlab.engine.propagator import radau_rule
from contactlab.engine.state import HEAD, NODES, Law, Memory

AGREEMENT, ROUNDED = 1e-2, 1e-11
"""Last correction of Newton's method over the tolerance of a step, and its round-off [1]."""

MOST_SWEEPS = 12
"""Newton's corrections of a step, after which it is shortened."""

SLOW = 0.1
"""Ratio of two corrections beyond which derivatives are taken anew."""

FELT = 1e-12
"""Relative difference of the friction that is no round-off."""

NODE, WEIGHT, LAGRANGE, DERIVATIVE = radau_rule(NODES)
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
    moves, first, h = moves_freely(path), first_flowing(path), state.length
    for i in range(NODES):
        gap, rate, load, slip = step.gap[i], step.gap_rate[i], step.load[i], step.slip[i]
        if state.variables > 0:
            recall(path, i)
        seen = seen_slip(path, slip)
        if begins or moves or state.variables > state.coupled:
            bounds = bounds_of(path, law, gap, rate, load, seen)
            step.normal[i], step.least[i], step.most[i] = bounds[0], bounds[1], bounds[2]
        normal = step.normal[i]
        friction, flow, stiffness = friction_of(
            path, law, gap, rate, seen, normal, step.least[i], step.most[i]
        )
        step.friction[i], step.stiffness[i], step.flow[i] = friction, stiffness, flow
        for k in range(first, state.variables):
            g = flow if k < state.coupled else rate_of(law, memory, k, gap, rate, seen, normal)
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
                step.by_memory[i, k] = (rate_of(law, memory, k, gap, rate, seen, normal) - g) / dz
                if moves:
                    step.push[i, k] = (forces_of(path, law, gap, rate, load, slip)[3] - friction) / dz
            path.row[HEAD + k] = z
        if moves:
            way = 1.0 if slip >= 0.0 else -1.0
            dv, most = way * NUDGE * max(abs(slip), 1e-18), NUDGE * max(state.fastest, abs(step.speed[i]))
            _, _, _, pushed, flowed, _ = forces_of(path, law, gap, rate, load, slip + dv)
            # Steep friction near rest is seen by a small difference, a dashpot by a large one.
            while abs(pushed - friction) < FELT * abs(friction) and abs(dv) < most:
                dv *= 1e3
                _, _, _, pushed, flowed, _ = forces_of(path, law, gap, rate, load, slip + dv)
            step.steepness[i] = (pushed - friction) / dv
            for k in range(first, state.variables):
                g = flowed
                if k >= state.coupled:
                    g = rate_of(law, memory, k, gap, rate, seen_slip(path, slip + dv), normal)
                step.by_slip[i, k] = (g - step.rate[i, k]) / dv


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
    moves, first, change = moves_freely(path), first_flowing(path), 0.0
    _evaluate(path, law, memory, fresh, begins)
    for k in range(first, state.variables):
        # The answer to a rest is about as large as the rest.
        negligible = 0.0 if begins else max(AGREEMENT * state.tolerance, ROUNDED) * size_of(path, k)
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
        size = size_of(path, k)
        for i in range(NODES):
            moved = step.left[i, k]
            if moves:
                for m in range(NODES):
                    moved += step.inverse[k, i, m] * h * step.by_slip[m, k] * step.before[m]
            step.memory[i, k] += moved
            size = max(size, abs(step.memory[i, k]))
            step.left[i, k] = moved
            # The error of the step is judged by rates of what it has come to.
            step.rate[i, k] += step.by_memory[i, k] * moved
            if moves:
                step.rate[i, k] += step.by_slip[i, k] * step.before[i]
        for i in range(NODES):
            moved = step.left[i, k]
            change = abs(moved) / size if not abs(moved) <= change * size else change
    return change


@inner_kernel
def collocate_path(path: Path, law: Law, memory: Memory | None) -> bool:
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
        fresh, before = moves_freely(path) or change > SLOW * before, change
    else:
        return False
    if state.framed == 1 and sticks(path):
        for i in range(NODES):
            step.extension[i] = _stuck_extension(path, state.time + NODE[i] * state.length)
            step.friction[i] = -(step.extension[i] + state.relaxation * step.speed[i]) / state.compliance
    elif state.framed == 1:
        for i in range(NODES):
            extension = state.extension
            for m in range(NODES):
                extension += state.length * INTEGRAL[i, m] * (step.speed[m] - step.slip[m])
            step.extension[i] = extension
    if first_flowing(path) == 1:
        for i in range(NODES):
            recall(path, i)
            seen = seen_slip(path, step.slip[i])
            step.memory[i, 0] = _stretch_on_bound(
                path, law, step.gap[i], step.gap_rate[i], seen, step.normal[i], step.friction[i]
            )
    return True


@part_kernel
def _stuck_extension(path: Path, time: float) -> float:
    """Return the extension of the frame at a time of a step in stick [m]."""
    state = path.states[0]
    return float(state.extension + load_point(path, time, True)[2] - load_point(path, state.time, False)[2])


@part_kernel
def open_step(path: Path, law: Law, length: float) -> None:
    """Set what the path prescribes at the nodes of a step of a length [s]."""
    state, step = path.states[0], path.steps[0]
    state.length = length
    for i in range(NODES):
        time = state.time + NODE[i] * length
        step.gap[i], step.gap_rate[i], step.load[i], _, step.speed[i] = press(path, law, time, True)
        if state.framed == 0:
            step.slip[i] = step.speed[i]


@part_kernel
def guess_nodes(path: Path, slip: float) -> None:
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
        if sticks(path):
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
def lay_polynomials(path: Path) -> None:
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
def step_error(path: Path, law: Law, memory: Memory | None) -> float:
    """Return the error of a step between its nodes over its tolerance, from what is missed at its start."""
    state, step = path.states[0], path.steps[0]
    h, first, worst = state.length, first_flowing(path), 0.0
    if state.variables == first and not moves_freely(path):
        return 0.0
    gap, rate, load, _, speed = press(path, law, state.time, False)
    slip = speed
    if state.framed == 1:
        slip = 0.0 if sticks(path) else _polynomial(step.slip, 0.0)
    for k in range(state.variables):
        path.row[HEAD + k] = state.memory[k]
    normal, _, _, friction, flow, _ = forces_of(path, law, gap, rate, load, slip)
    seen = seen_slip(path, slip)
    for k in range(first, state.variables):
        g = flow if k < state.coupled else rate_of(law, memory, k, gap, rate, seen, normal)
        missed, size = g, size_of(path, k)
        for m in range(NODES):
            missed -= LAGRANGE[m, 0] * step.rate[m, k]
            size = max(size, abs(step.memory[m, k]))
        if missed != 0.0:
            worst = max(worst, MISSED * h * abs(missed) / size)
    if moves_freely(path):
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
def dense_at(path: Path, law: Law, x: float) -> tuple[float, float, float, float, float, float, float]:
    """Leave the internal variables at a share x of the step recalled, and return the contact there.

    Gap, its rate, prescribed load, slip velocity, extension of the frame, way and velocity of the load point.
    The slip velocity is that of the extension's polynomial, so that works and energies close.
    """
    state, step = path.states[0], path.steps[0]
    time = state.time + x * state.length
    gap, rate, load, way, speed = press(path, law, time, x > 0.0)
    for k in range(state.variables):
        path.row[HEAD + k] = _variable_at(step, k, x)
    slip, extension = speed, 0.0
    if state.framed == 1 and sticks(path):
        slip, extension = 0.0, _stuck_extension(path, time)
    elif state.framed == 1:
        stretched = 0.0
        for d in range(NODES, -1, -1):
            stretched = stretched * x + extension
            extension = extension * x + step.extended[d]
        slip = speed - stretched / state.length
    return gap, rate, load, slip, extension, way, speed
