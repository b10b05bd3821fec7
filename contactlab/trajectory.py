"""What a simulation gives back: series, contacts, how the run ended, and when its ledger is closed."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import Any, Final, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.laws.base import ContactLaw, MultiplierLaw
from contactlab.motor.motor import ModalState, Motor
from contactlab.variables import CONTACTS, IMPACTS, INTERNAL, Variable, of_electrode
from contactlab.window import cut_to_window, joined

LEDGER_LIMIT: Final = 1e-2
"""Residual of a ledger over the energy turned over, beyond which its run is not balanced [1]."""

SCALE: Final = "max(|W_d|, |W_L|, E_0)"
"""The energy turned over, in symbols: see `openness`."""


def openness(residual: float, drive_work: float, load_work: float, start: float) -> float:
    """Return the share of the energy turned over that a ledger cannot account for [1].

        max|r| / max(max|W_d|, max|W_L|, E_0)

    What a run turns over has come in by the drive, by the load where it drives, or was there at the start
    as kinetic, strain and contact energy; losses and stored energy are where it went, so that a law that
    makes energy is not excused by its size. Arguments in joules, largest magnitudes. Zero where nothing is
    turned over and nothing is left, infinite where something is.
    """
    turned_over = max(abs(drive_work), abs(load_work), abs(start))
    if turned_over > 0.0:
        return residual / turned_over
    return 0.0 if residual == 0.0 else float("inf")


def contact_variables(law: ContactLaw) -> tuple[Variable, ...]:
    """Return the variables of contacts under a law, without its internal ones."""
    return (*CONTACTS, *IMPACTS) if isinstance(law, MultiplierLaw) else CONTACTS


class Ending(IntEnum):
    """How a run ended.

    >>> import contactlab as cl
    >>> cl.simulate(cl.build(), duration=1e-4).ending is cl.Ending.COMPLETE
    True
    >>> [ending.name.lower() for ending in cl.Ending]
    ['complete', 'diverged', 'chattered', 'interrupted', 'unbalanced', 'stalled', 'inconsistent']
    """

    COMPLETE = 0
    """It reached its end with a closed energy ledger."""
    DIVERGED = 1
    """Its state is no motor's any more, or its law answered with no number."""
    CHATTERED = 2
    """Its touch-downs and friction switches follow each other ever faster and come to no end."""
    INTERRUPTED = 3
    """Somebody stopped it; what there was is kept."""
    UNBALANCED = 4
    """It reached its end, but its energy ledger is open by more than LEDGER_LIMIT."""
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

    Times are in seconds; the records lie at `time`, the last one at the end of the run.

    Args:
        duration, contact_step: as asked for, and the largest step in contact that was used, zero of a
            rigid law in its limit of no step.
        series, contact_mode: every name of `variables.SERIES`, `variables.BEARING` and of the outputs of
            `motor.outputs`; 0 free, 1 slip and 2 stick; at every record.
        contacts: every name of `variables.CONTACTS`, of a rigid law those of `variables.IMPACTS`, a row
            each.
        ending, message: how the run ended; a run that is not complete holds what it had until then.
        final: normal coordinates of the resonator at the end.
        state: everything from which another run goes on; see `contactlab.engine.simulate`.
        part: of the first contact, where that began before the run, what lies in it: variables of a contact
            by name.
        earlier_loss: what a contact before the run had stored, and the run lost while apart [J].
        impulse_error: sum since t = 0 of the errors of all steps in contact, by which they were accepted
            [N s], without what the motion makes of them; NaN in time stepping, which has no estimate.
        instant_forces: normal force and friction [N] at the instants of `contactlab.engine.simulate`, as
            limits from the left and from the right, shape (instant, limit, force); NaN beyond the run.
        frame: stiffness [N/m], damping [N s/m] and first force [N] of a frame, see `contactlab.drive`; empty
            without one.
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
    state: Mapping[str, Any] = field(default_factory=dict)
    part: dict[str, float] = field(default_factory=dict)
    earlier_loss: float = 0.0
    impulse_error: float = float("nan")
    instant_forces: Array = field(default_factory=lambda: np.zeros((0, 2, 2)))
    frame: Mapping[str, float] = field(default_factory=dict)

    @property
    def rotor_velocity_error(self) -> float:
        """What the impulse error makes of the rotor's velocity, as friction [rad/s]."""
        return self.impulse_error * self.motor.geometry.rotor_radius / self.motor.rotor.inertia

    @property
    def contacts_within(self) -> dict[str, Array]:
        """The contacts, cut to the run, see `cut_to_window`."""
        columns = {**self.series, "time": self.time}
        return cut_to_window(columns, self.contacts, self.part)

    @property
    def lasting(self) -> tuple[str, ...]:
        """Names of the series of the law's internal variables whose life is the run."""
        return tuple(INTERNAL + each.name for each in self.law.lasting)

    @property
    def currents(self) -> Array:
        """Currents into the electrodes [A], (electrode, time); NaN where the capacitance is not known."""
        unknown = np.full(self.time.size, np.nan)
        electrodes = range(1, self.motor.modes.coupling.shape[1] + 1)
        return np.stack([self.series.get(of_electrode(e)[1].name, unknown) for e in electrodes])

    def followed_by(self, other: "Trajectory") -> "Trajectory":
        """Return the run and its continuation as one; a contact that was cut is whole in the second."""
        ended = ~np.isnan(self.contacts["separation_velocity"])
        before = {name: values[ended] for name, values in self.contacts.items()}
        before["energy_loss"][-1:] += other.earlier_loss

        def both(before: NDArray[Any], after: NDArray[Any]) -> NDArray[Any]:
            return np.concatenate((before[:-1], after))

        return replace(
            other,
            motor=self.motor,
            duration=self.duration + other.duration,
            record_interval=self.record_interval,
            time=both(self.time, other.time),
            series={name: both(values, other.series[name]) for name, values in self.series.items()},
            contact_mode=both(self.contact_mode, other.contact_mode),
            contacts={
                name: np.concatenate((values, other.contacts[name])) for name, values in before.items()
            },
            part=joined(self.part, other.part) if other.part and not ended.any() else self.part,
            earlier_loss=self.earlier_loss + (0.0 if ended.any() else other.earlier_loss),
        )

    @property
    def complete(self) -> bool:
        """Whether the run reached its end with a closed ledger."""
        return self.ending is Ending.COMPLETE
