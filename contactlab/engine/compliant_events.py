"""Inside a step of a compliant contact: its friction mode, what ends it, and its extremes."""

from contactlab.arrays import Array
from contactlab.compiled import inner_kernel, part_kernel
from contactlab.engine.contacts import count_event
from contactlab.engine.events import CONE, NOTHING, RELEASE, REVERSAL
from contactlab.engine.plant import Plant
from contactlab.engine.run import DEPTH, DURATION, PEAK, SIGN, SWITCHES, Run
from contactlab.engine.state_friction import contact_at, sliding_at
from contactlab.engine.step import (
    BOUND,
    FRICTION,
    LENGTH,
    MODE,
    NORMAL,
    RUBBING,
    TAKEN,
    Step,
    flow_to,
    force_at,
    largest,
)
from contactlab.engine.tables import NODES, Tables
from contactlab.engine.touchdown import gap_and_rate
from contactlab.laws.base import RATE_DEPENDENT, SET_VALUED, SLIP, STICK, FrictionKernel

SLIP_ROUND_OFF = 1e-13
"""Slip velocity [m/s] that a located reversal may leave."""

CONE_ROUND_OFF = 1e-9
"""Relative excess of friction over its bound that still sticks: the bound is reached, not left."""


@inner_kernel
def switch_friction(step: Step, run: Run, event: int) -> None:
    """Set the friction mode after a step that ended in REVERSAL or CONE."""
    if event == REVERSAL:
        step.whole[MODE] = STICK
    else:
        _slip_against(step, run, force_at(step, FRICTION, step.real[TAKEN] / step.real[LENGTH]))
    _count_switch(run)


@inner_kernel
def _slip_against(step: Step, run: Run, friction: float) -> None:
    step.whole[MODE] = SLIP
    run.whole[SIGN] = -1 if friction > 0.0 else 1


@inner_kernel
def _count_switch(run: Run) -> None:
    run.whole[SWITCHES] += 1
    count_event(run)


@part_kernel
def contradicted(
    plant: Plant,
    step: Step,
    run: Run,
    slip: float,
    rub: FrictionKernel,
    parameters: Array,
) -> bool:
    """Whether the step denies its own friction mode from its start; the other mode is then set.

    Stick whose friction leaves the cone at once must slip against it; slip that starts from
    zero into the wrong direction must stick. Creeping friction has no modes.
    """
    if step.whole[RUBBING] == RATE_DEPENDENT:
        return False
    if step.whole[MODE] == STICK:
        bound = step.force[BOUND, 0]
        friction = step.force[FRICTION, 0]
        if abs(friction) > bound * (1.0 + CONE_ROUND_OFF) and (
            force_at(step, BOUND, 0.0) <= abs(force_at(step, FRICTION, 0.0))
        ):
            _slip_against(step, run, friction)
            _count_switch(run)
            return True
        return False
    sign = run.whole[SIGN]
    if largest(step.force[BOUND]) > 0.0 and sign * step.sliding[0] < 0.0:
        if step.whole[RUBBING] != SET_VALUED:
            begun = run.contact[DURATION] > 0.0
            slip = sliding_at(plant, step, 0.0, rub, parameters) if begun else 0.0
        if sign * slip > SLIP_ROUND_OFF:
            return False
        step.whole[MODE] = STICK
        _count_switch(run)
        return True
    return False


@part_kernel
def first_event(
    plant: Plant,
    tables: Tables,
    step: Step,
    run: Run,
    rate: float,
    rub: FrictionKernel,
    parameters: Array,
) -> tuple[int, float]:
    """The earliest event in the step and its time, or NOTHING and the step's length.

    Args:
        plant, tables, step, run: the step.
        rate: gap rate at its start [m/s].
        rub, parameters: the law.
    """
    left = 0.0
    before = rate
    sticks = step.whole[MODE] == STICK
    rubs = largest(step.force[BOUND]) > 0.0 and step.whole[RUBBING] != RATE_DEPENDENT
    for i in range(NODES):
        right = tables.nodes[i] * step.real[LENGTH]
        first = NOTHING
        s = right
        for event in (CONE, REVERSAL, RELEASE):
            if event == RELEASE:
                # A gap that is open while it closes is round-off of a touch-down.
                happened = step.gap[i] >= 0.0 and step.gap_rate[i] >= 0.0
            elif event == REVERSAL:
                happened = rubs and not sticks and run.whole[SIGN] * step.sliding[i] < 0.0
            else:
                ceiling = step.force[BOUND, i] * (1.0 + CONE_ROUND_OFF)
                happened = sticks and abs(step.force[FRICTION, i]) > ceiling
            if happened:
                at = locate(plant, step, event, left, right, rub, parameters)
                if event == RELEASE and at == left and before < 0.0:
                    at = right
                first, s = (event, at) if first == NOTHING or at < s else (first, s)
        now = step.gap_rate[i]
        if before > 0.0 > now and step.gap[i] < 0.0:
            top = _highest(plant, step, left, right, before, now)
            if top > 0.0:
                at = locate(plant, step, RELEASE, left, top, rub, parameters)
                first, s = (RELEASE, at) if first == NOTHING or at < s else (first, s)
        if first != NOTHING:
            return first, s
        left = right
        before = now
    return NOTHING, step.real[LENGTH]


@inner_kernel
def _highest(
    plant: Plant, step: Step, left: float, right: float, before: float, after: float
) -> float:
    """A time at which the gap is open between two nodes at which it is closed, or zero where there is none.

    The gap rate falls from `before` to `after`; its zero by secants, of which two are plenty.
    """
    at = left
    for _ in range(3):
        at = left + (right - left) * before / (before - after)
        flow_to(plant, step, at)
        gap, rate = gap_and_rate(plant, step.other_q, step.other_v)
        if gap >= 0.0:
            return at
        if rate > 0.0:
            left, before = at, rate
        else:
            right, after = at, rate
    return 0.0


@inner_kernel
def track_extremes(
    plant: Plant, tables: Tables, step: Step, run: Run, gap: float, rate: float, normal: float
) -> None:
    """Largest normal force and penetration of the contact so far, between the nodes as well.

    Args:
        plant, tables, step, run: the step.
        gap, rate, normal: gap [m], its rate [m/s] and normal force [N] at its start.
    """
    s, h = step.real[TAKEN], step.real[LENGTH]
    run.contact[PEAK] = max(run.contact[PEAK], normal)
    run.contact[DEPTH] = max(run.contact[DEPTH], -gap)
    before = rate
    left = 0.0
    for i in range(NODES):
        right, gap, now = tables.nodes[i] * h, step.gap[i], step.gap_rate[i]
        if right > s:
            # An event or the end of the run cuts the step here.
            right = s
            flow_to(plant, step, s)
            gap, now = gap_and_rate(plant, step.other_q, step.other_v)
        run.contact[PEAK] = max(run.contact[PEAK], force_at(step, NORMAL, right / h))
        run.contact[DEPTH] = max(run.contact[DEPTH], -gap)
        if before < 0.0 <= now and left < right:
            # The turning point by a line through the rates, and from there by the gap's parabola.
            curvature = (now - before) / (right - left)
            flow_to(plant, step, left - before / curvature)
            gap, slope = gap_and_rate(plant, step.other_q, step.other_v)
            run.contact[DEPTH] = max(run.contact[DEPTH], 0.5 * slope * slope / curvature - gap)
        if right == s:
            break
        before = now
        left = right
    _track_peak(step, run, s / h)


@inner_kernel
def _track_peak(step: Step, run: Run, end: float) -> None:
    """Largest normal force from the zero of its polynomial's slope on [0, end], if it has one."""
    left, right = 0.0, end
    if not (_slope(step, left) > 0.0 > _slope(step, right)):
        return
    for _ in range(60):
        middle = 0.5 * (left + right)
        if _slope(step, middle) > 0.0:
            left = middle
        else:
            right = middle
    run.contact[PEAK] = max(run.contact[PEAK], force_at(step, NORMAL, left))


@inner_kernel
def _slope(step: Step, x: float) -> float:
    """Derivative of the normal force polynomial at x = s/h."""
    total = 0.0
    for d in range(NODES - 1, 0, -1):
        total = total * x + d * step.shape[NORMAL, d]
    return total


@inner_kernel
def event_value(
    plant: Plant, step: Step, s: float, event: int, rub: FrictionKernel, parameters: Array
) -> float:
    """A function of time in the step whose zero is the event."""
    if event == CONE:
        x = s / step.real[LENGTH]
        return force_at(step, BOUND, x) - abs(force_at(step, FRICTION, x))
    if event == REVERSAL:
        return sliding_at(plant, step, s, rub, parameters)
    flow_to(plant, step, s)
    return contact_at(plant, step.other_q, step.other_v)[0]


@inner_kernel
def locate(
    plant: Plant,
    step: Step,
    event: int,
    left: float,
    right: float,
    rub: FrictionKernel,
    parameters: Array,
) -> float:
    """Time of an event between left and right, where its function has different signs.

    Regula falsi that halves the value of an end that stays twice (the Illinois rule).
    """
    at_left = event_value(plant, step, left, event, rub, parameters)
    at_right = event_value(plant, step, right, event, rub, parameters)
    if at_left == 0.0 or at_left * at_right > 0.0:
        # The zero lies at an end, to round-off: the nearer one.
        return left if abs(at_left) <= abs(at_right) else right
    stayed = 0
    before = left
    s = right
    for _ in range(100):
        s = (at_left * right - at_right * left) / (at_left - at_right)
        if not left < s < right:
            s = 0.5 * (left + right)
        value = event_value(plant, step, s, event, rub, parameters)
        if value == 0.0 or abs(s - before) <= 1e-14 * step.real[LENGTH]:
            break
        before = s
        if value * at_right > 0.0:
            right, at_right = s, value
            if stayed < 0:
                at_left *= 0.5
            stayed = -1
        else:
            left, at_left = s, value
            if stayed > 0:
                at_right *= 0.5
            stayed = 1
    return s
