"""How a run ended, in a sentence: the value, the bound and the way out.

Asked after the run has ended, at the state it ended in, so that a run that goes on pays nothing for it.
"""

from collections.abc import Iterator
from typing import Any, Final, NamedTuple, final

import numpy as np

from contactlab.arrays import Array
from contactlab.energy import LEDGER_LIMIT, SCALE
from contactlab.engine.flight import MOST_HALVINGS
from contactlab.engine.kinematics import Run, contact_from
from contactlab.engine.ledger import openness_of
from contactlab.engine.plant import modes_of
from contactlab.engine.recorder import IDLE_LIMIT
from contactlab.engine.state import (
    CHATTERED,
    DIVERGED,
    EVENT_LIMIT,
    INCONSISTENT,
    NOT_FINITE,
    START,
    UNFOLLOWED,
    UNSOLVED,
)
from contactlab.laws.base import SET_VALUED, STICK
from contactlab.trajectory import Ending

FARTHEST: Final = 1.0
"""Way of a tip [m] in a steady state from which on round-off, 2e-16 of it, is seen by a contact's force."""

PROBES: Final = 65
"""States at which a law is asked along the way of a step."""

STEEP: Final = 0.01
"""Change of a force over its size that counts as one."""

NARROW: Final = 10.0 ** np.arange(-15.0, -6.0)
"""Changes of gap, gap rate or slip over their own size that should not change a force by as much."""

FORCES: Final = ("normal force", "friction bound", "friction")
OF_FORCE: Final = ("normal force", "friction bound", "stored energy", "normal loss")
OF_FRICTION: Final = (
    "friction",
    "rate of the friction's memory",
    "stored energy of the friction",
    "tangential stiffness",
)


def explain(
    run: Run, kernels: tuple[Any, ...], parameters: Array, contact_step: float
) -> tuple[Ending, str]:
    """Give the ending of a run that stopped by itself, and a sentence on it; the kernels are its law's."""
    state = run.state
    time, code = f"{state.time:.6g} s", state.ending
    if code == CHATTERED:
        return Ending.CHATTERED, (
            f"The contact chatters at {time}: more than {EVENT_LIMIT} touch-downs and friction "
            f"switches within {state.window:.3g} s, or no progress. The run stops there; a "
            f"shorter contact step than {contact_step:.3g} s or another law may pass it."
        )
    if code == DIVERGED:
        return Ending.DIVERGED, (
            f"The run diverges at {time}: {_runaway(run)}. Check the drive and the law's "
            f"parameters, or shorten the contact step, {contact_step:.3g} s."
        )
    if code == UNFOLLOWED:
        return Ending.DIVERGED, (
            f"The run diverges at {time}: the tip moves too fast to be followed, {MOST_HALVINGS} halvings "
            "of one step of its flight do not tell whether it touches. Check the drive and the start."
        )
    if code == INCONSISTENT:
        return Ending.INCONSISTENT, _inconsistency(state)
    witness = _Witness(run, kernels, parameters)
    answer = witness.not_finite()
    if answer or code == NOT_FINITE:
        answer = answer or f"a value that is not finite near {witness.state_after(0.0)}"
        return Ending.DIVERGED, (
            f"The run diverges at {time}: the law answers with {answer}. It must "
            "answer every state of a contact with finite numbers and no negative friction bound; mend the "
            "law, or its parameters."
        )
    return Ending.STALLED, f"The run stalls at {time}: {_no_progress(run, witness)}"


def balanced(state: Any, series: dict[str, Array], contact_step: float) -> tuple[Ending, str]:
    """Give the ending of a run that reached its end: complete, or with an open ledger and a sentence."""
    openness = openness_of(state, float(np.abs(series["energy_residual"]).max()))
    # A ledger that is no number is not closed.
    if openness <= LEDGER_LIMIT:
        return Ending.COMPLETE, ""
    way_out = (
        "Choose a smaller solver.tolerance; if that does not close it, the energy that the law stores and "
        "loses does not fit its force."
        if state.compliant
        else f"Choose a shorter solver.contact_step than {contact_step:.3g} s."
    )
    return Ending.UNBALANCED, (
        f"The run reached its end, but its energy ledger is open by {openness:.3g} of the energy turned "
        f"over, {SCALE}; it must be at most {LEDGER_LIMIT:g}. {way_out}"
    )


def _runaway(run: Run) -> str:
    """Say in what way the state is no motor's."""
    modes, radius = modes_of(run.plant), run.plant.geometry.radius
    q, v = modes.q[:, START], modes.v[:, START]
    if not (np.isfinite(q).all() and np.isfinite(v).all()):
        return "the state is not finite"
    th = float(modes.row_th @ q)
    if abs(th) >= 1.0:
        return f"the tip leans by {th:.3g} rad, and 1 rad is the most"
    return (
        f"the tip lies {-contact_from(run.plant, q, v)[0]:.3g} m deep in the rotor, and a tenth of its "
        f"radius, {0.1 * radius:.3g} m, is the most"
    )


def _no_progress(run: Run, witness: "_Witness") -> str:
    """Say how little a run moves, what its steps are too long for, and the way out."""
    state = run.state
    pace = (
        f"more than {state.most_steps} steps in contact within {state.window:.3g} s, where a few "
        "hundred are usual"
    )
    if state.ending == UNSOLVED:
        pace = "no step in contact, however short, satisfies the law"
    elif state.idle > IDLE_LIMIT:
        pace = f"more than {IDLE_LIMIT} steps in a row hardly move the clock"
    sway = float(run.plant.tones["steady_u"].sum())
    if sway >= FARTHEST:
        return (
            f"{pace}. The steady state of the tones moves the tip by {sway:.3g} m, and a gap that is summed "
            f"from it is good to {sway * np.finfo(np.float64).eps:.3g} m only. Leave out a tone that meets a "
            "mode without stiffness so slowly."
        )
    if jump := witness.jump():
        return (
            f"{pace}. The law's {jump}: for the steps that is a jump. Let the force change over a wider "
            "range; friction that jumps with the slip is set-valued and wants no kernel of its own."
        )
    return f"{pace}. Check the law's parameters, or choose a larger solver.tolerance."


def _inconsistency(state: Any) -> str:
    """Say why a rigid contact closes and its law has no impulse for it."""
    time = float(state.time)
    friction, critical = state.friction_limit, state.critical_friction
    if friction < critical:
        return (
            f"The run ends at {time:.6g} s: the contact closes, and the law has no normal impulse that "
            "stops it. Check the law: an approach must be answered."
        )
    return (
        f"The run ends at {time:.6g} s in Painleve's paradox: the friction coefficient {friction:.6g} is "
        f"not below the critical {critical:.6g}, d_nn/|d_nt| of the contact there, so that the friction of "
        "its slip presses the bodies together more than the normal impulse parts them, and the law has no "
        "impulse that stops the approach. Lower the friction coefficient, or take a law that may stick or "
        "a compliant one."
    )


@final
class _State(NamedTuple):
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
class _Witness:
    """A law where its run ended: an answer that is no number, or a force that changes at once."""

    def __init__(self, run: Run, kernels: tuple[Any, ...], parameters: Array) -> None:
        rule = run.propagator.rule
        self._plant, self._at = run.plant, run.state
        self._reach = float(rule.longest * 0.5**rule.contact_level)
        self._force, self._friction = kernels[:2]
        self._parameters = parameters

    def not_finite(self) -> str:
        """Give the first answer on the way of the step that cannot be, in words; empty where all can."""
        at = self._at
        if not at.compliant:
            values = {
                "normal impulse": at.normal.node[0],
                "friction impulse": at.friction.node[0],
            }
            found = [f"{name} {value}" for name, value in values.items() if not np.isfinite(value)]
            return f"{' and '.join(found)} at {self.state_after(0.0)}" if found else ""
        for time in np.linspace(0.0, self._reach, PROBES):
            state = self.state_after(float(time))
            for name, value in self._answers(state):
                if not np.isfinite(value) or (name == "friction bound" and value < 0.0):
                    return f"{name} {value} at {state}"
        return ""

    def jump(self) -> str:
        """Say where the law's force changes at once, in words; empty where it does not."""
        here, at = self.state_after(0.0), self._at
        if not at.compliant:
            return ""
        if not here.gap < 0.0:
            here = self.state_after(self._reach)
        known = dict(self._answers(here))
        size = max(abs(known.get("normal force", 0.0)), at.momentum / self._reach)
        speed = max(abs(here.gap_rate), at.impact_speed)
        sizes = abs(here.gap), speed, max(abs(here.slip), speed)
        for narrow in NARROW:
            for place, name in enumerate(here._fields):
                for sign in (-1.0, 1.0):
                    moved = here[place] + sign * narrow * sizes[place]
                    for force, value in self._answers(here._replace(**{name: moved})):
                        if force in FORCES and abs(value - known.get(force, value)) > STEEP * size:
                            unit = "m" if place == 0 else "m/s"
                            return (
                                f"{force} goes from {known[force]:.4g} N to {value:.4g} N where the "
                                f"{name.replace('_', ' ')} goes from {here[place]:.10g} {unit} to "
                                f"{moved:.10g} {unit}"
                            )
        return ""

    def state_after(self, time: float) -> _State:
        """Give the state after a time of straight motion from where the run ended [s]."""
        modes = modes_of(self._plant)
        q, v = modes.q[:, START] + time * modes.v[:, START], modes.v[:, START]
        gap, rate, slip = contact_from(self._plant, q, v)
        return _State(gap, rate, 0.0 if self._at.mode == STICK else slip)

    def _answers(self, state: _State) -> Iterator[tuple[str, float]]:
        """Give what a penalty law says to a state, by name."""
        if not state.gap < 0.0:
            return
        found = self._force(*state, self._at.impact_speed, self._parameters)
        yield from zip(OF_FORCE, found, strict=True)
        if self._at.friction_kind != SET_VALUED:
            friction = self._friction(*state, found[0], self._at.internal, self._parameters)
            yield from zip(OF_FRICTION, friction, strict=True)
