"""The hybrid loop: a phase proposes a step, the step is committed, and its event opens the next phase."""

from contactlab.arrays import Array
from contactlab.compiled import kernel, part_kernel
from contactlab.engine.balance import weigh
from contactlab.engine.compliant_contact import press
from contactlab.engine.compliant_events import switch_friction
from contactlab.engine.contacts import close_contact, open_contact
from contactlab.engine.events import NOTHING, RELEASE, TOUCH
from contactlab.engine.flight import fly
from contactlab.engine.plant import Plant
from contactlab.engine.rigid_contact import hold_contact
from contactlab.engine.run import (
    END,
    ENDING,
    NOT_FINITE,
    PHASE,
    PRESSED,
    RUNNING,
    STORED,
    TIME,
    TOUCHING,
    UNSOLVED,
    Run,
    commit,
)
from contactlab.engine.step import FLIGHT, KIND, TAKEN, Step, begin, is_finite
from contactlab.engine.tables import Tables
from contactlab.laws.base import FrictionKernel, MultiplierKernel, PenaltyKernel

TOUCH_REFINEMENT = 6
"""Levels below the contact step at which a compliant contact begins: the force starts as a power of time."""


@kernel
def advance(
    plant: Plant,
    tables: Tables,
    step: Step,
    run: Run,
    force: PenaltyKernel,
    rub: FrictionKernel,
    solve: MultiplierKernel,
    compliant: bool,
    parameters: Array,
    budget: int,
) -> None:
    """Run until the end, an ending, full contact storage or a number of steps; call again to go on.

    Args:
        plant, tables, step, run: the motor and the memory of its run; they hold all of the state,
            so that it does not matter into how many calls a run is cut.
        force: kernel of a penalty law, used where `compliant`.
        rub: its friction where that is not set-valued.
        solve: kernel of a multiplier law, used otherwise.
        compliant: the law's family.
        parameters: the law's parameters.
        budget: number of steps.
    """
    for _ in range(budget):
        if run.real[TIME] >= run.real[END] or run.whole[ENDING] != RUNNING:
            return
        if run.whole[STORED] >= run.contacts.shape[0] - 1:
            return
        refinement = TOUCH_REFINEMENT if compliant else 0
        if run.whole[PHASE] == PRESSED:
            open_contact(plant, step, run, tables.contact_level + refinement)
        begin(plant, step, run.real[TIME])
        if run.whole[PHASE] != TOUCHING:
            event = fly(plant, tables, step, run)
        else:
            event = _touch(plant, tables, step, run, force, rub, solve, compliant, parameters)
        commit(plant, tables, step, run, force, rub, parameters)
        weigh(plant, step, run)
        if event == TOUCH:
            open_contact(plant, step, run, tables.contact_level + refinement)
        elif event == RELEASE:
            close_contact(plant, tables, step, run)
        elif event != NOTHING:
            switch_friction(step, run, event)


@part_kernel
def _touch(
    plant: Plant,
    tables: Tables,
    step: Step,
    run: Run,
    force: PenaltyKernel,
    rub: FrictionKernel,
    solve: MultiplierKernel,
    compliant: bool,
    parameters: Array,
) -> int:
    """Take a step that `begin` made ready through contact; returns the event that ends it."""
    if compliant:
        event = press(plant, tables, step, run, force, rub, parameters)
    else:
        event = hold_contact(plant, tables, step, run, solve, parameters)
    if run.whole[ENDING] == RUNNING and not is_finite(step):
        run.whole[ENDING] = NOT_FINITE
    if run.whole[ENDING] in (NOT_FINITE, UNSOLVED):
        # The state stays as it is, so that it can be told what the law was asked.
        step.whole[KIND] = FLIGHT
        step.real[TAKEN] = 0.0
        return NOTHING
    return event
