"""Finding the touch-down of a free flight: the first zero of the gap, and never a later one.

Over a stretch of flight the gap's second derivative is bounded by B. Between two instants at which
gap and gap rate are known, the gap lies above both parabolas that leave them with curvature -B. Where
these stay positive there is no contact; where they do not, the stretch is halved, left half first,
until every piece is either proven open or holds one falling zero.
"""

from math import sqrt

from contactlab.arrays import Array
from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.plant import Plant
from contactlab.engine.step import Step, flow_to, tip_motion
from contactlab.motor.geometry import contact_frame

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


@part_kernel
def gap_and_rate(plant: Plant, q: Array, v: Array) -> tuple[float, float]:
    """Gap [m] and gap rate [m/s] of a state."""
    u, th, u_rate, th_rate, _ = tip_motion(plant, q, v)
    gap, n_u, n_th, _, _ = contact_frame(u, th, plant.tip_length, plant.radius, plant.clearance)
    return gap, n_u * u_rate + n_th * th_rate


@part_kernel
def curvature_bound(plant: Plant, step: Step, h: float) -> float:
    """B >= |gddot| over the next h of flight [m/s^2], for as long as the gap is open.

    A free oscillator's acceleration a obeys the oscillator's own equation, so that
    |a(s)| <= |a(0)| + |adot(0)| min(s, 1/sqrt k) for any damping; the tones add their amplitudes. The
    answer from rest to a force f exp(i omega s) has |a(s)| <= |f| (1 + omega s), as its impulse response
    never moves faster than it began. The rest is geometry: |dn.L/dth| <= L_tip |th| (L_tip + R + |e|) / R
    and the centripetal terms.
    """
    u_acc = 0.0
    th_acc = 0.0
    u = 0.0
    th = 0.0
    u_rate = 0.0
    th_rate = 0.0
    for j in range(plant.stiffness.size):
        k, c = plant.stiffness[j], plant.damping[j]
        acceleration = -c * step.free_v[j] - k * step.free_q[j]
        jerk = -c * acceleration - k * step.free_v[j]
        reach = h if k * h * h < 1.0 else 1.0 / sqrt(k)
        bound = abs(acceleration) + abs(jerk) * reach + abs(plant.constant[j])
        u_acc += abs(plant.row_u[j]) * bound
        th_acc += abs(plant.row_th[j]) * bound
        u += plant.row_u[j] * step.q[j]
        th += plant.row_th[j] * step.q[j]
        u_rate += plant.row_u[j] * step.v[j]
        th_rate += plant.row_th[j] * step.v[j]
    for p in range(plant.near.shape[0]):
        j, k = plant.near[p, 0], plant.near[p, 1]
        bound = sqrt(plant.force_re[j, k] ** 2 + plant.force_im[j, k] ** 2)
        bound *= 1.0 + plant.omega[k] * h
        u_acc += abs(plant.row_u[j]) * bound
        th_acc += abs(plant.row_th[j]) * bound
    for k in range(plant.omega.size):
        u_acc += plant.omega[k] ** 2 * plant.steady_u[k]
        th_acc += plant.omega[k] ** 2 * plant.steady_th[k]
    u_rate = abs(u_rate) + u_acc * h
    th_rate = abs(th_rate) + th_acc * h
    u = abs(u) + u_rate * h
    th = abs(th) + th_rate * h
    tip = plant.tip_length
    excess = plant.clearance + u + 0.5 * tip * th * th
    lever = tip * th * (tip + plant.radius + excess) / plant.radius
    speed = u_rate + tip * th_rate
    return u_acc + lever * th_acc + tip * th_rate * th_rate + speed * speed / plant.radius


@inner_kernel
def coarseness(plant: Plant, step: Step) -> float:
    """What the digits of the gap [m] grow by where the parts that it is summed from outgrow REACH.

    Round-off is that of the parts: clearance, free motion and steady state of every mode, and the slope's
    by its lever.
    """
    u = plant.clearance
    th = 0.0
    slope = 0.0
    for j in range(plant.stiffness.size):
        part = abs(step.free_q[j])
        for k in range(plant.omega.size):
            part += abs(plant.steady_re[j, k]) + abs(plant.steady_im[j, k])
        u += abs(plant.row_u[j]) * part
        th += abs(plant.row_th[j]) * part
        slope += plant.row_th[j] * step.q[j]
    lever = plant.tip_length * abs(slope) * (1.0 + plant.tip_length / plant.radius)
    return max((abs(u) + lever * th) / REACH, 1.0)


@inner_kernel
def stays_open(
    a: float, gap_a: float, rate_a: float, b: float, gap_b: float, rate_b: float, bound: float
) -> bool:
    """Whether the gap is proven positive on [a, b]."""
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
def certain_opening(plant: Plant, step: Step, h: float, coarse: float) -> float:
    """Time up to which the gap only widens and at which it is open, in (0, h); zero where none is known.

    The gap lies above gap + rate s - B s^2/2, whose highest point this is: a release whose own gap
    is lost in round-off is well clear there, before it could close again.

    Args:
        plant, step: the flight, as `begin` left it.
        h: end of the stretch [s].
        coarse: see `coarseness`.
    """
    gap, rate = gap_and_rate(plant, step.q, step.v)
    bound = curvature_bound(plant, step, h)
    if rate > 0.0 and rate < bound * h and gap + 0.5 * rate * rate / bound > coarse * ROUND_OFF:
        return rate / bound
    return 0.0


@inner_kernel
def first_touch(
    plant: Plant,
    step: Step,
    start: float,
    h: float,
    gap_end: float,
    rate_end: float,
    coarse: float,
    stack: Array,
) -> float:
    """Time of the first touch-down in (start, h] of a flight that is open at `start`, NO_TOUCH or LOST.

    Args:
        plant, step: the flight, as `begin` left it.
        start, h: beginning and end of the stretch [s].
        gap_end, rate_end: gap [m] and its rate [m/s] at h.
        coarse: see `coarseness`.
        stack: scratch, shape (>= 64, 3).
    """
    a = start
    gap_a, rate_a = gap_and_rate(plant, step.q, step.v)
    if start > 0.0:
        flow_to(plant, step, start)
        gap_a, rate_a = gap_and_rate(plant, step.other_q, step.other_v)
    b, gap_b, rate_b = h, gap_end, rate_end
    bound = curvature_bound(plant, step, h)
    waiting = 0
    halvings = 0
    while halvings < MOST_HALVINGS:
        width = b - a
        indistinct = bound * width * width < coarse * RESOLUTION or waiting >= stack.shape[0]
        if stays_open(a, gap_a, rate_a, b, gap_b, rate_b, bound) or (indistinct and gap_b > 0.0):
            if waiting == 0:
                return NO_TOUCH
            waiting -= 1
            a, gap_a, rate_a = b, gap_b, rate_b
            b, gap_b, rate_b = stack[waiting, 0], stack[waiting, 1], stack[waiting, 2]
        elif gap_b <= 0.0 and rate_a + bound * width < 0.0:
            return _falling_zero(plant, step, a, gap_a, b, gap_b, coarse * RESOLUTION)
        elif indistinct:
            return b
        else:
            stack[waiting, 0], stack[waiting, 1], stack[waiting, 2] = b, gap_b, rate_b
            waiting += 1
            halvings += 1
            b = 0.5 * (a + b)
            flow_to(plant, step, b)
            gap_b, rate_b = gap_and_rate(plant, step.other_q, step.other_v)
    return LOST


@inner_kernel
def _falling_zero(
    plant: Plant, step: Step, a: float, gap_a: float, b: float, gap_b: float, digit: float
) -> float:
    """The zero of a falling gap in [a, b], to a digit [m]: Newton, kept inside the bracket."""
    s = a + (b - a) * gap_a / (gap_a - gap_b)
    for _ in range(60):
        flow_to(plant, step, s)
        gap, rate = gap_and_rate(plant, step.other_q, step.other_v)
        if gap > 0.0:
            a = s
        else:
            b = s
        if abs(gap) < digit or b - a < 1e-18:
            break
        target = s - gap / rate if rate < 0.0 else 0.5 * (a + b)
        following = target if a < target < b else 0.5 * (a + b)
        if following == s:
            break
        s = following
    return s
