"""Why a law stops a run: an answer that is no number, or a force that changes at once.

Asked after the run has ended, at the state it ended in, so that a run that goes on pays nothing for it.
"""

from collections.abc import Iterator
from typing import Any, Final, NamedTuple, final

import numpy as np

from contactlab.arrays import Array
from contactlab.engine.kinematics import Run, contact_from
from contactlab.engine.plant import modes_of
from contactlab.engine.state import START
from contactlab.laws.base import SET_VALUED, STICK

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
        run: the motor and its state.
        kernels, parameters: the law's, see `kernels_of`.
    """

    def __init__(self, run: Run, kernels: tuple[Any, ...], parameters: Array) -> None:
        rule = run.propagator.rule
        self._run = run
        self._state_record = run.state
        self._reach = float(rule.longest * 0.5**rule.contact_level)
        self._force, self._friction = kernels[:2]
        self._parameters = parameters

    def not_finite(self) -> str:
        """Give the first answer on the way of the step that cannot be, in words; empty where all can."""
        if not self._state_record.compliant:
            return self._impulses()
        for time in np.linspace(0.0, self._reach, PROBES):
            state = self._state(float(time))
            for name, value in self._answers(state):
                if not np.isfinite(value) or (name == "friction bound" and value < 0.0):
                    return f"{name} {value} at {state}"
        return ""

    def unknown(self) -> str:
        """Say where an answer was no number, if the way of the step does not tell which."""
        return f"a value that is not finite near {self._state(0.0)}"

    def _impulses(self) -> str:
        """Say which impulses of a rigid law are no numbers."""
        state = self._state_record
        values = {
            "normal impulse": state.normal.node[0],
            "friction impulse": state.friction.node[0],
        }
        found = [f"{name} {value}" for name, value in values.items() if not np.isfinite(value)]
        return f"{' and '.join(found)} at {self._state(0.0)}" if found else ""

    def jump(self) -> str:
        """Say where the law's force changes at once, in words; empty where it does not."""
        here = self._state(0.0)
        if not self._state_record.compliant:
            return ""
        if not here.gap < 0.0:
            here = self._state(self._reach)
        known = dict(self._answers(here))
        size = max(abs(known.get("normal force", 0.0)), self._state_record.momentum / self._reach)
        speed = max(abs(here.gap_rate), self._state_record.impact_speed)
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
        """Give the state after a time of straight motion from where the run ended [s]."""
        modes = modes_of(self._run.plant)
        q, v = modes.q[:, START] + time * modes.v[:, START], modes.v[:, START]
        gap, rate, slip = contact_from(self._run.plant, q, v)
        return State(gap, rate, 0.0 if self._state_record.mode == STICK else slip)

    def _answers(self, state: State) -> Iterator[tuple[str, float]]:
        """Give what a penalty law says to a state, by name."""
        if not state.gap < 0.0:
            return
        at = self._state_record
        found = self._force(*state, at.impact_speed, self._parameters)
        yield from zip(_OF_FORCE, found, strict=True)
        if at.friction_kind != SET_VALUED:
            friction = self._friction(*state, found[0], at.internal, self._parameters)
            yield from zip(_OF_FRICTION, friction, strict=True)


_OF_FORCE: Final = ("normal force", "friction bound", "stored energy", "normal loss")
_OF_FRICTION: Final = (
    "friction",
    "rate of the friction's memory",
    "stored energy of the friction",
    "tangential stiffness",
)
_FORCES: Final = ("normal force", "friction bound", "friction")
