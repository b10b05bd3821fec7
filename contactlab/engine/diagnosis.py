"""Why a law stops a run: an answer that is no number, or a force that changes at once.

Asked after the run has ended, at the state it ended in, so that a run that goes on pays nothing for it.
"""

from collections.abc import Iterator
from typing import Any, Final, NamedTuple, final

import numpy as np

from contactlab.arrays import Array
from contactlab.engine.plant import Plant
from contactlab.engine.run import MOMENTUM, Run
from contactlab.engine.step import CLOSING, FRICTION, MEMORY, MODE, NORMAL, RUBBING, Step
from contactlab.laws.base import SET_VALUED, STICK
from contactlab.motor.geometry import contact_frame

PROBES: Final = 65
"""States at which a law is asked along the way of a step."""

STEEP: Final = 0.01
"""Change of a force over its size that counts as one."""

NARROW: Final = 10.0 ** np.arange(-15.0, -6.0)
"""Changes of gap, gap rate or slip over their own size that should not change a force by as much."""


@final
class State(NamedTuple):
    """What a law is asked about: gap [m], gap rate [m/s] and slip [m/s]."""

    gap: float
    gap_rate: float
    slip: float

    def __str__(self) -> str:
        return (
            f"a gap of {self.gap:.6g} m, a gap rate of {self.gap_rate:.6g} m/s and a slip of "
            f"{self.slip:.6g} m/s"
        )


@final
class Witness:
    """A law where its run ended.

    Args:
        plant, step, run: the motor and the memory of its run.
        reach: way of a step in contact along which the law is asked [s].
        compliant: the law's family.
        kernels, parameters: the law's, see `kernels_of`.
    """

    def __init__(
        self,
        plant: Plant,
        step: Step,
        run: Run,
        reach: float,
        compliant: bool,
        kernels: tuple[Any, ...],
        parameters: Array,
    ) -> None:
        self._plant = plant
        self._step = step
        self._run = run
        self._reach = reach
        self._compliant = compliant
        self._force, self._rub = kernels[:2]
        self._parameters = parameters

    def not_finite(self) -> str:
        """The first answer on the way of the step that cannot be, in words; empty where all can."""
        if not self._compliant:
            return self._impulses()
        for time in np.linspace(0.0, self._reach, PROBES):
            state = self._state(float(time))
            for name, value in self._answers(state):
                if not np.isfinite(value) or (name == "friction bound" and value < 0.0):
                    return f"{name} {value} at {state}"
        return ""

    def unknown(self) -> str:
        """Where an answer was no number, if the way of the step does not tell which."""
        return f"a value that is not finite near {self._state(0.0)}"

    def _impulses(self) -> str:
        """The impulses of a rigid law that are no numbers, in words."""
        names = {"normal impulse": NORMAL, "friction impulse": FRICTION}
        found = [
            f"{name} {self._step.force[row, 0]}"
            for name, row in names.items()
            if not np.isfinite(self._step.force[row, 0])
        ]
        return f"{' and '.join(found)} at {self._state(0.0)}" if found else ""

    def jump(self) -> str:
        """Where the law's force changes at once, in words; empty where it does not."""
        here = self._state(0.0)
        if not self._compliant:
            return ""
        if not here.gap < 0.0:
            here = self._state(self._reach)
        known = dict(self._answers(here))
        size = max(abs(known.get("normal force", 0.0)), self._run.real[MOMENTUM] / self._reach)
        speed = max(abs(here.gap_rate), self._step.real[CLOSING])
        sizes = State(abs(here.gap), speed, max(abs(here.slip), speed))
        for narrow in NARROW:
            for place, name in enumerate(("gap", "gap rate", "slip")):
                for sign in (-1.0, 1.0):
                    moved = here[place] + sign * narrow * sizes[place]
                    there = here._replace(**{here._fields[place]: moved})
                    for force, value in self._answers(there):
                        if force in _FORCES and abs(value - known.get(force, value)) > STEEP * size:
                            unit = "m" if place == 0 else "m/s"
                            return (
                                f"{force} goes from {known[force]:.4g} N to {value:.4g} N where the "
                                f"{name} goes from {here[place]:.10g} {unit} to {moved:.10g} {unit}"
                            )
        return ""

    def _state(self, time: float) -> State:
        """The state after a time of straight motion from where the run ended [s]."""
        plant = self._plant
        q, v = self._step.q + time * self._step.v, self._step.v
        u, th = float(plant.row_u @ q), float(plant.row_th @ q)
        u_rate, th_rate = float(plant.row_u @ v), float(plant.row_th @ v)
        gap, n_u, n_th, t_u, t_th = contact_frame(
            u, th, plant.tip_length, plant.radius, plant.clearance
        )
        slip = t_u * u_rate + t_th * th_rate + float(plant.row_r @ v)
        if self._step.whole[MODE] == STICK:
            slip = 0.0
        return State(float(gap), float(n_u * u_rate + n_th * th_rate), float(slip))

    def _answers(self, state: State) -> Iterator[tuple[str, float]]:
        """What a penalty law says to a state, by name."""
        if not state.gap < 0.0:
            return
        step = self._step
        found = self._force(*state, step.real[CLOSING], self._parameters)
        yield from zip(_OF_FORCE, found, strict=True)
        if step.whole[RUBBING] != SET_VALUED:
            rubbed = self._rub(*state, found[0], step.real[MEMORY], self._parameters)
            yield from zip(_OF_RUB, rubbed, strict=True)


_OF_FORCE: Final = ("normal force", "friction bound", "stored energy", "normal loss")
_OF_RUB: Final = (
    "friction",
    "rate of the friction's memory",
    "stored energy of the friction",
    "tangential stiffness",
)
_FORCES: Final = ("normal force", "friction bound", "friction")
