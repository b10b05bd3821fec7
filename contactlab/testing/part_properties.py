"""Properties of a composed law: it is its parts, each asked alone."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from contactlab.arrays import Array
from contactlab.laws.composed import Composed
from contactlab.laws.friction import cone_bound
from contactlab.laws.intake import guarded
from contactlab.laws.memory import AT_TOUCH
from contactlab.testing.asking import Asked
from contactlab.testing.claim import Claims
from contactlab.testing.kernel_properties import TINY, Worst, states_of, variables_of_friction
from contactlab.testing.plants import Bench

Side = tuple[Any, tuple[Any, ...], Array]
Sides = tuple[Side, Side]
"""Friction and normal force: the part, what its kernels are asked, and its own internal variables."""


def parts_keep_apart(bench: Bench) -> Claims:
    """A composed law is its parts, each asked alone with its own coefficients and nothing behind them."""
    law, worst = bench.law, Worst()
    if not isinstance(law, Composed):
        return
    asked = Asked(law)
    for gap, rate, slip, speed, kept in states_of(bench):
        expected, found = answers_of_parts(law, gap, rate, slip, speed, kept), []
        found += asked.force(gap, rate, slip, speed, kept)
        state = gap, rate, slip, found[0], kept
        if asked.has_friction:
            found += asked.friction(*state)
        found += [*asked.rates(*state)[asked.own :], *asked.guards(*state), *asked.limits(kept)]
        for event in range(AT_TOUCH, law.guards):
            found += asked.jumped(event, *state)[asked.own :].tolist()
        for one, other in zip(found, expected, strict=True):
            apart = abs(one - other) / (abs(one) + abs(other) + TINY)
            worst.take("answers of the composed law less those of its parts alone, relative", apart)
    yield from worst.values()


def answers_of_parts(
    law: Composed, gap: float, rate: float, slip: float, speed: float, kept: Array
) -> list[float]:
    """Give what the parts of a law say of one state: force, friction, rates, guards, limits and jumps."""
    normal, damping, friction = (guarded(np.array(given)) for given in law.coefficients)
    count, part, drag = variables_of_friction(law), law.normal, law.friction
    # Nothing lies behind what each part remembers, either.
    bent, pressed = (guarded(some) for some in (kept[:count], kept[count:]))
    of_normal: tuple[Array, ...] = (pressed, normal) if part.remembered else (normal,)
    of_friction: tuple[Array, ...] = (bent, friction) if drag.remembered else (friction,)
    kernel: Any = part.elastic if part.force is None else part.force
    if part.force is None:
        spring, stored, stiffness, slope = kernel(-gap, normal, 0)
        lost = 0.0
    else:
        spring, stored, stiffness, slope, lost = kernel(-gap, -rate, pressed, normal, 0)
    alone = law.damping.damped(spring, -rate, speed, damping, 0)
    bound = cone_bound(alone, slip, friction, 0)
    if drag.bound is not None:
        bound = drag.bound(alone, slip, *of_friction, 0)
    answers = [alone, bound, stored, lost + (spring - alone) * rate]
    swept = alone, stiffness, -slope * rate, slip
    if drag.state is not None and drag.remembered:
        force, held, tangential = drag.state(*swept, *of_friction, 0)
        answers += force, 0.0, held, tangential
    elif drag.state is not None:
        z = float(kept[0]) if drag.internal_variables else 0.0
        answers += drag.state(*swept, z, friction, 0)
    way = -gap, -rate, *of_normal, 0
    limits = (0.0, 0.0) if part.limits is None else part.limits(*of_normal, 0)
    sides = (drag, (*swept, *of_friction, 0), bent), (part, way, pressed)
    return [*answers, *_memory_of_parts(sides, limits)]


def _memory_of_parts(sides: Sides, limits: tuple[float, float]) -> Iterator[float]:
    """Give rates, guards, limits and jumps of the friction and the normal force, in what each is asked."""
    (drag, _, _), _ = sides
    guards = sum(part.guards for part, _, _ in sides)
    remembering = [side for side in sides if side[0].remembered]
    for part, state, own in remembering:
        for k in range(own.size):
            yield 0.0 if part.rate is None else part.rate(k, *state)
    for part, state, _ in sides:
        for k in range(part.guards):
            yield part.guard(k, *state)
    yield from limits
    for event in range(AT_TOUCH, guards):
        for part, state, own in remembering:
            mine = event if event < 0 or part is drag else event - drag.guards
            theirs = event >= 0 and (event < drag.guards) != (part is drag)
            for k in range(own.size):
                kept_as_is = theirs or part.jump is None
                yield float(own[k]) if kept_as_is else part.jump(k, mine, *state)
