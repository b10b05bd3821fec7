"""The hybrid loop: a phase proposes a step, it is committed, and its event opens or closes a contact."""

from typing import Any, NamedTuple, final

from contactlab.arrays import Array
from contactlab.compiler.kernels import inner_kernel
from contactlab.engine.compliant import count_event, switch_friction
from contactlab.engine.flight import RESOLUTION, step_flight
from contactlab.engine.friction import jump_at_guard
from contactlab.engine.impulses import settle
from contactlab.engine.kinematics import begin, contact_at
from contactlab.engine.memory import SLIP_ROUND_OFF, jump, leave, lose_earlier, note_release, press
from contactlab.engine.propagator import FLIGHT_DOUBLINGS, step_length
from contactlab.engine.recorder import CRAWL, commit, end_with_forces
from contactlab.engine.rootfinding import keeps_slip
from contactlab.engine.state import (
    CONE,
    FLIGHT,
    GUARD,
    PRESSED,
    RELEASE,
    RELEASED,
    REVERSAL,
    RUNNING,
    SPEED,
    START,
    TOUCH,
    TOUCHING,
    Law,
    Records,
    Run,
)
from contactlab.laws.base import FREE, RATE_DEPENDENT, SLIP, STICK
from contactlab.laws.memory import AT_RELEASE, AT_SLIP, AT_STICK, AT_TOUCH

TOUCH_REFINEMENT = 6
"""Levels below the contact step at which a compliant contact begins: the force starts as a power of time."""


@final
class LoopData(NamedTuple):
    """All that the loop reads and writes beside the kernels of a law.

    Plant, propagator and scratch of a step, each the only record of an array: of a record by itself the
    compiler would ask for a description of its fields at every call, which takes longer than the rest of it.
    States, shape (start,), motions, shape (start, q or v, coordinate), and records contain everything, so
    that another call continues the runs, by `budget` steps of each start.
    """

    plant: Any
    propagator: Any
    step: Any
    states: Any
    motions: Array
    records: Records
    waves: Array
    parameters: Array
    row: Array
    budget: int


@inner_kernel
def run_law(data: LoopData, law: Law, step_contact: Any) -> None:
    """Run a law from starts until the end, an ending, full contact storage or so many steps of each.

    `step_contact` takes a step in contact.
    """
    plant, propagator, step = data.plant[0], data.propagator[0], data.step[0]
    for i in range(data.states.size):
        run, motion, left = Run(plant, propagator, data.states[i], step), data.motions[i], data.budget
        for j in range(plant.mode_count):
            mode = plant.modes[j]
            mode.q[START], mode.v[START] = motion[0, j], motion[1, j]
        law.row[SPEED] = run.state.impact_speed
        while left > 0 and _opens_step(run, law, data.waves):
            if run.state.phase == TOUCHING:
                event = step_contact(run, law)
            elif run.state.phase == PRESSED:
                # A rigid contact from the start on: its touch-down takes no time, and what is recorded there
                # is before the impact.
                run.step.kind, run.state.accepted_length = FLIGHT, 0.0
                event = TOUCH
            else:
                event = step_flight(run, law)
            # Ledger, records and clock are those of the mode that the step was solved in; only then does the
            # event change it.
            commit(run, law, data.records)
            _act(run, law, data.records.ends, event)
            left -= 1
        for j in range(plant.mode_count):
            mode = plant.modes[j]
            motion[0, j], motion[1, j] = mode.q[START], mode.v[START]


@inner_kernel
def _opens_step(run: Run, law: Law, waves: Array) -> bool:
    """Make a step ready, and tell whether there is one to take."""
    state, step = run.state, run.step
    # A full store is emptied by the caller, which goes on from here.
    full = state.contact_count >= step.contacts.size - 1
    if state.time >= state.end or state.ending != RUNNING or full:
        return False
    if state.end - state.time <= run.propagator.rule.longest:
        # The end may cut this step: another run goes on from where it began.
        step.saved[0] = state
        for j in range(run.plant.mode_count):
            mode = run.plant.modes[j]
            mode.saved_q, mode.saved_v = mode.q[START], mode.v[START]
    if state.phase == PRESSED and state.law.constrained == 0:
        _open_contact(run, law)
        if state.law.compliant != 0:
            press(run, law, law.memory)
    ended = state.time == state.piece_end and state.mode == STICK and state.law.constrained != 0
    begin(run, waves)
    if ended and abs(contact_at(run.plant, START)[2]) > SLIP_ROUND_OFF:
        # A prescribed velocity may jump where a piece of its path ends: the contact goes on as in a new run.
        state.impulse_scale = 0.0
    if state.phase != TOUCHING or state.law.compliant != 0 or state.law.constrained != 0:
        # Beyond its end a piece says nothing; a rigid contact's step is as short as its error wants it.
        finest = run.propagator.rule.level_count - 1
        while state.level < finest and step_length(run.propagator, state.level + 1) >= (
            state.piece_end - state.time
        ):
            state.level += 1
    return True


@inner_kernel
def _act(run: Run, law: Law, ends: Array, event: int) -> None:
    """Open, close or switch the contact after the event of a committed step."""
    state = run.state
    if event == TOUCH:
        leave(run, law, law.memory)
        _open_contact(run, law)
    elif event in (REVERSAL, CONE):
        if state.law.constrained != 0:
            # What collocation left of the slip within the step must not choose the way that the slip begins.
            settle(run, state.mode == STICK)
        switch_friction(state, event)
        jump(run, law, law.memory, AT_STICK if event == REVERSAL else AT_SLIP)
    elif event == GUARD:
        if jump_at_guard(run, law):
            switch_friction(state, REVERSAL)
        # No polynomial goes on over a jump.
        state.level_before = state.level + 1
        count_event(state)
    elif event == RELEASE:
        _release(run, law, ends)
    elif state.due_event != 0:
        jump(run, law, law.memory, state.due_event)
        state.due_event = 0
    elif state.mode == FREE:
        leave(run, law, law.memory)


@inner_kernel
def _release(run: Run, law: Law, ends: Array) -> None:
    """End the contact, and store it where it was one."""
    state = run.state
    if state.law.constrained != 0 and state.contact.duration > 0.0:
        settle(run, state.mode == STICK)
    for k in range(state.law.variables):
        ends[state.contact_count, k] = state.memory[k]
    note_release(run, law, law.memory)
    jump(run, law, law.memory, AT_RELEASE)
    state.contact.separation_velocity = contact_at(run.plant, START)[1]
    if 0.0 < state.acting_time < state.contact.duration:
        end_with_forces(state)
        state.contact.separation_velocity = state.acting_end_rate
    if _is_contact(run):
        run.step.contacts[state.contact_count] = state.contact
        state.contact_count += 1
    else:
        # Round-off alone tells a graze from a miss.
        state.touchdowns -= 1
        state.total.normal_impulse -= state.contact.normal_impulse
        state.total.friction_impulse -= state.contact.friction_impulse
        lose_earlier(run, state.contact.energy_loss)
    state.mode, state.phase = FREE, RELEASED
    state.level = run.propagator.rule.fresh_level
    leave(run, law, law.memory)


@inner_kernel
def _is_contact(run: Run) -> bool:
    """Return whether what ends here was a contact, and not a touch by round-off without impulse."""
    contact, rule = run.state.contact, run.propagator.rule
    # Less deep than the digits of the gap; a contact that only pulls is not deep at all.
    if run.state.law.compliant != 0 and 0.0 < contact.max_penetration < RESOLUTION:
        return False
    if contact.normal_impulse != 0.0 or contact.friction_impulse != 0.0:
        return bool(contact.duration > 0.0 or run.state.law.constrained != 0)
    return bool(contact.duration >= CRAWL * step_length(run.propagator, rule.contact_level))


@inner_kernel
def _open_contact(run: Run, law: Law) -> None:
    """Start a contact at the present state, some levels below that of the contact step."""
    state, contact = run.state, run.state.contact
    _, rate, slip, _, _, _, _ = contact_at(run.plant, START)
    contact.start_time, contact.approach_velocity, contact.separation_velocity = (state.time, rate, 0.0)
    contact.duration, contact.stick_duration, contact.energy_loss = 0.0, 0.0, 0.0
    state.acting_time, state.acting_stick_time = 0.0, 0.0
    contact.normal_impulse, contact.friction_impulse = 0.0, 0.0
    contact.peak_normal_force, contact.max_penetration = 0.0, 0.0
    contact.peak_lasting_force, contact.largest_impact, contact.impact_energy_gain = 0.0, 0.0, 0.0
    state.normal_before, state.friction_before = 0.0, 0.0
    state.phase, state.impact_speed = TOUCHING, max(-rate, 0.0)
    law.row[SPEED] = state.impact_speed
    # A touch-down without slip begins in stick; if the bound is exceeded, its first step finds that out.
    slides = slip != 0.0 or state.law.friction_kind == RATE_DEPENDENT or keeps_slip(run)
    state.mode = SLIP if slides else STICK
    state.sign = 1 if slip > 0.0 else -1
    rule = run.propagator.rule
    state.level = rule.contact_level + state.law.compliant * TOUCH_REFINEMENT
    if state.law.constrained != 0:
        # Transients that an impact leaves are resolved as after a release, by fewer nodes.
        state.level = max(state.level, rule.fresh_level + FLIGHT_DOUBLINGS)
    state.touchdowns += 1
    count_event(state)
    jump(run, law, law.memory, AT_TOUCH)
