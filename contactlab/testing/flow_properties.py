"""Properties of what a law remembers: its ledger, its jumps, its guards, its limits and its mirror image."""

from collections.abc import Callable
from functools import partial

import numpy as np

from contactlab.arrays import Array
from contactlab.laws.memory import AT_RELEASE, AT_TOUCH
from contactlab.testing.asking import Asked
from contactlab.testing.claim import Claims, at_most
from contactlab.testing.flows import Instant, flow_of
from contactlab.testing.kernel_properties import TINY, Worst
from contactlab.testing.plants import Bench

NUDGE = 1e-4
"""Share of the shortest time of a state within which its energy is differentiated."""

DIFFERENCE = 1e-6
"""Error of a derivative that is a central difference, as a share."""

LOCATED = 1e-6
"""Error of what is found at an instant that is located, as a share of the largest."""


def slope(energy: Callable[[Instant], float], asked: Asked, at: Instant, span: Array) -> tuple[float, float]:
    """Give dV/dt [W] of an energy along the flow that a law's own rates make, and the difference's error."""
    normal = asked.force(at.gap, at.rate, at.slip, at.speed, at.kept)[0]
    rates = asked.rates(at.gap, at.rate, at.slip, normal, at.kept)
    ends = asked.limits(at.kept)
    times = [0.01 * at.path.duration, *(abs(at.gap - each) / (abs(at.rate) + TINY) for each in ends)]
    times += [float(size / (abs(rate) + TINY)) for size, rate in zip(span, rates, strict=True) if size > 0.0]
    h = NUDGE * min(times)

    def moved(by: float) -> Instant:
        gap, rate, slip = at.path.at(at.time + by)
        return at._replace(gap=gap, rate=rate, slip=slip, kept=at.kept + by * rates)

    coarse, fine = ((energy(moved(s)) - energy(moved(-s))) / (2.0 * s) for s in (h, 0.5 * h))
    # What float64 leaves of a difference, and what a kink in it does.
    return fine, 2.0 * abs(coarse - fine) + 1e-14 * abs(energy(at)) / h


def energy_of(asked: Asked, at: Instant) -> float:
    """Give what the normal direction stores [J]."""
    return float(asked.force(at.gap, at.rate, at.slip, at.speed, at.kept)[2])


def held_of(asked: Asked, at: Instant) -> float:
    """Give what friction stores [J]."""
    normal = asked.force(at.gap, at.rate, at.slip, at.speed, at.kept)[0]
    return float(asked.friction(at.gap, at.rate, at.slip, normal, at.kept)[2])


def losses_of(bench: Bench) -> tuple[Worst, Worst]:
    """Give the losses that are negative along a law's flows: of the normal direction, and of friction."""
    flow, pressed, dragged = flow_of(bench), Worst(), Worst()
    asked = Asked(bench.law)
    for at in flow.instants:
        normal, _, _, loss = asked.force(at.gap, at.rate, at.slip, at.speed, at.kept)
        size = abs(normal * at.rate) + abs(loss) + TINY
        pressed.take("negative normal loss along a flow, over the power", -loss / size)
        if asked.has_friction:
            drag = asked.friction(at.gap, at.rate, at.slip, normal, at.kept)[0]
            change, error = slope(partial(held_of, asked), asked, at, flow.span)
            power = abs(drag * at.slip) + abs(change) + TINY
            gained = max(drag * at.slip + change - error, 0.0) / power
            dragged.take("energy that friction makes along a flow, over the power", gained, DIFFERENCE)
    return pressed, dragged


def flow_keeps_the_ledger(bench: Bench) -> Claims:
    """dV/dt = -N gdot - loss along every flow, with V by differences; nothing is stored at a touch-down."""
    flow, worst = flow_of(bench), Worst()
    if not flow.instants:
        yield from _walked(bench)
        return
    asked, largest = Asked(bench.law), TINY
    for at in flow.instants:
        normal, _, stored, loss = asked.force(at.gap, at.rate, at.slip, at.speed, at.kept)
        change, error = slope(partial(energy_of, asked), asked, at, flow.span)
        power = abs(normal * at.rate) + abs(change) + abs(loss) + TINY
        missed = max(abs(change + normal * at.rate + loss) - error, 0.0) / power
        worst.take("dV/dt less -N gdot - loss along a flow, over the power", missed, DIFFERENCE)
        largest = max(largest, abs(stored))
    for jump in flow.jumps:
        if jump.event == AT_TOUCH:
            stored = abs(energy_of(asked, jump.at)) / largest
            worst.take("energy that is there before a touch-down, over the largest", stored, LOCATED)
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
    asked = Asked(bench.law)

    def stored(at: Instant) -> float:
        return energy_of(asked, at) + (held_of(asked, at) if asked.has_friction else 0.0)

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
    asked = Asked(law)
    yield at_most(f"drawn paths on which a guard does not let go {flow.chatter}", len(flow.chatter), 0)
    for jump in flow.jumps:
        if jump.event < 0:
            continue
        at = jump.at
        normal = asked.force(at.gap, at.rate, at.slip, at.speed, jump.kept)[0]
        rates = asked.rates(at.gap, at.rate, at.slip, normal, jump.kept)
        # A rate that has just changed its sign is zero there, and has it a moment later.
        soon = 1e-6 * at.path.duration
        gap, rate, slip = at.path.at(at.time + soon)
        kept = jump.kept + soon * rates
        normal = asked.force(gap, rate, slip, at.speed, kept)[0]
        fallen = -asked.guards(gap, rate, slip, normal, kept)[jump.event]
        worst.take(
            "guard below zero after its own jump, over its size", fallen / flow.largest[jump.event], 0.0
        )
    below = (-flow.lowest / (flow.largest + TINY)).tolist()
    for k, share in enumerate(below):
        worst.take(f"guard {k} below zero while a contact lasts, over its size", share, LOCATED)
    yield from worst.values()


def limits_in_order(bench: Bench) -> Claims:
    """A contact ends at no smaller gap than it begins at; both are numbers."""
    if bench.law.limits is None:
        return
    flow = flow_of(bench)
    limits = np.array([Asked(bench.law).limits(np.array(_initial(bench))), *flow.limits])
    odd = int((~np.isfinite(limits)).any(axis=1).sum())
    yield at_most(f"drawn paths that it cannot be followed on {flow.faults}", len(flow.faults), 0)
    yield at_most("limits that are no numbers", odd, 0)
    yield at_most(
        "gap of the beginning over that of the end", float((limits[:, 0] - limits[:, 1]).max()), 0.0, "m"
    )


def _initial(bench: Bench) -> list[float]:
    return [one.initial for one in bench.law.internal_variables]


def memory_is_its_own(bench: Bench) -> Claims:
    """No kernel reads more internal variables or parameters than there are, and all rates are numbers."""
    flow = flow_of(bench)
    if not flow.instants:
        return
    changed = wild = 0
    lured = [Asked(bench.law, lure) for lure in (np.nan, 1.0, -1.0)]
    for at in flow.instants:
        answers = [_all_of(asked, at) for asked in lured]
        changed += any(repr(answer) != repr(answers[0]) for answer in answers)
        wild += not np.isfinite(answers[0]).all()
    yield at_most("answers that change with what lies beyond the memory", changed, 0)
    yield at_most("answers that are no numbers", wild, 0)


def _all_of(asked: Asked, at: Instant) -> list[float]:
    """Give every answer that all kernels have to a state."""
    normal, bound, stored, loss = asked.force(at.gap, at.rate, at.slip, at.speed, at.kept)
    state = at.gap, at.rate, at.slip, normal, at.kept
    found = [normal, bound, stored, loss, *asked.rates(*state), *asked.limits(at.kept)]
    if asked.law.guards:
        found += asked.guards(*state).tolist()
    if asked.has_friction:
        found += asked.friction(*state)
    for event in range(AT_TOUCH, asked.law.guards):
        found += asked.jumped(event, *state).tolist()
    return [float(each) for each in found]


def image_of(bench: Bench) -> Worst:
    """Give how unlike a law is in the mirror, where odd variables change their signs as the slip does."""
    flow, worst = flow_of(bench), Worst()
    asked = Asked(bench.law)
    parity = np.array([one.parity for one in bench.law.internal_variables], dtype=np.float64)
    for at in flow.instants:
        sides = [
            (asked, at, 1.0, np.ones(parity.size)),
            (asked, at._replace(slip=-at.slip, kept=parity * at.kept), -1.0, parity),
        ]
        here, there = (np.array(_signed(*side)) for side in sides)
        apart = np.abs(here - there) / (np.abs(here) + np.abs(there) + TINY)
        worst.take("answers unlike those to the mirrored state, relative", float(apart.max()))
    return worst


def _signed(asked: Asked, at: Instant, side: float, signs: Array) -> list[float]:
    """Give the answers to a state, those that change their signs in the mirror with theirs."""
    normal, bound, stored, loss = asked.force(at.gap, at.rate, at.slip, at.speed, at.kept)
    state = at.gap, at.rate, at.slip, normal, at.kept
    found = [normal, bound, stored, loss, *(signs * asked.rates(*state)), *asked.limits(at.kept)]
    if asked.law.guards:
        found += asked.guards(*state).tolist()
    if asked.has_friction:
        drag, _, held, stiffness = asked.friction(*state)
        found += [side * drag, held, stiffness]
    for event in range(AT_TOUCH, asked.law.guards):
        found += (signs * asked.jumped(event, *state)).tolist()
    return [float(each) for each in found]
