"""Properties of a composed law: it is its parts, each evaluated alone."""

from typing import Any

import numpy as np

from contactlab.arrays import Array
from contactlab.laws.composed import Composed
from contactlab.laws.memory import AT_TOUCH
from contactlab.testing.claim import Claims
from contactlab.testing.evaluation import Evaluator
from contactlab.testing.kernel_properties import TINY, Worst, states_of
from contactlab.testing.plants import Bench


def parts_keep_apart(bench: Bench) -> Claims:
    """A composed law is its parts, each evaluated alone with its own coefficients and variables."""
    law, worst = bench.law, Worst()
    if not isinstance(law, Composed):
        return
    evaluator = Evaluator(law)
    for gap, rate, slip, speed, kept in states_of(bench):
        expected = forces_of_parts(law, gap, rate, slip, speed, kept)
        result = [*evaluator.force(gap, rate, slip, speed, kept)]
        state = gap, rate, slip, result[0], kept
        if evaluator.has_friction:
            result += evaluator.friction(*state)
        result += [
            *evaluator.rates(*state)[evaluator.own :],
            *evaluator.guards(*state),
            *evaluator.limits(kept),
        ]
        for event in range(AT_TOUCH, law.guards):
            result += evaluator.jumped(event, *state)[evaluator.own :].tolist()
        for item, other in zip(result, expected, strict=True):
            apart = abs(item - other) / (abs(item) + abs(other) + TINY)
            worst.take("answers of the composed law less those of its parts alone, relative", apart)
    yield from worst.values()


def forces_of_parts(
    law: Composed, gap: float, rate: float, slip: float, speed: float, kept: Array
) -> list[float]:
    """Return force, friction, rates, guards, limits and jumps of the parts of a law in one state."""
    part, drag = law.normal, law.friction
    state = {"gap": gap, "depth": -gap, "gap_rate": rate, "depth_rate": -rate, "slip": slip}
    state |= {"impact_speed": speed}
    count = len(drag.internal_variables)
    bent, pressed = _variables_of(drag, kept[:count]), _variables_of(part, kept[count:])
    if part.force is None:
        (spring, stored, stiffness, slope), lost = part.evaluate("elastic", **state, **pressed), 0.0
    else:
        spring, stored, stiffness, slope, lost = part.evaluate("force", **state, **pressed)
    damping: Any = law.damping
    solved = {**damping.solved(part), "elastic_force": spring}
    alone = damping.evaluate("damped", **state, **solved)
    pressing = {**state, **bent, "normal": alone}
    two_sided = drag.bounds is not None
    bound = drag.evaluate("bounds", **pressing)[1] if two_sided else drag.evaluate("bound", **pressing)
    results = [alone, bound, stored, lost + (spring - alone) * rate]
    swept = {**state, **bent, "normal": alone, "normal_stiffness": stiffness}
    swept["normal_stiffness_rate"] = -slope * rate
    if drag.state is not None:
        arguments = drag.evaluate("state", **swept)
        results += (
            (arguments[0], 0.0, *arguments[1:]) if len(drag.internal_variables) > drag.coupled else arguments
        )
    sides = ((drag, swept, kept[:count]), (part, {**state, **pressed}, kept[count:]))
    for each, known, own in sides:
        for k in range(own.size if len(each.internal_variables) > getattr(each, "coupled", 0) else 0):
            results.append(0.0 if each.rate is None else each.evaluate("rate", **known, which=k))
    for each, known, _ in sides:
        results += [each.evaluate("guard", **known, which=k) for k in range(each.guards)]
    results += (0.0, 0.0) if part.limits is None else part.evaluate("limits", **state, **pressed)
    for event in range(AT_TOUCH, law.guards):
        for each, known, own in sides:
            mine = event if event < 0 or each is drag else event - drag.guards
            theirs = event >= 0 and (event < drag.guards) != (each is drag)
            for k in range(own.size if len(each.internal_variables) > getattr(each, "coupled", 0) else 0):
                as_it_was = theirs or each.jump is None
                jumped = float(own[k]) if as_it_was else each.evaluate("jump", **known, which=k, event=mine)
                results.append(jumped)
    return results


def _variables_of(part: Any, values: Array) -> dict[str, Any]:
    """Return the internal variables of a part by name, and as z."""
    named = zip(part.internal_variables, values.tolist(), strict=True)
    return {"z": np.array(values), **{variable.name: value for variable, value in named}}
