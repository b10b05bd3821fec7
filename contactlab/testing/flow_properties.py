"""Properties of what a law remembers: its ledger, its jumps, its guards, its limits and its mirror image."""

from collections.abc import Callable

import numpy as np

from contactlab.arrays import Array
from contactlab.laws.consistency import ACCURATELY, NUDGE, TINY, derivative, ends_behind_its_beginning
from contactlab.laws.memory import AT_RELEASE, AT_TOUCH
from contactlab.testing.claim import Claims, at_most
from contactlab.testing.flows import Instant, flow_of
from contactlab.testing.kernel_properties import Worst, anomalies_of, every_result
from contactlab.testing.plants import Bench, Evaluator

LOCATED = 1e-6
"""Error of what is found at an instant that is located, as a share of the largest."""


def slope(
    energy: Callable[[Evaluator, Instant], float], evaluator: Evaluator, at: Instant, span: Array
) -> tuple[float, float]:
    """Return dV/dt [W] of an energy along the flow of a law's own rates, and the difference's error."""
    normal = evaluator.force(at.gap, at.rate, at.slip, at.speed, at.kept)[0]
    rates = evaluator.rates(at.gap, at.rate, at.slip, normal, at.kept)
    ends = evaluator.limits(at.kept)
    times = [0.01 * at.path.duration, *(abs(at.gap - each) / (abs(at.rate) + TINY) for each in ends)]
    times += [float(size / (abs(rate) + TINY)) for size, rate in zip(span, rates, strict=True) if size > 0.0]

    def moved(by: float) -> float:
        gap, rate, slip = at.path.at(at.time + by)
        return energy(evaluator, at._replace(gap=gap, rate=rate, slip=slip, kept=at.kept + by * rates))

    return derivative(moved, 0.0, NUDGE * min(times))


def energy_of(evaluator: Evaluator, at: Instant) -> float:
    """Return what the normal direction stores [J]."""
    return float(evaluator.force(at.gap, at.rate, at.slip, at.speed, at.kept)[2])


def stored_energy(evaluator: Evaluator, at: Instant) -> float:
    """Return what friction stores [J]."""
    normal = evaluator.force(at.gap, at.rate, at.slip, at.speed, at.kept)[0]
    return float(evaluator.friction(at.gap, at.rate, at.slip, normal, at.kept)[2])


def losses_of(bench: Bench) -> tuple[Worst, Worst]:
    """Return the losses that are negative along a law's flows: of the normal direction, and of friction."""
    flow, pressed, dragged = flow_of(bench), Worst(), Worst()
    evaluator = Evaluator(bench.law)
    for at in flow.instants:
        normal, _, _, loss = evaluator.force(at.gap, at.rate, at.slip, at.speed, at.kept)
        size = abs(normal * at.rate) + abs(loss) + TINY
        pressed.take("negative normal loss along a flow, over the power", -loss / size)
        if evaluator.has_friction:
            drag = evaluator.friction(at.gap, at.rate, at.slip, normal, at.kept)[0]
            change, error = slope(stored_energy, evaluator, at, flow.span)
            power = abs(drag * at.slip) + abs(change) + TINY
            gained = max(drag * at.slip + change - error, 0.0) / power
            dragged.take("energy that friction makes along a flow, over the power", gained, ACCURATELY)
    return pressed, dragged


def flow_keeps_the_ledger(bench: Bench) -> Claims:
    """dV/dt = -N gdot - loss along every flow, with V by differences; a touch-down makes none."""
    flow, worst = flow_of(bench), Worst()
    if not flow.instants:
        yield from _walked(bench)
        return
    evaluator, largest = Evaluator(bench.law), TINY
    for at in flow.instants:
        normal, _, stored, loss = evaluator.force(at.gap, at.rate, at.slip, at.speed, at.kept)
        change, error = slope(energy_of, evaluator, at, flow.span)
        power = abs(normal * at.rate) + abs(change) + abs(loss) + TINY
        missed = max(abs(change + normal * at.rate + loss) - error, 0.0) / power
        worst.take("dV/dt less -N gdot - loss along a flow, over the power", missed, ACCURATELY)
        largest = max(largest, abs(stored))
    left, path = 0.0, None
    for jump in flow.jumps:
        # A new path begins with nothing, and so does a contact that remembers nothing of the one before.
        fresh = jump.at.path is not path or np.array_equal(jump.at.kept, evaluator.initial)
        path = jump.at.path
        if jump.event == AT_TOUCH:
            result = energy_of(evaluator, jump.at) - (0.0 if fresh else left)
            text = "energy that a touch-down finds beyond what a release has left, over the largest"
            worst.take(text, result / largest, LOCATED)
        elif jump.event == AT_RELEASE:
            left = energy_of(evaluator, jump.at)
    yield from _walked(bench)
    yield from worst.values()


def _walked(bench: Bench) -> Claims:
    faults = flow_of(bench).faults if bench.law.limits is None else []
    if bench.law.internal_variables and not bench.rigid:
        yield at_most(f"drawn paths that it cannot be followed on {faults}", len(faults), 0)


def jumps_lose(bench: Bench) -> Claims:
    """What is stored falls where the internal variables jump, and is not negative where a contact ends."""
    flow, worst = flow_of(bench), Worst()
    if not flow.jumps:
        return
    evaluator = Evaluator(bench.law)

    def stored(at: Instant) -> float:
        return energy_of(evaluator, at) + (stored_energy(evaluator, at) if evaluator.has_friction else 0.0)

    largest = max([abs(stored(at)) for at in flow.instants], default=0.0) + TINY
    for jump in flow.jumps:
        before = stored(jump.at)
        if jump.event == AT_RELEASE:
            worst.take("energy owed at a release, over the largest", -before / largest, LOCATED)
        else:
            gained = (stored(jump.at._replace(kept=jump.kept)) - before) / largest
            worst.take("energy that a jump makes, over the largest", gained)
    yield from worst.values()


def guards_let_go(bench: Bench) -> Claims:
    """A guard that has fallen is positive again after its jump, and none stays below zero."""
    law, flow, worst = bench.law, flow_of(bench), Worst()
    if not law.guards:
        return
    evaluator = Evaluator(law)
    yield at_most(f"drawn paths on which a guard does not let go {flow.chatter}", len(flow.chatter), 0)
    for jump in flow.jumps:
        if jump.event < 0:
            continue
        at = jump.at
        normal = evaluator.force(at.gap, at.rate, at.slip, at.speed, jump.kept)[0]
        rates = evaluator.rates(at.gap, at.rate, at.slip, normal, jump.kept)
        # A rate that has just changed its sign is zero there, and has it a moment later.
        soon = 1e-6 * at.path.duration
        gap, rate, slip = at.path.at(at.time + soon)
        kept = jump.kept + soon * rates
        normal = evaluator.force(gap, rate, slip, at.speed, kept)[0]
        fallen = -evaluator.guards(gap, rate, slip, normal, kept)[jump.event]
        worst.take(
            "guard below zero after its own jump, over its size", fallen / flow.largest[jump.event], 0.0
        )
    for k, share in enumerate((-flow.lowest / (flow.largest + TINY)).tolist()):
        worst.take(f"guard {k} below zero while a contact lasts, over its size", share, LOCATED)
    yield from worst.values()


def limits_in_order(bench: Bench) -> Claims:
    """A contact ends at no smaller gap than it begins at; both are numbers."""
    if bench.law.limits is None:
        return
    flow, evaluator = flow_of(bench), Evaluator(bench.law)
    limits = [evaluator.limits(evaluator.initial), *flow.limits]
    odd = int((~np.isfinite(limits)).any(axis=1).sum())
    yield at_most(f"drawn paths that it cannot be followed on {flow.faults}", len(flow.faults), 0)
    yield at_most("limits that are no numbers", odd, 0)
    yield max((ends_behind_its_beginning(*each) for each in limits), key=lambda claim: claim.value)


def memory_is_its_own(bench: Bench) -> Claims:
    """No kernel reads more internal variables or parameters than there are, and all answers are numbers."""
    anomalies = anomalies_of(bench)
    yield at_most("answers that change with what lies beyond the memory", anomalies.beyond, 0)
    yield at_most("answers that are no numbers", anomalies.wild, 0)


def image_of(bench: Bench) -> Worst:
    """Return how unlike a law is in the mirror, where odd variables change their signs as the slip does."""
    flow, worst = flow_of(bench), Worst()
    evaluator = Evaluator(bench.law)
    parity = np.array([item.parity for item in bench.law.internal_variables], dtype=np.float64)
    for at in flow.instants:
        mirrored = at.gap, at.rate, -at.slip, at.speed, parity * at.kept
        here = np.array(every_result(evaluator, (at.gap, at.rate, at.slip, at.speed, at.kept)))
        there = np.array(every_result(evaluator, mirrored, -1.0, parity))
        apart = np.abs(here - there) / (np.abs(here) + np.abs(there) + TINY)
        worst.take("answers unlike those to the mirrored state, relative", float(apart.max()))
    return worst
