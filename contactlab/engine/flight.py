"""One stretch of free flight: up to the next level of the ladder, the touch-down or the end."""

from math import sqrt

from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.events import NOTHING, TOUCH
from contactlab.engine.plant import Plant
from contactlab.engine.run import (
    DIVERGED,
    END,
    ENDING,
    FLIGHT_STEPS,
    LEVEL,
    OPEN,
    PHASE,
    SEPARATING,
    TIME,
    Run,
)
from contactlab.engine.step import FLIGHT, KIND, LENGTH, TAKEN, Step, flow_to, free_response
from contactlab.engine.tables import NODES, Tables, build_level, step_length
from contactlab.engine.touchdown import (
    LOST,
    NO_TOUCH,
    curvature_bound,
    first_touch,
    gap_and_rate,
)

CLEAR = 1e-18
"""Gap [m] that no round-off after a release amounts to: that of u and of the clearance is 1e-21."""


@part_kernel
def fly(plant: Plant, tables: Tables, step: Step, run: Run) -> int:
    """Take a step that `begin` made ready through free flight; returns TOUCH or NOTHING.

    While SEPARATING, round-off decides the sign of the gap, so that no touch-down is looked for
    until the gap is clear, or open and opening; a gap that is closed and closing is a new contact,
    and one that rests at exactly zero is none. These steps are so short that the gap, with the rate
    it has and the curvature it may have, cannot close in them by more than CLEAR.
    """
    level = run.whole[LEVEL]
    h = step_length(tables, level)
    s = min(h, run.real[END] - run.real[TIME])
    if run.whole[PHASE] == SEPARATING:
        s = min(s, _unseen(plant, step, h))
    step.whole[KIND] = FLIGHT
    step.real[LENGTH] = h
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
        touch = first_touch(plant, step, s, gap, rate, run.stack)
        if touch == LOST:
            run.whole[ENDING] = DIVERGED
            s = 0.0
        elif touch != NO_TOUCH:
            s = touch
            event = TOUCH
    elif gap <= 0.0 and rate <= 0.0 and gap + rate < 0.0:
        event = TOUCH
    elif gap > CLEAR or (gap > 0.0 and rate > 0.0):
        run.whole[PHASE] = OPEN
    coarsest = 0 if run.whole[PHASE] == OPEN else tables.contact_level
    run.whole[LEVEL] = max(level - 1, coarsest) if level > coarsest else level
    step.real[TAKEN] = s
    return event


@inner_kernel
def _unseen(plant: Plant, step: Step, h: float) -> float:
    """Time [s] in which a gap of zero closes by less than CLEAR: r s >= B s^2 / 2, or B s^2 / 2 < CLEAR."""
    _, rate = gap_and_rate(plant, step.q, step.v)
    bound = curvature_bound(plant, step, h)
    if bound * h * h <= CLEAR:
        return h
    return max(rate / bound, sqrt(CLEAR / bound))
