"""The hybrid loop: a phase proposes a step, the step is committed, and its event opens the next phase.

There is a loop for each family of laws, so that a run compiles only what it needs.
"""

from typing import Any

from contactlab.arrays import Array
from contactlab.compiled import kernel, part_kernel
from contactlab.engine.compliant import step_compliant, switch_friction
from contactlab.engine.contacts import close_contact, open_contact
from contactlab.engine.flight import step_flight
from contactlab.engine.kinematics import Law, Run, begin, is_finite
from contactlab.engine.recorder import commit
from contactlab.engine.rigid import step_rigid
from contactlab.engine.state import (
    FLIGHT,
    NOT_FINITE,
    NOTHING,
    PRESSED,
    RELEASE,
    RUNNING,
    START,
    TOUCH,
    TOUCHING,
    UNSOLVED,
)
from contactlab.laws.base import FrictionKernel, MultiplierKernel, PenaltyKernel

TOUCH_REFINEMENT = 6
"""Levels below the contact step at which a compliant contact begins: the force starts as a power of time."""


@kernel
def advance_compliant(
    run: Run,
    series: Any,
    force: PenaltyKernel,
    friction: FrictionKernel,
    solve: MultiplierKernel,
    parameters: Array,
    budget: int,
) -> None:
    """Run a penalty law until the end, an ending, full contact storage or a number of steps.

    Call it again to go on.

    Args:
        run, series: the motor, its state and the records of its run; they hold all that there is, so that
            it does not matter into how many calls a run is cut.
        force, friction, solve, parameters: the law; its kernels of the other family are idle.
        budget: number of steps.
    """
    law = Law(force, friction, solve, parameters)
    for _ in range(budget):
        if not _opens_step(run, TOUCH_REFINEMENT):
            return
        touching = run.state.phase == TOUCHING
        event = _checked(run, step_compliant(run, law)) if touching else step_flight(run, law)
        commit(run, law, series)
        _act(run, event, TOUCH_REFINEMENT)
        if event != NOTHING and event != TOUCH and event != RELEASE:
            switch_friction(run.state, event)


@kernel
def advance_rigid(
    run: Run,
    series: Any,
    force: PenaltyKernel,
    friction: FrictionKernel,
    solve: MultiplierKernel,
    parameters: Array,
    budget: int,
) -> None:
    """Run a multiplier law, see `advance_compliant`."""
    law = Law(force, friction, solve, parameters)
    for _ in range(budget):
        if not _opens_step(run, 0):
            return
        touching = run.state.phase == TOUCHING
        event = _checked(run, step_rigid(run, law)) if touching else step_flight(run, law)
        commit(run, law, series)
        _act(run, event, 0)


@part_kernel
def _opens_step(run: Run, refinement: int) -> bool:
    """Make a step ready, and tell whether there is one to take."""
    state = run.state
    if state.time >= state.end or state.ending != RUNNING:
        return False
    if state.stored >= run.step.contacts.size - 1:
        return False
    if state.end - state.time <= run.propagator.rule.longest:
        # The end may cut this step: another run goes on from where it began.
        run.step.saved[0] = state
        for j in range(run.plant.mode_count):
            mode = run.plant.modes[j]
            mode.saved_q, mode.saved_v = mode.q[START], mode.v[START]
    if state.phase == PRESSED:
        open_contact(run, refinement)
    begin(run)
    return True


@part_kernel
def _checked(run: Run, event: int) -> int:
    """Give the event of a step in contact; end the run where the law has not answered with numbers."""
    state = run.state
    if state.ending == RUNNING and not is_finite(run):
        state.ending = NOT_FINITE
    if state.ending == NOT_FINITE or state.ending == UNSOLVED:
        # The state stays as it is, so that it can be told what the law was asked.
        run.step.kind = FLIGHT
        state.taken = 0.0
        return NOTHING
    return event


@part_kernel
def _act(run: Run, event: int, refinement: int) -> None:
    """Open or close the contact after the event of a committed step."""
    if event == TOUCH:
        open_contact(run, refinement)
    elif event == RELEASE:
        close_contact(run)
