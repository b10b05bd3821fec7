"""What runs need before their first step: a law taken in, a plant, step responses, a loop and a state."""

from collections import deque
from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import partial
from typing import Any, NamedTuple, final

import numpy as np

from contactlab.arrays import Array
from contactlab.engine.arguments import (
    check_kinds,
    check_numbers,
    check_rates,
    default_contact_step,
    memory_mark,
)
from contactlab.engine.binding import FORCE, LIMITS, Bound, bind, row_of
from contactlab.engine.callback import law_errors
from contactlab.engine.context import HEAD, Impacts, Records, Run
from contactlab.engine.explanation import explain
from contactlab.engine.hybrid import TOUCH_REFINEMENT
from contactlab.engine.loop import advance, prepare_loop
from contactlab.engine.plant import Plant, pace_of, plant_of
from contactlab.engine.propagator import Propagator, Workspace
from contactlab.engine.state import OPEN, PRESSED, RELEASED, STATE, STEP, TOUCHING, one
from contactlab.laws.base import ContactLaw, MultiplierLaw, PenaltyLaw
from contactlab.laws.intake import CANARIES, check_answers, check_words, guarded
from contactlab.laws.memory import ODD
from contactlab.motor.motor import Motor
from contactlab.trajectory import Ending

DEFAULT_TOLERANCE = 1e-7
"""Error of the force at a compliant step's start, as an impulse over that of the contact; the step's end
converges with nearly twice the order of this estimate."""

ON_GRID = 1e-6
"""Part of a record interval that is round-off."""

_sound: deque[object] = deque(maxlen=64)
"""What the last laws that were taken in are made of: they answered as a law must."""

_workspace = Workspace()
"""Step responses of the last motor: they hang on it and on the length of a step, not on who asks first."""

LawErrors = Callable[[], AbstractContextManager[None]]
"""Makes a context in which a law may answer, and in which what its code raises becomes a `LawError`."""


@final
class Prepared(NamedTuple):
    """A motor and a law that are ready to run: memory, kernels and the numbers of the run."""

    law: ContactLaw
    duration: float
    contact_step: float
    tolerance: float
    plant: Plant
    propagator: Propagator
    bound: Bound
    parameters: Array
    row: Array
    """The same memory as the parameters, writable."""
    errors: LawErrors

    def run_of(self, state: Any) -> Run:
        """Give the context of a run in a state."""
        run = Run(self.plant, self.propagator, state, one(STEP))
        for k, variable in enumerate(self.law.internal_variables):
            run.step["memory_first"][k] = variable.initial
            run.step["memory_lasts"][k] = variable.life == "run"
        return run

    def records(self, count: int, run: Run) -> Records:
        """Give room for so many records of a run, and for its contacts."""
        return Records.of(count, run.step["contacts"].size, len(self.law.internal_variables))

    def prepare_loop(self, run: Run, impacts: Impacts | None = None) -> None:
        """Compile the loop for a run or for impacts, or load its code."""
        motions = np.zeros(1, STATE), np.zeros((1, 2, 1)), Records.of(1, 0, 0)
        prepare_loop(self.bound, run, *motions, impacts)

    def advance(
        self,
        run: Run,
        states: Any,
        motions: Array,
        records: Records,
        budget: int,
        impacts: Impacts | None = None,
    ) -> None:
        """Let runs go on by a number of steps each, see `contactlab.engine.loop`."""
        self.prepare_loop(run, impacts)
        with self.errors():
            rows = self.parameters, self.row
            marks = budget if impacts is None else None, 1 if self.bound.kernels[2] is None else None
            advance(run, states, motions, records, impacts, *rows, *marks, *self.bound.kernels)

    def explain(self, run: Run) -> tuple[Ending, str]:
        """Return the ending of a run that stopped by itself, and a sentence on it."""
        self._recall(run.state)
        with self.errors():
            return explain(run, self.bound.kernels, self.parameters, self.contact_step)

    def begin_with(self, state: Any, memory: Array | None) -> None:
        """Set the internal variables whose life is the run, in a state in free flight that `set_up` made.

        The gap at which the next contact begins, and what the law stores until then, follow from them. None
        leaves them as they are.
        """
        if memory is None:
            return
        lasting = [i for i, each in enumerate(self.law.internal_variables) if each.life == "run"]
        for i, value in zip(lasting, memory, strict=True):
            state["memory"][i] = value
        self._recall(state)
        if lasting and self.bound.kernels[LIMITS] is not None:
            with self.errors():
                state["begins"] = float(self.bound.kernels[LIMITS](0.0, self.parameters)[0])
                if isinstance(self.law, PenaltyLaw):
                    gap = float(state["begins"])
                    state["apart"] = float(self.bound.kernels[FORCE](gap, 0.0, 0.0, 0.0, self.parameters)[3])

    def _recall(self, state: Any) -> None:
        count = len(self.law.internal_variables)
        self.row[HEAD : HEAD + count] = state["memory"][:count]

    def set_up(self, state: Any, interval: float) -> None:
        """Set clock, grid of records, ladder, pace and what the kernels know of a law beside its own.

        On another ladder than before, the next step is the first of its kind.
        """
        law, rule = self.law, self.propagator.rule
        begins, compliant = float(state["end"]), isinstance(law, PenaltyLaw)
        state["first"] = round((begins - state["origin"]) / interval)
        if abs(begins - (state["origin"] + state["first"] * interval)) > ON_GRID * interval:
            state["origin"], state["first"] = begins, 0
        state["end"], state["interval"] = begins + self.duration, interval
        state["recorded"] = state["stored"] = 0
        if (state["longest"], state["contact_level"]) != (rule.longest, rule.contact_level):
            touching = state["phase"] == TOUCHING
            refinement = TOUCH_REFINEMENT if state["compliant"] else 0
            state["level"] = rule.contact_level + refinement if touching else rule.fresh_level
            state["level_before"] = state["level"] + 1
            state["longest"], state["contact_level"] = rule.longest, rule.contact_level
        state["compliant"], state["friction_limit"] = compliant, law.friction_limit
        self._set_memory(state)
        state["coupled"] = state["moments"] = 0
        if isinstance(law, PenaltyLaw):
            state["friction_kind"], state["coupled"] = law.friction_kind, law.coupled
            state["parity"] = law.internal_variables[0].parity if law.coupled else ODD
            state["moments"] = law.moment is not None
        if isinstance(law, MultiplierLaw):
            state["projects"] = law.projects
        state["told"] = not self.bound.seen.isdisjoint(("step", "impact"))
        state["turns"] = not self.bound.seen.isdisjoint(("tilt", "spin"))
        state["limited"] = law.limits is not None
        pace = pace_of(self.plant, float(state["end"]), self.contact_step, compliant)
        state["window"], state["most_steps"] = pace
        state["tolerance"] = self.tolerance

    def _set_memory(self, state: Any) -> None:
        """Let what is remembered go on, or begin where it is another law's."""
        law = self.law
        state["variables"], state["guards"] = len(law.internal_variables), law.guards
        if state["memory_of"] != (whose := memory_mark(law)):
            state["memory_of"], state["kept"], state["left"] = whose, 0, np.inf
            state["memory"][: len(law.internal_variables)] = [one.initial for one in law.internal_variables]
        self._recall(state)
        if not state["kept"] and self.bound.kernels[LIMITS] is not None:
            with self.errors():
                state["begins"] = float(self.bound.kernels[LIMITS](0.0, self.parameters)[0])


def prepared(
    motor: Motor,
    law: ContactLaw,
    duration: float,
    interval: float,
    contact_step: float | None,
    tolerance: float | None,
) -> Prepared:
    """Make a motor and a law ready; arguments and errors as of `contactlab.engine.simulate`."""
    check_kinds(motor, law)
    law = law.on_rotor(motor.geometry.rotor_radius)
    if contact_step is None:
        contact_step = default_contact_step(motor.modes, law)
    check_numbers(law, duration, interval, contact_step, tolerance)
    parameters, row, bound, errors = take_in(law)
    plant = plant_of(motor)
    check_rates(plant, duration)
    exact = isinstance(law, MultiplierLaw)
    propagator = _workspace.propagator(plant, contact_step, duration, exact)
    tolerance = DEFAULT_TOLERANCE if tolerance is None else tolerance
    made = plant, propagator, bound, parameters, row, errors
    return Prepared(law, duration, contact_step, tolerance, *made)


def take_in(law: ContactLaw, once: bool = False) -> tuple[Array, Array, Bound, LawErrors]:
    """Return a law's row between canaries, read-only and writable, and its bound kernels.

    Its answers are looked at for every new set of parameters, or `once` for all that have the same kernels.

    Raises:
        LawError: the law contradicts itself, or its own code raised an exception, which is the cause.
    """
    with law_errors(law.name):
        check_words(law)
        parameters = row_of(law)
    bound = bind(law)
    errors = partial(law_errors, law.name, *bound.callbacks)
    friction = law.friction_kind if isinstance(law, PenaltyLaw) else None
    values = parameters.size if once else parameters.tobytes()
    made_of = bound.kernels, values, friction, tuple(law.violations)
    # Interpreted functions may have changed since.
    if bound.callbacks or made_of not in _sound:
        with errors():
            check_answers(law, parameters, *bound.kernels)
        _sound.append(made_of)
    # What the law may only read, the engine writes.
    row = guarded(parameters)
    memory: Any = row.base
    return row, memory[CANARIES:-CANARIES], bound, errors


def phase_at(gap: float, rate: float) -> int:
    """Give the phase of a motion that starts with a gap [m], over that of a touch-down, and a rate [m/s]."""
    if gap < 0.0 or (gap == 0.0 and rate < 0.0):
        return PRESSED
    return OPEN if gap > 0.0 else RELEASED


def overlap_at(gap: float, law: ContactLaw) -> str:
    """Say why a law cannot start at a gap [m]; nothing where it can."""
    if gap >= 0.0 or isinstance(law, PenaltyLaw):
        return ""
    return (
        f"The gap is {gap} m at the start; it must not be negative where the law is rigid: tip and rotor "
        "would overlap."
    )


def fresh_state() -> Any:
    """Give the state of a run at t = 0, whose phase is not set yet."""
    # A first step continues a polynomial of zeros, of some length.
    unknown = {"left": np.inf, "least_open": np.inf, "most_open": -np.inf, "initial_energy": np.nan}
    return one(STATE, length=1.0, **unknown)
