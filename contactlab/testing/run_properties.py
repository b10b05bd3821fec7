"""Properties of the runs of a law: forces, their losses, convergence, repetition and mirror image."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from contactlab.arrays import Array
from contactlab.engine import simulate
from contactlab.laws import PenaltyLaw
from contactlab.laws.base import FREE
from contactlab.laws.consistency import TINY
from contactlab.laws.memory import AT_TOUCH, ODD
from contactlab.metrics.constraints import changes_side
from contactlab.motor.motor import Motor
from contactlab.testing.claim import Claims, at_least, at_most, close
from contactlab.testing.flow_properties import image_of, losses_of
from contactlab.testing.kernel_properties import impacts_of
from contactlab.testing.plants import (
    BELT_MASS,
    FLAT,
    MASS,
    MOTOR_DURATION,
    WEIGHT,
    Bench,
    Evaluator,
    block,
    completed,
    free_motion,
    run,
)
from contactlab.trajectory import Trajectory

TOO_SMALL = 1e-5
"""Relative error of a coarse run below which no order is computed: steps end at events."""

STEP_ERROR = 1e-5
"""Share that may have the wrong sign in the step in which slip or force ends: an error of the step."""


def no_force_when_open(bench: Bench) -> Claims:
    """No force in an interval that no contact reaches into."""
    for text, made in bench.runs.items():
        start, end = made.contacts["start_time"][:, None], made.time[1:]
        stop = start + made.contacts["duration"][:, None]
        # A release at the very end of one interval may round into the next.
        slack = 1e-12 * made.time[-1]
        touched = ((start <= end + slack) & (stop >= made.time[:-1] - slack)).any(axis=0)
        # A damping may end the force before the gap opens; until then the step's polynomial is near zero.
        touched |= (made.contact_mode[1:] != FREE) & (made.contact_mode[:-1] != FREE)
        force = np.abs(made.series["normal_force"]) + np.abs(made.series["friction_force"])
        result = force[1:][~touched].max(initial=force[0])
        yield at_most(f"force between contacts, {text}", result, 0.0, "N")


def no_tension(bench: Bench) -> Claims:
    """N >= 0."""
    for text, made in bench.runs.items():
        force = made.series["normal_force"]
        pull = -force.min() / max(force.max(), TINY)
        yield at_most(f"pull, {text}, over the peak force", pull, STEP_ERROR)


def inside_the_cone(bench: Bench) -> Claims:
    """|F| <= mu (|N| + C) over every record interval, which for a rigid law is shorter than a step."""
    for text, made in bench.runs.items():
        normal, friction = (np.abs(made.series[f"{n}_force"]) for n in ("normal", "friction"))
        # Forces are read as differences of impulses, which round off.
        cone = bench.law.friction_limit * (normal + bench.law.friction_offset)
        judged = np.ones(normal.size, dtype=bool)
        if bench.law.allows_tension:
            # Where a force begins to pull within an interval, its mean says nothing of its size.
            judged = ~changes_side(made.series["normal_force"])
        excess = (friction - cone)[judged].max(initial=0.0) / max(normal.max(), TINY)
        # Friction has a kink where the force begins to pull, and no step ends there.
        bound = 1e-6 if bench.law.allows_tension else 1e-8
        yield at_most(f"friction over its bound, {text}, over the peak force", excess, bound)


def friction_opposes_slip(bench: Bench) -> Claims:
    """The work of F on v over every record interval, and F of an impact against the slip it leaves.

    What a friction with a memory stores is part of that work, along drawn flows too.
    """
    result = impacts_of(bench)["friction_opposes_slip"] if bench.rigid else losses_of(bench)[1]
    yield from result.values()
    for text, made in bench.runs.items():
        gained = _gained(np.diff(made.series["friction_loss"]))
        yield at_most(f"work of friction, {text}, over all friction loss", gained, STEP_ERROR)


def dissipates(bench: Bench) -> Claims:
    """Every contact loses energy; a compliant one at every instant, a rigid one in any impact."""
    yield from (impacts_of(bench)["dissipates"] if bench.rigid else losses_of(bench)[0]).values()
    for text, made in bench.runs.items():
        if not bench.rigid:
            normal, friction = (np.diff(made.series[f"{n}_loss"]) for n in ("contact", "friction"))
            gained = _gained(normal, float(np.abs(friction).sum()))
            yield at_most(f"work of normal losses, {text}, over all losses", gained, STEP_ERROR)
        gain = _gained(made.contacts["energy_loss"])
        yield at_most(f"energy from a contact, {text}, over all losses", gain, 1e-9)


def stick_is_exact(bench: Bench) -> Claims:
    """A block in balance on a belt is pushed with less than friction can hold, and keeps its place."""
    law, depth, weight, end = bench.law, 0.0, WEIGHT, 2e-3
    push = 0.4 * law.friction_limit * weight
    if isinstance(law, PenaltyLaw):
        evaluator = Evaluator(law)
        begin, depths = evaluator.limits(evaluator.initial)[0], 10.0 ** np.arange(-8.0, 1.0)
        kept = evaluator.jumped(AT_TOUCH, begin, 0.0, 0.0, 0.0, evaluator.initial)
        # From shallow to deep: how deep the law is valid is not known.
        results = ((float(d), evaluator.force(-d, 0.0, 0.0, 0.0, kept)) for d in depths)
        depth, weight, bound = next(
            ((d, normal, bound) for d, (normal, bound, _, _) in results if normal > 1e-3), (0.0, 0.0, 0.0)
        )
        if weight == 0.0:
            raise RuntimeError(f"{law.name}: its normal force carries no weight at any penetration.")
        # What a contact that has just begun can hold may be less than the most that the law allows.
        push = 0.4 * bound
    motor = block(MASS, height=-depth, weight=weight, push=push)
    # An interval that no number of steps fills, or a chatter of two steps could hide in it.
    series = run(motor, law, end, record_interval=1.03e-6).series
    # Without friction it would go this far: what it creeps until it touches is round-off of that.
    speed = max(push / MASS * end, TINY)
    slip = np.abs(series["slip_velocity"]).max() / speed
    yield at_most("slip of a block that friction can hold, over its free speed", slip, 1e-9)
    creep = np.ptp(FLAT * (series["tip_slope"] + series["rotor_angle"])) / (0.5 * speed * end)
    yield at_most("creep of a block that friction can hold, over its free way", creep, 1e-9)


def ledger_closes(bench: Bench) -> Claims:
    """E(t) - E(0) = drive_work - losses - load_work + residual, every term its own quadrature."""
    for text, made in bench.runs.items():
        energy = made.series["kinetic_energy"] + made.series["strain_energy"]
        scale = max(energy.max(), np.abs(made.series["drive_work"]).max())
        residual = np.abs(made.series["energy_residual"]).max() / scale
        yield at_most(f"ledger residual, {text}, over the energy", residual, bench.balance)


def contacts_sum_to_the_losses(bench: Bench) -> Claims:
    """Every loss of friction and contact is that of one contact, what it stored and lost later with it."""
    for text, made in bench.runs.items():
        rows = made.contacts["energy_loss"]
        lost = sum(np.diff(made.series[f"{name}_loss"][[0, -1]])[0] for name in ("friction", "contact"))
        energy = made.series["kinetic_energy"] + made.series["strain_energy"]
        scale = max(float(np.abs(rows).sum()), 1e-6 * float(energy.max()))
        yield close(f"losses of the contacts, {text}", float(rows.sum()), float(lost), 1e-9, "J", scale)


def impulse_is_momentum(bench: Bench) -> Claims:
    """A block and its belt, contact by contact; along the belt wherever there is none, and at the end."""
    made = bench.runs["block"]
    contacts, series = made.contacts, made.series
    finished = np.isfinite(contacts["separation_velocity"])
    change = contacts["separation_velocity"] - contacts["approach_velocity"]
    impulse = contacts["normal_impulse"] - WEIGHT * contacts["duration"]
    worst = np.abs(MASS * change - impulse)[finished].max(initial=0.0)
    scale = np.abs(contacts["normal_impulse"]).max()
    yield at_most("momentum of a block less its normal impulse, each contact", worst / scale, 1e-9)

    begun, ended = (
        np.searchsorted(contacts["start_time"] + length, made.time + 1e-12 * made.time[-1])
        for length in (0.0, contacts["duration"])
    )
    value = np.append(0.0, np.cumsum(contacts["friction_impulse"]))[ended]
    belt = FLAT * series["rotor_velocity"]
    tip = series["slip_velocity"] + belt
    scale = max(np.abs(contacts["friction_impulse"]).max(), MASS * np.abs(tip).max())
    for name, momentum, sign in (("block", MASS * tip, 1.0), ("belt", BELT_MASS * belt, -1.0)):
        missing = np.abs(momentum - momentum[0] - sign * value)[begun == ended].max()
        yield at_most(f"momentum of a {name} less its friction impulses", missing / scale, 1e-9)


def forces_move_the_motor(bench: Bench) -> Claims:
    """The rotor's momentum by the friction impulses, and the tip's way by the recorded mean forces.

    q_j(T) - q_j,free(T) = sum_i f_ji int w_j(T - t) dt, by the midpoint of every record interval, with
    w_j(s) = (exp(r1 s) - exp(r2 s))/(r1 - r2) and r^2 + c r + k = 0.
    """
    made, motor = bench.runs["motor"], bench.motor
    rotor, geometry, radius = motor.rotor, motor.geometry, motor.geometry.rotor_radius
    series, push, end = made.series, made.contacts["friction_impulse"], made.time[-1]
    gained = rotor.inertia * (series["rotor_velocity"][-1] - rotor.initial_velocity)
    torque = rotor.load_torque * end + rotor.damping * series["rotor_angle"][-1]
    value, scale = -radius * push.sum() - torque, max(radius * np.abs(push).sum(), TINY)
    text = "momentum of the rotor against friction impulses, in all"
    yield close(text, gained, value, 1e-9, "N m s", scale)

    (exponents, *free), names = free_motion(motor), {"tip_normal_displacement": "m", "tip_slope": "rad"}
    rows = motor.modes.approach, motor.modes.tip_slope
    forces = np.array([series["normal_force"], series["friction_force"]])[:, 1:]
    acting = np.flatnonzero(forces[0])
    impulses = (forces * np.diff(made.time))[:, acting]
    values = (*(series[name] for name in names), end - made.time)
    u, th, late = (0.5 * (each[1:] + each[:-1])[acting] for each in values)
    places = zip(u.tolist(), th.tolist(), strict=True)
    frames = [geometry.frame(*place)[1:] for place in places]
    # Of both forces on u and on th.
    acted = np.einsum("ijk,ji->ki", np.reshape(frames, (-1, 2, 2)), impulses)
    first, second = exponents[motor.drive.frequency.size :].reshape(2, -1, 1)
    response = ((np.exp(first * late) - np.exp(second * late)) / (first - second)).real
    driven = (response * (np.transpose(rows) @ acted)).sum(axis=1)
    for name, row, terms in zip(names, rows, free, strict=True):
        result = (np.exp(exponents * end) @ terms).real + row @ driven
        scale, text = np.abs(series[name]).max(), f"{name} under the recorded forces"
        # An impact lies anywhere in its interval.
        left = 1e-3 if bench.rigid else bench.balance
        yield close(text, result, series[name][-1], left, names[name], scale)


def converges(bench: Bench) -> Claims:
    """The error against the limit or a much finer run, fitted over step or tolerance in logarithms."""
    # A law whose default run does not end is not asked for finer ones.
    duration, step = completed(bench.motor_run).duration, bench.law.default_contact_step
    make = partial(run, bench.motor, bench.law, duration)
    if bench.rigid:
        word, sizes = "step", [step * 2.0**k for k in range(5, -1, -1)]
        runs, reference = [make(size) for size in sizes], make(bench.step and step / 16.0)
    else:
        word, sizes = "tolerance", [10.0**-k for k in range(2, 7)]
        runs = [make(2.0 * step, tolerance=size) for size in sizes]
        reference = make(0.5 * step, tolerance=1e-10)
    expected = _ends(reference)
    scale = np.where(expected == 0.0, 1.0, np.abs(expected))
    errors = [np.sqrt(np.mean(((_ends(made) - expected) / scale) ** 2)) for made in runs]
    if max(errors) < TOO_SMALL:
        yield at_most(f"error at any {word}, too small for an order", max(errors), TOO_SMALL)
        return
    order = np.polyfit(np.log(sizes), np.log(np.maximum(errors, TINY)), 1)[0]
    # An order fitted to a few runs is uncertain by 0.3.
    least = bench.law.convergence_order - 0.3
    yield at_least(f"order of convergence with the {word}", order, least)


def _ends(made: Trajectory) -> Array:
    """Return where a run ends, and its impulses."""
    ends = ("rotor_velocity", "tip_slope", "tip_normal_displacement")
    impulses = (made.contacts[f"{way}_impulse"].sum() for way in ("normal", "friction"))
    return np.array([*(made.series[name][-1] for name in ends), *impulses])


def _gained(losses: Array, others: float = 0.0) -> float:
    """Return the largest gain over all losses, of which some may be others' [J]."""
    return float(max(-losses.min(), 0.0) / max(np.abs(losses).sum() + others, TINY))


RECORDS = 150
"""Intervals of a run that is cut, or recorded coarsely."""


def repeats_bit_for_bit(bench: Bench) -> Claims:
    """A run that is repeated has the same bits."""
    result = _differing(bench, bench.motor)
    yield at_most(f"quantities that differ when run again {result}", len(result), 0)


def goes_on(bench: Bench) -> Claims:
    """A run that is cut within a contact and goes on is the one that was not, in all that is recorded."""
    whole, interval = _coarsely(bench), MOTOR_DURATION / RECORDS
    touching = np.flatnonzero(whole.contact_mode[:-1] != FREE)
    at = int(touching[2 * touching.size // 3]) if touching.size else RECORDS // 2
    first = _coarsely(bench, max(at, 1) * interval)
    second = _coarsely(bench, MOTOR_DURATION - max(at, 1) * interval, first.state)
    records = len(second.time)
    unlike = [n for n, x in second.series.items() if not np.array_equal(x, whole.series[n][-records:])]
    ended = int(np.isfinite(first.contacts["separation_velocity"]).sum())
    for name, values in whole.contacts.items():
        parts = np.append(first.contacts[name][:ended], second.contacts[name])
        unlike += [] if np.array_equal(parts, values, equal_nan=True) else [f"{name} of the contacts"]
    yield at_most(f"quantities that differ when a run is cut {unlike}", len(unlike), 0)


def records_change_nothing(bench: Bench) -> Claims:
    """Two runs that are recorded at other intervals have the same contacts and the same end."""
    fine, coarse = completed(bench.motor_run), _coarsely(bench)
    unlike = [
        name
        for name, values in fine.contacts.items()
        if not np.array_equal(values, coarse.contacts[name], equal_nan=True)
    ]
    for name in ("displacement", "velocity"):
        if not np.array_equal(getattr(fine.final, name), getattr(coarse.final, name)):
            unlike.append(name)
    yield at_most(f"quantities that differ with the record interval {unlike}", len(unlike), 0)


def _coarsely(bench: Bench, duration: float = MOTOR_DURATION, start: Any = None) -> Trajectory:
    """Run a bench's motor with few records, from a state that it goes on from where there is one."""
    steps: dict[str, Any] = {"contact_step": bench.step, "record_interval": MOTOR_DURATION / RECORDS}
    return completed(simulate(bench.motor, bench.law, duration=duration, start=start, **steps))


def mirrors(bench: Bench) -> Claims:
    """Left and right exchanged, and with them the sign of what is along the rotor and of odd variables."""
    yield from image_of(bench).values()
    motor, rotor = bench.motor, bench.motor.rotor
    velocity, torque = -rotor.initial_velocity, -rotor.load_torque
    modes = replace(motor.modes, tip_slope=-motor.modes.tip_slope)
    turned = replace(rotor, initial_velocity=velocity, load_torque=torque)
    geometry = replace(motor.geometry, angle=-motor.geometry.angle)
    moving = ("tip_tangential_displacement", "tip_slope", "rotor_velocity", "rotor_angle")
    odd = [f"internal_{each.name}" for each in bench.law.internal_variables if each.parity == ODD]
    signed = (*moving, "slip_velocity", "friction_force", "friction_impulse", *odd)
    result = _differing(bench, replace(motor, modes=modes, rotor=turned, geometry=geometry), signed)
    yield at_most(f"quantities that differ in the mirror {result}", len(result), 0)


def _differing(bench: Bench, motor: Motor, mirrored: tuple[str, ...] = ()) -> list[str]:
    """Name what another motor's run has otherwise, but for the sign of some."""
    made, other = (
        {"contact_mode": each.contact_mode.astype(np.float64), **each.series, **each.contacts}
        for each in (completed(bench.motor_run), completed(bench.attempt_motor(motor)))
    )
    signs = {name: -1.0 if name in mirrored else 1.0 for name in made}
    return [n for n in made if not np.array_equal(made[n], signs[n] * other[n], equal_nan=True)]
