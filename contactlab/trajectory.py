"""What a simulation gives back: recorded series, the contacts and how the run ended."""

from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.laws.base import ContactLaw
from contactlab.motor.motor import ModalState, Motor


class Ending(IntEnum):
    """How a run ended."""

    COMPLETE = 0
    DIVERGED = 1
    CHATTERED = 2
    INTERRUPTED = 3
    UNBALANCED = 4
    """It reached its end, but its energy ledger is open by more than `contactlab.energy.LEDGER_LIMIT`."""
    STALLED = 5
    """Its steps in contact became too many, or too short."""
    INCONSISTENT = 6
    """Its rigid contact closed, and the law had no impulse for it."""

    @property
    def reached_end(self) -> bool:
        """Whether the run reached its end, so that its numbers are those of the whole run."""
        return self in (Ending.COMPLETE, Ending.UNBALANCED)


@final
@dataclass(frozen=True)
class Trajectory:
    """A run in memory.

    Args:
        motor, law: what ran.
        duration: asked-for duration [s].
        contact_step: largest step in contact that was used [s].
        record_interval: time between records [s]; the last record lies at the end of the run.
        time: of the records [s], shape (time,).
        series: every name of `variables.SERIES`, shape (time,).
        contact_mode: 0 free, 1 slip, 2 stick, shape (time,).
        contacts: every name of `variables.CONTACTS`, shape (contact,).
        statistics: counts of the solver's work.
        ending: how the run ended; a run that is not complete holds what it had until then.
        message: the ending in a sentence, empty for a complete run.
        final: normal coordinates of the resonator at the end.
        state: everything from which another run goes on, arrays and numbers by name; see
            `contactlab.engine.simulate`.
    """

    motor: Motor
    law: ContactLaw
    duration: float
    contact_step: float
    record_interval: float
    time: Array
    series: dict[str, Array]
    contact_mode: NDArray[np.int8]
    contacts: dict[str, Array]
    statistics: dict[str, int]
    ending: Ending
    message: str
    final: ModalState
    state: dict[str, Any] = field(default_factory=dict)

    @property
    def complete(self) -> bool:
        """Whether the run reached its end with a closed ledger."""
        return self.ending is Ending.COMPLETE
