"""A motor and a law made ready to run: bound law, plant, step responses and compiled loop."""

from collections import deque
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import partial
from hashlib import sha256
from typing import Any, Final, NamedTuple, final

import numpy as np

from contactlab.arrays import Array
from contactlab.checks import ON_GRID, SMALLEST_STEP
from contactlab.engine.arguments import check_kinds, check_numbers
from contactlab.engine.binding import FORCE, FRICTION, LIMITS, Bound, bind, law_errors, row_of
from contactlab.engine.compiled_loops import loop_of
from contactlab.engine.compliant import kinked_variables
from contactlab.engine.defaults import DEFAULT_TOLERANCE, default_contact_step
from contactlab.engine.explanation import explain
from contactlab.engine.initial_state import memory_mark
from contactlab.engine.loop import TOUCH_REFINEMENT, LoopData
from contactlab.engine.plant import Plant, modes_of, pace_of, plant_of
from contactlab.engine.propagator import Propagator, Workspace, resolving_step
from contactlab.engine.state import (
    HEAD,
    NO_INSTANTS,
    NO_OUTPUTS,
    SPEED,
    STATE,
    STEP,
    TOUCHING,
    ImpactBatch,
    Read,
    Records,
    Run,
    copy_of,
    new_record,
)
from contactlab.interrupts import signals_wait
from contactlab.laws.base import SET_VALUED, ContactLaw, MultiplierLaw, PenaltyLaw, is_stepped
from contactlab.laws.consistency import CANARIES, check_declarations, check_kernels, guarded
from contactlab.laws.memory import ODD
from contactlab.laws.registry import classes_of
from contactlab.motor.motor import Motor
from contactlab.motor.outputs import output_rows
from contactlab.trajectory import Ending

SMALLEST: Final = float(np.finfo(np.float64).tiny)
"""Duration of a contact that goes on, of which nothing is counted yet [s]."""

IDLE_LIMIT: Final = 1000
"""Steps in a row that hardly move the clock, of a law without kinks between which its steps shrink."""

_loops: dict[object, Callable[..., None]] = {}
"""Loops that are compiled, by kinds of laws and the rooms for coordinates and tones."""

_sound: deque[object] = deque(maxlen=64)
"""Kernels and parameters of the last laws that passed the consistency check."""

_workspace = Workspace()
"""Step responses of the last motor: they hang on it and on the length of a step, not on who asks first."""

NO_WAVES: Final = np.zeros((0, 0))
"""The table of a drive that has no waveform."""

LawErrors = Callable[[], AbstractContextManager[None]]
"""Makes a context in which a law may answer, and in which what its code raises becomes a `LawError`."""


@final
class Prepared(NamedTuple):
    """A motor and a law that are ready to run."""

    law: ContactLaw
    duration: float
    contact_step: float
    """Longest step in contact [s]."""
    tolerance: float
    stepped: bool
    """Whether the law is rigid and stepped in time."""
    plant: Plant
    propagator: Propagator
    bound: Bound
    parameters: Array
    row: Array
    """The same memory as the parameters, writable."""
    errors: LawErrors
    waves: Array = NO_WAVES
    """The waveform's table."""
    read: Read = NO_OUTPUTS
    """What is recorded beside tip and rotor, see `contactlab.motor.outputs`."""
    signature: int = 0
    """Digest of motor, law, steps and tolerance: runs that share them go on from each other bit for bit."""
    source: tuple[Motor | None, ContactLaw | None] = (None, None)
    """Motor and law as given; the law without what follows from the rotor's radius."""

    def run_of(self, state: Any) -> Run:
        """Return the context of a run in a state, with a plant and a scratch of its own."""
        self.row[SPEED] = 0.0
        run = Run(copy_of(self.plant), self.propagator, state, new_record(STEP))
        for k, variable in enumerate(self.law.internal_variables):
            run.step["memory_first"][k] = variable.initial
            run.step["memory_lasts"][k] = variable.life == "run"
        return run

    def records(self, count: int, run: Run, instants: Array = NO_INSTANTS) -> Records:
        """Return room for so many records of a run, for its contacts and for its forces at instants."""
        contacts, variables = run.step["contacts"].size, len(self.law.internal_variables)
        return Records.of(count, contacts, variables, self.read, instants)

    def prepare_loop(self, run: Run, impacts: ImpactBatch | None = None) -> Callable[..., None]:
        """Return the loop for a run or for impacts; compile it, or load its code, where it is new."""
        compliant = isinstance(self.law, PenaltyLaw)
        shapes = run.plant["phasors"].shape, run.plant["couplings"].shape
        room = compliant, self.bound.plain, self.bound.may_raise, impacts is None, shapes
        if room not in _loops:
            # Compiled by types alone, with values that are never run.
            data = self._data(run, np.zeros(1, STATE), np.zeros((1, 2, 1)), Records.of(1, 0, 0), 0)
            _loops[room] = loop_of(self.bound, compliant, data, impacts is not None)
        return _loops[room]

    def advance(
        self,
        run: Run,
        states: Any,
        motions: Array,
        records: Records,
        budget: int,
        impacts: ImpactBatch | None = None,
    ) -> None:
        """Continue runs by a number of steps each, or work impacts off."""
        loop = self.prepare_loop(run, impacts)
        data = self._data(run, states, motions, records, budget)
        with signals_wait(), self.errors():
            loop(data, *([] if impacts is None else [impacts]), *self.bound.of_loop)

    def _data(self, run: Run, states: Any, motions: Array, records: Records, budget: int) -> LoopData:
        plant, propagator, step = (each.base for each in (run.plant, run.propagator, run.step))
        law = self.waves, self.parameters, self.row
        return LoopData(plant, propagator, step, states, motions, records, *law, budget)

    @property
    def bound_law(self) -> tuple[Array, Array, Bound, LawErrors]:
        """What `take_in` returns of the law, with a row of its own as before any contact."""
        parameters, row = _between_canaries(self.parameters)
        row[: HEAD + len(self.law.internal_variables)] = [
            0.0,
            *(v.initial for v in self.law.internal_variables),
        ]
        return parameters, row, self.bound, self.errors

    @property
    def constrained(self) -> bool:
        """Whether the law is rigid and taken in its limit of no step."""
        return isinstance(self.law, MultiplierLaw) and not self.stepped

    def explain(self, run: Run) -> tuple[Ending, str]:
        """Return the ending of a run that stopped by itself, and a sentence on it."""
        self._recall(run.state)
        with self.errors():
            return explain(run, self.bound.kernels, self.parameters, self.contact_step)

    def begin_with(self, state: Any, memory: Array | None) -> None:
        """Set the internal variables of the run, unless None, in a state from `set_up`.

        In a state from `state_in_contact` they are all of the law's.
        """
        if memory is None:
            return
        on = state["phase"] == TOUCHING or state["limits"]["remembered"] != 0
        begun = [i for i, each in enumerate(self.law.internal_variables) if on or each.life == "run"]
        for i, value in zip(begun, memory, strict=True):
            state["memory"][i] = value
        self._recall(state)
        if begun and state["phase"] != TOUCHING:
            self._part(state, True)

    def _part(self, state: Any, stores: bool) -> None:
        """Set where the next contact begins and, unless nothing is, what the law stores until then."""
        limits, kernels = state["limits"], self.bound.kernels
        limits["contact_gap"] = limits["stored_energy"] = 0.0
        if kernels[LIMITS] is not None:
            with self.errors():
                gap = limits["contact_gap"] = float(kernels[LIMITS](0.0, self.parameters)[0])
                if stores and isinstance(self.law, PenaltyLaw):
                    limits["stored_energy"] = float(kernels[FORCE](gap, 0.0, 0.0, 0.0, self.parameters)[3])

    def end_at(self, rate: float) -> float:
        """Return the gap at which a contact ends at a gap rate [m/s], of what is recalled [m]."""
        if self.bound.kernels[LIMITS] is None:
            return 0.0
        with self.errors():
            return float(self.bound.kernels[LIMITS](rate, self.parameters)[1])

    def touch(self, state: Any, contact: tuple[float, float, float]) -> None:
        """Let the contact of a state from `state_in_contact` go on, at a gap [m], gap rate and slip [m/s].

        Its row begins at the start, and what its friction has stored by then is no loss of this run.
        """
        state["sign"] = 1 if contact[2] > 0.0 else -1
        # It has begun: there is no impact.
        state["contact"]["duration"] = SMALLEST
        if isinstance(self.law, PenaltyLaw) and self.law.friction_kind != SET_VALUED:
            kernels: Any = self.bound.kernels
            with self.errors():
                normal = kernels[FORCE](*contact, float(state["impact_speed"]), self.parameters)[0]
                recovered = float(kernels[FRICTION](*contact, float(normal), self.parameters)[2])
            state["total"]["friction_loss"] = state["contact"]["energy_loss"] = recovered

    def _recall(self, state: Any) -> None:
        count = len(self.law.internal_variables)
        self.row[HEAD : HEAD + count] = state["memory"][:count]

    def set_up(self, state: Any, interval: float) -> None:
        """Initialise time, output grid, step sizes, watchdog, internal variables and law flags.

        If the step sizes changed, the step-size control is restarted.
        """
        law, rule, known, limits = self.law, self.propagator.rule, state["law"], state["limits"]
        begins, compliant = float(state["end"]), isinstance(law, PenaltyLaw)
        # Records of a run that goes on lie on the grid of the run before, if that has one there: both
        # together are those of one run.
        state["first"] = round((begins - state["origin"]) / interval)
        if abs(begins - (state["origin"] + state["first"] * interval)) > ON_GRID * interval:
            state["origin"], state["first"] = begins, 0
        state["run_start"], state["end"], state["interval"] = begins, begins + self.duration, interval
        state["record_count"] = state["contact_count"] = 0
        state["earlier_loss"] = 0.0
        known["compliant"], known["friction_limit"] = compliant, law.friction_limit
        anew = state["signature"] != self.signature
        # The first step under another motor, law or step sizes begins as after an event: there is no
        # polynomial to go on from, and no impulse that errors were relative to.
        if anew:
            touching = state["phase"] == TOUCHING
            state["level"] = (
                rule.contact_level + compliant * TOUCH_REFINEMENT if touching else rule.fresh_level
            )
            state["level_before"] = state["level"] + 1
            state["signature"], state["impulse_scale"] = self.signature, 0.0
            state["least_remainder"], state["most_remainder"] = np.inf, -np.inf
            state["initial_energy"] = np.nan
        known["variables"], known["guards"] = len(law.internal_variables), law.guards
        # Internal variables continue under the same law, and are initialised under another.
        if known["variables_mark"] != (whose := memory_mark(law)):
            known["variables_mark"], limits["remembered"], limits["release_gap"] = whose, 0, np.inf
            state["memory"][: len(law.internal_variables)] = [each.initial for each in law.internal_variables]
        self._recall(state)
        if anew and not limits["remembered"]:
            self._part(state, state["touchdowns"] > 0)
        known["coupled"] = 0
        if isinstance(law, PenaltyLaw):
            known["friction_kind"], known["coupled"] = law.friction_kind, law.coupled
            known["parity"] = law.internal_variables[0].parity if law.coupled else ODD
        if isinstance(law, MultiplierLaw):
            known["projects"], known["sticks"] = law.projects, law.sticks
            known["constrained"] = self.constrained
        known["has_limits"] = law.limits is not None
        known["stepped"] = self.stepped
        # Of a compliant law the step in contact is a bound that a healthy run may never reach.
        watched = min(self.contact_step, law.default_contact_step) if compliant else self.contact_step
        watched = min(watched, float(rule.longest) * 0.5 ** int(rule.contact_level))
        pace = pace_of(self.plant, watched, self.stepped)
        # Rebounds without an end are taken as none by a rigid law itself.
        watchdog = state["watchdog"]
        watchdog["window"] = 0.0 if self.constrained else pace[0]
        # Each variable with kinks of its own has as many events and short steps as a law without.
        kinked = kinked_variables(state)
        watchdog["most_steps"], watchdog["most_idle"] = kinked * pace[1], kinked * IDLE_LIMIT
        state["tolerance"] = self.tolerance


def prepared(
    motor: Motor,
    law: ContactLaw,
    duration: float,
    contact_step: float | None,
    tolerance: float | None,
    like: Prepared | None = None,
) -> Prepared:
    """Make a motor and a law ready; arguments and errors as of `contactlab.engine.Simulator`."""
    check_kinds(motor, law)
    shared: Any = like
    others: Any = shared.source if like else (None, None)
    other, other_law = others
    source, radius = (motor, law), motor.geometry.rotor_radius
    # Interpreted functions may have changed since.
    if law is other_law and radius == other.geometry.rotor_radius and not shared.bound.callbacks:
        law, bound_law = shared.law, shared.bound_law
    else:
        law, bound_law = law.on_rotor(radius), None
    if contact_step is None:
        contact_step = default_contact_step(motor, law, duration)
    check_numbers(law, duration, contact_step, tolerance)
    parameters, row, bound, errors = bound_law or take_in(law)
    stepped = is_stepped(law, contact_step)
    # A step follows the fastest vibration, and none may be so short that it does not move the clock.
    same = other and motor.modes is other.modes
    rate, most = motor.persisting_rate, 1.0 / (SMALLEST_STEP * duration)
    if rate > most:
        raise ValueError(
            f"The fastest mode or tone turns at {rate:.6g} rad/s; a run of {duration:.6g} s follows at most "
            f"{most:.3g} rad/s. Leave it out, or run shorter."
        )
    if contact_step is None:
        contact_step = resolving_step(rate, duration)
    tolerance = DEFAULT_TOLERANCE if tolerance is None else tolerance
    numbers = duration, contact_step, tolerance, stepped
    if (
        bound_law
        and moves_alike(motor, other)
        and (shared.duration, shared.contact_step, shared.tolerance, shared.stepped) == numbers
    ):
        return shared._replace(parameters=parameters, row=row)  # type: ignore[no-any-return]
    plant = plant_of(motor, (other, shared.plant) if other else None)
    if isinstance(law, MultiplierLaw) and plant["wave"]["led_gap"]:
        raise ValueError(
            f"{law.name} is rigid, and every mode that moves the tip towards the rotor is prescribed; a "
            "rigid contact needs one that a force moves. Take a compliant law, or leave that mode free."
        )
    propagator = _workspace.propagator(plant, contact_step, duration, stepped, rate)
    made = stepped, plant, propagator, bound, parameters, row, errors
    waveform = motor.drive.waveform
    waves = NO_WAVES if waveform is None else waveform.table()
    steps = np.array(
        [*propagator.rule[["longest", "contact_level"]].item(), contact_step, tolerance, stepped]
    )
    # Of the plant what it has, without the room for more.
    count = plant["mode_count"]
    moved = modes_of(plant), *(plant[name][:count] for name in ("phasors", "couplings"))
    moved = *moved, *(plant[name] for name in ("tones", "geometry", "wave"))
    signature = signature_of(law, *moved, parameters, waves, steps)
    read = shared.read if same and motor.drive is other.drive else output_rows(motor)
    return Prepared(law, duration, contact_step, tolerance, *made, waves, read, signature, source)


def moves_alike(motor: Motor, other: Motor) -> bool:
    """Return whether two motors differ in nothing but where they start, the rotor's velocity included."""
    same = all(
        getattr(motor, name) is getattr(other, name) for name in ("modes", "drive", "geometry", "preload")
    )
    return same and motor.rotor == replace(other.rotor, initial_velocity=motor.rotor.initial_velocity)


def signature_of(law: ContactLaw, *contents: Any) -> int:
    """Return a number that identifies the classes of a law and its parts, and arrays."""
    names = ",".join(f"{each.__module__}.{each.__qualname__}" for each in classes_of(law))
    digest = sha256(names.encode())
    for content in contents:
        # As bytes: NumPy copies records field by field.
        digest.update(np.ascontiguousarray(content).view(np.uint8).data)
    return int.from_bytes(digest.digest()[:8], "little", signed=True)


def take_in(law: ContactLaw, once: bool = False) -> tuple[Array, Array, Bound, LawErrors]:
    """Return a law's row between canaries, read-only and writable, and its bound kernels.

    Its answers are looked at for every new set of parameters, or `once` for all that have the same kernels.

    Raises:
        LawError: the law contradicts itself, or its own code raised an exception, which is the cause.
    """
    with law_errors(law.name):
        check_declarations(law)
        parameters = row_of(law)
    bound = bind(law)
    errors = partial(law_errors, law.name, *bound.callbacks)
    friction = law.friction_kind if isinstance(law, PenaltyLaw) else None
    values = parameters.size if once else parameters.tobytes()
    made_of = bound.kernels, values, friction, tuple(law.violations)
    # Interpreted functions may have changed since.
    if bound.callbacks or made_of not in _sound:
        with errors():
            check_kernels(law, parameters, *bound.kernels)
        _sound.append(made_of)
    return *_between_canaries(parameters), bound, errors


def _between_canaries(row: Array) -> tuple[Array, Array]:
    """Return a copy of a law's row that it may only read, and the same memory for the engine to write."""
    parameters = guarded(row)
    memory: Any = parameters.base
    return parameters, memory[CANARIES:-CANARIES]
