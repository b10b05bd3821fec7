"""One stretch of free flight, and its touch-down: the first zero of the gap, and never a later one.

Over a stretch of flight the gap's second derivative is bounded by B. Between two instants at which
gap and gap rate are known, the gap lies above both parabolas that leave them with curvature -B. Where
these stay positive there is no contact; where they do not, the stretch is halved, left half first,
until every piece is either proven open or holds one falling zero.

The gap at which the next contact begins may move, as that of a surface which recovers. Over a piece in which
its curvature keeps its sign it stays below lines through its ends: their slopes are the larger of rate and
chord at the left end, the smaller one at the right end. The parabolas are then those of the gap over them.
"""

from math import sqrt

from contactlab.compiler.kernels import inner_kernel, part_kernel
from contactlab.engine.kinematics import (
    Tip,
    contact_after,
    contact_at,
    contact_of,
    fly,
    free_accelerations,
    tip_motion,
)
from contactlab.engine.memory import limit_at, note_limit
from contactlab.engine.plant import ORDERS, Plant
from contactlab.engine.propagator import FLIGHT_DOUBLINGS, build_flight, step_length
from contactlab.engine.rootfinding import locate_gap
from contactlab.engine.state import (
    FLIGHT,
    LAST,
    NOTHING,
    OPEN,
    RELEASED,
    SEPARATING,
    START,
    TOUCH,
    UNFOLLOWED,
    Law,
    Run,
)

CLEAR = 1e-18
"""Gap [m] that no round-off after a release amounts to: that of u and of the clearance is 1e-21, and more
for a tip that moves far, see `coarseness`."""

REFINEMENT = 15 + FLIGHT_DOUBLINGS
"""Levels that a flight begins finer where its gap opens from nothing, as a power of time."""

REACH = 1e-5
"""Way [m] of a tip up to which its gap has the digits below; further ones have fewer, see `coarseness`."""

RESOLUTION = 1e-22
"""Gap [m] below which float64 does not distinguish open from touching."""

ROUND_OFF = 1e-19
"""Gap [m] that is open for certain, whatever float64 makes of it after a release."""

ROUGH = 1e-9
"""Share of the largest curvature of a gap below which that at an instant is not relied on."""

NO_TOUCH, LOST = -1.0, -2.0
"""The flight stays open; the flight cannot be followed."""

MOST_HALVINGS = 10_000
"""Halvings of one stretch: a motor takes a few tens, a state that has run away takes them all."""


Instant = tuple[float, float, float, float, float]
"""Time in a step [s], gap over that at which the next contact begins [m], gap rate [m/s], that gap [m] and
its rate [m/s]."""


@inner_kernel
def step_flight(run: Run, law: Law) -> int:
    """Take a step that `begin` made ready through free flight; returns TOUCH or NOTHING.

    A touch-down is looked for from where the gap is known to be open. While SEPARATING, that is
    where it has certainly opened; one that opens so slowly that round-off or the error of a rigid
    release decides its sign is followed, in steps that double from very short ones, until it is
    clear. A gap that is closed and closes faster and faster is a new contact; one that rests is none.
    Gaps are those over the one at which the next contact begins, and so are the rates that decide.
    """
    state, level = run.state, run.state.level
    run.step.kind = FLIGHT
    note_limit(run, law.memory)
    tip = tip_motion(run.plant, START)
    before, rate_before, slip, _, _, _, _ = contact_of(run.plant, tip)
    limit, limit_rate = limit_at(run, law, law.memory, 0.0, (before, rate_before, slip))
    before, widens = before - limit, rate_before - limit_rate
    coarse = coarseness(run, tip[1])
    h = step_length(run.propagator, level)
    bound = curvature_bound(run, tip, h)
    # A gap that begins at zero and widens is open up to the highest point of its lower bound.
    opening = _certain_opening(before, widens, bound, h, coarse)
    follows = state.phase != OPEN
    if state.phase == RELEASED:
        state.phase = SEPARATING
        if opening == 0.0 and widens < bound * h:
            # Of a gap that hardly opens, round-off would decide.
            level = min(level + REFINEMENT, run.propagator.rule.level_count - 1)
            h = step_length(run.propagator, level)
            bound = curvature_bound(run, tip, h)
            opening = _certain_opening(before, widens, bound, h, coarse)
    state.length = h
    # The motion at the end is exact; all that follows is what happens on the way to it.
    build_flight(run.plant, run.propagator, level)
    run.step.flown_drive, run.step.flown_damping, run.step.flown_load = fly(run, level, LAST)
    gap, rate, slip, _, _, _, _ = contact_at(run.plant, LAST)
    last_limit, last_limit_rate = limit_at(run, law, law.memory, h, (gap, rate, slip))
    gap -= last_limit
    closes = rate - last_limit_rate
    end = h, gap, rate, last_limit, last_limit_rate
    # A contact limit that moves in flight raises the gap that must be cleared by its steepest rate.
    if last_limit == limit and limit_rate == 0.0 and last_limit_rate == 0.0:
        run.step.limit_moves = 0
    elif opening > 0.0:
        rise = max(limit_rate, (last_limit - limit) / h)
        opening = _certain_opening(before, rate_before - rise, bound, h, coarse)
    state.flight_steps += 1
    touch = NO_TOUCH
    if state.phase == OPEN:
        # Open at the start: searched from there.
        start = 0.0, before, rate_before, limit, limit_rate
        touch = _first_touch(run, law, start, end, bound, coarse)
    elif opening > 0.0:
        state.phase = OPEN
        # Just released: searched from the highest point of the lower bound, where it is open for certain.
        before, rate_before, slip, _, _, _, _ = contact_after(run, opening)
        limit, limit_rate = limit_at(run, law, law.memory, opening, (before, rate_before, slip))
        opened = opening, before - limit, rate_before, limit, limit_rate
        touch = _first_touch(run, law, opened, end, bound, coarse)
    # Not open for certain: closed and closing faster at the end is a touch-down, clear of round-off is open.
    elif gap <= 0.0 and closes <= 0.0 and gap + closes < 0.0 and closes < widens:
        touch = h
    elif gap > coarse * CLEAR:
        state.phase = OPEN
    if touch == LOST:
        state.ending = UNFOLLOWED
    coarsest = 0 if state.phase == OPEN else run.propagator.rule.contact_level
    state.level = max(level - 1, coarsest) if level > coarsest else level
    # The end cuts a flight that was searched as if it went on: a run that goes on finds the same touch-down.
    s = h if touch == NO_TOUCH else max(touch, 0.0)
    remaining = min(state.end, state.piece_end) - state.time
    # A gap that is not clear yet where the run ends is followed further by one that goes on.
    unclear = follows and remaining < s and contact_after(run, remaining)[0] <= coarse * CLEAR + limit
    state.phase = SEPARATING if unclear else state.phase
    state.accepted_length = min(s, remaining)
    return TOUCH if touch >= 0.0 and state.accepted_length == s else NOTHING


@part_kernel
def _certain_opening(gap: float, rate: float, bound: float, h: float, coarse: float) -> float:
    """Return the time in (0, h) up to which the gap certainly widens and is then open; zero where unknown.

    It is the highest point of gap + rate s - B s^2/2, a lower bound of the gap.
    """
    certain = 0.0 < rate < bound * h and gap + 0.5 * rate * rate / bound > coarse * ROUND_OFF
    return rate / bound if certain else 0.0


@inner_kernel
def curvature_bound(run: Run, tip: Tip, h: float) -> float:
    """Return B >= |gddot| over the next h of flight [m/s^2], for as long as the gap is open.

    A free oscillator's acceleration a obeys the oscillator's own equation, so that
    |a(s)| <= |a(0)| + |adot(0)| min(s, 1/sqrt k) for any damping, and so does its jerk; the tones add their
    amplitudes. The answer from rest to a force f exp(i omega s) has |a(s)| <= |f| (1 + omega s), as its
    impulse response never moves faster than it began; that to a waveform's force has
    |a(s)| <= |f(0)| + int |fdot|, and either has |adot| <= |fdot| + (c + k s) |a|. The rest is geometry:
    |dn.L/dth| <= L_tip (|th| (L_tip + R + |e|) + |sin beta| (R + g_0)) / R and the centripetal terms.
    Over a short step what the start has of gddot counts, and what the jerk may add.
    """
    plant, lengths = run.plant, run.plant.geometry
    u_acc, th_acc, u_jerk, th_jerk = 0.0, 0.0, 0.0, 0.0
    u, th, u_rate, th_rate, _ = tip
    short = h < run.propagator.rule.longest
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        k, c = mode.stiffness, mode.damping
        # Eq. 2.8 for the free part, and for its jerk once more: a, adot and addot all obey the oscillator's
        # equation.
        acceleration = -c * mode.free_v - k * mode.free_q
        jerk = -c * acceleration - k * mode.free_v
        reach = h if k * h * h < 1.0 else 1.0 / sqrt(k)
        forced, rate = _from_rest(plant, j, h)
        bound = abs(acceleration) + abs(jerk) * reach + forced
        u_acc += abs(mode.row_u) * bound
        th_acc += abs(mode.row_th) * bound
        if short:
            snap = -c * jerk - k * acceleration
            bound = abs(jerk) + abs(snap) * reach + rate + (c + k * h) * forced
            u_jerk += abs(mode.row_u) * bound
            th_jerk += abs(mode.row_th) * bound
    for i in range(plant.tone_count):
        tone = plant.tones[i]
        # All modes' steady states together: tones add their amplitudes whatever their phases.
        u_acc += tone.omega**2 * tone.steady_u
        th_acc += tone.omega**2 * tone.steady_th
        if short:
            u_jerk += tone.omega**3 * tone.steady_u
            th_jerk += tone.omega**3 * tone.steady_th
    # Bounds within the step of what the geometry depends on: rates by accelerations, displacements by rates.
    u_rate, th_rate = abs(u_rate) + u_acc * h, abs(th_rate) + th_acc * h
    u, th = abs(u) + u_rate * h, abs(th) + th_rate * h
    length, radius = lengths.tip_length, lengths.radius
    # Eq. 2.9. The lever of the slope grows with the slope and with how far the tip lies below the rotor's
    # edge.
    excess = lengths.clearance + u + 0.5 * length * th * th
    lever = length * th * (length + radius + excess) / radius
    lever += length * abs(lengths.sine) * (radius + lengths.clearance) / radius
    speed = u_rate + length * th_rate
    whirl = length * th_rate * th_rate
    bound = u_acc + lever * th_acc + whirl + speed * speed / radius
    if short:
        # gdddot = n.Ldddot + 3 (v_T.Lddot - gdot |v_T|^2 / |d|) / |d|, with |d| >= R.
        jerk = u_jerk + lever * th_jerk + length * th_rate * (3.0 * th_acc + th_rate * th_rate)
        jerk += 3.0 * speed * (u_acc + length * th_acc + whirl + speed * speed / radius) / radius
        # Eq. 2.9a, where it says more. The first bound, in a small part, covers the round-off of a curvature
        # that nearly vanishes.
        at_start = abs(free_accelerations(run, START, 0.0)[0])
        bound = min(bound, at_start + jerk * h + ROUGH * bound)
    return float(bound)


@inner_kernel
def _from_rest(plant: Plant, j: int, h: float) -> tuple[float, float]:
    """Return bounds of the acceleration by forces without a steady state, and of the rate of these forces."""
    # The impulse response is nowhere steeper than at its start, |wdot| <= 1, so that an acceleration is at
    # most |f(0)| + int |fdot| (docs/theory/flight.md, "Waveforms").
    forced, rate = abs(plant.modes[j].constant), 0.0
    if plant.wave.electrodes > 0:
        power = 1.0
        for m in range(ORDERS):
            forced += abs(plant.forces[j, m]) * power
            if m + 1 < ORDERS:
                rate += abs(plant.forces[j, m + 1]) * power
            power *= h / (m + 1)
    for k in range(plant.tone_count):
        phasor, omega = plant.phasors[j, k], plant.tones[k].omega
        if phasor.near != 0:
            force = sqrt(phasor.force_re**2 + phasor.force_im**2)
            forced += force * (1.0 + omega * h)
            rate += force * omega
    return forced, rate


@inner_kernel
def coarseness(run: Run, slope: float) -> float:
    """Return what the digits of the gap [m] grow by where the parts that it is summed from outgrow REACH.

    Round-off is that of the parts: clearance, free motion and steady state of every mode, and the slope's
    by its lever.
    """
    plant, lengths = run.plant, run.plant.geometry
    u, th = lengths.clearance, 0.0
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        part = abs(mode.free_q)
        for k in range(plant.tone_count):
            part += abs(plant.phasors[j, k].steady_re) + abs(plant.phasors[j, k].steady_im)
        u += abs(mode.row_u) * part
        th += abs(mode.row_th) * part
    lever = lengths.tip_length * (
        abs(slope) * (1.0 + lengths.tip_length / lengths.radius) + abs(lengths.sine)
    )
    return float(max((abs(u) + lever * th) / REACH, 1.0))


@inner_kernel
def _first_touch(run: Run, law: Law, start: Instant, end: Instant, bound: float, coarse: float) -> float:
    """Find the time of the first touch-down of a flight that begins open; else give NO_TOUCH or LOST."""
    step = run.step
    a, gap_a, gap_rate_a, limit_a, limit_rate_a = start
    b, gap_b, gap_rate_b, limit_b, limit_rate_b = end
    waiting, halvings = 0, 0
    while halvings < MOST_HALVINGS:
        h = b - a
        # Slopes of lines above the gap at which contact begins: the gap over it is bounded below by the
        # parabolas of eq. 2.10 with these rates taken off.
        chord = (limit_b - limit_a) / h if step.limit_moves != 0 else 0.0
        rate_a = gap_rate_a - max(limit_rate_a, chord)
        rate_b = gap_rate_b - min(limit_rate_b, chord)
        bend = abs(limit_rate_b - limit_rate_a)
        indistinct = (bound * h + bend) * h < coarse * RESOLUTION or waiting >= step.wait_time.size
        # Two lower bounds of the gap, with the largest curvature from either end; docs/theory/flight.md.
        # The parabolas from both ends have the same curvature, so they cross once.
        # Where they cross: eq. 2.10 is linear in s there. The larger of the two is least at the crossing, or
        # at an end, which is known.
        slope = bound * h - rate_a + rate_b
        least = gap_a + rate_a * h - 0.5 * bound * h * h
        # Only round-off or a zero bound makes it negative: the left parabola lies above all along.
        if slope > 0.0:
            s = min(max((gap_a - gap_b + rate_b * h + 0.5 * bound * h * h) / slope, 0.0), h)
            falling = gap_a + rate_a * s - 0.5 * bound * s * s
            least = max(falling, gap_b - rate_b * (h - s) - 0.5 * bound * (h - s) * (h - s))
        proven = least > 0.0 and gap_a > 0.0 and gap_b > 0.0
        if proven or (indistinct and gap_b > 0.0):
            # Proven open: on with the piece that waits next, from left to right, so that the first zero is
            # found first.
            if waiting == 0:
                return NO_TOUCH
            waiting -= 1
            a, gap_a, gap_rate_a = b, gap_b, gap_rate_b
            limit_a, limit_rate_a = limit_b, limit_rate_b
            b, gap_b = step.wait_time[waiting], step.wait_gap[waiting]
            gap_rate_b = step.wait_rate[waiting]
            limit_b, limit_rate_b = step.wait_limit[waiting], step.wait_limit_rate[waiting]
        # Closed at the end, and falling all along: one zero, which is located. Else the piece is halved, its
        # second half waiting.
        elif gap_b <= 0.0 and gap_rate_a - min(limit_rate_a, limit_rate_b) + bound * h < 0.0:
            left = a, gap_a, gap_rate_a - limit_rate_a
            right = b, gap_b, gap_rate_b - limit_rate_b
            return locate_gap(run, law, TOUCH, left, right, coarse * RESOLUTION)
        elif indistinct:
            return b
        else:
            step.wait_time[waiting], step.wait_gap[waiting] = b, gap_b
            step.wait_rate[waiting] = gap_rate_b
            step.wait_limit[waiting], step.wait_limit_rate[waiting] = limit_b, limit_rate_b
            waiting += 1
            halvings += 1
            b = 0.5 * (a + b)
            gap_b, gap_rate_b, slip, _, _, _, _ = contact_after(run, b)
            limit_b, limit_rate_b = limit_at(run, law, law.memory, b, (gap_b, gap_rate_b, slip))
            gap_b -= limit_b
    return LOST
