"""One stretch of free flight: up to the next level of the ladder, the touch-down or the end."""

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import inner_kernel
from contactlab.engine.plant import Plant
from contactlab.engine.run import (
    END,
    FLIGHT_STEPS,
    LEVEL,
    OPEN,
    PHASE,
    TIME,
    Run,
    commit,
    open_contact,
)
from contactlab.engine.step import FLIGHT, Step, flow_to, free_response
from contactlab.engine.tables import NODES, Tables, build_level, step_length
from contactlab.engine.touchdown import NO_TOUCH, first_touch, gap_and_rate
from contactlab.laws.base import FREE, PenaltyKernel

Array = NDArray[np.float64]


@inner_kernel
def fly(
    plant: Plant,
    tables: Tables,
    step: Step,
    run: Run,
    touch_level: int,
    force: PenaltyKernel,
    parameters: Array,
) -> None:
    """Advance a step that `begin` made ready through free flight.

    While SEPARATING, round-off decides the sign of the gap, so that no touch-down is looked for
    until the gap is open and opening; a gap that is closed and closing is a new contact.
    """
    level = run.whole[LEVEL]
    h = step_length(tables, level)
    s = min(h, run.real[END] - run.real[TIME])
    if s < h:
        flow_to(plant, step, s, h, FLIGHT)
        gap, rate = gap_and_rate(plant, step.other_q, step.other_v)
    else:
        build_level(plant, tables, level)
        free_response(plant, tables, step, level, NODES - 1)
        gap, rate = gap_and_rate(plant, step.node_q[-1], step.node_v[-1])
    touches = False
    clear = run.whole[PHASE] == OPEN
    if clear:
        touch = first_touch(plant, step, s, gap, rate, run.stack)
        touches = touch != NO_TOUCH
        s = touch if touches else s
    else:
        touches = gap <= 0.0 and rate <= 0.0
        clear = gap > 0.0 and rate > 0.0
    commit(plant, tables, step, run, h, s, FLIGHT, FREE, force, parameters)
    run.whole[FLIGHT_STEPS] += 1
    if touches:
        open_contact(plant, step, run, touch_level)
        return
    if clear:
        run.whole[PHASE] = OPEN
    coarsest = 0 if clear else tables.contact_level
    run.whole[LEVEL] = max(level - 1, coarsest) if level > coarsest else level
