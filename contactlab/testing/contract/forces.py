"""Properties of the forces that a run records: where they act, how large, and what they cost."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from contactlab.laws import MultiplierLaw
from contactlab.testing.claim import Claim, at_most, close
from contactlab.testing.contract.bench import BELT_MASS, MASS, MOTOR_DURATION, NUDGE, WEIGHT, Bench
from contactlab.testing.contract.kernels import ROUND_OFF, answers_of
from contactlab.testing.flights.closed import flight_of
from contactlab.testing.plants import FLAT
from contactlab.trajectory import Trajectory

Array = NDArray[np.float64]

STEP_ERROR = 1e-5
"""Share that may have the wrong sign in the step in which slip or force ends: an error of the step."""


def no_force_when_open(bench: Bench) -> Iterator[Claim]:
    """No force in an interval that no contact reaches into."""
    for words, trajectory in _runs(bench):
        force = np.abs(trajectory.series["normal_force"]) + np.abs(
            trajectory.series["friction_force"]
        )
        yield at_most(f"force between contacts, {words}", force[_open(trajectory)].max(), 0.0, "N")


def no_tension(bench: Bench) -> Iterator[Claim]:
    """N >= 0."""
    for words, trajectory in _runs(bench):
        force = trajectory.series["normal_force"]
        pull = max(-force.min(), 0.0) / max(force.max(), 1e-300)
        yield at_most(f"pull, {words}, over the peak force", pull, STEP_ERROR)


def inside_the_cone(bench: Bench) -> Iterator[Claim]:
    """|F| <= mu N over every record interval, which for a rigid law is shorter than a step."""
    limit = bench.law.friction_limit
    for words, trajectory in _runs(bench):
        normal = np.abs(trajectory.series["normal_force"])
        friction = np.abs(trajectory.series["friction_force"])
        # Forces are read as differences of impulses, which round off.
        excess = (friction - limit * normal).max() / max(normal.max(), 1e-300)
        yield at_most(f"friction over its bound, {words}, over the peak force", excess, 1e-8)


def friction_opposes_slip(bench: Bench) -> Iterator[Claim]:
    """The work of F on v over every record interval, and F of an impact against the slip it leaves."""
    if isinstance(bench.law, MultiplierLaw):
        pushed = answers_of(bench.law).pushed
        yield at_most("friction impulse along the slip it leaves", pushed, ROUND_OFF)
    for words, trajectory in _runs(bench):
        gained = _gained(trajectory.series["friction_loss"])
        yield at_most(f"work of friction, {words}, over all friction loss", gained, STEP_ERROR)


def dissipates(bench: Bench) -> Iterator[Claim]:
    """Every contact loses energy; a compliant one at every instant, a rigid one in any impact."""
    if isinstance(bench.law, MultiplierLaw):
        gain = answers_of(bench.law).gain
        yield at_most("energy made by an impact, over impulse times velocity", gain, ROUND_OFF)
    for words, trajectory in _runs(bench):
        if not bench.rigid:
            gained = _gained(trajectory.series["contact_loss"])
            yield at_most(f"work of normal losses, {words}, over all of them", gained, STEP_ERROR)
        losses = trajectory.contacts["energy_loss"]
        gain = max(-losses.min(), 0.0) / max(np.abs(losses).sum(), 1e-300)
        yield at_most(f"energy from a contact, {words}, over all losses", gain, 1e-9)


def stick_is_exact(bench: Bench) -> Iterator[Claim]:
    """A block that is pushed with less than friction can hold keeps its place."""
    series, end = bench.nudged.series, bench.nudged.time[-1]
    # Without friction it would go this far: what it creeps until it touches is round-off of that.
    speed = max(NUDGE * bench.law.friction_limit * WEIGHT / MASS * end, 1e-300)
    slip = np.abs(series["slip_velocity"]).max() / speed
    yield at_most("slip of a block that friction can hold, over its free speed", slip, 1e-9)
    creep = np.ptp(FLAT * (series["tip_slope"] + series["rotor_angle"])) / (0.5 * speed * end)
    yield at_most("creep of a block that friction can hold, over its free way", creep, 1e-9)


def ledger_closes(bench: Bench) -> Iterator[Claim]:
    """E(t) - E(0) = drive_work - losses - load_work + residual, every term its own quadrature."""
    for words, trajectory in _runs(bench):
        series = trajectory.series
        energy = series["kinetic_energy"] + series["strain_energy"]
        scale = max(energy.max(), np.abs(series["drive_work"]).max())
        residual = np.abs(series["energy_residual"]).max() / scale
        yield at_most(
            f"ledger residual, {words}, over the energy there is", residual, bench.balance
        )


def impulse_is_momentum(bench: Bench) -> Iterator[Claim]:
    """Impulses against changes of momentum: a block and its belt contact by contact, then the motor."""
    yield from _momentum_of_the_block(bench.skipping)
    yield from _momentum_of_the_motor(bench)


def _runs(bench: Bench) -> tuple[tuple[str, Trajectory], ...]:
    return (("motor", bench.motor_run), ("block", bench.skipping))


def _open(trajectory: Trajectory) -> NDArray[np.bool_]:
    """Records whose interval no contact reaches into."""
    start, end = trajectory.time[:-1], trajectory.time[1:]
    contact_start = trajectory.contacts["start_time"]
    contact_end = contact_start + trajectory.contacts["duration"]
    # A release at the very end of one interval may round into the next.
    slack = 1e-12 * trajectory.time[-1]
    touched = (contact_start[:, None] <= end + slack) & (contact_end[:, None] >= start - slack)
    return np.concatenate([[True], ~touched.any(axis=0)])


def _gained(loss: Array) -> float:
    """Largest fall of a loss that should only grow, over all its changes."""
    steps = np.diff(loss)
    return float(max(-steps.min(), 0.0) / max(np.abs(steps).sum(), 1e-300))


def _momentum_of_the_block(trajectory: Trajectory) -> Iterator[Claim]:
    contacts, series = trajectory.contacts, trajectory.series
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
    before = np.searchsorted(trajectory.time, contacts["start_time"], side="right") - 1
    after = np.minimum(np.searchsorted(trajectory.time, ends), trajectory.time.size - 1)
    # Contacts that share a record interval are counted together.
    alone = np.ones(push.size, dtype=bool)
    alone[1:] &= before[1:] >= after[:-1]
    alone[:-1] &= alone[1:]
    scale = max(np.abs(push).max(), MASS * np.abs(tip).max())
    for words, mass, velocity, sign in (("block", MASS, tip, 1.0), ("belt", BELT_MASS, belt, -1.0)):
        change = mass * (velocity[after] - velocity[before])
        worst = np.abs(change - sign * push)[alone].max(initial=0.0)
        yield at_most(
            f"momentum of a {words} less its friction impulse, each contact", worst / scale, 1e-9
        )
        total = mass * (velocity[-1] - velocity[0])
        yield close(
            f"momentum of a {words} against friction impulses, in all",
            total,
            sign * push.sum(),
            1e-9,
            scale=scale,
            units="N s",
        )


def _momentum_of_the_motor(bench: Bench) -> Iterator[Claim]:
    """The rotor's momentum, and the resonator moved by the recorded forces through its own response."""
    trajectory, motor = bench.motor_run, bench.motor
    rotor = motor.rotor
    gained = rotor.inertia * (trajectory.series["rotor_velocity"][-1] - rotor.initial_velocity)
    torque = (
        rotor.load_torque * MOTOR_DURATION + rotor.damping * trajectory.series["rotor_angle"][-1]
    )
    push = trajectory.contacts["friction_impulse"]
    given = -motor.geometry.rotor_radius * push.sum() - torque
    scale = motor.geometry.rotor_radius * np.abs(push).sum()
    yield close(
        "momentum of the rotor against friction impulses, in all",
        gained,
        given,
        1e-9,
        scale=max(scale, 1e-300),
        units="N m s",
    )
    u, th = _driven_by_records(bench)
    for words, found, name in (
        ("displacement", u, "tip_normal_displacement"),
        ("slope", th, "tip_slope"),
    ):
        recorded = trajectory.series[name]
        yield close(
            f"tip {words} under the recorded forces",
            found,
            float(recorded[-1]),
            bench.balance,
            scale=float(np.abs(recorded).max()),
            units="m" if name != "tip_slope" else "rad",
        )


def _driven_by_records(bench: Bench) -> tuple[float, float]:
    """Tip displacement and slope at the end: the free flight and the answer to the recorded mean forces.

    q_j(T) - q_j,free(T) = sum_i f_ji int w_j(T - t) dt, by the midpoint of every record interval, with
    w_j(s) = (exp(r1 s) - exp(r2 s))/(r1 - r2) and r^2 + c r + k = 0.
    """
    trajectory, motor = bench.motor_run, bench.motor
    modes, geometry = motor.modes, motor.geometry
    end = trajectory.time[-1]
    lengths = np.diff(trajectory.time)
    middle = 0.5 * (trajectory.time[1:] + trajectory.time[:-1])
    u, th = (
        0.5 * (trajectory.series[name][1:] + trajectory.series[name][:-1])
        for name in ("tip_normal_displacement", "tip_slope")
    )
    arm = geometry.tip_length
    x = -arm * np.sin(th)
    y = arm * np.cos(th) + u - arm - geometry.clearance - geometry.rotor_radius
    distance = np.hypot(x, y)
    n, t = np.array([x, y]) / distance, np.array([-y, x]) / distance
    normal, friction = (
        trajectory.series[name][1:] * lengths for name in ("normal_force", "friction_force")
    )
    push = normal * n + friction * t
    turn = -arm * (np.cos(th) * push[0] + np.sin(th) * push[1])
    root = np.sqrt((0.25 * modes.damping**2 - modes.stiffness).astype(np.complex128))
    tips = []
    flight = flight_of(motor)
    acting = np.flatnonzero(normal != 0.0)
    for row, free in ((modes.tip_displacement, flight.u), (modes.tip_slope, flight.th)):
        total = float((np.exp(flight.exponents * end) @ free).real)
        for j in range(root.size):
            late = end - middle[acting]
            first = np.exp((-0.5 * modes.damping[j] + root[j]) * late)
            second = np.exp((-0.5 * modes.damping[j] - root[j]) * late)
            answer = ((first - second) / (2.0 * root[j])).real
            force = modes.tip_displacement[j] * push[1] + modes.tip_slope[j] * turn
            total += float(row[j] * (answer @ force[acting]))
        tips.append(total)
    return tips[0], tips[1]
