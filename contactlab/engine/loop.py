"""The hybrid loop: a phase proposes a step, the step is committed, and its event opens or closes a contact.

There is a loop for each family of laws, so that a run compiles only what it needs. It calls the law by
address, as first-class functions of one type, and is so compiled once for all laws.
"""

import sys
from typing import Any

import numba
import numpy as np

from contactlab.arrays import Array
from contactlab.compiled import INTERPRETED, inner_kernel, is_compiled, kernel
from contactlab.engine.callback import Callback, law_errors
from contactlab.engine.compliant import count_event, step_compliant, switch_friction
from contactlab.engine.flight import step_flight
from contactlab.engine.kinematics import Law, Run, begin, contact_at
from contactlab.engine.law_kernels import compiled
from contactlab.engine.recorder import commit
from contactlab.engine.rigid import step_rigid
from contactlab.engine.state import (
    CONE,
    PRESSED,
    RELEASE,
    RELEASED,
    REVERSAL,
    RUNNING,
    SAMPLE,
    START,
    STATE,
    TOUCH,
    TOUCHING,
)
from contactlab.laws.base import (
    FREE,
    FRICTION_SIGNATURE,
    MULTIPLIER_SIGNATURE,
    PENALTY_SIGNATURE,
    RATE_DEPENDENT,
    SLIP,
    STICK,
    ContactLaw,
    MultiplierLaw,
    PenaltyLaw,
)
from contactlab.laws.intake import function_of

TOUCH_REFINEMENT = 6
"""Levels below the contact step at which a compliant contact begins: the force starts as a power of time."""

NO_FORCE = kernel(lambda _1, _2, _3, _4, _5: (0.0, 0.0, 0.0, 0.0))
NO_FRICTION = kernel(lambda _1, _2, _3, _4, _5, _6: (0.0, 0.0, 0.0, 0.0))
NO_IMPULSE = kernel(lambda _1, _2, _3, _4, _5, _6, _7, _8: (0.0, 0.0, 0))
"""Kernels that stand for those that a law lacks."""

SIGNATURES = PENALTY_SIGNATURE, FRICTION_SIGNATURE, MULTIPLIER_SIGNATURE

_compiled: set[object] = set()
"""Loops with the rooms for coordinates and tones that they are compiled for."""


def kernels_of(law: ContactLaw) -> tuple[tuple[Any, ...], tuple[Callback, ...]]:
    """Give the law's kernels, idle ones for those that it lacks, and the callbacks of interpreted ones."""
    functions: list[Any] = [NO_FORCE, NO_FRICTION, NO_IMPULSE]
    with law_errors(law.name):
        if isinstance(law, PenaltyLaw):
            functions[0] = function_of(law, "force")
            if law.friction_force is not None:
                functions[1] = function_of(law, "friction_force")
        if isinstance(law, MultiplierLaw):
            functions[2] = function_of(law, "solve")
    kernels, callbacks = zip(*map(compiled, functions, SIGNATURES), strict=True)
    return kernels, tuple(each for each in callbacks if each is not None)


def loop_for(law: ContactLaw, run: Run) -> Any:
    """Give the loop of a law's family, compiled or with its code loaded."""
    loop: Any = advance_compliant if isinstance(law, PenaltyLaw) else advance_rigid
    room = loop, run.plant["phasors"].shape
    if INTERPRETED or room in _compiled:
        return loop
    if not is_compiled(loop.__name__):
        print(
            "contactlab: compiling the engine; this happens once for an installation and takes "
            "up to a minute.",
            file=sys.stderr,
            flush=True,
        )
    # Left to itself the compiler would take each law for a type of its own.
    laws = map(numba.types.FunctionType, SIGNATURES)
    memory = np.zeros(1, STATE), np.zeros((1, 2, 1)), np.zeros(1, SAMPLE)
    given = numba.typeof(run), *map(numba.typeof, memory), *laws
    loop.disable_compile(False)
    loop.compile((*given, PENALTY_SIGNATURE.args[-1], numba.types.int64))
    loop.disable_compile()
    _compiled.add(room)
    return loop


@kernel
def advance_compliant(
    run: Run,
    states: Any,
    motions: Array,
    series: Any,
    force: Any,
    friction: Any,
    solve: Any,
    parameters: Array,
    budget: int,
) -> None:
    """Run a penalty law, start after start, until the end, an ending, full contact storage or so many steps.

    States, shape (start,), and motions, shape (start, q or v, coordinate), take the place of the run's own.
    Call it again to go on: they and the series hold all that there is, however often a run is cut.
    """
    law = Law(force, friction, solve, parameters)
    for i in range(states.size):
        each, left = Run(run.plant, run.propagator, states[i], run.step), budget
        _begin_at(each, motions[i])
        while left > 0 and _opens_step(each):
            touching = each.state.phase == TOUCHING
            event = step_compliant(each, law) if touching else step_flight(each, law)
            commit(each, law, series)
            _act(each, event)
            left -= 1
        _leave_at(each, motions[i])


@kernel
def advance_rigid(
    run: Run,
    states: Any,
    motions: Array,
    series: Any,
    force: Any,
    friction: Any,
    solve: Any,
    parameters: Array,
    budget: int,
) -> None:
    """Run a multiplier law, see `advance_compliant`."""
    law = Law(force, friction, solve, parameters)
    for i in range(states.size):
        each, left = Run(run.plant, run.propagator, states[i], run.step), budget
        _begin_at(each, motions[i])
        while left > 0 and _opens_step(each):
            touching = each.state.phase == TOUCHING
            event = step_rigid(each, law) if touching else step_flight(each, law)
            commit(each, law, series)
            _act(each, event)
            left -= 1
        _leave_at(each, motions[i])


@inner_kernel
def _begin_at(run: Run, motion: Array) -> None:
    """Set displacements and rates at the start of a step."""
    for j in range(run.plant.mode_count):
        mode = run.plant.modes[j]
        mode.q[START], mode.v[START] = motion[0, j], motion[1, j]


@inner_kernel
def _leave_at(run: Run, motion: Array) -> None:
    """Take displacements and rates from the start of a step."""
    for j in range(run.plant.mode_count):
        mode = run.plant.modes[j]
        motion[0, j], motion[1, j] = mode.q[START], mode.v[START]


@inner_kernel
def _opens_step(run: Run) -> bool:
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
        _open_contact(run)
    begin(run)
    return True


@inner_kernel
def _act(run: Run, event: int) -> None:
    """Open, close or switch the contact after the event of a committed step."""
    state = run.state
    if event == TOUCH:
        _open_contact(run)
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
        state.mode, state.phase = FREE, RELEASED
        state.level = run.propagator.rule.fresh_level


@inner_kernel
def _open_contact(run: Run) -> None:
    """Start a contact at the present state, some levels below that of the contact step."""
    state, contact = run.state, run.state.contact
    _, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    contact.start_time, contact.approach_velocity, contact.separation_velocity = (state.time, rate, 0.0)
    contact.duration, contact.stick_duration, contact.energy_loss = 0.0, 0.0, 0.0
    contact.normal_impulse, contact.friction_impulse = 0.0, 0.0
    contact.peak_normal_force, contact.max_penetration = 0.0, 0.0
    state.normal_before, state.friction_before, state.internal = 0.0, 0.0, 0.0
    state.phase, state.impact_speed = TOUCHING, max(-rate, 0.0)
    state.mode = SLIP if slip != 0.0 or state.friction_kind == RATE_DEPENDENT else STICK
    state.sign = 1 if slip > 0.0 else -1
    state.level = run.propagator.rule.contact_level + state.compliant * TOUCH_REFINEMENT
    state.touchdowns += 1
    count_event(state)
