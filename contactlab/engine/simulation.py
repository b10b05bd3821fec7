"""Runs of a motor with a contact law: one with its trajectory, or many without records."""

from collections import deque
from collections.abc import Callable
from dataclasses import InitVar, dataclass, field
from functools import cached_property
from typing import Any, final

import numpy as np

from contactlab.arrays import Array
from contactlab.checks import ON_GRID
from contactlab.engine.arguments import check_interval
from contactlab.engine.explanation import balanced
from contactlab.engine.flight import CLEAR
from contactlab.engine.initial_state import (
    AT_REST,
    check_start,
    fresh_state,
    overlap_at,
    phase_at,
    state_in_contact,
)
from contactlab.engine.kinematics import contact_from, contacts_from
from contactlab.engine.plant import modes_of, root_inertia
from contactlab.engine.preparation import Prepared, prepared
from contactlab.engine.recorder import take_series
from contactlab.engine.state import (
    BEFORE,
    BYTES,
    CONTACT,
    COUNTS,
    NO_INSTANTS,
    PRESSED,
    RUNNING,
    SPEED,
    START,
    STATE,
    TOUCHING,
    EndState,
    Records,
    Run,
    State,
    copy_of,
    new_record,
    state_from_value,
)
from contactlab.laws.base import FREE, ContactLaw
from contactlab.motor.motor import ModalState, Motor
from contactlab.motor.outputs import output_series
from contactlab.trajectory import Ending, Trajectory, contact_variables
from contactlab.variables import EXTREMES, SUMS

STEPS_PER_CALL = 50_000
"""Steps between two looks at progress and Ctrl-C."""

_last: deque["Simulator"] = deque(maxlen=1)
"""That of the last call of `simulator_of`, with which the next one shares what is the same."""


def simulate(
    motor: Motor,
    law: ContactLaw,
    *,
    duration: float,
    record_interval: float,
    contact_step: float | None = None,
    tolerance: float | None = None,
    progress: Callable[[float], None] | None = None,
    start: State | None = None,
    memory: Array | None = None,
    contact: State | None = None,
    instants: Array = NO_INSTANTS,
) -> Trajectory:
    """Simulate a motor from its start, by default at rest; the drive is switched on at t = 0.

    Free flight is exact (the modal flow under the harmonic drive) and every touch-down is located. In contact
    a law is collocated at order 9 with error control, a multiplier law with impacts at the touch-downs; only
    where it is given a contact step is it stepped in time, at order 1. The trajectory does not depend on the
    record interval.

    A run that continues another's `Trajectory.state` is the uncut run, bit for bit, where motor, law, steps
    and tolerance are the same: a step that the cut shortened is repeated whole. Where any of them is another,
    it begins at the end of the run before, in contact or in flight as that ended. Clock, contact, ledger and
    statistics count since t = 0, and the first record is the state that it starts from. Only where nothing
    vibrates does the step length follow the duration.

    Args:
        duration: [s], positive; after the start that is continued.
        record_interval: [s], positive and at most the duration. The last record lies at the end.
        contact_step: longest step in contact of a penalty law [s], or the step of the time stepping of a
            multiplier law; None takes that of `contactlab.engine.defaults.default_contact_step`.
        tolerance: error of a collocated step [1]; None takes the default. Time stepping has none.
        progress: called with 0 once the engine is compiled, then now and then with the simulated time [s].
        memory: values at t = 0 of the law's internal variables whose life is the run, in the order of
            `law.lasting`; None takes their initial ones. A run that goes on has those of its state.
        contact: state of a run under the same law whose contact goes on at t = 0, or whose last contact is
            not forgotten yet; the motion is the motor's. The memory then has all internal variables.
        instants: times since t = 0 [s], increasing, shape (instant,), at which the trajectory has the forces
            themselves, beside their means over the record intervals.

    Raises:
        ValueError: an argument out of range, an undamped mode that a tone meets, tip and rotor that
            overlap at the start where the law is rigid, or a state that cannot go on.
        TypeError: an argument of another kind, or a law of neither family.
        LawError: the law contradicts itself, or its own code raised an exception, which is the cause.
    """
    return simulator_of(motor, law, duration, contact_step, tolerance).run(
        record_interval=record_interval,
        progress=progress,
        start=start,
        memory=memory,
        contact=contact,
        instants=instants,
    )


def simulator_of(
    motor: Motor,
    law: ContactLaw,
    duration: float,
    contact_step: float | None = None,
    tolerance: float | None = None,
) -> "Simulator":
    """Return a simulator that shares with that of the last call what is the same, see `Simulator`."""
    made = Simulator(motor, law, duration, contact_step, tolerance, _last[-1] if _last else None)
    _last.append(made)
    return made


@final
@dataclass(frozen=True, eq=False)
class Simulator:
    """A motor under a contact law made ready once, to run as often as wanted.

        >>> from contactlab.laws import HertzPenalty
        >>> from contactlab.motor.bodies import ball
        >>> simulator = Simulator(ball(1e-3, height=1e-4), HertzPenalty(), 1e-2)
        >>> first, again = (simulator.run(record_interval=1e-3) for _ in range(2))
        >>> first.series["gap"].tobytes() == again.series["gap"].tobytes()
        True

    Runs follow each other; none depends on those before.

    Args:
        motor: what moves.
        law: what acts between tip and rotor.
        duration: of each run [s], positive; after the start that is continued.
        contact_step: longest step in contact of a penalty law [s], or the step of the time stepping of a
            multiplier law; None takes that of `contactlab.engine.defaults.default_contact_step`.
        tolerance: error of a collocated step [1]; None takes the default. Time stepping has none.
        like: another simulator, with which this one shares what is the same: bound kernels and consistency
            check of the same law object, the part of the plant that modes, drive and waveform make where
            they are the same objects, and the step responses.

    Raises:
        ValueError: an argument out of range, or an undamped mode that a tone meets.
        TypeError: an argument of another kind, or a law of neither family.
        LawError: the law contradicts itself, or its own code raised an exception, which is the cause.
    """

    motor: Motor
    law: ContactLaw
    duration: float
    contact_step: float | None = None
    tolerance: float | None = None
    like: InitVar["Simulator | None"] = None
    ready: Prepared = field(init=False, repr=False)

    @np.errstate(all="ignore")
    def __post_init__(self, like: "Simulator | None") -> None:
        numbers = self.duration, self.contact_step, self.tolerance
        object.__setattr__(self, "ready", prepared(self.motor, self.law, *numbers, like and like.ready))

    # Numbers that overflow end a run, with a sentence.
    @np.errstate(all="ignore")
    def run(
        self,
        *,
        record_interval: float,
        progress: Callable[[float], None] | None = None,
        start: State | None = None,
        memory: Array | None = None,
        contact: State | None = None,
        instants: Array = NO_INSTANTS,
    ) -> Trajectory:
        """Run from a start; arguments, result and errors as of `simulate`."""
        motor, ready = self.motor, self.ready
        law, duration = ready.law, ready.duration
        check_interval(law, duration, record_interval)
        contact_step = 0.0 if ready.constrained else ready.contact_step
        state = new_record(STATE)
        states = state.base
        parted = states["contact"][:0]
        run = ready.run_of(state)
        q, v = (modes_of(run.plant)[name][:, START] for name in ("q", "v"))
        if start is None:
            states[0] = fresh_state() if contact is None else state_in_contact(contact)
            _begin(run, ready, motor, record_interval, memory)
        else:
            check_start(start, run.plant, law)
            parted = _go_on(states, run, ready, start, record_interval)
        earlier = states["contact_of_run"].copy()[0]
        for name in EXTREMES:
            state["contact_of_run"][name] = 0.0
        motions = np.stack([q, v])[None]
        # The records at 0, interval, 2 interval, ... and at the end.
        intervals = max(int(np.ceil(duration / record_interval - ON_GRID)), 1)
        records = ready.records(intervals + 1, run, instants)
        ready.prepare_loop(run)

        tell = progress or (lambda _: None)
        tell(0.0)
        finished = [_table(parted)]
        ends = [np.repeat(memory_of(state, law)[None], parted.size, axis=0)]
        contacts = _table(run.step["contacts"])

        def collect(kept: int) -> None:
            """Move all but the last finished contacts out of the run's storage."""
            kept = min(kept, state["contact_count"])
            if count := state["contact_count"] - kept:
                finished.append(contacts[:count].copy())
                ends.append(records.ends[:count].copy())
                contacts[:kept], records.ends[:kept] = contacts[count:][:kept], records.ends[count:][:kept]
                state["contact_count"] = kept

        ending, message = Ending.COMPLETE, ""
        try:
            while state.time < state.end and state.ending == RUNNING:
                ready.advance(run, states, motions, records, STEPS_PER_CALL)
                # What the last one has stored may be lost until the next.
                collect(1)
                tell(float(state.time))
        except KeyboardInterrupt:
            ending, message = Ending.INTERRUPTED, f"Interrupted at {state.time:.6g} s."
        if state.ending != RUNNING:
            ending, message = ready.explain(run)
        collect(0)
        # The contact that the end cuts, if it cuts one, has no separation.
        cut = states["contact"][: int(state.phase == TOUCHING)].copy()
        cut["separation_velocity"] = np.nan
        cut["energy_loss"] -= state.spring_energy
        finished.append(_table(cut))
        ends.append(memory_of(state, law)[None][: cut.size])
        time, series, contact_modes = take_series(run, records.series)
        series |= output_series(motor, time, records.outputs[: time.size])
        names = [f"internal_{variable.name}" for variable in law.internal_variables]
        series |= dict(zip(names, records.traces[: time.size].T.copy(), strict=True))
        if ending is Ending.COMPLETE:
            ending, message = balanced(run, series, contact_modes, contact_step)
        columns = (
            np.ascontiguousarray(np.concatenate(finished).T),
            np.ascontiguousarray(np.concatenate(ends).T),
        )
        table = dict(zip(CONTACT.names or (), columns[0], strict=True))
        table = {variable.name: table[variable.name] for variable in contact_variables(law)}
        part = _first_part(state, earlier, table)
        return Trajectory(
            motor=motor,
            law=law,
            duration=duration,
            contact_step=contact_step,
            record_interval=record_interval,
            time=time,
            series=series,
            contact_mode=contact_modes,
            contacts=table | dict(zip(names, columns[1], strict=True)),
            statistics={name: int(state[name]) for name in COUNTS.split()},
            ending=ending,
            message=message,
            final=ModalState(q[:-1].copy(), v[:-1].copy()),
            state=_state_to_go_on(run, series, ending, cut),
            part=part,
            earlier_loss=float(state["earlier_loss"]),
            impulse_error=np.nan if state["law"]["stepped"] else float(state["impulse_error"]),
            instant_forces=records.forces,
        )


def _begin(run: Run, ready: Prepared, motor: Motor, interval: float, memory: Array | None) -> None:
    """Set plant and state to the start of a motor at t = 0."""
    state, modes = run.state, modes_of(run.plant)
    q, v = modes["q"][:, START], modes["v"][:, START]
    v[-1] = -motor.rotor.initial_velocity * motor.geometry.rotor_radius / modes["row_r"][-1]
    q[:-1], v[:-1] = motor.first_motion
    contact = contact_from(run.plant, q, v)
    touches = state["phase"] == TOUCHING
    if not touches and (fault := overlap_at(contact[0], ready.law)):
        raise ValueError(fault)
    ready.set_up(state, interval)
    ready.begin_with(state, memory)
    if touches:
        ready.touch(state, contact)
    else:
        state["phase"] = phase_at(contact[0] - float(state["limits"]["contact_gap"]), contact[1])
        if motor.start is not None and motor.start.touching and contact[0] < ready.end_at(contact[1]):
            state["phase"] = PRESSED
    if contact[0] - float(state["limits"]["contact_gap"]) <= AT_REST and contact[1] <= 0.0:
        # It was at rest before: flights of round-off from there are no motion to compare others with.
        state["watchdog"]["longest_quiet"] = np.inf


def _go_on(states: Any, run: Run, ready: Prepared, start: State, interval: float) -> Any:
    """Set plant and state to the end of a run; under all the same to before the step that the end cut.

    Another rotor has the same angle and velocity, and what touches depends on gap and law. Returns the
    contact that is parted by that, if any.
    """
    modes = modes_of(run.plant)
    q, v = modes["q"][:, START], modes["v"][:, START]
    same = start["signature"] == ready.signature
    states[0], q[:], v[:] = state_from_value(start, BEFORE if same else "")
    state, none = states[0], states["contact"][:0]
    ready.set_up(state, interval)
    if same:
        # What the cut step lost stands in the run before, and is lost again.
        state["earlier_loss"] = start["limits.stored_energy"] - state["limits"]["stored_energy"]
        return none
    inertia = root_inertia(run.plant) / start["root_inertia"]
    # The rotor's coordinate is sqrt(J) alpha (eq. 1.8): with another J the same angle is another number.
    q[-1], v[-1] = inertia * q[-1], inertia * v[-1]
    gap, rate, _ = contact_from(run.plant, q, v)
    # Another clearance or geometry moves the contact: what touched may be open, and the reverse.
    moved, compliant = gap != state["gap"], state["law"]["compliant"] != 0
    if moved and (fault := overlap_at(gap, ready.law)):
        raise ValueError(fault)
    if state["phase"] == TOUCHING:
        if gap < ready.end_at(rate) if compliant else not moved:
            return none
        state["mode"], state["contact"]["separation_velocity"] = FREE, rate
        state["phase"] = phase_at(gap - float(state["limits"]["contact_gap"]), rate)
        return states["contact"].copy()
    gap -= float(state["limits"]["contact_gap"])
    if moved or (compliant and abs(gap) > CLEAR):
        state["phase"] = phase_at(gap, rate)
    return none


def _table(contacts: Any) -> Array:
    """Return records of contacts as numbers, shape (contact, variable), in their memory where it is whole."""
    numbers: Array = np.ascontiguousarray(contacts).view(np.float64)
    return numbers.reshape(-1, len(CONTACT.names or ()))


def _first_part(state: Any, earlier: Any, contacts: dict[str, Array]) -> dict[str, float]:
    """Return what lies in the run of a first contact that began before; of it `earlier` is known."""
    begun = contacts["start_time"][:1]
    if not begun.size or not begun[0] == earlier["start_time"] < state["run_start"]:
        return {}
    sums = {name: float(contacts[name][0] - earlier[name]) for name in contacts.keys() & SUMS}
    extremes = {name: float(state["contact_of_run"][name]) for name in contacts.keys() & EXTREMES}
    return {"start_time": float(state["run_start"]), "approach_velocity": np.nan, **sums, **extremes}


def memory_of(state: Any, law: ContactLaw) -> Array:
    """Return the law's internal variables in a state, shape (variable,)."""
    return np.array(state["memory"][: len(law.internal_variables)])


def _state_to_go_on(run: Run, series: dict[str, Array], ending: Ending, cut: Any) -> EndState:
    """Return the state: where the run stopped, and before the step that its end cut.

    The contact that the end cut, if it cut one, is kept as it is there.
    """
    plant, state, before = run.plant, copy_of(run.state), copy_of(run.step["saved"][0])
    forces = {
        name: series[name][-1]
        for name in ("normal_force", "friction_force", "energy_residual")
        if series[name].size
    }

    def parts() -> tuple[tuple[Any, Array, Array], tuple[Any, Array, Array]]:
        modes = modes_of(plant)
        q, v = modes["q"][:, START], modes["v"][:, START]
        earlier, saved = before, (modes["saved_q"], modes["saved_v"])
        if not ending.reached_end:
            state["end"] = state["time"]
            earlier, saved = copy_of(state), (q, v)
        # What a run under another motor needs to know of this one.
        state["gap"], state["root_inertia"] = contact_from(plant, q, v)[0], root_inertia(plant)
        for name, value in forces.items():
            state[name] = value
        state["contact_of_run"]["start_time"] = np.nan
        if cut.size:
            state["contact_of_run"] = cut[0]
        for name in ("normal_force", "friction_force", "initial_energy", "end", "contact_of_run"):
            earlier[name] = state[name]
        return (state, q, v), (earlier, *saved)

    return EndState(parts)


@final
@dataclass(frozen=True)
class Ends:
    """Where runs ended.

    Args:
        displacement, velocity: q [m kg^1/2] and qd [m s^-1 kg^1/2], shape (start, mode).
        rotor_velocity: [rad/s], shape (start,).
        memory: internal variables whose life is the run, or all of them, shape (start, variable).
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
    """Map of starts of a motor at t = 0 to their ends, the same bits as `simulate`, without records.

    Args:
        simulator: motor and law, whose duration the flow takes; the motor's own start is ignored.
        contact: as of `simulate`; starts and ends then have the same contact, and all internal variables.
    """

    simulator: Simulator
    contact: State | None = None

    def __call__(
        self,
        displacement: Array,
        velocity: Array,
        rotor_velocity: Array,
        memory: Array | None = None,
        times: int = 1,
    ) -> Ends:
        """Run the motor from starts in the form of `Ends`, for some times the duration.

        A start that overlaps the rotor of a rigid law breaks off; so does a run that ends over the residual
        indentation of its last contact, whose internal variables are not among those of the run, or in
        another contact than its start's.

        Raises:
            LawError: the law's own code raised an exception, which is the cause.
            KeyboardInterrupt: somebody pressed Ctrl-C.
        """
        ready, (run, records) = self.simulator.ready, self._scratch
        ready.row[SPEED] = 0.0
        made, radius = modes_of(run.plant), float(run.plant["geometry"]["radius"])
        row = made["row_r"][-1]
        motions = np.zeros((len(rotor_velocity), 2, made.size))
        motions[:, 0, :-1], motions[:, 1, :-1] = displacement, velocity
        motions[:, 1, -1] = -rotor_velocity * radius / row
        whole = np.repeat(self._fresh.view(BYTES), len(motions))
        states: Any = whole.view(STATE)
        states["end"] = times * ready.duration
        contacts = contacts_from(run.plant, motions[:, 0], motions[:, 1])
        if memory is not None and ready.law.internal_variables:
            for state, values in zip(states, memory, strict=True):
                ready.begin_with(state, values)
        if self._touches:
            messages = [""] * len(motions)
            for state, contact in zip(states, contacts, strict=True):
                ready.touch(state, contact)
        else:
            begins = states["limits"]["contact_gap"].tolist()
            states["phase"] = [
                phase_at(gap - begin, rate) for (gap, rate, _), begin in zip(contacts, begins, strict=True)
            ]
            messages = [overlap_at(gap, ready.law) for gap, _, _ in contacts]
        going = np.flatnonzero([not message for message in messages])
        while going.size:
            # What waits here for Ctrl-C is as long as one run's wait, however many there are.
            some, moved = whole[going].view(STATE), motions[going]
            ready.advance(run, some, moved, records, max(STEPS_PER_CALL // going.size, 1))
            some["contact_count"] = 0
            whole[going], motions[going] = some.view(BYTES), moved
            going = going[(some["time"] < some["end"]) & (some["ending"] == RUNNING)]
        # A sentence is made from the motor's state where its run ended, which the plant holds for one run at
        # a time.
        for i in np.flatnonzero(states["ending"] != RUNNING):
            made["q"][:, START], made["v"][:, START] = motions[i]
            messages[i] = ready.explain(run._replace(state=states[i]))[1]
        messages = [text or self._elsewhere(state) for text, state in zip(messages, states, strict=True)]
        lasting = [self.contact is not None or each.life == "run" for each in ready.law.internal_variables]
        remembered = np.ascontiguousarray(states["memory"][:, : len(lasting)])[:, lasting]
        broken = [bool(message) for message in messages]
        motions[broken], remembered[broken] = np.nan, np.nan
        rotor = -(row * motions[:, 1, -1]) / radius
        return Ends(motions[:, 0, :-1], motions[:, 1, :-1], rotor, remembered, tuple(messages))

    @property
    def _touches(self) -> bool:
        """Whether the starts are in contact."""
        return self.contact is not None and bool(self.contact["phase"] == TOUCHING)

    def _elsewhere(self, state: Any) -> str:
        """Return why an end has not the contact of the starts; nothing where it has."""
        touches, kept = bool(state["phase"] == TOUCHING), bool(state["limits"]["remembered"])
        if self.contact is None:
            return "The run ends over what its last contact has left of a dent." if kept > touches else ""
        if self._touches:
            count = [i for i, each in enumerate(self.simulator.law.internal_variables) if each.discrete]
            same = touches and bool(state["mode"] == self.contact["mode"])
            same = same and np.array_equal(state["memory"][count], self.contact["memory"][count])
        else:
            same = kept and not touches
        return "" if same else "The run ends in another contact than that of its start."

    @cached_property
    def _scratch(self) -> tuple[Run, Records]:
        """Plant, scratch and room for contacts of all runs, which follow each other."""
        run = self.simulator.ready.run_of(self._fresh[0])
        return run, self.simulator.ready.records(0, run)

    @cached_property
    def _fresh(self) -> Any:
        """The state of every start but for its phase, shape (1,)."""
        states = np.zeros(1, STATE)
        states[0] = fresh_state() if self.contact is None else state_in_contact(self.contact)
        self.simulator.ready.set_up(states[0], self.simulator.duration)
        return states
