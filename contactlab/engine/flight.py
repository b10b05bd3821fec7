"""One stretch of free flight: up to the next level of the ladder, the touch-down or the end."""

from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.events import NOTHING, TOUCH
from contactlab.engine.nodes import free_response
from contactlab.engine.plant import Plant
from contactlab.engine.run import (
    END,
    ENDING,
    FLIGHT_STEPS,
    LEVEL,
    OPEN,
    PHASE,
    RELEASED,
    SEPARATING,
    TIME,
    UNFOLLOWED,
    Run,
)
from contactlab.engine.step import FLIGHT, KIND, LENGTH, TAKEN, Step, flow_to
from contactlab.engine.tables import NODES, Tables, build_level, level_count, step_length
from contactlab.engine.touchdown import (
    LOST,
    NO_TOUCH,
    certain_opening,
    coarseness,
    curvature_bound,
    first_touch,
    gap_and_rate,
)

CLEAR = 1e-18
"""Gap [m] that no round-off after a release amounts to: that of u and of the clearance is 1e-21, and more
for a tip that moves far, see `coarseness`."""

REFINEMENT = 15
"""Levels that a flight begins finer where its gap opens from nothing, as a power of time."""


@part_kernel
def fly(plant: Plant, tables: Tables, step: Step, run: Run) -> int:
    """Take a step that `begin` made ready through free flight; returns TOUCH or NOTHING.

    A touch-down is looked for from where the gap is known to be open. While SEPARATING, that is
    where it has certainly opened; one that opens so slowly that round-off or the error of a rigid
    release decides its sign is followed, in steps that double from very short ones, until it is
    clear. A gap that is closed and closes faster and faster is a new contact; one that rests is none.
    """
    level = run.whole[LEVEL]
    _, before = gap_and_rate(plant, step.q, step.v)
    coarse = coarseness(plant, step)
    if run.whole[PHASE] == RELEASED:
        level = _level_after_release(plant, tables, step, level, before, coarse)
        run.whole[PHASE] = SEPARATING
    h = step_length(tables, level)
    s = min(h, run.real[END] - run.real[TIME])
    step.whole[KIND] = FLIGHT
    step.real[LENGTH] = h
    start = 0.0
    if run.whole[PHASE] == SEPARATING:
        start = certain_opening(plant, step, s, coarse)
        if start > 0.0:
            run.whole[PHASE] = OPEN
    if s < h:
        flow_to(plant, step, s)
        gap, rate = gap_and_rate(plant, step.other_q, step.other_v)
    else:
        build_level(plant, tables, level)
        free_response(plant, tables, step, level, NODES - 1)
        gap, rate = gap_and_rate(plant, step.node_q[-1], step.node_v[-1])
    run.whole[FLIGHT_STEPS] += 1
    event = NOTHING
    if run.whole[PHASE] == OPEN:
        touch = first_touch(plant, step, start, s, gap, rate, coarse, run.stack)
        if touch == LOST:
            run.whole[ENDING] = UNFOLLOWED
            s = 0.0
        elif touch != NO_TOUCH:
            s = touch
            event = TOUCH
    elif gap <= 0.0 and rate <= 0.0 and gap + rate < 0.0 and rate < before:
        event = TOUCH
    elif gap > coarse * CLEAR:
        run.whole[PHASE] = OPEN
    coarsest = 0 if run.whole[PHASE] == OPEN else tables.contact_level
    run.whole[LEVEL] = max(level - 1, coarsest) if level > coarsest else level
    step.real[TAKEN] = s
    return event


@inner_kernel
def _level_after_release(
    plant: Plant, tables: Tables, step: Step, level: int, rate: float, coarse: float
) -> int:
    """The level as it is, or a much finer one for a gap that hardly opens: there, round-off decides.

    Args:
        plant, tables, step, level: the flight and the level it would begin with.
        rate: gap rate of the release [m/s].
        coarse: see `coarseness`.
    """
    h = step_length(tables, level)
    opens = rate >= curvature_bound(plant, step, h) * h
    opens = opens or certain_opening(plant, step, h, coarse) > 0.0
    return level if opens else min(level + REFINEMENT, level_count(tables) - 1)
