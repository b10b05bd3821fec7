"""The hybrid loop: a phase proposes a step, the step is committed, and its event opens or closes a contact.

There is a loop for each family of laws, so that a run compiles only what it needs. It calls the law by
address, as first-class functions of one type, and is so compiled once for all laws.
"""

from typing import Any

import numba
import numpy as np

from contactlab.arrays import Array
from contactlab.compilation import telling
from contactlab.compiled import INTERPRETED, inner_kernel, is_compiled, kernel
from contactlab.engine.binding import OF_PLAIN, SIGNATURES
from contactlab.engine.compliant import count_event, step_compliant, switch_friction
from contactlab.engine.context import Law, Memory, Records, Run
from contactlab.engine.flight import step_flight
from contactlab.engine.friction import jump_at_guard
from contactlab.engine.kinematics import begin, contact_at
from contactlab.engine.memory import jump, leave
from contactlab.engine.moments import press
from contactlab.engine.propagator import step_length
from contactlab.engine.recorder import CRAWL, commit
from contactlab.engine.rigid import step_rigid
from contactlab.engine.state import (
    CONE,
    GUARD,
    PRESSED,
    RELEASE,
    RELEASED,
    REVERSAL,
    RUNNING,
    START,
    STATE,
    TOUCH,
    TOUCHING,
)
from contactlab.laws.base import FREE, RATE_DEPENDENT, SLIP, STICK, ContactLaw, PenaltyLaw
from contactlab.laws.memory import AT_RELEASE, AT_SLIP, AT_STICK, AT_TOUCH

TOUCH_REFINEMENT = 6
"""Levels below the contact step at which a compliant contact begins: the force starts as a power of time."""

KINDS = {
    "advance_compliant": ("the engine for compliant laws", 15.0),
    "advance_rigid": ("the engine for rigid laws", 7.0),
    "advance_compliant_with_memory": ("the engine for compliant laws that remember", 26.0),
    "advance_rigid_with_memory": ("the engine for rigid laws that remember", 14.0),
    "strike_compliant": ("impacts under compliant laws", 13.0),
    "strike_rigid": ("impacts under rigid laws", 1.0),
    "strike_compliant_with_memory": ("impacts under compliant laws that remember", 24.0),
    "strike_rigid_with_memory": ("impacts under rigid laws that remember", 1.0),
}
"""The loops in words, and what each takes to compile [s] beyond what it shares with others."""

SHARED, SHARED_WITH_MEMORY = 12.0, 20.0
"""What an idle processor takes [s] for what all loops have in common, and those of laws that remember."""

_compiled: set[object] = set()
"""Loops with the rooms for coordinates and tones that they are compiled for."""


def loop_for(law: ContactLaw, plain: bool, run: Run) -> Any:
    """Give the loop of a law's kind, compiled or with its code loaded."""
    loops: Any = (advance_compliant_with_memory, advance_compliant)
    if not isinstance(law, PenaltyLaw):
        loops = (advance_rigid_with_memory, advance_rigid)
    motions = np.zeros(1, STATE), np.zeros((1, 2, 1)), Records.of(1, 0, 0)
    return compiled_for(plain, loops, run, (run, *motions), (numba.types.int64,))


def compiled_for(plain: bool, loops: Any, run: Run, given: tuple[Any, ...], numbers: Any = ()) -> Any:
    """Give the one of two loops that is for the law, compiled or with its code loaded.

    The first is for laws that remember, the second for plain ones. They are called with things like those
    given, then the law's rows, numbers of some types, and the law's kernels.
    """
    loop = loops[plain]
    room = loop, run.plant["phasors"].shape
    if INTERPRETED or room in _compiled:
        return loop
    # Left to itself the compiler would take each law for a type of its own.
    kernels = [*map(numba.types.FunctionType, SIGNATURES.values())][: OF_PLAIN if plain else None]
    row = SIGNATURES["force"].args[-1]
    rows = (row,) if plain else (row, row.copy(readonly=False))
    name = loop.__name__
    with telling(KINDS[name][0], _usual_time(name)):
        loop.disable_compile(False)
        loop.compile((*map(numba.typeof, given), *rows, *numbers, *kernels))
        loop.disable_compile()
    _compiled.add(room)
    return loop


def _usual_time(name: str) -> float:
    """Give what an idle processor usually takes to compile a loop with all that is not there yet [s]."""
    remembers = name.endswith("with_memory")
    there = [each for each in KINDS if is_compiled(each)]
    lacks_memory = remembers and not any(each.endswith("with_memory") for each in there)
    return KINDS[name][1] + (not there) * SHARED + lacks_memory * SHARED_WITH_MEMORY


@inner_kernel
def run_compliant(run: Run, states: Any, motions: Array, records: Records, law: Law, budget: int) -> None:
    """Run a penalty law from starts, see `advance_compliant`."""
    for i in range(states.size):
        each, left = Run(run.plant, run.propagator, states[i], run.step), budget
        _begin_at(each, motions[i])
        while left > 0 and _opens_step(each, law):
            touching = each.state.phase == TOUCHING
            event = step_compliant(each, law) if touching else step_flight(each, law)
            commit(each, law, records.series, records.traces)
            _act(each, law, records.ends, event)
            left -= 1
        _leave_at(each, motions[i])


@inner_kernel
def _run_rigid(run: Run, states: Any, motions: Array, records: Records, law: Law, budget: int) -> None:
    for i in range(states.size):
        each, left = Run(run.plant, run.propagator, states[i], run.step), budget
        _begin_at(each, motions[i])
        while left > 0 and _opens_step(each, law):
            touching = each.state.phase == TOUCHING
            event = step_rigid(each, law) if touching else step_flight(each, law)
            commit(each, law, records.series, records.traces)
            _act(each, law, records.ends, event)
            left -= 1
        _leave_at(each, motions[i])


@kernel
def advance_compliant(
    run: Run,
    states: Any,
    motions: Array,
    records: Records,
    parameters: Array,
    budget: int,
    force: Any,
    friction: Any,
    solve: Any,
) -> None:
    """Run a penalty law, start after start, until the end, an ending, full contact storage or so many steps.

    States, shape (start,), and motions, shape (start, q or v, coordinate), take the place of the run's own.
    Call it again to go on: they and the records hold all that there is, however often a run is cut.
    """
    law = Law(force, friction, solve, parameters, None)
    run_compliant(run, states, motions, records, law, budget)


@kernel
def advance_rigid(
    run: Run,
    states: Any,
    motions: Array,
    records: Records,
    parameters: Array,
    budget: int,
    force: Any,
    friction: Any,
    solve: Any,
) -> None:
    """Run a multiplier law, see `advance_compliant`."""
    law = Law(force, friction, solve, parameters, None)
    _run_rigid(run, states, motions, records, law, budget)


@kernel
def advance_compliant_with_memory(
    run: Run,
    states: Any,
    motions: Array,
    records: Records,
    parameters: Array,
    row: Array,
    budget: int,
    force: Any,
    friction: Any,
    solve: Any,
    rate: Any,
    guard: Any,
    jumps: Any,
    limits: Any,
    moment: Any,
) -> None:
    """Run a penalty law that is not plain, see `advance_compliant`."""
    memory = Memory(rate, guard, jumps, limits, moment, parameters, row)
    law = Law(force, friction, solve, parameters, memory)
    run_compliant(run, states, motions, records, law, budget)


@kernel
def advance_rigid_with_memory(
    run: Run,
    states: Any,
    motions: Array,
    records: Records,
    parameters: Array,
    row: Array,
    budget: int,
    force: Any,
    friction: Any,
    solve: Any,
    rate: Any,
    guard: Any,
    jumps: Any,
    limits: Any,
    moment: Any,
) -> None:
    """Run a multiplier law that is not plain, see `advance_compliant`."""
    memory = Memory(rate, guard, jumps, limits, moment, parameters, row)
    law = Law(force, friction, solve, parameters, memory)
    _run_rigid(run, states, motions, records, law, budget)


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
def _opens_step(run: Run, law: Law) -> bool:
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
        _open_contact(run, law)
        if state.compliant != 0:
            press(run, law, law.memory)
    begin(run)
    return True


@inner_kernel
def _act(run: Run, law: Law, ends: Array, event: int) -> None:
    """Open, close or switch the contact after the event of a committed step."""
    state = run.state
    if event == TOUCH:
        _forget(run, law)
        _open_contact(run, law)
    elif event in (REVERSAL, CONE):
        switch_friction(state, event)
        jump(run, law, law.memory, AT_STICK if event == REVERSAL else AT_SLIP)
    elif event == GUARD:
        if jump_at_guard(run, law):
            switch_friction(state, REVERSAL)
        # No polynomial goes on over a jump.
        state.level_before = state.level + 1
        count_event(state)
    elif event == RELEASE:
        _note_memory(state, ends)
        jump(run, law, law.memory, AT_RELEASE)
        state.contact.separation_velocity = contact_at(run.plant, START)[1]
        if _is_contact(run):
            run.step.contacts[state.stored] = state.contact
            state.stored += 1
        else:
            # Round-off alone tells a graze from a miss.
            state.touchdowns -= 1
            if state.stored > 0:
                run.step.contacts[state.stored - 1].energy_loss += state.contact.energy_loss
        state.mode, state.phase = FREE, RELEASED
        state.level = run.propagator.rule.fresh_level
        _forget(run, law)
    elif state.switched != 0:
        jump(run, law, law.memory, state.switched)
        state.switched = 0
    elif state.mode == FREE:
        _forget(run, law)


@inner_kernel
def _forget(run: Run, law: Law) -> None:
    """Set where the next contact begins; the friction's variable is reset with the others of a contact."""
    state = run.state
    leave(run, law, law.memory)
    if state.kept == 0 and state.lasts == 0:
        state.internal = state.first_internal


@inner_kernel
def _is_contact(run: Run) -> bool:
    """Tell whether what ends here was a contact: it took time, and more than none if it gave no impulse.

    A tip that starts on the rotor at rest, or grazes it, may touch by round-off for a moment that is
    shorter than any step is taken for: it leaves as it came, and nothing was exchanged.
    """
    contact, rule = run.state.contact, run.propagator.rule
    if contact.normal_impulse != 0.0 or contact.friction_impulse != 0.0:
        return bool(contact.duration > 0.0)
    return bool(contact.duration >= CRAWL * step_length(run.propagator, rule.contact_level))


@inner_kernel
def _note_memory(state: Any, ends: Array) -> None:
    """Keep the internal variables at the end of a contact with its row."""
    own = ends.shape[1] - state.variables
    for k in range(ends.shape[1]):
        ends[state.stored, k] = state.memory[k - own] if k >= own else state.internal


@inner_kernel
def _open_contact(run: Run, law: Law) -> None:
    """Start a contact at the present state, some levels below that of the contact step."""
    state, contact = run.state, run.state.contact
    _, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    contact.start_time, contact.approach_velocity, contact.separation_velocity = (state.time, rate, 0.0)
    contact.duration, contact.stick_duration, contact.energy_loss = 0.0, 0.0, 0.0
    contact.normal_impulse, contact.friction_impulse = 0.0, 0.0
    contact.peak_normal_force, contact.max_penetration = 0.0, 0.0
    state.normal_before, state.friction_before = 0.0, 0.0
    state.phase, state.impact_speed = TOUCHING, max(-rate, 0.0)
    state.mode = SLIP if slip != 0.0 or state.friction_kind == RATE_DEPENDENT else STICK
    state.sign = 1 if slip > 0.0 else -1
    state.level = run.propagator.rule.contact_level + state.compliant * TOUCH_REFINEMENT
    state.touchdowns += 1
    count_event(state)
    jump(run, law, law.memory, AT_TOUCH)
