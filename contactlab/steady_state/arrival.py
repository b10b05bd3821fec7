"""Steady state that a motor reaches: a transient, an orbit nearby, and a test that it is approached."""

from contextlib import suppress
from dataclasses import replace
from math import ceil, inf, log
from typing import Final

import numpy as np

from contactlab.arrays import Array
from contactlab.config import Setup
from contactlab.engine import simulate
from contactlab.engine.initial_state import memory_mark
from contactlab.engine.state import State
from contactlab.interrupts import raise_if_stopped
from contactlab.laws.base import ELASTOPLASTIC, FREE, RATE_DEPENDENT, SLIP, STICK, is_stepped
from contactlab.motor import ModalState
from contactlab.settling.statistics import (
    PERIODIC,
    REPEATS,
    WITHOUT_CONTACT,
    cycle_of,
    kind_without_period,
    repeats_after,
    trend,
)
from contactlab.steady_state.period_map import BrokenOffError, PeriodMap, continues, period_of
from contactlab.steady_state.shooting import NoOrbitError, Orbit, continued, orbit_from
from contactlab.steady_state.state import Steady
from contactlab.trajectory import Ending, Trajectory
from contactlab.variables import INTERNAL

FORGOTTEN: Final = 1e-3
"""Remaining share of the resonator's free vibration at the first search for an orbit."""

LEAST_WARM_UP: Final = 8
MOST_WARM_UP: Final = 200
"""Bounds of the transient before the first search for an orbit [periods of the drive]."""

SHORTEST_FLIGHT: Final = 0.02
"""Shortest free flight that contains a Poincare section [periods]; without one it lies in the contact."""

RECORDS: Final = 256
"""Records of the period in which a section in contact is chosen."""

TEST_RUN: Final = 0.125
"""Duration of a test run towards an orbit, in settling times of the orbit."""

DEVIATION: Final = 0.2
"""Largest deviation of a test run from the linearised map, over the distance covered."""

BETWEEN: Final = 16
"""Places between a motor and an orbit at which the drift of a slow rotor is looked at."""

BALANCED: Final = 1e-6
"""Mean torque on a rotor that keeps its velocity, over the torques in it that are balanced."""

ARRIVED: Final = 1e-8
"""Distance from an orbit, relative to its state, at which a motor has reached it."""

SETTLED: Final = 1e-9
"""Relative difference of the states of a periodic motion without an orbit, over `TAIL` periods."""

TAIL: Final = 48

SAME: Final = 1e-6
"""Relative difference of the states of two equal cycles of an orbit."""

REVERSALS: Final = 8
"""Contacts of a run whose friction has the other sense a period later: so many are no passage."""

AVERAGED: Final = 240
"""Periods of a motion across a jump of the period map that are averaged at least."""

DRIFT: Final = 3.0
"""Largest trend of a stationary run, in its statistical errors."""


Start = tuple[float, ModalState | None, float, Array | None, State | None]
"""Phase of the drive [periods], modal state, rotor velocity [rad/s], internal variables and contact of a
`PeriodMap`."""


JUMPS: Final = (
    "From period to period the slip at a touch-down has another sense, and with it the friction of a law "
    "that does not stick: the period map jumps there, and no orbit closes across the jump."
)
"""Why a motion has no orbit, see `contactlab.Steady`."""


class NotSettledError(RuntimeError):
    """A motor reaches no steady state; the message is a sentence."""


class UnboundedError(NotSettledError):
    """An internal variable of the law has no steady value; the message is a sentence."""


def settled(
    setup: Setup, belt: float | None, begins: Start, longest: int, sense: float = 0.0, cycle: int = 0
) -> Steady | None:
    """Compute the steady state that a motor reaches.

    Args:
        setup: what moves.
        belt: velocity at which the rotor is held [rad/s]; None for one that is free.
        begins: phase of the drive [periods], modal state (None is at rest), rotor velocity [rad/s], internal
            variables (None are their initial values) and the contact that goes on (None is none).
        longest: run without an orbit [periods].
        sense: of a rotation that must not be reversed; 0 for one that may.
        cycle: periods of the drive in an orbit on which the motor begins, of another belt, load or tolerance:
            one like it is looked for at once; 0 for a motor that comes from elsewhere.

    Returns:
        The steady state; None once the rotation is reversed.

    Raises:
        UnboundedError: an internal variable of the law still grows or falls after the longest run.
        NotSettledError: the rotor does.
    """
    phase, modal, velocity, memory, contact = begins
    clock = PeriodMap(setup, phase, belt=belt, contact=continues(contact, setup.law))
    memory = None if clock.contact is None and contact is not None else memory
    modes = setup.motor.modes
    nothing = np.zeros(modes.stiffness.size)
    z = clock.state_of(modal or ModalState(nothing, nothing), velocity, memory)
    # What no spring holds does not swing.
    swings = modes.stiffness > 0.0
    # A mode falls with d/2, or overdamped with d/2 - sqrt(d^2/4 - omega^2). The transient lasts until the
    # slowest one has fallen to `FORGOTTEN`, within bounds.
    half, stiffness = 0.5 * modes.damping[swings], modes.stiffness[swings]
    slowest = float((half - np.sqrt(np.maximum(half**2 - stiffness, 0.0))).min(initial=inf))
    decayed = -log(FORGOTTEN) / (slowest * clock.period) if slowest > 0.0 else inf
    run = clock.run(z, LEAST_WARM_UP if cycle else ceil(min(max(decayed, LEAST_WARM_UP), MOST_WARM_UP)))
    orbit, done, far = None, 0, (inf, inf)
    while done < longest:
        # The load has turned the rotor back.
        if sense and sense * float(np.diff(run.series["rotor_angle"][[0, -1]])[0]) <= 0.0:
            return None
        samples = _stroboscopic_samples(run)
        states = np.hstack([samples, _remembered(run)])
        # No contact in the second half of the run: the tip vibrates freely.
        touches = run.contacts["start_time"] + run.contacts["duration"]
        if touches.max(initial=-inf) < 0.5 * (run.time[0] + run.time[-1]):
            return _without_contact(clock, run)
        # No orbit closes across a jump of the period map; nothing is to be waited for but means.
        jumps = orbit is None and _jumps(run) and not repeats_after(samples, REPEATS)
        if jumps and len(samples) >= AVERAGED:
            with suppress(NotSettledError):
                return _without_orbit(clock, run)
        # Newton's method fails at a jump from afar, too: it is not tried again while a jump may lie ahead.
        later = not getattr(setup.law, "sticks", True) and 0 < done < AVERAGED
        if orbit is None and not (jumps or later):
            clock, run = _at_section(clock, run)
            # Shoot from the motor's state at the section, for one period of the drive or for as many as a
            # long run shows the motion to have.
            count = cycle_of(samples, REPEATS) if len(samples) >= TAIL else max(cycle, 1)
            orbit, far = _orbit(replace(clock, periods=count), clock.end_of(run)), (inf, inf)
        wait = inf
        if orbit is not None:
            # Does the motor go to this orbit? Two test runs of an eighth of the settling time decide by
            # (7.5); a rotor too slow for these by the drift along its slowest direction.
            lasts, most = TEST_RUN * orbit.settling_time, longest * clock.period
            times = ceil(min(lasts, most) / orbit.map.period) or 1
            periods, z = times * orbit.map.periods, clock.end_of(run)
            slow = lasts > most
            missed = (0.0 if _drifts_to(orbit, z) else inf) if slow else _missed(orbit, z, times)
            if missed <= DEVIATION:
                return _on_orbit(clock, orbit, round(run.state["end"] / clock.period) + periods)
            # Not yet: the motor runs on, and the orbit stays a candidate while the motor comes nearer to it
            # and moves more as the linearised map says. What that misses falls as the distance does.
            run = _on(run, periods)
            before, far = far, (float(np.linalg.norm(clock.end_of(run) - orbit.state)), missed)
            wait = orbit.settling_time / clock.period * log(missed / DEVIATION)
            nearer = far[0] < before[0] and (slow or far[1] < before[1])
            orbit, wait = (orbit, wait) if nearer else (None, inf)
        # No orbit is closed next to the motion, though its samples repeat themselves to round-off: the last
        # repetitions are the steady state.
        elif len(states) >= TAIL and (count := repeats_after(states[-TAIL:], SETTLED)):
            done, run = round(run.state["end"] / clock.period), _on(run, TAIL // count * count)
            _check_balance(clock, run)
            return Steady(setup, PERIODIC, count, run, None, done, clock.belt, phase=clock.phase)
        done = round(run.state["end"] / clock.period)
        # Look again when the linearised map may hold, or else after three times as long.
        more = ceil(min(max(wait, done / 4), 2 * done, longest - done))
        run = _on(run, more) if more > 0 else run
    # A rotor that still drifts to an orbit is taken to come to it; others have the means of another run.
    if orbit is not None and _drifts_to(orbit, clock.end_of(run)):
        return _on_orbit(clock, orbit, done)
    return _without_orbit(clock, _on(run, longest // 2))


def followed(setup: Setup, known: Orbit) -> Steady | None:
    """Compute the steady state of a motor whose numbers differ from those of a known orbit, on its branch.

    Newton's method begins on the known orbit (`shooting.continued`), and what it finds is accepted as
    `settled` accepts an orbit: it is stable, and a motor on the known orbit goes to it as the linearised map
    says. From rest a motor that has several motions may come to another one.

    Args:
        setup: what moves; its drive has the period of the known one.
        known: orbit of another motor that `is_followed`.

    Returns:
        None where the branch is not followed in one step; the motor or law may be of another kind, too.
    """
    before, law = known.map, setup.law
    contact = continues(before.contact, law)
    if memory_mark(law) != memory_mark(before.setup.law) or (contact is None) != (before.contact is None):
        return None
    section = replace(before, setup=setup, contact=contact)
    # Units of the states: modes and rotor may be others, too.
    units, others = _units(section), _units(before)
    if units.shape != others.shape:
        return None
    scale = units / others
    z = scale * known.state
    try:
        orbit = continued(section, z, scale[:, None] * known.jacobian / scale)
        # That of an orbit that is not stable is infinite.
        times = ceil(min(TEST_RUN * orbit.settling_time / section.period, MOST_WARM_UP + 1.0)) or 1
        if times > MOST_WARM_UP or not _missed(orbit, z, times) <= DEVIATION:
            return None
        state = _on_orbit(section, orbit, times)
    # A rigid law refuses a start inside the rotor.
    except (NoOrbitError, BrokenOffError, NotSettledError, ValueError):
        return None
    return state if section.ends_at(state.motion) else None


def _units(section: PeriodMap) -> Array:
    """Return the state of a map whose quantities in SI are all one."""
    each = np.ones(section.scale.size)
    return section.state_of(ModalState(each, each), 1.0, np.ones(len(section.variables)))


def is_followed(orbit: Orbit) -> bool:
    """Return whether an orbit depends on its state z alone, so that its branch is that of z.

    Orbits do not that take several periods or have directions that keep what they are given, and, in contact,
    those that count the impact that began it, a residual indentation or discrete internal variables.
    """
    section, contact = orbit.map, orbit.map.contact
    if section.periods > 1 or orbit.neutral.any():
        return False
    if contact is None:
        return True
    if contact["limits.remembered"] or any(each.discrete for each in section.setup.law.internal_variables):
        return False
    other = replace(section, contact={**contact, "impact_speed": 1.0 + contact["impact_speed"]})
    return orbit.is_near(other.ends(orbit.state[None])[0], ARRIVED)


def _on(run: Trajectory, periods: float, records: int = 1) -> Trajectory:
    """Continue a run for some periods, with some records in each."""
    # The phase of the drive goes on with the clock, which began at that of the run.
    period = period_of(run.motor.drive)
    later = simulate(
        run.motor,
        run.law,
        duration=periods * period,
        record_interval=min(1.0 / records, periods) * period,
        contact_step=(step := run.contact_step or None),
        tolerance=None if is_stepped(run.law, step) else run.state["tolerance"],
        progress=raise_if_stopped,
        start=run.state,
    )
    if later.ending is Ending.INTERRUPTED:
        raise KeyboardInterrupt(later.message)
    if not later.ending.reached_end:
        raise BrokenOffError(later.message)
    return later


def _orbit(section: PeriodMap, z: Array) -> Orbit | None:
    """Compute a stable orbit near a state, with the least number of periods."""
    try:
        orbit = orbit_from(section, z)
        if section.periods > 1:
            # An orbit of several periods may be one of fewer, run through several times.
            twice = _stroboscopic_samples(section.run(orbit.state, 2.0, section.periods))
            if 0 < (count := repeats_after(twice, SAME)) < section.periods:
                orbit = Orbit.at(replace(section, periods=count), orbit.state)
    except (NoOrbitError, BrokenOffError):
        return None
    return orbit if orbit.stable else None


def _missed(orbit: Orbit, z: Array, times: int) -> float:
    """Return how far the motor moves from where the linearised map to an orbit takes it, over what it covers.

    That is the larger of two runs, from its state and from half-way. As the rotor is slow, the motor moves
    along a line; in front of another orbit it would cover less of it.
    """
    if orbit.is_near(z, ARRIVED):
        return 0.0
    # Half way may lie inside the rotor, and has no end then.
    starts = np.array([z, 0.5 * (z + orbit.state)])
    ends = orbit.map.ends(starts, times)
    if orbit.is_near(ends[0], ARRIVED):
        return 0.0
    # (7.5): |P^m(z) - z* - A^m (z - z*)| <= 0.2 |A^m (z - z*) - (z - z*)|.
    deviations = starts - orbit.state
    predicted = deviations @ np.linalg.matrix_power(orbit.jacobian, times).T
    missed = np.linalg.norm(ends - orbit.state - predicted, axis=1)
    shares = missed / np.linalg.norm(predicted - deviations, axis=1)
    return float(shares.max()) if np.isfinite(shares).all() else inf


def _on_orbit(clock: PeriodMap, orbit: Orbit, done: int) -> Steady:
    """Return the motion on an orbit that was reached after some periods."""
    motion = orbit.map.run(orbit.state)
    if orbit.neutral.any():
        _check_balance(clock, motion)
    count = orbit.map.periods
    return Steady(clock.setup, PERIODIC, count, motion, orbit, done, clock.belt, phase=clock.phase)


def _drifts_to(orbit: Orbit, z: Array) -> bool:
    """Return whether a rotor that is too slow to be waited for drifts from a state to an orbit.

    All but its velocity is forgotten within some periods; then the distance along the slowest direction, by
    its left eigenvector, must fall at each of some places between.
    """
    # With the left eigenvector w of the largest multiplier, w^T (z - z*) is the distance along the slowest
    # direction alone, once the others have decayed to `FORGOTTEN`.
    values, vectors = np.linalg.eig(orbit.jacobian.T)
    others = np.sort(np.abs(np.where(orbit.neutral, 0.0, orbit.multipliers)))[:-1]
    times = ceil(log(FORGOTTEN) / log(max(others.max(initial=0.0), FORGOTTEN)))
    along = vectors[:, np.abs(np.abs(values) - orbit.largest).argmin()]
    if times > MOST_WARM_UP or along.imag.any():
        return False
    # From each place between: first the decay of the other directions, then as long again for the drift, in
    # which the distance must fall without a change of sign. The motor's own state is the first: where it goes
    # elsewhere, no other is looked at.
    for place in np.linspace(1.0, 0.0, BETWEEN, endpoint=False):
        before = orbit.map.ends((orbit.state + place * (z - orbit.state))[None], times)
        after = orbit.map.ends(before, times)
        here, there = (float((ends - orbit.state)[0] @ along.real) for ends in (before, after))
        if not (abs(there) < abs(here) and here * there > 0.0):
            return False
    return True


def _without_orbit(clock: PeriodMap, run: Trajectory) -> Steady:
    """Take the means of a run that is on no orbit, in which nothing grows or drifts, and say its kind."""
    periods, done = run.time.size - 1, round(run.state["end"] / clock.period)
    for variable, name, values in zip(run.law.lasting, run.lasting, _remembered(run).T, strict=True):
        if _grows(values) or _drifts(values):
            last = run.series[name]
            raise UnboundedError(
                f"The internal variable {variable.name} of {clock.setup.law.name} has no steady value: after "
                f"{done} periods of the drive it still changes by "
                f"{(last[-1] - last[1]) / (periods - 1):.3g} {variable.units} a period, and nothing was "
                "found that brings it back, so that the motor has no steady state. Simulate it for the time "
                "that matters; one that only needs longer is given it by `longest`."
            )
    velocity = np.diff(run.series["rotor_angle"]) / clock.period
    if clock.belt is None and _drifts(velocity):
        raise NotSettledError(
            f"The rotor has not settled after {done} periods of the drive: over the last {periods} "
            f"its velocity, {velocity.mean():.4g} rad/s in the mean, has changed by {trend(velocity)[0]:.2g} "
            "rad/s. Run it longer, by `longest`; a load that drives it, without damping of the rotor, may do "
            "so for ever."
        )
    # A velocity that stays the same to round-off may be that of a rotor too heavy to be seen moving.
    if np.ptp(velocity) <= SETTLED * np.abs(velocity).max():
        _check_balance(clock, run)
    samples = _stroboscopic_samples(run)
    # In a contact that lasts, the steps of time stepping do not divide the period.
    count = repeats_after(samples[-TAIL:], max(run.contact_step / clock.period, REPEATS))
    # Rotor and energy follow the tip.
    kind = PERIODIC if count else kind_without_period(samples[:, 2:])
    reason = JUMPS if not count and _jumps(run) else ""
    began = done - periods
    return Steady(clock.setup, kind, count, run, None, began, clock.belt, phase=clock.phase, reason=reason)


def _jumps(run: Trajectory) -> bool:
    """Return whether the motion of a law without stick goes to and fro across a jump of the period map.

    Its friction has the sense of the slip at the touch-down, whatever comes of it: where that slip passes
    zero, the impulse jumps by twice its size.
    """
    if getattr(run.law, "sticks", True):
        return False
    start, sense = run.contacts["start_time"], np.sign(run.contacts["friction_impulse"])
    if not start.size:
        return False
    # The sense of the contact a period later.
    later = np.interp(start + period_of(run.motor.drive), start, sense, right=0.0)
    return bool(np.count_nonzero(sense * later < -0.5) >= REVERSALS)


def _check_balance(clock: PeriodMap, run: Trajectory) -> None:
    """Refuse a motion that seems to repeat itself though a mean torque acts on its rotor.

    One so heavy is seen to move in no run that can be waited for.
    """
    if clock.belt is not None:
        return
    velocity = np.diff(run.series["rotor_angle"]) / np.diff(run.time)
    rotor, radius, rows = run.motor.rotor, run.motor.geometry.rotor_radius, run.contacts_within
    # On a motion that repeats itself the contact's torque -R F and what brakes balance in the mean: tau + C_r
    # Omega. The scale is friction of either sense, which may cancel.
    pushed = -radius * float(run.series["friction_force"][1:].mean())
    braked = rotor.load_torque + rotor.damping * float(velocity.mean())
    rubbed = radius * float(np.abs(rows["friction_impulse"]).sum()) / run.duration
    if abs(pushed - braked) > BALANCED * max(rubbed, abs(rotor.load_torque), abs(braked)):
        raise NotSettledError(
            f"The rotor keeps its velocity of {velocity.mean():.6g} rad/s to round-off, though a mean torque "
            f"of {pushed - braked:.3g} N m acts on it: it settles too slowly for a steady state to be found. "
            "Give it less inertia, or hold it by a belt."
        )


def _grows(values: Array) -> bool:
    """Return whether a sequence is monotonic and changes by more than round-off."""
    steps = np.diff(values)
    # As the depth of wear: it never turns.
    monotonic = bool(np.all(steps >= 0.0) or np.all(steps <= 0.0))
    return monotonic and bool(abs(values[-1] - values[0]) > SETTLED * np.abs(values).max())


def _drifts(values: Array) -> bool:
    """Return whether a sequence has a trend, beyond its statistical error and beyond round-off."""
    change, error = trend(values)
    return bool(abs(change) > max(DRIFT * error, SETTLED * np.abs(values).max()))


def _without_contact(clock: PeriodMap, run: Trajectory) -> Steady:
    """Return the free vibration, with the rotor velocity at which load and damping balance."""
    # Without contact load and damping balance: C_r Omega = -tau.
    clock, done = clock.at_end_of(run, clock.phase), round(run.state["end"] / clock.period)
    rotor, z = clock.setup.motor.rotor, clock.end_of(run)
    if clock.belt is None and rotor.damping > 0.0:
        z[-1] = -clock.rotor_scale * rotor.load_torque / rotor.damping
    elif clock.belt is None and rotor.load_torque != 0.0:
        raise NotSettledError(
            f"The tip does not touch the rotor, and nothing holds it against its load of "
            f"{rotor.load_torque:.4g} N m; it must have damping, or contact. Make the clearance smaller, or "
            "leave the load out."
        )
    motion = clock.run(z)
    return Steady(clock.setup, WITHOUT_CONTACT, 1, motion, None, done, clock.belt, phase=clock.phase)


def _at_section(clock: PeriodMap, run: Trajectory) -> tuple[PeriodMap, Trajectory]:
    """Continue a run to a section: the middle of its longest flight, or of its longest stretch in contact."""
    # In flight the whole state is free. A contact that hardly opens has its section where the state of the
    # contact lasts longest, seen in a period with fine records.
    part, seen = flight_of(run, clock.period), run
    if part is None:
        seen = run = _on(run, 1.0, RECORDS)
        part = stretch_of(run)
    if part:
        run = _on(run, part)
    return clock.at_end_of(run, clock.phase + part).weighing(seen), run


def flight_of(run: Trajectory, period: float) -> float | None:
    """Return the middle of the longest free flight of a run's last period; None where there is none."""
    # Begin and end of each contact in the last period, in its parts.
    begin, rows = float(run.time[-1]) - period, run.contacts
    touched = np.clip((rows["start_time"] - begin) / period, 0.0, 1.0)
    released = np.clip((rows["start_time"] + rows["duration"] - begin) / period, 0.0, 1.0)
    within = released > touched
    touched, released = np.sort(touched[within]), np.sort(released[within])
    if not touched.size:
        return 0.0
    # The last flight goes on in the period that follows.
    flights = np.append(touched[1:], touched[0] + 1.0) - released
    longest = int(flights.argmax())
    if flights[longest] < SHORTEST_FLIGHT:
        return None
    # Nothing lies so close to a section that its last digits mattered.
    return round(float(released[longest] + 0.5 * flights[longest]), 6) % 1.0


def stretches_of(run: Trajectory) -> Array:
    """Return the state of the contact at the records of a run but its first, shape (record, number).

    It is free, sticks, slips one way or the other, and has the values of the discrete internal variables.
    """
    # Slip in either sense is another state, but where friction passes zero slip smoothly.
    mode = run.contact_mode[1:].astype(float)
    if getattr(run.law, "friction_kind", None) != RATE_DEPENDENT:
        mode[(mode == SLIP) & (run.series["slip_velocity"][1:] < 0.0)] = -SLIP
    discrete = [run.series[INTERNAL + each.name][1:] for each in run.law.internal_variables if each.discrete]
    return np.column_stack([mode, *discrete])


def stretch_of(run: Trajectory) -> float:
    """Return the middle of the longest stretch in contact of a run that repeats itself, as a share of it.

    In a stretch the state of the contact is the same. Where friction has a spring it sticks: in slip the
    bound holds the spring's stretch.
    """
    state = stretches_of(run)
    # Stretches of a period go round: the last one continues in the first.
    changes = np.flatnonzero((state != np.roll(state, 1, axis=0)).any(axis=1))
    if not changes.size:
        return 0.0
    lengths, mode = np.diff(np.append(changes, changes[0] + len(state))), state[changes, 0]
    if getattr(run.law, "friction_kind", None) == ELASTOPLASTIC and (mode == STICK).any():
        lengths[mode != STICK] = 0
    lengths[mode == FREE] = 0
    longest = int(lengths.argmax())
    return round(float(changes[longest] + 0.5 * lengths[longest]) / len(state), 6) % 1.0


def _remembered(run: Trajectory) -> Array:
    """Return the internal variables of the run once a period over their largest, (period, variable)."""
    values = [run.series[name][1:] for name in run.lasting]
    columns = [each / (np.abs(each).max() or 1.0) for each in values]
    return np.array(columns).reshape(len(columns), run.time.size - 1).T


def _stroboscopic_samples(run: Trajectory) -> Array:
    """Return the state once a period, each quantity over its largest, shape (period, quantity)."""
    series = {name: values[1:] for name, values in run.series.items()}
    energy = series["kinetic_energy"] + series["strain_energy"]
    inertia, most = run.motor.rotor.inertia, float(energy.max())
    # The rotor counts by its energy: sqrt(J/2) Omega over the root of the largest energy of the resonator.
    moves = most > 0.0 and run.motor.belt_velocity is None
    moving = series["rotor_velocity"] * (np.sqrt(0.5 * inertia / most) if moves else 0.0)
    tip = np.array([series["tip_normal_displacement"], series["tip_tangential_displacement"]])
    # One of them may be held by the contact and be no more than round-off.
    tip /= np.abs(tip).max() or 1.0
    return np.column_stack([moving, energy / (most or 1.0), *tip])
