"""A law by itself on a prescribed path: the forces that a motion brings, which it does not change.

import contactlab as cl
import numpy as np

time = np.linspace(0.0, 1e-3, 201)
rubbing = cl.Composed(friction=cl.Dahl())
loop = cl.drive(rubbing, time, gap=-1e-6, slip=1e-6 * np.sin(2e3 * np.pi * time))
loop.plot()
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import ceil, factorial
from typing import Any, Final, Self, cast, final

import numpy as np
import scipy

from contactlab.arrays import Array
from contactlab.checks import ON_GRID, check_shape, checked_arguments
from contactlab.engine.arguments import check_interval, check_law, check_tolerance
from contactlab.engine.binding import FORCE, FRICTION, SIGNATURES, row_of
from contactlab.engine.compiled_loops import path_loop_of
from contactlab.engine.equilibrium import penetrations
from contactlab.engine.memory import NUDGE
from contactlab.engine.path_contact import BY_GAP, BY_LOAD, COLUMNS, MOTION, NODAL, RIGID, Path as Walked
from contactlab.engine.preparation import take_in
from contactlab.engine.state import CHATTERED, COUNTS, HEAD, INCONSISTENT, NO_INSTANTS, NOT_FINITE, RUNNING
from contactlab.laws.base import RATE_DEPENDENT, SET_VALUED, ContactLaw, PenaltyLaw
from contactlab.laws.composed import Composed
from contactlab.motor.bodies import FLAT, led_body
from contactlab.motor.motor import ModalState, Motor
from contactlab.motor.waveform import MOST_DEGREE, Waveform
from contactlab.parameter import Parameter, not_negative, positive
from contactlab.simulation import Solution, simulate
from contactlab.trajectory import Ending, Trajectory, contact_variables
from contactlab.variables import SERIES

TOLERANCE: Final = 1e-12
"""Default error of a step's impulse, over the largest force in the longest step [1]."""

FIT_TOLERANCE: Final = 1e-8
"""Default error of a step of a path's own loop [1], well below any noise."""

EVEN: Final = 64.0
"""Longest step over the shortest piece of a path, as far as that takes no more than `MOST_STEPS`."""

MOST_STEPS: Final = 50_000
"""Longest steps of a path with pieces of many lengths."""

RECORDS: Final = 1000
"""Least number of records of a run whose interval is not given."""

DEGREE: Final = 7
"""Default degree of the spline through the samples of a path. Of a sine with 40 samples a period
viscous friction is off by 1e-7 of its largest value, by 2e-4 through a cubic one: tests/test_driving.py."""

BOUND: Final = [*SIGNATURES].index("bound")
"""Place of the kernel of a rigid law's bound."""

SPEEDS: Final = 1e-9, 10.0, 2001
"""Slip velocities at which the steepest fall of friction is looked for: least, largest [m/s], number."""

MOST_CORRECTIONS: Final = 100
"""Of Newton's method for steady sliding."""

SAME_TIME: Final = 1e-12
"""Share of a path within which two of its pieces begin at once."""

AT_EDGE: Final = 1e-5
"""Distance from an edge of a path below which an instant lies at it, over the shortest interval of them."""

AT_START: Final = 1e-4
"""Distance of the first instant from the start of its path, over that."""

FRAME: Final = {
    "frame_stiffness": positive("k", "N m-1", "of a frame that the path of slip pulls; none"),
    "frame_damping": not_negative("c", "N s m-1", "of the frame"),
    "frame_force": Parameter("", "N", "of the frame's spring at the start"),
}
"""Numbers of a frame by their names as arguments and options."""

Path = Array | Waveform | float
"""Samples at the times, a waveform of one row from the first time on, or a number."""


@checked_arguments(
    time="s",
    gap="m",
    normal="N",
    slip="m",
    velocity="m/s",
    period="s",
    frame_stiffness="N/m",
    frame_damping="N s/m",
    frame_force="N",
    duration="s",
    record_interval="s",
    tolerance="1",
)
def drive(
    law: ContactLaw,
    time: Array,
    *,
    gap: Path | None = None,
    normal: Path | None = None,
    slip: Path = 0.0,
    velocity: Path | None = None,
    degree: int = DEGREE,
    period: float | None = None,
    touching: bool = False,
    frame_stiffness: float | None = None,
    frame_damping: float = 0.0,
    frame_force: float = 0.0,
    duration: float | None = None,
    record_interval: float | None = None,
    tolerance: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> Solution:
    """Take a law along a prescribed path, and record its forces, internal variables and losses.

    The motion is the path's, exactly; of the work that it does

        drive_work = -int (N gdot + F v) dt = change of contact_energy + contact_loss + friction_loss

    up to `energy_residual`. Signs are those of a run: the gap is positive when open, and friction opposes
    the slip velocity. Where a path stands still set-valued friction keeps its last value, as no motion says
    another. A radius of the rotor that the law asks for is that of a plate.

    Behind a frame the path of slip is that of the load point x_L, as a tribometer or a rock apparatus has it,
    and there is no inertia: the slip x follows from

        k (x_L - x) + c (x_L' - x') + F = 0

    `strain_energy` and `damping_loss` are the frame's, and the contact must stay closed. Where friction falls
    faster than the frame unloads there is no such motion, and the run ends: stick-slip, which takes a mass,
    as of `contactlab.block`.

    Without a frame it is a run of a body on the path, whose contact may open. Its steps are controlled by the
    impulse of the forces, so that means, works and losses have its tolerance; behind a frame, and in
    `contactlab.driving.LawOnPath`, it is the slip and the internal variables that have it. There the force at
    an instant is as good, but not the mean over a reversal: that of `rate_and_state` would err by a hundredth
    of the largest friction.

        >>> import contactlab as cl
        >>> import numpy as np
        >>> time = np.linspace(0.0, 1.0, 401)
        >>> law = cl.HertzPenalty(stiffness=1e10, friction_coefficient=0.3)
        >>> loop = cl.drive(law, time, gap=-1e-6, slip=1e-3 * np.sin(2.0 * np.pi * time))
        >>> f"{loop['friction_loss'][-1]:.9f} J"
        '0.012000000 J'

    Args:
        law: of either family.
        time: of the samples [s], increasing, shape (sample,).
        gap: of a compliant law [m].
        normal: normal force [N], positive, in place of the gap. Of a compliant law it is that of the gaps at
            which the law has these forces at rest: damping is refused where they vary, and memory along the
            normal.
        slip: displacement along the surface [m]; its rate is the slip velocity.
        velocity: in place of slip [m/s], whose integral it is; `contactlab.driving.integrated` has its error.
        degree: of the spline through the samples: 1 joins them by lines, so that velocities jump; 3, 5 or 7
            is smooth, with an error of the fourth, sixth or eighth order in the time between samples. Corners
            and jumps take 1.
        period: after which the path repeats itself [s], see `Waveform.sampled`; None is once.
        touching: whether a first gap in the neck of an adhesive law is in it, see `ModalState`.
        frame_stiffness, frame_damping: k [N/m] and c [N s/m]; None for no frame.
        frame_force: force of the frame's spring at the start [N], which pulls along the slip. Friction that
            is no function of the slip velocity has that of its internal variables: none, as a rule.
        duration: [s]; by default from the first sample to the last, or a period.
        record_interval: [s]; by default the mean time between samples, or less for a thousand records. Forces
            are means over it, as in every run.
        tolerance: error of a step [1]; None takes 1e-12, behind a frame 1e-8.
        progress: as of `contactlab.simulate`; behind a frame called once, at the end.

    Returns:
        A run, whose `plot` draws forces over the path.

    Raises:
        TypeError, ValueError: an argument out of range, one too many or one too few.
        LawError: the law contradicts itself, or its code raised an exception.
    """
    if velocity is not None:
        if np.any(np.asarray(slip) != 0.0):
            raise ValueError("A path has slip and velocity; it must have one of them.")
        slip = integrated(time, _samples("velocity", velocity, time))[0]
    motor = driven_by(law, time, gap, normal, slip, degree, period, touching)
    length = (period or float(time[-1] - time[0])) if duration is None else duration
    if record_interval is None:
        record_interval = min(length / RECORDS, float(time[-1] - time[0]) / (time.size - 1))
    if frame_stiffness is not None or frame_damping or frame_force:
        check_interval(law, length, record_interval)
        check_tolerance(tolerance)
        intervals = max(ceil(length / record_interval - ON_GRID), 1)
        loop = LawOnPath(
            law,
            time,
            gap=gap,
            normal=normal,
            slip=slip,
            degree=degree,
            period=period,
            frame=Frame(frame_stiffness, frame_damping, frame_force),
            duration=duration,
            records=np.minimum(record_interval * np.arange(intervals + 1), length),
            tolerance=FIT_TOLERANCE if tolerance is None else tolerance,
        )
        solution = _solution(loop, law, motor, record_interval)
        if progress is not None:
            progress(float(solution["time"][-1]))
        return solution
    return simulate(
        motor,
        law,
        duration=length,
        record_interval=record_interval,
        contact_step=longest_step(motor, law),
        tolerance=TOLERANCE if tolerance is None else tolerance,
        progress=progress,
    )


def longest_step(motor: Motor, law: ContactLaw) -> float | None:
    """Return the step in contact of a compliant law [s]: no step goes beyond a piece of the path.

    Of a path with long pieces beside short ones it is short enough for both.
    """
    edges = cast(Waveform, motor.drive.waveform).pieces.x
    pieces, least = np.diff(edges), (edges[-1] - edges[0]) / MOST_STEPS
    longest = min(pieces.max(), max(EVEN * pieces.min(), least))
    return float(longest) if isinstance(law, PenaltyLaw) else None


def driven_by(
    law: ContactLaw,
    time: Array,
    gap: Path | None = None,
    normal: Path | None = None,
    slip: Path = 0.0,
    degree: int = DEGREE,
    period: float | None = None,
    touching: bool = False,
) -> Motor:
    """Return the body that takes a law along a path; arguments and errors as of `drive`."""
    first = _prescribed(law, time, gap, normal)
    compliant = isinstance(law, PenaltyLaw)
    if isinstance(law, PenaltyLaw) and normal is not None:
        first = -penetrations(law, first)
    rows = np.stack([first, _samples("slip", slip, time)])
    path = Waveform.sampled(time - time[0], rows, degree, period)
    return led_body(_cut_at(path, _reversals(path)), compliant, touching)


def _prescribed(law: ContactLaw, time: Array, gap: Path | None, normal: Path | None) -> Array:
    """Return the samples of a gap [m], or of a normal force [N], which a law may have; errors of `drive`."""
    check_law(law)
    compliant = isinstance(law, PenaltyLaw)
    if (gap is None) == (normal is None) or not (compliant or gap is None):
        wanted = (
            "a path of gap or of normal, and not of both" if compliant else "a path of normal, not of gap"
        )
        raise ValueError(f"{law.name} is {'compliant' if compliant else 'rigid'}; it must have {wanted}.")
    check_shape("time", time, (-1,), "one number a sample")
    if normal is None:
        return _samples("gap", gap, time)
    first = _samples("normal", normal, time)
    if not (first > 0.0).all():
        raise ValueError(f"normal is {first.min()} N at its least; it must be positive.")
    if isinstance(law, Composed):
        varies = bool(np.ptp(first) > 0.0)
        if (varies and law.damping.name != "none") or law.normal.internal_variables:
            raise ValueError(
                f"The normal force of {law.name} does not follow from its gap alone; give it a path of gap"
                f"{'' if law.normal.internal_variables else ', or a constant normal force'}."
            )
        if not law.normal.rises:
            raise ValueError(
                f"The normal force of {law.name} falls along a part of its depth, so that several depths may "
                "have one normal force; give it a path of gap."
            )
    return first


def _samples(name: str, path: Path | None, time: Array) -> Array:
    """Return the values of a path at its times."""
    value: Any = path.voltage(time)[0] if isinstance(path, Waveform) else path
    samples = value + np.zeros(time.shape) if np.ndim(value) == 0 else np.asarray(value)
    check_shape(name, samples, time.shape, "one number a sample")
    return samples


def integrated(time: Array, velocity: Array, error: Array | None = None) -> tuple[Array, str]:
    """Return the slip from a velocity along the surface [m], zero at first, and a sentence on its error.

    It is the integral of the cubic spline through the samples, whose error is of fourth order in their
    distance: that of every second sample errs sixteen times as much.

    Args:
        time: increasing [s], shape (time,).
        velocity: [m/s], shape (time,).
        error: its standard deviation, independent from sample to sample [m/s]; None where it is not stated.
    """
    slip = np.asarray(scipy.interpolate.CubicSpline(time, velocity).antiderivative()(time))
    coarse = scipy.interpolate.CubicSpline(time[::2], velocity[::2]).antiderivative()(time[::2])
    off = float(np.abs(coarse - slip[::2]).max())
    text = f"slip is the integral of velocity; that of every second sample differs by {off:.2g} m"
    if error is not None:
        weights = 0.5 * (np.diff(time, prepend=time[0]) + np.diff(time, append=time[-1]))
        drift = float(np.sqrt(np.sum((weights * error) ** 2)))
        text += f", and the error of velocity makes one of {drift:.2g} m at the end"
    return slip, f"{text}."


def _reversals(path: Waveform) -> Array:
    """Return the times at which the slip of a path reverses [s]: friction may have a kink there."""
    pieces: Any = path.pieces
    velocity: Any = scipy.interpolate.PPoly(pieces.c[:, :, 1], pieces.x).derivative()
    # A piece whose first velocity outweighs all that changes it has no root, which is costly to look for.
    lengths = np.diff(pieces.x) ** np.arange(len(velocity.c) - 1, 0, -1)[:, None]
    velocity.c[:-1, (np.abs(velocity.c[:-1]) * lengths).sum(axis=0) < np.abs(velocity.c[-1])] = 0.0
    turns = velocity.roots(extrapolate=False)
    return np.asarray(turns[np.isfinite(turns)])


def _cut_at(path: Waveform, times: Array) -> Waveform:
    """Let pieces of a path end at some times, and so steps."""
    pieces: Any = path.pieces
    edges = np.union1d(pieces.x, times)
    edges = edges[np.append(True, np.diff(edges) > SAME_TIME * (edges[-1] - edges[0]))]
    edges[-1] = pieces.x[-1]
    powers = [pieces(edges[:-1], order) / factorial(order) for order in range(len(pieces.c) - 1, -1, -1)]
    return Waveform(scipy.interpolate.PPoly(np.stack(powers), edges), path.periodic)


def stays_closed(law: ContactLaw, gap: Array | None) -> bool:
    """Return whether a contact is closed along a whole path of a gap, or of a normal force, which is None.

    A law with limits of its own may part, or touch, at gaps that are not zero.
    """
    return gap is None or (law.limits is None and bool(gap.max() < 0.0))


@final
@dataclass(frozen=True)
class Frame:
    """What a load point pulls a contact by; see `drive`.

    Raises:
        ValueError: a number out of range.
    """

    stiffness: float | None
    damping: float = 0.0
    force: float = 0.0

    def __post_init__(self) -> None:
        if self.stiffness is None:
            raise ValueError("A frame has a damping or a force; it must have a frame_stiffness, too.")
        for name, value in self.numbers.items():
            if not FRAME[name].admits(value):
                bound = FRAME[name].range or "finite"
                raise ValueError(f"{name} is {value:g}{FRAME[name].label}; it must be {bound}.")

    @property
    def numbers(self) -> dict[str, float]:
        """The numbers by their names in `FRAME`."""
        return {name: float(getattr(self, name.removeprefix("frame_"))) for name in FRAME}

    def changed(self, numbers: Mapping[str, float]) -> Self:
        """Return the frame with other numbers, by their names in `FRAME`."""
        return replace(self, **{name.removeprefix("frame_"): float(x) for name, x in numbers.items()})


@final
class LawOnPath:
    """A law on a path, or behind a frame, made ready once for many sets of its numbers, as by a fit.

    The contact is closed all along. Where a run has means, works and losses to its tolerance, this has forces
    at instants, in a few hundredths of the time.

    Args:
        law: whose numbers may change, and not its kind; see `stays_closed`.
        time, gap, normal, slip, degree, period: as of `drive`.
        frame: that the path pulls; None for a path of the slip itself.
        duration: [s]; None for that of the samples.
        instants: times at which forces are wanted [s], increasing, since the first sample.
        records: times at which all is recorded [s].
        tolerance: error of a step [1].

    Raises:
        TypeError, ValueError, LawError: as of `drive`.
    """

    def __init__(
        self,
        law: ContactLaw,
        time: Array,
        *,
        gap: Path | None = None,
        normal: Path | None = None,
        slip: Path = 0.0,
        degree: int = DEGREE,
        period: float | None = None,
        frame: Frame | None = None,
        duration: float | None = None,
        instants: Array = NO_INSTANTS,
        records: Array = NO_INSTANTS,
        tolerance: float = FIT_TOLERANCE,
    ) -> None:
        first = _prescribed(law, time, gap, normal)
        law, compliant = law.on_rotor(FLAT), isinstance(law, PenaltyLaw)
        if isinstance(law, PenaltyLaw) and normal is not None:
            # Refuses what presses the law too deep.
            penetrations(law, np.array([first.max()]))
        self._parameters, self._row, self._bound, self._errors = take_in(law)
        rows = np.stack([first, _samples("slip", slip, time)])
        path = Waveform.sampled(time - time[0], rows, degree, period)
        edges, pieces, breaks = _pieces_until(path, degree, duration)
        if not np.ptp(first) > 0.0:
            # Without the spline's round-off.
            pieces[:, 0, 0], pieces[:, 0, 1:] = first[0], 0.0
        if not stays_closed(law, None if gap is None else _extremes(edges, pieces)):
            raise ValueError(
                f"The gap of {law.name} opens along the path; it must be closed all along, and the law "
                "without limits of its own. Give the path a normal force, or leave out the frame."
            )
        self._fresh = np.zeros(1, MOTION)
        known = self._fresh[0]
        known["end"], known["tolerance"] = breaks[-1], tolerance
        known["prescribed"] = BY_GAP if gap is not None else BY_LOAD if compliant else RIGID
        known["friction_kind"] = law.friction_kind if isinstance(law, PenaltyLaw) else SET_VALUED
        known["variables"], known["guards"] = len(law.internal_variables), law.guards
        known["coupled"], known["load"] = law.coupled if compliant else 0, np.nan
        self._frame = frame
        units = [each.units for each in law.internal_variables]
        count = len(units)
        known["alike"][:count] = [units.index(unit) for unit in units]
        known["largest"][:count] = [float(unit == "1") for unit in units]
        self.path = Walked(
            edges,
            pieces,
            breaks,
            at_breaks(np.append(0.0, breaks), np.asarray(instants, np.float64)),
            np.full((len(instants), 2), np.nan),
            np.ascontiguousarray(records, np.float64),
            np.zeros(len(records), COLUMNS),
            np.zeros((len(records), count)),
            np.zeros(1, MOTION),
            np.zeros(1, NODAL),
            self._parameters,
            self._row,
        )
        self._loop = path_loop_of(self._bound, self.path)

    def run(self, law: ContactLaw, frame: Frame | None = None) -> Any:
        """Take the law with other numbers along the path; returns its state at the end, `MOTION`.

        A frame with other numbers stands for the path's own.

        Forces at the instants and records are those of `path`, until the next run.

        Raises:
            LawError: the law's own code raised an exception.
            ValueError: it is a law of another kind.
        """
        row = row_of(law.on_rotor(FLAT))
        if row.shape != self._row.shape:
            raise ValueError(f"{law.name} has {row.size} numbers here; it must have {self._row.size}.")
        self._row[:] = row
        states = self.path.states
        states.view(np.uint8)[:] = self._fresh.view(np.uint8)
        state = states[0]
        frame = frame or self._frame
        if frame is not None and frame.stiffness is not None:
            state["framed"], state["first_force"] = 1, frame.force
            state["compliance"] = 1.0 / frame.stiffness
            state["relaxation"] = frame.damping / frame.stiffness
        count = int(state["variables"])
        state["memory"][:count] = row[HEAD : HEAD + count]
        self.path.forces[:] = np.nan
        with self._errors():
            self._loop(self.path, *self._bound.of_loop)
        return state

    def critical_stiffness(self) -> float:
        """Stiffness below which steady sliding as fast as the load point is unstable [N/m]; NaN if unknown.

        Of friction F(v, z) with one variable, z' = r(v, z), it is F_z r_v - r_z (F_v - c): of rate and state
        (b - a) N/D.
        """
        state, kernels = self.path.states[0], self._bound.kernels
        if state["friction_kind"] != RATE_DEPENDENT or state["variables"] != 1 or state["coupled"] != 1:
            return np.nan
        gap, normal, speed = (float(state[name]) for name in ("last_gap", "last_normal", "last_speed"))

        def flow(v: float, z: float) -> Array:
            self._row[HEAD] = z
            with self._errors():
                return np.array(kernels[FRICTION](gap, 0.0, v, normal, self._parameters)[:2])

        z = float(state["memory"][0])
        for _ in range(MOST_CORRECTIONS):
            dz = NUDGE * max(abs(z), NUDGE)
            rate = flow(speed, z)[1]
            change = rate / ((flow(speed, z + dz)[1] - rate) / dz)
            # A logarithm may be far off.
            z -= float(np.clip(change, -1.0, 1.0))
            if not abs(change) > NUDGE * abs(z):
                break
        else:
            return np.nan
        dv, dz = NUDGE * speed, NUDGE * max(abs(z), NUDGE)
        here = flow(speed, z)
        by_slip, by_z = (flow(speed + dv, z) - here) / dv, (flow(speed, z + dz) - here) / dz
        damping = float(state["relaxation"] / state["compliance"])
        return float(by_z[0] * by_slip[1] - by_z[1] * (by_slip[0] - damping))

    def critical_damping(self) -> float:
        """Damping of a frame from which on no fall of set-valued friction with its slip ends a run [N s/m].

        max -dF/dv: then k e + c (x_L' - v) = F(v) has one v, at any stiffness. Zero of other friction.
        """
        state, kernels = self.path.states[0], self._bound.kernels
        if state["friction_kind"] != SET_VALUED:
            return 0.0
        gap, normal = float(state["last_gap"]), float(state["last_normal"])
        speeds = np.geomspace(*SPEEDS)
        with self._errors():
            if state["prescribed"] == RIGID:
                friction = [kernels[BOUND](normal, v, self._parameters) for v in speeds]
            else:
                friction = [-kernels[FORCE](gap, 0.0, v, 0.0, self._parameters)[1] for v in speeds]
        return max(float(-(np.diff(friction) / np.diff(speeds)).min()), 0.0)


def at_breaks(edges: Array, instants: Array) -> Array:
    """Return instants [s], those at edges of a path but for round-off as these.

    Of several edges it is the first: the limit of a force there is that from the left. The first instant, if
    at the start, is just after that, and after a reversal there.
    """
    if not instants.size:
        return instants
    near = AT_EDGE * float(np.diff(instants, prepend=edges[0], append=edges[-1])[1:-1].min(initial=edges[-1]))
    first = edges[np.minimum(np.searchsorted(edges, instants - near), edges.size - 1)]
    result = np.where(np.abs(first - instants) <= near, first, instants)
    if instants[0] - edges[0] <= near:
        result[0] = edges[np.searchsorted(edges, near, side="right") - 1] + AT_START * near
    return result


def _solution(loop: LawOnPath, law: ContactLaw, motor: Motor, interval: float) -> Solution:
    """Run a law behind a frame, and return what a run of it would have."""
    state = loop.run(law)
    path, count = loop.path, int(state["next_record"])
    time, records, traces = path.records[:count], path.series[:count], path.traces[:count]
    ending, message = _ending(loop, law, state)

    def means(impulses: Array) -> Array:
        """Return means over the record intervals; the first record has none."""
        return np.append(0.0, np.diff(impulses) / np.diff(time))

    zero = np.zeros(count)
    stored = records["contact_energy"]
    energy = records["strain_energy"] + stored
    series = dict.fromkeys((variable.name for variable in SERIES), zero) | {
        "tip_normal_displacement": -records["gap"],
        "tip_tangential_displacement": records["way"],
        "tip_slope": -records["way"] / FLAT,
        "gap": records["gap"],
        "slip_velocity": records["slip_velocity"],
        "normal_force": means(records["normal_impulse"]),
        "friction_force": means(records["friction_impulse"]),
        "strain_energy": records["strain_energy"],
        "contact_energy": stored,
        "drive_work": records["drive_work"],
        "damping_loss": records["damping_loss"],
        "contact_loss": records["contact_loss"],
    }
    # What the contact takes and does not store is lost, along the normal or by friction.
    taken = records["friction_work"] + records["normal_work"]
    series["friction_loss"] = taken - (stored - stored[0]) - records["contact_loss"]
    losses = series["damping_loss"] + series["friction_loss"] + series["contact_loss"]
    series["energy_residual"] = energy - energy[0] - series["drive_work"] + losses
    names = [f"internal_{each.name}" for each in law.internal_variables]
    contact = {
        "start_time": 0.0,
        "duration": float(state["time"]),
        "stick_duration": float(state["stick_time"]),
        "normal_impulse": float(state["normal_impulse"]),
        "friction_impulse": float(state["friction_impulse"]),
        "peak_normal_force": float(state["most_normal"]),
        "max_penetration": max(float(-records["gap"].min()), 0.0),
        "separation_velocity": np.nan,
        "energy_loss": float(series["friction_loss"][-1] + series["contact_loss"][-1]),
    }
    ends = dict(zip(names, traces[-1:].T, strict=True))
    table = {each.name: np.array([contact.get(each.name, 0.0)]) for each in contact_variables(law)}
    done = {"contact_steps": int(state["steps"]), "rejected_steps": int(state["rejected"]), "touchdowns": 1}
    trajectory = Trajectory(
        motor=motor,
        law=law,
        duration=float(path.breaks[-1]),
        contact_step=0.0,
        record_interval=interval,
        time=time.copy(),
        series={name: np.array(x) for name, x in series.items()} | dict(zip(names, traces.T, strict=True)),
        contact_mode=records["mode"].astype(np.int8),
        contacts=table | ends,
        statistics=dict.fromkeys(COUNTS.split(), 0) | done,
        ending=ending,
        message=message,
        final=ModalState(np.zeros(2), np.zeros(2)),
        frame={
            "stiffness": 1.0 / float(state["compliance"]),
            "damping": float(state["relaxation"] / state["compliance"]),
            "force": float(state["first_force"]),
        },
    )
    return Solution(trajectory)


def _ending(loop: LawOnPath, law: ContactLaw, state: Any) -> tuple[Ending, str]:
    """Return how a law behind a frame ended, and why."""
    code, time = int(state["ending"]), f"{float(state['time']):.6g} s"
    if code == RUNNING:
        return Ending.COMPLETE, ""
    if code == INCONSISTENT:
        return Ending.INCONSISTENT, (
            f"The frame_force is {float(state['first_force']):.6g} N, which the friction of {law.name} does "
            f"not balance at the start; choose {-float(state['force']):.6g} N."
        )
    if code == NOT_FINITE:
        return Ending.DIVERGED, f"At {time} the law {law.name} has answered with no finite number."
    stiffness, critical = 1.0 / float(state["compliance"]), loop.critical_stiffness()
    damping, least = float(state["relaxation"]) * stiffness, loop.critical_damping()
    known, mend = "", "a stiffer frame or frame_damping"
    if critical > stiffness:
        known = f", which is below the critical {critical:.6g} N/m"
    elif least > damping:
        known = f", whose damping is {damping:.6g} N s/m: at {least:.6g} N s/m no stiffness is critical"
        mend = "that frame_damping"
    return Ending.CHATTERED if code == CHATTERED else Ending.STALLED, (
        f"At {time} the friction of {law.name} falls faster than a frame of {stiffness:.6g} N/m unloads"
        f"{known}: stick-slip, of which there is no motion without inertia. Take {mend}, or a mass on a "
        "spring, contactlab.block."
    )


def _pieces_until(path: Waveform, degree: int, duration: float | None) -> tuple[Array, Array, Array]:
    """Return edges, ascending powers and breaks of a path up to a duration [s], see `engine.path.Path`.

    A spline of the highest degree is smoother at its samples than a step sees; the others break there.
    """
    turns = _reversals(path)
    cut = _cut_at(path, turns)
    edges, powers = cut.pieces.x, np.moveaxis(cut.pieces.c[::-1], 0, 2)
    whole = float(edges[-1])
    length = whole if duration is None else duration
    if path.periodic:
        times = ceil(length / whole)
        starts = whole * np.arange(times)[:, None]
        edges = np.append((starts + edges[:-1]).ravel(), whole * times)
        powers, turns = np.tile(powers, (times, 1, 1)), (starts + turns).ravel()
    elif length > whole * (1.0 + SAME_TIME):
        raise ValueError(f"The duration is {length} s; it must be at most that of the path, {whole} s.")
    # A reversal is an edge but for round-off; between two pieces it is a root of each.
    turns = edges[np.searchsorted(0.5 * (edges[1:] + edges[:-1]), turns)]
    breaks = np.unique(turns) if degree == MOST_DEGREE else edges[1:-1]
    breaks = breaks[(breaks > SAME_TIME * length) & (breaks < (1.0 - SAME_TIME) * length)]
    return edges, np.ascontiguousarray(powers), np.append(breaks, length)


def _extremes(edges: Array, pieces: Array) -> Array:
    """Return the first row of a path at the samples and half-way between them."""
    halves = 0.5 * np.diff(edges)
    return np.append(
        pieces[:, 0, 0], (pieces[:, 0] * halves[:, None] ** np.arange(pieces.shape[2])).sum(axis=1)
    )
