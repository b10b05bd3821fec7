"""A compliant contact step by step: accuracy, release, and the switches between slip and stick."""

import numpy as np

from contactlab.arrays import Array
from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.compliant_events import (
    contradicted,
    first_event,
    track_extremes,
)
from contactlab.engine.compliant_step import TOUCHED, attempt, start_forces, start_motion
from contactlab.engine.contacts import impulse_scale
from contactlab.engine.events import NOTHING
from contactlab.engine.nodes import add_collocated
from contactlab.engine.plant import Plant
from contactlab.engine.run import (
    CONTACT_STEPS,
    DURATION,
    END,
    ENDING,
    LEVEL,
    LEVEL_BEFORE,
    MOMENTUM,
    REJECTED_STEPS,
    SIGN,
    TIME,
    TOLERANCE,
    UNSOLVED,
    Run,
)
from contactlab.engine.step import (
    BOUND,
    COLLOCATED,
    FRICTION,
    KIND,
    LENGTH,
    MEMORY_RATE,
    MODE,
    NORMAL,
    TAKEN,
    Step,
)
from contactlab.engine.tables import NODES, Tables, level_count, step_length
from contactlab.laws.base import SLIP, FrictionKernel, PenaltyKernel

CLOCK = 64.0 * np.finfo(np.float64).eps
"""Shortest step over the time at which it begins: below it the clock decides, and no force."""


@part_kernel
def press(
    plant: Plant,
    tables: Tables,
    step: Step,
    run: Run,
    force: PenaltyKernel,
    rub: FrictionKernel,
    parameters: Array,
) -> int:
    """Take a step that `begin` made ready through compliant contact; returns the event that ends it.

    The mode of the step that follows is set by `switch_friction` once the step is committed.
    """
    step.whole[KIND] = COLLOCATED
    gap, rate, slip = start_motion(plant, step)
    normal, bound, rubbed, steepness = start_forces(
        step, run, gap, rate, slip, force, rub, parameters
    )
    if run.contact[DURATION] == 0.0:
        run.real[MOMENTUM] = impulse_scale(
            plant, tables, step, run, rate, normal, force, parameters
        )
    if bound == 0.0:
        # What has no say in the slip cannot have followed its sign.
        _slip_freely(step, run, slip)
    level = _separation_level(tables, run, gap, rate, normal)
    finest = _finest_level(tables, run.real[TIME])
    flips = 0
    _guess(step, run, normal, bound, rubbed)
    while True:
        if level >= level_count(tables):
            run.whole[ENDING] = UNSOLVED
            step.real[TAKEN] = 0.0
            return NOTHING
        error = attempt(
            plant,
            tables,
            step,
            run,
            level,
            normal,
            bound,
            rubbed,
            steepness,
            force,
            rub,
            parameters,
        )
        # A dip that ends before the first node would be left where it begins, still approaching,
        # unless nothing of it could be seen.
        hidden = step.gap[0] >= 0.0 and rate * step.real[LENGTH] < TOUCHED
        if (error > 1.0 or hidden) and (level < finest or error == np.inf):
            run.whole[REJECTED_STEPS] += 1
            level += 2 if error > 500.0 or hidden else 1
            if error < np.inf:
                level = min(level, finest)
            continue
        if not contradicted(plant, step, run, slip, rub, parameters):
            break
        # Neither slipping nor sticking fits at this length: look closer before trying again.
        flips += 1
        level += 2 * (flips // 2)
        normal, bound, rubbed, steepness = start_forces(
            step, run, gap, rate, slip, force, rub, parameters
        )
    remaining = run.real[END] - run.real[TIME]
    event, s = first_event(plant, tables, step, run, rate, rub, parameters)
    if s > remaining:
        event, s = NOTHING, remaining
    step.real[TAKEN] = s
    track_extremes(plant, tables, step, run, gap, rate, normal)
    if s == step.real[LENGTH]:
        add_collocated(plant, tables, step, level)
    run.whole[CONTACT_STEPS] += 1
    run.whole[LEVEL_BEFORE] = level
    run.whole[LEVEL] = _following_level(tables, level, error)
    return event


@inner_kernel
def _finest_level(tables: Tables, time: float) -> int:
    """Level of the shortest step that a run takes at a time [s]."""
    level = level_count(tables) - 9
    while level > tables.contact_level and step_length(tables, level) < CLOCK * time:
        level -= 1
    return int(level)


@inner_kernel
def _slip_freely(step: Step, run: Run, slip: float) -> None:
    """Let the sign of a slip that nothing resists be that of the slip itself."""
    if step.whole[MODE] == SLIP and slip != 0.0:
        run.whole[SIGN] = 1 if slip > 0.0 else -1


@inner_kernel
def _guess(step: Step, run: Run, normal: float, bound: float, rubbed: float) -> None:
    """Make TAKEN the place x = s/h of the step's start on the force polynomial that stands.

    The first attempt continues the step before; every further one starts on its own forerunner, at
    x = 0. Where there is no such step, or a coarser one is to follow, the forces start constant.
    """
    if run.contact[DURATION] > 0.0 and run.whole[LEVEL] >= run.whole[LEVEL_BEFORE]:
        step.real[TAKEN] /= step.real[LENGTH]
        return
    step.real[TAKEN] = 0.0
    for d in range(NODES):
        step.shape[NORMAL, d] = normal if d == 0 else 0.0
        step.shape[BOUND, d] = bound if d == 0 else 0.0
        step.shape[FRICTION, d] = rubbed if d == 0 else 0.0
        step.shape[MEMORY_RATE, d] = 0.0


@part_kernel
def _separation_level(tables: Tables, run: Run, gap: float, rate: float, normal: float) -> int:
    """Level that walks up to a release instead of stepping over it while the force still matters."""
    level = run.whole[LEVEL]
    if rate > 0.0 and gap < 0.0:
        h = step_length(tables, level)
        small = run.real[TOLERANCE] * run.real[MOMENTUM]
        while h * rate > -0.7 * gap and abs(normal) * h > small and level < level_count(tables) - 1:
            level += 1
            h *= 0.5
    return int(level)


@part_kernel
def _following_level(tables: Tables, level: int, error: float) -> int:
    """Level of the next step: the error falls as h^(NODES + 1)."""
    growth = 2.0 ** (NODES + 1)
    for _ in range(2):
        if level > tables.contact_level and 2.0 * error * growth < 1.0:
            level -= 1
            error *= growth
    return level
