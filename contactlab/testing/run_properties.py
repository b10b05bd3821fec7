"""Properties of the runs of a law: its forces and what they cost, repetition, mirror and convergence."""

from collections.abc import Iterator
from dataclasses import fields
from typing import Any

import numpy as np

from contactlab.arrays import Array
from contactlab.compiled import fleeting_kernel
from contactlab.laws import ContactLaw
from contactlab.testing.claim import PROPERTIES, Claim, Claims, at_least, at_most, close, proof
from contactlab.testing.contract import BELT_MASS, MASS, NUDGE, WEIGHT, Bench
from contactlab.testing.flights import flight_of
from contactlab.testing.kernel_properties import ROUND_OFF, TINY, answers_of
from contactlab.testing.plants import FLAT, completed, mirrored
from contactlab.trajectory import Trajectory

STEP_ERROR = 1e-5
"""Share that may have the wrong sign in the step in which slip or force ends: an error of the step."""

ORDER_SCATTER = 0.3
"""An order fitted to a few runs is uncertain by this much."""

_KINEMATICS = ("tip_tangential_displacement", "tip_slope", "rotor_velocity", "rotor_angle")
MIRRORED = (*_KINEMATICS, "slip_velocity", "friction_force", "friction_impulse")
"""What changes its sign in a mirror."""


@proof(PROPERTIES)
def no_force_when_open(bench: Bench) -> Claims:
    """No force in an interval that no contact reaches into."""
    for words, made in bench.runs:
        start, end = made.contacts["start_time"][:, None], made.time[1:]
        stop = start + made.contacts["duration"][:, None]
        # A release at the very end of one interval may round into the next.
        slack = 1e-12 * made.time[-1]
        touched = ((start <= end + slack) & (stop >= made.time[:-1] - slack)).any(axis=0)
        force = np.abs(made.series["normal_force"]) + np.abs(made.series["friction_force"])
        found = force[1:][~touched].max(initial=force[0])
        yield at_most(f"force between contacts, {words}", found, 0.0, "N")


@proof(PROPERTIES)
def no_tension(bench: Bench) -> Claims:
    """N >= 0."""
    for words, made in bench.runs:
        force = made.series["normal_force"]
        pull = max(-force.min(), 0.0) / max(force.max(), TINY)
        yield at_most(f"pull, {words}, over the peak force", pull, STEP_ERROR)


@proof(PROPERTIES)
def inside_the_cone(bench: Bench) -> Claims:
    """|F| <= mu N over every record interval, which for a rigid law is shorter than a step."""
    for words, made in bench.runs:
        normal, friction = (np.abs(made.series[f"{n}_force"]) for n in ("normal", "friction"))
        # Forces are read as differences of impulses, which round off.
        excess = (friction - bench.law.friction_limit * normal).max() / max(normal.max(), TINY)
        yield at_most(f"friction over its bound, {words}, over the peak force", excess, 1e-8)


@proof(PROPERTIES)
def friction_opposes_slip(bench: Bench) -> Claims:
    """The work of F on v over every record interval, and F of an impact against the slip it leaves."""
    if bench.rigid:
        pushed = answers_of(bench)["pushed"]
        yield at_most("friction impulse along the slip it leaves", pushed, ROUND_OFF)
    for words, made in bench.runs:
        gained = _gained(np.diff(made.series["friction_loss"]))
        yield at_most(f"work of friction, {words}, over all friction loss", gained, STEP_ERROR)


@proof(PROPERTIES)
def dissipates(bench: Bench) -> Claims:
    """Every contact loses energy; a compliant one at every instant, a rigid one in any impact."""
    if bench.rigid:
        gain = answers_of(bench)["gain"]
        yield at_most("energy made by an impact, over impulse times velocity", gain, ROUND_OFF)
    for words, made in bench.runs:
        if not bench.rigid:
            gained = _gained(np.diff(made.series["contact_loss"]))
            yield at_most(f"work of normal losses, {words}, over all of them", gained, STEP_ERROR)
        gain = _gained(made.contacts["energy_loss"])
        yield at_most(f"energy from a contact, {words}, over all losses", gain, 1e-9)


@proof(PROPERTIES)
def stick_is_exact(bench: Bench) -> Claims:
    """A block that is pushed with less than friction can hold keeps its place."""
    series, end = bench.nudged.series, bench.nudged.time[-1]
    # Without friction it would go this far: what it creeps until it touches is round-off of that.
    speed = max(NUDGE * bench.law.friction_limit * WEIGHT / MASS * end, TINY)
    slip = np.abs(series["slip_velocity"]).max() / speed
    yield at_most("slip of a block that friction can hold, over its free speed", slip, 1e-9)
    creep = np.ptp(FLAT * (series["tip_slope"] + series["rotor_angle"])) / (0.5 * speed * end)
    yield at_most("creep of a block that friction can hold, over its free way", creep, 1e-9)


@proof(PROPERTIES)
def ledger_closes(bench: Bench) -> Claims:
    """E(t) - E(0) = drive_work - losses - load_work + residual, every term its own quadrature."""
    for words, made in bench.runs:
        energy = made.series["kinetic_energy"] + made.series["strain_energy"]
        scale = max(energy.max(), np.abs(made.series["drive_work"]).max())
        residual = np.abs(made.series["energy_residual"]).max() / scale
        words = f"ledger residual, {words}, over the energy there is"
        yield at_most(words, residual, bench.balance)


@proof(PROPERTIES)
def impulse_is_momentum(bench: Bench) -> Claims:
    """Impulses against changes of momentum: a block and its belt contact by contact, then the motor."""
    yield from _momentum_of_the_block(bench.skipping)
    yield from _momentum_of_the_motor(bench)


@proof(PROPERTIES)
def converges(bench: Bench) -> Claims:
    """The error against a much finer run, fitted over step or tolerance in logarithms."""
    sizes, (*runs, reference) = bench.converging()
    errors = [_distance(made, reference) for made in runs]
    order = float(np.polyfit(np.log(sizes), np.log(np.maximum(errors, TINY)), 1)[0])
    word = "step" if bench.rigid else "tolerance"
    least = bench.law.convergence_order - ORDER_SCATTER
    yield at_least(f"order of convergence with the {word}", order, least)


@proof(PROPERTIES)
def repeats_bit_for_bit(bench: Bench) -> Claims:
    """The same run twice."""
    yield _same("when run again", bench, bench.law)


@proof(PROPERTIES)
def calls_leave_no_trace(bench: Bench) -> Claims:
    """A run in which the law is asked two more times, elsewhere, before every answer."""
    yield _same("when asked more often", bench, _often_asked(bench.law))


@proof(PROPERTIES)
def mirrors(bench: Bench) -> Claims:
    """Left and right exchanged."""
    yield _same("in the mirror", bench, bench.law, mirror=True)


def _same(words: str, bench: Bench, law: ContactLaw, mirror: bool = False) -> Claim:
    """Claim that another run of the motor has the same numbers but for their sign; an equal NaN is."""
    made, count = bench.motor_run, 0
    again = completed(bench.attempt_motor(law, mirrored(bench.motor) if mirror else bench.motor))
    for name, column in _columns(made).items():
        other = (-1.0 if mirror and name in MIRRORED else 1.0) * _columns(again)[name]
        alike = column.shape == other.shape
        same = np.isclose(column, other, rtol=0.0, atol=0.0, equal_nan=True) if alike else [False]
        count += int(np.size(same) - np.count_nonzero(same))
    return at_most(f"numbers that differ {words}", count, 0)


def _columns(made: Trajectory) -> dict[str, Array]:
    return {**made.series, **made.contacts, "contact_mode": made.contact_mode.astype(np.float64)}


def _often_asked(law: ContactLaw) -> ContactLaw:
    """Give the law with kernels that are asked about other states before they are asked what counts."""

    def asking(inner: Any, count: int) -> property:
        @fleeting_kernel
        def often(*given: Any) -> Any:
            inner(1.5 * given[0], -given[1], -given[2], *given[3:])
            inner(0.5 * given[0], 2.0 * given[1], 0.0, *given[3:])
            return inner(*given)

        # A kernel names its arguments.
        asked: Any = {
            5: lambda a, b, c, d, p: often(a, b, c, d, p),
            6: lambda a, b, c, d, e, p: often(a, b, c, d, e, p),
            8: lambda a, b, c, d, e, f, g, p: often(a, b, c, d, e, f, g, p),
        }[count]
        outer = None if inner is None else fleeting_kernel(asked)
        return property(lambda _: outer)

    counts = {"force": 5, "friction_force": 6, "solve": 8}
    kernels = {n: asking(getattr(law, n), c) for n, c in counts.items() if hasattr(law, n)}
    made: Any = type(type(law).__name__, (type(law),), kernels)
    return made(**{f.name: getattr(law, f.name) for f in fields(law)})  # type: ignore[arg-type, no-any-return]


def _distance(made: Trajectory, reference: Trajectory) -> float:
    """How far two runs are apart: their ends and their impulses, relative, as a root mean square."""
    parts = []
    for name in ("rotor_velocity", "tip_slope", "tip_normal_displacement"):
        expected = reference.series[name][-1]
        parts.append((made.series[name][-1] - expected) / (abs(expected) or 1.0))
    for name in ("normal_impulse", "friction_impulse"):
        scale = np.abs(reference.contacts[name]).sum() or 1.0
        parts.append((made.contacts[name].sum() - reference.contacts[name].sum()) / scale)
    return float(np.sqrt(np.mean(np.square(parts))))


def _gained(losses: Array) -> float:
    """Give the largest gain over all losses."""
    return float(max(-losses.min(), 0.0) / max(np.abs(losses).sum(), TINY))


def _momentum_of_the_block(made: Trajectory) -> Claims:
    contacts, series = made.contacts, made.series
    finished = np.isfinite(contacts["separation_velocity"])
    change = contacts["separation_velocity"] - contacts["approach_velocity"]
    impulse = contacts["normal_impulse"] - WEIGHT * contacts["duration"]
    worst = np.abs(MASS * change - impulse)[finished].max(initial=0.0)
    scale = np.abs(contacts["normal_impulse"]).max()
    yield at_most("momentum of a block less its normal impulse, each contact", worst / scale, 1e-9)

    belt = FLAT * series["rotor_velocity"]
    tip = series["slip_velocity"] + belt
    push = contacts["friction_impulse"]
    ends = contacts["start_time"] + contacts["duration"]
    before = np.searchsorted(made.time, contacts["start_time"], side="right") - 1
    after = np.minimum(np.searchsorted(made.time, ends), made.time.size - 1)
    # Contacts that share a record interval are counted together.
    alone = np.ones(push.size, dtype=bool)
    alone[1:] &= before[1:] >= after[:-1]
    alone[:-1] &= alone[1:]
    scale = max(np.abs(push).max(), MASS * np.abs(tip).max())
    for name, mass, velocity, sign in (("block", MASS, tip, 1.0), ("belt", BELT_MASS, belt, -1.0)):
        change = mass * (velocity[after] - velocity[before])
        worst = np.abs(change - sign * push)[alone].max(initial=0.0)
        words = f"momentum of a {name} less its friction impulse, each contact"
        yield at_most(words, worst / scale, 1e-9)
        total, given = mass * (velocity[-1] - velocity[0]), sign * push.sum()
        words = f"momentum of a {name} against friction impulses, in all"
        yield close(words, total, given, 1e-9, "N s", scale)


def _momentum_of_the_motor(bench: Bench) -> Claims:
    """The rotor's momentum, and the resonator moved by the recorded forces through its own response."""
    made, rotor, radius = bench.motor_run, bench.motor.rotor, bench.motor.geometry.rotor_radius
    series, push = made.series, made.contacts["friction_impulse"]
    gained = rotor.inertia * (series["rotor_velocity"][-1] - rotor.initial_velocity)
    torque = rotor.load_torque * made.duration + rotor.damping * series["rotor_angle"][-1]
    given, scale = -radius * push.sum() - torque, max(radius * np.abs(push).sum(), TINY)
    words = "momentum of the rotor against friction impulses, in all"
    yield close(words, gained, given, 1e-9, "N m s", scale)
    displacement, slope = _driven_by_records(bench)
    for name, units, found in (("normal_displacement", "m", displacement), ("slope", "rad", slope)):
        recorded = series[f"tip_{name}"]
        words = f"tip {name.removeprefix('normal_')} under the recorded forces"
        yield close(words, found, recorded[-1], bench.balance, units, np.abs(recorded).max())


def _driven_by_records(bench: Bench) -> Iterator[float]:
    """Give tip displacement and slope at the end: free flight, and the answer to the recorded mean forces.

    q_j(T) - q_j,free(T) = sum_i f_ji int w_j(T - t) dt, by the midpoint of every record interval, with
    w_j(s) = (exp(r1 s) - exp(r2 s))/(r1 - r2) and r^2 + c r + k = 0.
    """
    made, motor, flight = bench.motor_run, bench.motor, flight_of(bench.motor)
    modes, geometry, arm = motor.modes, motor.geometry, motor.geometry.tip_length
    u, th, middle = (
        0.5 * (values[1:] + values[:-1])
        for values in (made.series["tip_normal_displacement"], made.series["tip_slope"], made.time)
    )
    x = -arm * np.sin(th)
    y = arm * np.cos(th) + u - arm - geometry.clearance - geometry.rotor_radius
    n, t = np.array([x, y]) / np.hypot(x, y), np.array([-y, x]) / np.hypot(x, y)
    forces = (made.series["normal_force"], made.series["friction_force"])
    normal, friction = (force[1:] * np.diff(made.time) for force in forces)
    push = normal * n + friction * t
    turn = -arm * (np.cos(th) * push[0] + np.sin(th) * push[1])
    acting = np.flatnonzero(normal != 0.0)
    late = made.time[-1] - middle[acting]
    first, second = flight.exponents[motor.drive.frequency.size :].reshape(2, -1, 1)
    answer = ((np.exp(first * late) - np.exp(second * late)) / (first - second)).real
    force = np.outer(modes.tip_displacement, push[1]) + np.outer(modes.tip_slope, turn)
    driven = (answer * force[:, acting]).sum(axis=1)
    for row, free in ((modes.tip_displacement, flight.u), (modes.tip_slope, flight.th)):
        yield float((np.exp(flight.exponents * made.time[-1]) @ free).real + row @ driven)
