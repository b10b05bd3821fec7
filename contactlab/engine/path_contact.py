"""A law on a path or behind a frame, asked where the path has it, see `contactlab.engine.path`."""

from typing import Any, Final, NamedTuple, final

import numpy as np

from contactlab.arrays import Array
from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.engine.memory import NUDGE, SLIP_ROUND_OFF
from contactlab.engine.state import HEAD, NODES, SPEED, Law, Memory, record
from contactlab.laws.base import RATE_DEPENDENT, SET_VALUED, SLIP, STICK
from contactlab.laws.memory import MOST_VARIABLES

BY_GAP, BY_LOAD, RIGID = range(3)
"""What the first row of a path prescribes: a gap, or the normal force of a compliant or of a rigid law."""

DEEPEST, HALVINGS = 1e-3, 60
"""Largest penetration at which a normal force is looked for [m], and halvings of it."""

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
def recall(path: Path, place: int) -> None:
    """Put the internal variables at a node, or at the time in between, where the law reads them."""
    for k in range(path.states[0].variables):
        path.row[HEAD + k] = path.steps[0].memory[place, k]


@part_kernel
def load_point(path: Path, time: float, left: bool) -> tuple[float, float, float, float]:
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
        normal = law.force(-depth, 0.0, 0.0, 0.0, law.parameters)[0]
        missed, nudged = normal - load, depth * (1.0 + NUDGE)
        # Of the forces themselves: a load that is much larger would leave no digit of their difference.
        slope = (law.force(-nudged, 0.0, 0.0, 0.0, law.parameters)[0] - normal) / (nudged - depth)
        if missed > 0.0:
            most = depth
        else:
            least = depth
        change = missed / slope if slope > 0.0 else np.inf
        depth -= change
        if abs(change) <= 1e-14 * abs(depth) < np.inf or most - least <= 1e-15 * most:
            break
    reached = law.force(-depth, 0.0, 0.0, 0.0, law.parameters)[0]
    return depth if abs(reached - load) <= 1e-9 * load else np.nan


@part_kernel
def press(path: Path, law: Law, time: float, left: bool) -> tuple[float, float, float, float, float]:
    """Return gap [m], its rate, the normal force if it is prescribed [N], way and velocity of the load."""
    state = path.states[0]
    first, rate, way, speed = load_point(path, time, left)
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
def bounds_of(
    path: Path, law: Law, gap: float, rate: float, load: float, slip: float
) -> tuple[float, float, float, float, float]:
    """Return normal force, least and largest friction [N], stored energy [J] and normal loss [W]."""
    if path.states[0].prescribed == RIGID:
        bound = law.bound(load, slip, law.parameters)
        return load, -bound, bound, 0.0, 0.0
    normal, least, most, stored, loss = law.force(gap, rate, slip, path.row[SPEED], law.parameters)
    return normal, least, most, stored, loss


@part_kernel
def sticks(path: Path) -> bool:
    """Return whether the contact has no slip: set-valued friction holds it."""
    return bool(path.states[0].mode == STICK and path.states[0].friction_kind == SET_VALUED)


@part_kernel
def slides(path: Path) -> bool:
    """Return whether friction is on its bound."""
    return bool(path.states[0].mode == SLIP and path.states[0].friction_kind != RATE_DEPENDENT)


@part_kernel
def moves_freely(path: Path) -> bool:
    """Return whether the slip velocity is unknown."""
    return path.states[0].framed == 1 and not sticks(path)


@part_kernel
def seen_slip(path: Path, slip: float) -> float:
    """Return the slip that the law receives: exactly zero in stick alone [m/s]."""
    if sticks(path):
        return 0.0
    at_bound = slides(path) and path.states[0].friction_kind == SET_VALUED
    if at_bound and slip * path.states[0].sign <= 0.0:
        return float(path.states[0].sign * SLIP_ROUND_OFF)
    return slip


@part_kernel
def first_flowing(path: Path) -> int:
    """Return the number of the first internal variable that flows by its rate, and not with the bound."""
    return 1 if path.states[0].coupled == 1 and slides(path) else 0


@part_kernel
def friction_of(
    path: Path, law: Law, gap: float, rate: float, seen: float, normal: float, least: float, most: float
) -> tuple[float, float, float]:
    """Return the friction [N], the flow of its variable and its stiffness, of what is recalled."""
    state = path.states[0]
    friction, flow, stiffness = state.force, 0.0, 0.0
    if state.friction_kind != SET_VALUED:
        friction, flow, _, stiffness = law.friction(gap, rate, seen, normal, law.parameters)
    if slides(path):
        friction = least if state.sign > 0 else most
    return friction, flow, stiffness


@part_kernel
def forces_of(
    path: Path, law: Law, gap: float, rate: float, load: float, slip: float
) -> tuple[float, float, float, float, float, float]:
    """Return normal force, least and largest friction, friction [N], its flow and stiffness, recalled."""
    seen = seen_slip(path, slip)
    normal, least, most, _, _ = bounds_of(path, law, gap, rate, load, seen)
    friction, flow, stiffness = friction_of(path, law, gap, rate, seen, normal, least, most)
    return normal, least, most, friction, flow, stiffness


@inner_kernel
def rate_of(
    law: Law, memory: Memory | None, k: int, gap: float, rate: float, slip: float, normal: float
) -> float:
    """Return the rate of internal variable k, of what is recalled."""
    if memory is None:
        return 0.0
    return float(memory.rate(k, gap, rate, slip, normal, law.parameters))


@part_kernel
def size_of(path: Path, k: int) -> float:
    """Return the size that errors of variable k are relative to, see `MOTION`."""
    state = path.states[0]
    return float(max(state.largest[state.alike[k]], abs(state.memory[k])))
