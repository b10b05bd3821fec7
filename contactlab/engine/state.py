"""The memory of the engine, by name: records that kernels and Python read and write alike.

A record is one pointer to a kernel, whatever it holds: few and cheap arguments are what lets the engine
be many small kernels that compile soon. What has a size of its own (modes, tones, levels) is an array in a
record, with room for more than most motors have, so that the code is the same for all of them.
"""

from collections.abc import Iterator
from typing import Any, Final, NamedTuple, cast, final

import numpy as np
from numpy.typing import NDArray

from contactlab.arrays import Array
from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.laws.base import Kernel
from contactlab.laws.consistency import HEAD as HEAD
from contactlab.laws.memory import MOST_VARIABLES
from contactlab.variables import BEARING, CONTACTS, IMPACTS, SERIES


def _number(value: int) -> int:
    """Return a number that is no Python int: a kernel is copied for each of those that it is called with."""
    return cast(int, np.int64(value))


NODES: Final = _number(5)
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
    made = np.zeros(1, kind)
    for name, value in values.items():
        made[name] = value
    return made[0]


FORCE: Final = record(("node", float, NODES), ("coefficient", float, NODES))
"""A force over a step: its values at the nodes and the polynomial in s/h through them."""

LEDGER: Final = record(
    real="drive_work damping_loss friction_loss contact_loss load_work normal_impulse friction_impulse"
)
"""Terms of the energy ledger [J], and impulses [N s]."""

CONTACT: Final = record(real=" ".join(variable.name for variable in (*CONTACTS, *IMPACTS)))
SAMPLE: Final = record(("contact_mode", np.int8), real=" ".join(each.name for each in (*SERIES, BEARING)))
"""A record of the series; the forces are impulses since the start until the run is read."""

STATE: Final = record(
    # Forces of the last step [N], of which the next begins its guess: friction lies within `bound` of `bias`;
    # the rate of the coupled internal variable; the contact that goes on; the ledger since t = 0.
    *((name, FORCE) for name in ("normal", "friction", "bound", "bias", "internal_rate")),
    ("contact", CONTACT),
    # That contact as the run before left it; in the run that goes on, the extremes since then.
    ("part", CONTACT),
    ("total", LEDGER),
    ("memory", float, MOST_VARIABLES),  # internal variables of the law, see `contactlab.laws.memory`
    real="time run_start end piece_end interval origin "  # [s], of run and piece of a waveform; records lie
    # at origin + (first + i) interval
    "window window_start last_event calm "  # of the stall watchdog; of the last event; longest time without
    # one [s]
    "tolerance "  # of a collocated step [1]
    "length taken momentum "  # the last step and what was taken of it [s]; impulse scale of the contact [N s]
    "impact_speed begins left apart "  # with which the contact began [m/s]; gap at which the next contact
    # begins, and at which the last one ended if below that [m]; what the law stores while apart [J]
    "earlier_loss "  # what a contact before the run has stored and the run lost [J]
    "normal_before friction_before "  # of a rigid contact [N]
    "loaded loaded_stick loaded_rate "  # of the contact until its forces ended, and gap rate there [s], [m/s]
    "held_energy "  # what a spring of the friction holds at the last record [J]
    "initial_energy least_open most_open "  # at t = 0; what the ledger's terms left so far [J]
    "turned_over "  # largest work of drive or load [J]
    "friction_limit critical_friction "  # largest |F|/N that the law allows; d_nn/|d_nt| of the last step,
    # from which on a rigid contact may have several solutions or none [1]
    "normal_force friction_force "  # mean over the last record interval [N]
    "energy_residual gap root_inertia",  # at the end [J], [m]; root of the rotor's moment of inertia
    whole="first phase mode sign "  # record of this run; ...; of the slip
    "level level_before "  # of the next step, of the one before
    "recorded stored ending events idle "  # records and contacts; in the window; steps without progress
    "most_steps steps_before "  # in contact in a window, and those taken before it
    "projects constrained compliant friction_kind parity variables coupled guards "  # of the law; whether a
    # rigid one has no step; whether the first variable is solved together with the friction
    "sticks limited "  # whether it may stick in time stepping, and has limits
    "stepped signature "  # whether it is stepped in time; see `contactlab.engine.preparation.Prepared`
    "memory_of guard switched kept " + COUNTS,  # whose the memory is; guard that falls; event of a rigid
    # contact, see `contactlab.laws.memory`; whether the last contact is not forgotten yet
)
"""All that a run goes on from, beside displacements and rates."""

STEP: Final = record(
    # Generalised forces along u and th [N, N m],
    # and along the rotor's row.
    *((name, FORCE) for name in ("push_u", "push_th", "push_r")),
    # The contact at the nodes [m, m/s, W]; `end` is the gap at which it ends; `sliding` is what must keep its
    # sign in slip: the slip, less what a spring of the friction takes of it [m/s].
    *((n, float, NODES) for n in ("gap", "gap_rate", "slip", "loss", "sliding", "end")),
    # The law's internal variables, their rates at the start, their first values, and whose life is the run.
    ("memory", float, (PLACES, MOST_VARIABLES)),
    *((n, float, MOST_VARIABLES) for n in ("memory_rate", "memory_first", "memory_lasts")),
    # The tip's motion there without contact, and the directions, of which a HELD step keeps the first.
    *((n, float, NODES) for n in ("u", "th", "u_rate", "th_rate", "rotor")),
    *((n, float, NODES) for n in ("n_u", "n_th", "t_u", "t_th")),
    ("system", float, (2 * NODES, 2 * NODES + 1)),
    # Stretches of a flight that wait to be searched, and contacts that wait to be collected.
    *((n, float, 96) for n in ("wait_time", "wait_gap", "wait_rate", "wait_limit", "wait_limit_rate")),
    ("contacts", CONTACT, 512),
    # The state before the step that reaches the end.
    ("saved", STATE, (1,)),
    # Kind of the step; whether the gap at which the next contact begins moves in flight.
    whole="kind limit_moves",
)
"""Scratch of one step."""


@part_kernel
def fit(rule: Any, force: Any) -> None:
    """Lay the polynomial through the values at the nodes."""
    for d in range(NODES):
        total = 0.0
        for m in range(NODES):
            total += force.node[m] * rule.lagrange[m, d]
        force.coefficient[d] = total


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


@inner_kernel
def largest(values: Array) -> float:
    """Return the largest of a few values."""
    most = values[0]
    for value in values:
        most = max(most, value)
    return float(most)


State = dict[str, Any]
"""A state as a value: displacements q, rates v and all of `STATE`, NumPy arrays and numbers by name.

That of a trajectory holds its end, and by names that begin with BEFORE what is another at the start of the
step that the end cut."""

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


def state_as_value(state: Any, q: Array, v: Array) -> State:
    """Return a state as a plain dict of arrays and numbers."""
    values = state.copy().view(LEAVES).item()
    return {"q": q.copy(), "v": v.copy(), **dict(zip(_names, values, strict=True))}


def state_from_value(value: State, prefix: str = "") -> tuple[Any, Array, Array]:
    """Return the state record, displacements and rates of a value, by names with a prefix where there are."""
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


@final
class Records(NamedTuple):
    """What a run writes: its series, and the internal variables at records and at the ends of contacts.

    outputs, shape (record, output, 2), are what `rows`, shape (output, mode), read of displacements and of
    velocities at the records, and of the tones by `phasors`, shape (output, 2, tone).
    """

    series: Any
    traces: Array
    ends: Array
    outputs: Array
    rows: Array
    phasors: NDArray[np.complex128]

    @classmethod
    def of(cls, records: int, contacts: int, variables: int, read: Read = NO_OUTPUTS) -> "Records":
        """Return room for so many of each."""
        traces, ends = np.zeros((records, variables)), np.zeros((contacts, variables))
        return cls(np.zeros(records, SAMPLE), traces, ends, np.zeros((records, len(read[0]), 2)), *read)
