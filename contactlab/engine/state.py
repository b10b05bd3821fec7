"""The memory of the engine, by name: records that kernels and Python read and write alike.

A record is one pointer to a kernel, whatever it holds: few and cheap arguments are what lets the engine
be many small kernels that compile soon. What has a size of its own (modes, tones, levels) is an array in a
record, with room for more than most motors have, so that the code is the same for all of them.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from typing import Any, Final, NamedTuple, cast, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.compiler.lanes import COUNT, WIDTH, Lanes, fill, load_all, store
from contactlab.laws.base import Kernel
from contactlab.laws.consistency import HEAD as HEAD
from contactlab.laws.memory import MOST_VARIABLES
from contactlab.variables import BEARING, CONTACTS, IMPACTS, SERIES


def _number(value: int) -> int:
    """Return a number that is no Python int: a kernel is copied for each of those that it is called with."""
    return cast(int, np.int64(value))


NODES: Final = _number(COUNT)
"""Radau IIA nodes a step: quadrature of order 9, collocation of order 9 for a smooth force."""

LAST, START, BETWEEN, RECORDED, PLACES = NODES - 1, NODES, NODES + 1, NODES + 2, NODES + 3
"""Places of a motion beside the nodes 0 ... LAST: the start of a step, a time in between, the last record."""

RELEASED, SEPARATING, OPEN, TOUCHING, PRESSED = map(_number, range(5))
"""Phases. RELEASED is the instant after a contact, SEPARATING open but not yet clear of it; PRESSED is a
start in contact, or on the point of it."""

FLIGHT, HELD, COLLOCATED = _number(-1), _number(0), NODES - 1
"""Kinds of a step: the degree of its force polynomial. FLIGHT has no force, HELD a constant one."""

WHOLE, BY_FLOW, BY_INTERVAL = map(_number, range(3))
"""How the motion at the nodes of a part of a step is known: the part is the whole step, by the flow to each
from the step's start, or by that over a record interval."""

NOTHING, TOUCH, RELEASE, REVERSAL, CONE, GUARD, PEAK = map(_number, range(7))
"""What ends a step: no event; the gap closes; the gap opens or the contact would pull; slip changes sign;
friction that sticks reaches its bound; a guard of the law falls through zero. A PEAK of the normal force ends
none."""

RUNNING, DIVERGED, UNSOLVED, CHATTERED, UNFOLLOWED, STALLED, NOT_FINITE, INCONSISTENT = range(8)
"""Endings as the kernels know them: no motor's state any more, no step that satisfies the law, too many
events, a touch-down that cannot be searched, too many steps, a law that answered with no number, and one
that has no impulse for a contact that closes."""

EVENT_LIMIT = 1000
"""Touch-downs and friction switches within one window that count as chattering."""

CALMS = 10.0
"""Longest window over the longest time without an event so far: intervals shrink where a contact chatters."""

COUNTS: Final = "flight_steps contact_steps rejected_steps sweeps touchdowns friction_switches wedged_steps"
"""Statistics of the solver's work."""


class Record(np.void):  # type: ignore[misc] # NumPy's stubs have it final
    """A record whose fields are attributes, as they are in kernels; those of `np.record` are slow."""

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except ValueError:
            raise AttributeError(name) from None

    def __setattr__(self, name: str, value: Any) -> None:
        self[name] = value


def record(*parts: object, real: str = "", whole: str = "") -> np.dtype[Any]:
    """Declare a record: pairs or triples of NumPy, then real and whole numbers by name."""
    reals, wholes = [(n, np.float64) for n in real.split()], [(n, np.int64) for n in whole.split()]
    return np.dtype((Record, np.dtype([*parts, *reals, *wholes], align=True)))


def new_record(kind: np.dtype[Any], **values: object) -> Any:
    """Make a record, zero but for some values; its fields are attributes, as they are in kernels."""
    # NumPy makes zeros of a record field by field; of bytes, it leaves to the machine what is never touched.
    made = np.frombuffer(np.zeros(kind.itemsize, np.uint8), kind)
    for name, value in values.items():
        made[name] = value
    return made[0]


def copy_of(record: Any) -> Any:
    """Return a copy of the only record of an array, byte by byte: NumPy copies its fields one by one."""
    kind = record.dtype
    return np.frombuffer(bytearray(record.base.view(np.uint8)), kind)[0]


FORCE: Final = record(("node", float, NODES), ("coefficient", float, NODES))
"""A force over a step: its values at the nodes and the polynomial in s/h through them."""

LEDGER: Final = record(
    real="drive_work damping_loss friction_loss contact_loss load_work normal_impulse friction_impulse"
)
"""Terms of the energy ledger [J], and impulses [N s]."""

CONTACT: Final = record(real=" ".join(variable.name for variable in (*CONTACTS, *IMPACTS)))
SAMPLE: Final = record(("contact_mode", np.int8), real=" ".join(each.name for each in (*SERIES, BEARING)))
"""A record of the series; the forces are impulses since the start until the run is read."""

LAW: Final = record(
    ("friction_limit", float),  # largest |F|/N that it allows [1]
    ("compliant", int),  # whether it is a PenaltyLaw
    ("stepped", int),  # whether it is rigid and stepped in time
    ("constrained", int),  # whether it is rigid and in its limit of no step
    ("projects", int),  # see MultiplierLaw
    ("sticks", int),  # see MultiplierLaw
    ("friction_kind", int),  # SET_VALUED, ELASTOPLASTIC or RATE_DEPENDENT
    ("variables", int),  # number of internal variables
    ("coupled", int),  # number of those that are solved together with the friction, 0 or 1
    ("parity", int),  # ODD or EVEN, of the coupled one
    ("variables_mark", int),  # identifies the internal variables, see `initial_state.memory_mark`
    ("guards", int),  # number of guards
    ("has_limits", int),  # whether contact begins and ends at gaps of the law's own
)
"""What the kernels of the engine know of a law."""

LIMITS: Final = record(
    ("contact_gap", float),  # gap at which the next contact begins [m]
    ("release_gap", float),  # gap at which the last contact ended, if below that of the next, else inf [m]
    ("stored_energy", float),  # energy that the law stores while the contact is open [J]
    ("remembered", int),  # whether the variables of the last contact are not reset yet
)
"""Beginning of the next contact: a residual indentation delays it."""

WATCHDOG: Final = record(
    ("window", float),  # time in which events and steps are counted [s]
    ("start", float),  # start of the present window [s]
    ("last_event", float),  # time of the last event [s]
    ("longest_quiet", float),  # longest time without an event so far [s]
    ("events", int),  # touch-downs, switches and guards in the window
    ("idle_steps", int),  # steps in a row that hardly move the clock
    ("most_steps", int),  # largest number of steps in contact in a window
    ("most_idle", int),  # largest number of steps in a row that hardly move the clock
    ("steps_before", int),  # steps in contact before the window
)
"""Stall watchdog."""

STATE: Final = record(
    ("normal", FORCE),  # normal force of the last step [N]
    ("friction", FORCE),  # friction of the last step [N], within `bound` of `bias`
    ("bound", FORCE),  # half the width of the interval of set-valued friction [N]
    ("bias", FORCE),  # middle of that interval [N]; of a rigid contact that slips the ratio F/N [1]
    ("internal_rate", FORCE),  # rate of the coupled internal variable [1/s times its unit]
    ("contact", CONTACT),  # the contact that goes on
    ("contact_of_run", CONTACT),  # its extremes since this run began
    ("total", LEDGER),  # energies and impulses since t = 0
    ("law", LAW),
    ("limits", LIMITS),
    ("watchdog", WATCHDOG),
    ("memory", float, MOST_VARIABLES),  # internal variables of the law
    ("time", float),  # [s]
    ("run_start", float),  # time at which this run began [s]
    ("end", float),  # time at which it ends [s]
    ("piece_end", float),  # end of the present piece of a waveform [s]
    ("interval", float),  # record interval [s]
    ("origin", float),  # records lie at origin + (first + i) interval [s]
    ("first", int),
    ("tolerance", float),  # error of a collocated step over the impulse of the contact [1]
    ("length", float),  # length of the last step [s]
    ("accepted_length", float),  # part of it up to its event [s]
    ("impulse_scale", float),  # impulse of the contact that errors are relative to [N s]
    ("impulse_error", float),  # sum of the errors of steps in contact since t = 0 [N s]
    ("impact_speed", float),  # approach with which the contact began [m/s]
    ("earlier_loss", float),  # energy stored by a contact before this run and lost in it [J]
    ("normal_before", float),  # normal force of the step before in time stepping [N]
    ("friction_before", float),  # friction of the step before in time stepping [N]
    ("acting_time", float),  # time in the contact until its forces end [s]
    ("acting_stick_time", float),  # part of it in stick [s]
    ("acting_end_rate", float),  # gap rate where the forces end [m/s]
    ("spring_energy", float),  # energy in a spring of the friction at the last record [J]
    ("initial_energy", float),  # energy at t = 0 [J]
    ("least_remainder", float),  # least sum of energy and ledger so far [J]
    ("most_remainder", float),  # largest sum of energy and ledger so far [J]
    ("turnover", float),  # largest work of drive or load so far [J]
    ("critical_friction", float),  # d_nn/|d_nt| of the last step, of Painleve's paradox [1]
    ("normal_force", float),  # mean over the last record interval [N]
    ("friction_force", float),  # mean over the last record interval [N]
    ("energy_residual", float),  # of the ledger at the end [J]
    ("gap", float),  # gap at the end [m]
    ("root_inertia", float),  # root of the rotor's moment of inertia [kg^0.5 m]
    ("phase", int),  # RELEASED, SEPARATING, OPEN, TOUCHING or PRESSED
    ("mode", int),  # FREE, SLIP or STICK
    ("sign", int),  # of the slip, 1 or -1
    ("level", int),  # of the next step in the hierarchy of step sizes
    ("level_before", int),  # of the last one
    ("record_count", int),  # records of this run so far
    ("contact_count", int),  # contacts that wait to be collected
    ("ending", int),  # RUNNING, or why the run has ended
    ("guard", int),  # guard that falls through zero
    ("due_event", int),  # event whose reset map a rigid contact applies after the step, else 0
    ("signature", int),  # digest of motor, law and steps, see `preparation.Prepared`
    whole=COUNTS,
)
"""All that a run goes on from, beside displacements and rates."""

STEP: Final = record(
    # Generalised forces along u and th [N, N m],
    # and along the rotor's row.
    *((name, FORCE) for name in ("push_u", "push_th", "push_r")),
    # The contact at the nodes [m, m/s, W]; `end` is the gap at which it ends; `sliding` is what must keep its
    # sign in slip: the slip, less what a spring of the friction takes of it [m/s].
    *((n, float, NODES) for n in ("gap", "gap_rate", "slip", "loss", "sliding", "end")),
    # What a compliant law receives as gap [m] and slip [m/s] there, and its answers beside the loss [N].
    *((n, float, NODES) for n in ("closed", "seen", "normal", "least", "most")),
    # The law's internal variables, their rates at the start, their first values, and whose life is the run.
    ("memory", float, (PLACES, MOST_VARIABLES)),
    *((n, float, MOST_VARIABLES) for n in ("memory_rate", "memory_first", "memory_lasts")),
    # The tip's motion there without contact, and the directions, of which a HELD step keeps the first.
    *((n, float, NODES) for n in ("u", "th", "u_rate", "th_rate", "rotor")),
    *((n, float, NODES) for n in ("n_u", "n_th", "t_u", "t_th")),
    ("system", float, (2 * NODES, 2 * WIDTH)),
    # Stretches of a flight that wait to be searched, and contacts that wait to be collected.
    *((n, float, 96) for n in ("wait_time", "wait_gap", "wait_rate", "wait_limit", "wait_limit_rate")),
    ("contacts", CONTACT, 512),
    # The state before the step that reaches the end.
    ("saved", STATE, (1,)),
    # What a whole flight adds to the ledger [J].
    real="flown_drive flown_damping flown_load",
    # Kind of the step; whether the gap at which the next contact begins moves in flight.
    whole="kind limit_moves",
)
"""Scratch of one step."""


@part_kernel
def fit(rule: Any, force: Any) -> None:
    """Lay the polynomial through the values at the nodes."""
    coefficients = fill(0.0)
    for m in range(NODES):
        coefficients = coefficients + force.node[m] * load_all(rule.lagrange[m])
    store(force.coefficient, coefficients)


@part_kernel
def hold(force: Any, value: float) -> None:
    """Make the polynomial a constant, the value of the first node."""
    force.node[0] = value
    force.coefficient[0] = value
    for d in range(1, NODES):
        force.coefficient[d] = 0.0


@inner_kernel
def value_at(force: Any, x: float) -> float:
    """Return the value of a force polynomial at x = s/h."""
    total = 0.0
    for d in range(NODES - 1, -1, -1):
        total = total * x + force.coefficient[d]
    return total


@inner_kernel
def values_at(force: Any, x: Lanes) -> Lanes:
    """Return the values of a force polynomial at x = s/h of each node."""
    total = fill(0.0)
    for d in range(NODES - 1, -1, -1):
        total = total * x + force.coefficient[d]
    return total


@part_kernel
def slope_at(force: Any, x: float) -> float:
    """Return the derivative of a force polynomial at x = s/h."""
    total = 0.0
    for d in range(NODES - 1, 0, -1):
        total = total * x + d * force.coefficient[d]
    return total


@inner_kernel
def internal_at(state: Any, x: float) -> float:
    """Return the coupled internal variable at x = s/h."""
    total = 0.0
    for d in range(NODES - 1, -1, -1):
        total = (total + state.internal_rate.coefficient[d] / (d + 1)) * x
    return float(state.memory[0] + state.length * total)


State = Mapping[str, Any]
"""A state as a value: displacements q, rates v and all of `STATE`, NumPy arrays and numbers by name.

That of a trajectory holds its end, and by names that begin with BEFORE the start of the step that the end
cut."""

BEFORE: Final = "before."


def _leaves(kind: np.dtype[Any], name: str, start: int) -> Iterator[tuple[str, Any, int]]:
    """Return dotted name, kind and offset of every field that is no record itself."""
    for field, (part, offset, *_) in (kind.fields or {}).items():
        if part.names:
            yield from _leaves(part, f"{name}{field}.", start + offset)
        else:
            yield name + field, part, start + offset


_names, _kinds, _offsets = zip(*_leaves(STATE, "", 0), strict=True)
LEAVES: Final = np.dtype(
    {"names": _names, "formats": _kinds, "offsets": _offsets, "itemsize": STATE.itemsize}
)
"""The same memory as `STATE` without records in it, those by dotted names."""

PACKED: Final = np.dtype([*zip(_names, _kinds, strict=True)])
"""The same fields, one behind the other."""

NAMES: Final = frozenset(("q", "v", *_names))
"""Names of all that a state has."""

BYTES: Final = np.dtype((np.void, STATE.itemsize))
"""The same memory without fields: NumPy copies records field by field, in a hundred times the time."""


def state_as_value(state: Any, q: Array, v: Array) -> dict[str, Any]:
    """Return a state as a plain dict of arrays and numbers."""
    values = state.view(BYTES).copy().view(LEAVES).item()
    return {"q": q.copy(), "v": v.copy(), **dict(zip(_names, values, strict=True))}


@final
class EndState(Mapping[str, Any]):
    """State in which a run ended, see `State`; made when it is read first, and taken from records then.

    Args:
        parts: returns the state, q and v at the end, and at the start of the step that the end cut; copied.
    """

    def __init__(
        self, parts: Callable[[], tuple[tuple[Any, Array, Array], tuple[Any, Array, Array]]]
    ) -> None:
        self._make: Any = parts

    @cached_property
    def _parts(self) -> dict[str, tuple[Any, Array, Array]]:
        parts = zip(("", BEFORE), self._make(), strict=True)
        # What it was made from is large.
        self._make = None
        return {
            prefix: (state.view(BYTES).copy().view(LEAVES), q.copy(), v.copy())
            for prefix, (state, q, v) in parts
        }

    def __getstate__(self) -> dict[str, Any]:
        return {"_parts": self._parts, "_make": None}

    def record(self, prefix: str) -> tuple[Any, Array, Array]:
        """Return the state record, displacements and rates at the end, or BEFORE."""
        leaves, q, v = self._parts[prefix]
        return leaves.view(STATE), q, v

    def __getitem__(self, name: str) -> Any:
        prefix = BEFORE if name.startswith(BEFORE) else ""
        leaves, q, v = self._parts[prefix]
        name = name.removeprefix(prefix)
        if name not in NAMES:
            raise KeyError(name)
        if name in ("q", "v"):
            return q if name == "q" else v
        value = leaves[name]
        return value if value.ndim else value.item()

    def __iter__(self) -> Iterator[str]:
        yield from (prefix + name for prefix in self._parts for name in ("q", "v", *_names))

    def __len__(self) -> int:
        return sum(1 for _ in self)


def state_from_value(value: State, prefix: str = "") -> tuple[Any, Array, Array]:
    """Return the state record, displacements and rates of a value, by names with a prefix where there are."""
    if isinstance(value, EndState):
        return value.record(prefix)
    values: State = {name: value.get(prefix + name, value[name]) for name in ("q", "v", *_names)}
    leaves = np.zeros(1, LEAVES)
    for name in _names:
        leaves[name] = values[name]
    return leaves.view(STATE)[0], values["q"], values["v"]


(SPEED,) = range(HEAD)
"""Places in a law's row of what the engine writes there; internal variables begin at HEAD."""


class Run(NamedTuple):
    """The context of every kernel: the motor, its step responses, the state and the scratch of a step."""

    plant: Any
    propagator: Any
    state: Any
    step: Any


class Memory(NamedTuple):
    """The kernels of a law that is not plain, see `contactlab.engine.binding`."""

    rate: Kernel
    guard: Kernel
    jump: Kernel
    limits: Kernel


class Law(NamedTuple):
    """The bound kernels of a law, None those that its family has not, and what they read.

    The engine writes to `row`, which is the same memory as `parameters`. Of a law that is plain the memory is
    None, and code that is about it is compiled to nothing: functions that take a memory ask whether it is
    None before all else.
    """

    at_nodes: Any
    force: Kernel
    friction: Kernel
    impact: Any
    bound: Any
    parameters: Array
    row: Array
    memory: Memory | None


@final
class ImpactBatch(NamedTuple):
    """Impacts to integrate, see `contactlab.engine.impact`.

    Args:
        contacts: u_n, u_t [m/s], D_nn, D_nt, D_tt [1/kg], shape (impact, 5).
        outcomes: records of `OUTCOME`, shape (impact,).
        histories: records of `MOMENT`, shape (impact, record); of no record where none is kept.
        silent: room for the records of a run that keeps no history.
    """

    contacts: Array
    outcomes: Any
    histories: Any
    silent: Any


Read = tuple[Array, NDArray[np.complex128]]
"""Rows and phasors of `Records`."""

NO_OUTPUTS: Final[Read] = np.zeros((0, 0)), np.zeros((0, 2, 0), np.complex128)

NO_INSTANTS: Final = np.zeros(0)
"""Instants of a run whose forces are recorded as means alone."""


@final
class Records(NamedTuple):
    """What a run writes: its series, and the internal variables at records and at the ends of contacts.

    outputs, shape (record, output, 2), are what `rows`, shape (output, mode), read of displacements and of
    velocities at the records, and of the tones by `phasors`, shape (output, 2, tone).

    `forces` are normal force and friction [N] at the `instants`, increasing times [s], as limits from the
    left and from the right, shape (instant, limit, force); NaN where no step lies on that side. `passed[0]`
    is the number of instants that lie behind the run.
    """

    series: Any
    traces: Array
    ends: Array
    outputs: Array
    rows: Array
    phasors: NDArray[np.complex128]
    instants: Array
    forces: Array
    passed: NDArray[np.int64]

    @classmethod
    def of(
        cls,
        records: int,
        contacts: int,
        variables: int,
        read: Read = NO_OUTPUTS,
        instants: Array = NO_INSTANTS,
    ) -> "Records":
        """Return room for so many of each."""
        traces, ends = np.zeros((records, variables)), np.zeros((contacts, variables))
        outputs, forces = np.zeros((records, len(read[0]), 2)), np.full((instants.size, 2, 2), np.nan)
        series, passed = np.zeros(records, SAMPLE), np.zeros(1, np.int64)
        return cls(series, traces, ends, outputs, *read, instants, forces, passed)
