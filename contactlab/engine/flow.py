"""The flow of a motor over a duration: where many starts end, without what lies between.

A run's preparation costs ten times what a period of the motor does; here it is made once, and all starts
run in one call of the compiled loop.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from contactlab.arrays import Array
from contactlab.engine.kinematics import contacts_from
from contactlab.engine.plant import modes_of
from contactlab.engine.preparation import Prepared, fresh_state, overlap_at, phase_at, prepared
from contactlab.engine.simulation import STEPS_PER_CALL, memory_of
from contactlab.engine.state import RUNNING, START, STATE, TOUCHING
from contactlab.laws.base import ContactLaw
from contactlab.motor.motor import Motor


@final
@dataclass(frozen=True)
class Ends:
    """Where runs ended.

    Args:
        displacement, velocity: q [m kg^1/2] and qd [m s^-1 kg^1/2], shape (start, mode).
        rotor_velocity: [rad/s], shape (start,).
        memory: internal variables whose life is the run, shape (start, variable).
        messages: why a run did not reach its end, whose numbers are NaN then; empty for one that did.
    """

    displacement: Array
    velocity: Array
    rotor_velocity: Array
    memory: Array
    messages: tuple[str, ...]


@final
@dataclass(frozen=True)
class Flow:
    """Takes starts of a motor at t = 0 to their ends, to the bit where `simulate` takes them.

    Nothing is recorded, and the energy ledger is not looked at.

    Args:
        motor: what moves; its own start and its rotor's mean nothing here.
        law: what acts between tip and rotor.
        duration: [s].
        contact_step, tolerance: as of `contactlab.engine.simulate`, and so are the errors.
    """

    motor: Motor
    law: ContactLaw
    duration: float
    contact_step: float | None = None
    tolerance: float | None = None

    def __call__(
        self, displacement: Array, velocity: Array, rotor_velocity: Array, memory: Array | None = None
    ) -> Ends:
        """Let the motor run from starts, given as their ends are, see `Ends`.

        A start that a rigid law refuses, because tip and rotor overlap, ends as a run that broke off does;
        so does a run that ends over the residual indentation of its last contact, whose internal variables
        are then part of the state and are not among those of the run.

        Raises:
            LawError: the law's own code raised an exception, which is the cause.
            KeyboardInterrupt: somebody pressed Ctrl-C.
        """
        ready, made = self._ready, modes_of(self._ready.plant)
        radius, row = self.motor.geometry.rotor_radius, made["row_r"][-1]
        motions = np.zeros((len(rotor_velocity), 2, made.size))
        motions[:, 0, :-1], motions[:, 1, :-1] = displacement, velocity
        motions[:, 1, -1] = -rotor_velocity * radius / row
        states: Any = np.repeat(self._fresh, len(motions))
        contacts = contacts_from(ready.plant, motions[:, 0], motions[:, 1])
        for state, values in zip(states, memory if memory is not None else (), strict=False):
            ready.begin_with(state, values)
        begins = states["begins"].tolist()
        states["phase"] = [
            phase_at(gap - begin, rate) for (gap, rate, _), begin in zip(contacts, begins, strict=True)
        ]
        messages = [overlap_at(gap, ready.law) for gap, _, _ in contacts]
        going = np.flatnonzero([not message for message in messages])
        run = ready.run_of(self._fresh[0])
        records = ready.records(0, run)
        while going.size:
            # What waits here for Ctrl-C is as long as one run's wait, however many there are.
            some, moved = states[going], motions[going]
            ready.advance(run, some, moved, records, max(STEPS_PER_CALL // going.size, 1))
            some["stored"] = 0
            states[going], motions[going] = some, moved
            going = going[(some["time"] < some["end"]) & (some["ending"] == RUNNING)]
        for i in np.flatnonzero(states["ending"] != RUNNING):
            made["q"][:, START], made["v"][:, START] = motions[i]
            messages[i] = ready.explain(ready.run_of(states[i]))[1]
        for i in np.flatnonzero((states["kept"] != 0) & (states["phase"] != TOUCHING)):
            messages[i] = messages[i] or "The run ends over what its last contact has left of a dent."
        lasting = [each.life == "run" for each in self.law.internal_variables]
        remembered = np.array([memory_of(state, ready.law)[lasting] for state in states])
        remembered = remembered.reshape(len(motions), sum(lasting))
        broken = [bool(message) for message in messages]
        motions[broken], remembered[broken] = np.nan, np.nan
        rotor = -(row * motions[:, 1, -1]) / radius
        return Ends(motions[:, 0, :-1], motions[:, 1, :-1], rotor, remembered, tuple(messages))

    @cached_property
    def _ready(self) -> Prepared:
        numbers = self.duration, self.duration, self.contact_step, self.tolerance
        return prepared(self.motor, self.law, *numbers)

    @cached_property
    def _fresh(self) -> Any:
        """The state of every start but for its phase, shape (1,)."""
        states = np.zeros(1, STATE)
        states[0] = fresh_state()
        self._ready.set_up(states[0], self.duration)
        return states
