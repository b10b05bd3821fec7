"""The hybrid loop: a phase proposes a step, the step is committed, and its event opens or closes a contact.

There is a loop for each family of laws, so that a run compiles only what it needs.
"""

from typing import Any

from contactlab.arrays import Array
from contactlab.compiled import inner_kernel, kernel
from contactlab.engine.compliant import count_event, step_compliant, switch_friction
from contactlab.engine.flight import step_flight
from contactlab.engine.kinematics import Law, Run, begin, contact_at
from contactlab.engine.recorder import commit
from contactlab.engine.rigid import step_rigid
from contactlab.engine.state import (
    CONE,
    PRESSED,
    RELEASE,
    RELEASED,
    REVERSAL,
    RUNNING,
    START,
    TOUCH,
    TOUCHING,
)
from contactlab.laws.base import (
    FREE,
    RATE_DEPENDENT,
    SLIP,
    STICK,
    FrictionKernel,
    MultiplierKernel,
    PenaltyKernel,
)

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

    Call it again to go on: run and series hold all that there is, so that it does not matter into how many
    calls a run is cut. Kernels that the law lacks are idle.
    """
    law = Law(force, friction, solve, parameters)
    while budget > 0 and _opens_step(run, TOUCH_REFINEMENT):
        touching = run.state.phase == TOUCHING
        event = step_compliant(run, law) if touching else step_flight(run, law)
        commit(run, law, series)
        _act(run, event, TOUCH_REFINEMENT)
        budget -= 1


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
    while budget > 0 and _opens_step(run, 0):
        touching = run.state.phase == TOUCHING
        event = step_rigid(run, law) if touching else step_flight(run, law)
        commit(run, law, series)
        _act(run, event, 0)
        budget -= 1


@inner_kernel
def _opens_step(run: Run, refinement: int) -> bool:
    """Make a step ready, and tell whether there is one to take."""
    state, step = run.state, run.step
    full = state.stored >= step.contacts.size - 1
    if state.time >= state.end or state.ending != RUNNING or full:
        return False
    if state.end - state.time <= run.propagator.rule.longest:
        # The end may cut this step: another run goes on from where it began.
        step.saved[0] = state
        for j in range(run.plant.mode_count):
            mode = run.plant.modes[j]
            mode.saved_q, mode.saved_v = mode.q[START], mode.v[START]
    if state.phase == PRESSED:
        _open_contact(run, refinement)
    begin(run)
    return True


@inner_kernel
def _act(run: Run, event: int, refinement: int) -> None:
    """Open, close or switch the contact after the event of a committed step."""
    state = run.state
    if event == TOUCH:
        _open_contact(run, refinement)
    elif event in (REVERSAL, CONE):
        switch_friction(state, event)
    elif event == RELEASE:
        state.contact.separation_velocity = contact_at(run.plant, START)[1]
        if state.contact.duration > 0.0:
            run.step.contacts[state.stored] = state.contact
            state.stored += 1
        else:
            # What has no length is no contact: here round-off alone tells a graze from a miss.
            state.touchdowns -= 1
        state.mode = FREE
        state.phase = RELEASED
        state.level = run.propagator.rule.fresh_level


@inner_kernel
def _open_contact(run: Run, refinement: int) -> None:
    """Start a contact at the present state, some levels below that of the contact step."""
    state, contact = run.state, run.state.contact
    _, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    contact.start_time, contact.approach_velocity = state.time, rate
    contact.duration, contact.stick_duration, contact.energy_loss = 0.0, 0.0, 0.0
    contact.normal_impulse, contact.friction_impulse = 0.0, 0.0
    contact.peak_normal_force, contact.max_penetration = 0.0, 0.0
    contact.separation_velocity = 0.0
    state.normal_before, state.friction_before = 0.0, 0.0
    state.phase = TOUCHING
    state.impact_speed = max(-rate, 0.0)
    state.internal = 0.0
    state.mode = SLIP if slip != 0.0 or state.friction_kind == RATE_DEPENDENT else STICK
    state.sign = 1 if slip > 0.0 else -1
    state.level = run.propagator.rule.contact_level + refinement
    state.touchdowns += 1
    count_event(state)
