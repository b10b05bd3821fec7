"""One stretch of free flight, and its touch-down: the first zero of the gap, and never a later one.

Over a stretch of flight the gap's second derivative is bounded by B. Between two instants at which
gap and gap rate are known, the gap lies above both parabolas that leave them with curvature -B. Where
these stay positive there is no contact; where they do not, the stretch is halved, left half first,
until every piece is either proven open or holds one falling zero.
"""

from math import sqrt

from contactlab.compiled import inner_kernel
from contactlab.engine.kinematics import (
    Law,
    Run,
    contact_after,
    contact_at,
    free_response,
    tip_motion,
)
from contactlab.engine.propagator import build_level, step_length
from contactlab.engine.rootfinding import locate
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
)

CLEAR = 1e-18
"""Gap [m] that no round-off after a release amounts to: that of u and of the clearance is 1e-21, and more
for a tip that moves far, see `coarseness`."""

REFINEMENT = 15
"""Levels that a flight begins finer where its gap opens from nothing, as a power of time."""

REACH = 1e-5
"""Way [m] of a tip up to which its gap has the digits below; further ones have fewer, see `coarseness`."""

RESOLUTION = 1e-22
"""Gap [m] below which open and touching cannot be told apart in float64."""

ROUND_OFF = 1e-19
"""Gap [m] that is open for certain, whatever float64 makes of it after a release."""

NO_TOUCH, LOST = -1.0, -2.0
"""The flight stays open; the flight cannot be followed."""

MOST_HALVINGS = 10_000
"""Halvings of one stretch: a motor takes a few tens, a state that has run away takes them all."""


@inner_kernel
def step_flight(run: Run, law: Law) -> int:
    """Take a step that `begin` made ready through free flight; returns TOUCH or NOTHING.

    A touch-down is looked for from where the gap is known to be open. While SEPARATING, that is
    where it has certainly opened; one that opens so slowly that round-off or the error of a rigid
    release decides its sign is followed, in steps that double from very short ones, until it is
    clear. A gap that is closed and closes faster and faster is a new contact; one that rests is none.
    """
    state, rule = run.state, run.propagator.rule
    level = state.level
    before = contact_at(run.plant, START)[1]
    coarse = coarseness(run)
    if state.phase == RELEASED:
        level = _level_after_release(run, level, before, coarse)
        state.phase = SEPARATING
    h = step_length(run.propagator, level)
    s = h
    run.step.kind = FLIGHT
    state.length = h
    start = 0.0
    if state.phase == SEPARATING:
        start = _certain_opening(run, s, coarse)
        if start > 0.0:
            state.phase = OPEN
    build_level(run.plant, run.propagator, level)
    free_response(run, level, LAST)
    gap, rate, _, _, _, _, _ = contact_at(run.plant, LAST)
    state.flight_steps += 1
    event = NOTHING
    if state.phase == OPEN:
        touch = _first_touch(run, law, (start, s, gap, rate), coarse)
        if touch == LOST:
            state.ending = UNFOLLOWED
            s = 0.0
        elif touch != NO_TOUCH:
            s = touch
            event = TOUCH
    elif gap <= 0.0 and rate <= 0.0 and gap + rate < 0.0 and rate < before:
        event = TOUCH
    elif gap > coarse * CLEAR:
        state.phase = OPEN
    coarsest = 0 if state.phase == OPEN else rule.contact_level
    state.level = max(level - 1, coarsest) if level > coarsest else level
    # The end cuts a flight that was searched as if it went on: a run that goes on finds the same touch-down.
    remaining = state.end - state.time
    state.taken = min(s, remaining)
    return event if s <= remaining else NOTHING


@inner_kernel
def _level_after_release(run: Run, level: int, rate: float, coarse: float) -> int:
    """Give the level as it is, or a much finer one for a gap that hardly opens: there, round-off decides.

    `rate` is the gap rate of the release [m/s].
    """
    h = step_length(run.propagator, level)
    opens = rate >= curvature_bound(run, h) * h or _certain_opening(run, h, coarse) > 0.0
    return level if opens else min(level + REFINEMENT, run.propagator.rule.level_count - 1)


@inner_kernel
def curvature_bound(run: Run, h: float) -> float:
    """Give B >= |gddot| over the next h of flight [m/s^2], for as long as the gap is open.

    A free oscillator's acceleration a obeys the oscillator's own equation, so that
    |a(s)| <= |a(0)| + |adot(0)| min(s, 1/sqrt k) for any damping; the tones add their amplitudes. The
    answer from rest to a force f exp(i omega s) has |a(s)| <= |f| (1 + omega s), as its impulse response
    never moves faster than it began. The rest is geometry: |dn.L/dth| <= L_tip |th| (L_tip + R + |e|) / R
    and the centripetal terms.
    """
    plant = run.plant
    u_acc, th_acc = 0.0, 0.0
    u, th, u_rate, th_rate, _ = tip_motion(plant, START)
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        k, c = mode.stiffness, mode.damping
        acceleration = -c * mode.free_v - k * mode.free_q
        jerk = -c * acceleration - k * mode.free_v
        reach = h if k * h * h < 1.0 else 1.0 / sqrt(k)
        bound = abs(acceleration) + abs(jerk) * reach + abs(mode.constant)
        u_acc += abs(mode.row_u) * bound
        th_acc += abs(mode.row_th) * bound
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        if mode.near != 0:
            for k in range(plant.tone_count):
                phasor = plant.phasors[j, k]
                if phasor.near != 0:
                    bound = sqrt(phasor.force_re**2 + phasor.force_im**2)
                    bound *= 1.0 + plant.tones[k].omega * h
                    u_acc += abs(mode.row_u) * bound
                    th_acc += abs(mode.row_th) * bound
    for k in range(plant.tone_count):
        tone = plant.tones[k]
        u_acc += tone.omega**2 * tone.steady_u
        th_acc += tone.omega**2 * tone.steady_th
    u_rate = abs(u_rate) + u_acc * h
    th_rate = abs(th_rate) + th_acc * h
    u = abs(u) + u_rate * h
    th = abs(th) + th_rate * h
    tip: float = plant.geometry.tip_length
    radius: float = plant.geometry.radius
    excess: float = plant.geometry.clearance + u + 0.5 * tip * th * th
    lever = tip * th * (tip + radius + excess) / radius
    speed = u_rate + tip * th_rate
    return u_acc + lever * th_acc + tip * th_rate * th_rate + speed * speed / radius


@inner_kernel
def coarseness(run: Run) -> float:
    """Give what the digits of the gap [m] grow by where the parts that it is summed from outgrow REACH.

    Round-off is that of the parts: clearance, free motion and steady state of every mode, and the slope's
    by its lever.
    """
    plant = run.plant
    u, th, slope = plant.geometry.clearance, 0.0, 0.0
    for j in range(plant.mode_count):
        mode = plant.modes[j]
        part = abs(mode.free_q)
        for k in range(plant.tone_count):
            part += abs(plant.phasors[j, k].steady_re) + abs(plant.phasors[j, k].steady_im)
        u += abs(mode.row_u) * part
        th += abs(mode.row_th) * part
        slope += mode.row_th * mode.q[START]
    tip = plant.geometry.tip_length
    lever = tip * abs(slope) * (1.0 + tip / plant.geometry.radius)
    return float(max((abs(u) + lever * th) / REACH, 1.0))


@inner_kernel
def stays_open(
    a: float, gap_a: float, rate_a: float, b: float, gap_b: float, rate_b: float, bound: float
) -> bool:
    """Tell whether the gap is proven positive on [a, b]."""
    if gap_a <= 0.0 or gap_b <= 0.0:
        return False
    h = b - a
    # The parabolas from both ends have the same curvature, so they cross once.
    slope = bound * h - rate_a + rate_b
    if slope <= 0.0:
        # Only round-off or a zero bound gets here: the left parabola lies above all along.
        return gap_a + rate_a * h - 0.5 * bound * h * h > 0.0
    s = (gap_a - gap_b + rate_b * h + 0.5 * bound * h * h) / slope
    s = min(max(s, 0.0), h)
    lowest = max(
        gap_a + rate_a * s - 0.5 * bound * s * s,
        gap_b - rate_b * (h - s) - 0.5 * bound * (h - s) * (h - s),
    )
    return lowest > 0.0


@inner_kernel
def _certain_opening(run: Run, h: float, coarse: float) -> float:
    """Give the time up to which the gap only widens and at which it is open, in (0, h); zero where unknown.

    The gap lies above gap + rate s - B s^2/2, whose highest point this is: a release whose own gap
    is lost in round-off is well clear there, before it could close again.
    """
    gap, rate, _, _, _, _, _ = contact_at(run.plant, START)
    bound = curvature_bound(run, h)
    if rate > 0.0 and rate < bound * h and gap + 0.5 * rate * rate / bound > coarse * ROUND_OFF:
        return rate / bound
    return 0.0


@inner_kernel
def _first_touch(
    run: Run, law: Law, stretch: tuple[float, float, float, float], coarse: float
) -> float:
    """Find the time of the first touch-down of a flight that is open where it begins; else NO_TOUCH or LOST.

    A stretch has its beginning and end [s], gap [m] and gap rate [m/s] at the end.
    """
    step = run.step
    a, b, gap_b, rate_b = stretch
    gap_a, rate_a, _, _, _, _, _ = (
        contact_after(run, a) if a > 0.0 else contact_at(run.plant, START)
    )
    bound = curvature_bound(run, b)
    waiting = 0
    halvings = 0
    while halvings < MOST_HALVINGS:
        width = b - a
        indistinct = bound * width * width < coarse * RESOLUTION or waiting >= step.wait_time.size
        if stays_open(a, gap_a, rate_a, b, gap_b, rate_b, bound) or (indistinct and gap_b > 0.0):
            if waiting == 0:
                return NO_TOUCH
            waiting -= 1
            a, gap_a, rate_a = b, gap_b, rate_b
            b, gap_b = step.wait_time[waiting], step.wait_gap[waiting]
            rate_b = step.wait_rate[waiting]
        elif gap_b <= 0.0 and rate_a + bound * width < 0.0:
            return locate(run, law, TOUCH, a, b, coarse * RESOLUTION)
        elif indistinct:
            return b
        else:
            step.wait_time[waiting], step.wait_gap[waiting] = b, gap_b
            step.wait_rate[waiting] = rate_b
            waiting += 1
            halvings += 1
            b = 0.5 * (a + b)
            gap_b, rate_b, _, _, _, _, _ = contact_after(run, b)
    return LOST
