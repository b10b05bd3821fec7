"""Properties of what a law declares: parameters that act, units that fit, stiffness and stored energy."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import fields, is_dataclass, replace
from functools import cache
from itertools import islice
from math import isnan
from typing import Any

import numpy as np

from contactlab.laws import ContactLaw
from contactlab.laws.bare import Bare
from contactlab.laws.base import RATE_DEPENDENT, NormalForce, PenaltyLaw
from contactlab.laws.composed import Composed
from contactlab.laws.consistency import ACCURATELY, TINY, stiffness_is_a_derivative
from contactlab.laws.memory import AT_TOUCH
from contactlab.parameter import declared_fields, from_cf
from contactlab.quantity import dimensions
from contactlab.testing.claim import Claims, at_most
from contactlab.testing.kernel_properties import Worst, drawn_impacts, drawn_pressures, states_of
from contactlab.testing.plants import Bench, Evaluator

Put = Callable[[float, str], float]
"""Takes a number in SI and its units; gives it in the units of a bench."""

SCALES = {"[length]": 2.0**7, "[mass]": 2.0**-3, "[time]": 2.0**5}
"""Other units of length, mass and time: what a number in SI is multiplied by."""

SMALL_SLIP = 1e-3
"""Slip velocity at which a friction is loaded and unloaded [m/s]."""

LONGER = (1.0, 1e3, 1e6, 1e12)
"""What the internal variables of the states are multiplied by, so that bounds on them are met."""

LOADING = 200
"""Steps of a loading, and of the unloading after it."""


def reads_what_it_declares(bench: Bench) -> Claims:
    """Every parameter that a law declares changes some answer of its kernels."""
    law = bench.law
    # How many pieces there are, the number of the variables shows.
    unread = [
        name for name, value, text in law.effective() if text is not None and not isinstance(value, int)
    ]
    with np.errstate(all="ignore"):
        for each in (bench, replace(bench, law=_elsewhere(law))):
            if unread:
                before = [*_outputs(each.law, each)]
                unread = [name for name in unread if not _acts(name, each, before)]
    yield at_most(f"parameters that no kernel reads {unread}", len(unread), 0)


def _acts(name: str, bench: Bench, before: list[float]) -> bool:
    """Return whether another value of a parameter changes an answer, the first of which decides."""
    now = bench.law.describe()[name]
    # What decides between two answers, as the end of stick, shows by larger steps alone.
    for nearby in (1.001 * now, 0.5 * now, 2.0 * now, 0.01 * now, 100.0 * now) if now != 0.0 else (1e-3, 1.0):
        with suppress(ValueError, TypeError):
            others = _outputs(bench.law.changed(name, nearby), bench)
            if any(a != b and not isnan(a) * isnan(b) for a, b in zip(others, before, strict=True)):
                return True
    return False


def scales_with_units(bench: Bench) -> Claims:
    """In other units of length, mass and time the kernels give the same answers, in those units.

    Every number has the units that are declared of it: a stiffness of a power that is not the declared one,
    or a constant with a dimension inside a kernel, does not fit. The parameters of a bare function have no
    units to be changed, so that nothing is claimed of a law that has some.
    """
    law, worst = bench.law, Worst()
    if any(isinstance(part, Bare) for part in getattr(law, "parts", ())):
        yield at_most("not asked: the parameters of a bare function cannot declare units", 0, 0)
        return
    other = _in_other_units(law)
    pairs = zip(_named_outputs(other, bench, scaled=True), _named_outputs(law, bench), strict=True)
    for (values, _), (expected, kind) in pairs:
        missed = abs(values / _scale(kind) - expected) / (abs(expected) + TINY)
        worst.take("answers in other units less those in SI, relative", missed, 1e-9)
    yield from worst.values()


def part_says_its_stiffness(bench: Bench) -> Claims:
    """A normal force's stiffness and slope are the derivatives of its force and stiffness by the depth.

    Those of a bare function are of its force at rest, and asked for there.
    """
    law, worst = bench.law, Worst()
    if not isinstance(law, Composed):
        return
    part: NormalForce = law.normal
    count = len(law.friction.internal_variables)
    names = [item.name for item in part.internal_variables]
    for gap, rate, _, _, kept in states_of(bench):
        depth, z = -gap, kept[count:].copy()
        rate = 0.0 if isinstance(part, Bare) else rate
        known: dict[str, Any] = {"gap_rate": rate, "depth_rate": -rate, "slip": 0.0, "impact_speed": 0.0}
        known |= {"z": z, **dict(zip(names, z.tolist(), strict=True))}
        worst.add(*stiffness_is_a_derivative(part, depth, known, ACCURATELY))
    yield from worst.values()


def friction_stores_what_it_gives(bench: Bench) -> Claims:
    """Slip to and fro within the cone loses energy all along, with what friction stores taken into account.

    -F v - dE/dt >= 0: a store that is too small gives back what it never had, one that is too large takes
    more than the slip does work. The gap is held.
    """
    law, worst = bench.law, Worst()
    if not isinstance(law, PenaltyLaw) or law.friction_kind != RATE_DEPENDENT:
        return
    evaluator = Evaluator(law)
    gap = min(evaluator.limits(evaluator.initial)) - 1e-6
    normal = evaluator.force(gap, 0.0, SMALL_SLIP, 0.0, evaluator.initial)[0]
    if not normal > 0.0:
        return
    span = 1e-12
    loaded: list[tuple[float, float]] = []
    while span < 1e-3 and not loaded:
        # The first span at whose end a good part of the friction has built up.
        span *= 2.0
        if (
            abs(_loaded(evaluator, gap, normal, span, LOADING // 2)[-1][0])
            > 0.2 * law.friction_limit * normal
        ):
            loaded = _loaded(evaluator, gap, normal, span, LOADING)
    if not loaded:
        return
    drag, stored = np.transpose(loaded)
    way = span / (LOADING // 2) * np.where(np.arange(LOADING) < LOADING // 2, 1.0, -1.0)
    work = np.concatenate([[0.0], np.cumsum(-0.5 * (drag[1:] + drag[:-1]) * way)])
    lost = work - (stored - stored[0])
    most = float(np.abs(work).max() + np.abs(stored).max()) + TINY
    gained = float((np.maximum.accumulate(lost) - lost).max()) / most
    # The trapezium's error at friction that sets in with the first step.
    worst.take("energy that friction gains over slip to and fro, over its work", gained, 0.02)
    yield from worst.values()


def _loaded(
    evaluator: Evaluator, gap: float, normal: float, span: float, steps: int
) -> list[tuple[float, float]]:
    """Return friction [N] and its stored energy [J] along a slip of a span [m] forwards, then back."""
    kept, result = evaluator.initial.copy(), []
    length = span / (LOADING // 2) / SMALL_SLIP
    for i in range(steps + 1):
        slip = SMALL_SLIP if i < LOADING // 2 else -SMALL_SLIP
        friction, _, stored, _ = evaluator.friction(gap, 0.0, slip, normal, kept)
        result.append((float(friction), float(stored)))
        for _ in range(20):
            first = evaluator.rates(gap, 0.0, slip, normal, kept)
            middle = evaluator.rates(gap, 0.0, slip, normal, kept + 0.5 * length / 20 * first)
            kept = kept + length / 20 * middle
    return result


def _elsewhere(law: ContactLaw) -> ContactLaw:
    """Return the law with other numbers than its own: with an arm of no stiffness its time has no say."""
    other = law
    for name, value, text in law.effective():
        if text is not None and not isinstance(value, int):
            for instead in (1.3 * value,) if value != 0.0 else (1.0, 1e-3):
                with suppress(ValueError, TypeError):
                    other = other.changed(name, instead)
                    break
    return other


def _outputs(law: ContactLaw, bench: Bench) -> Iterator[float]:
    """Yield all that the kernels of a law answer to the states of a bench, after long histories too."""
    for longer in LONGER:
        yield from (value for value, _ in _named_outputs(law, bench, longer))
    # What units do not tell: the signs of guards.
    evaluator = Evaluator(law)
    for gap, rate, slip, speed, kept in [] if bench.rigid else states_of(bench):
        normal = evaluator.force(gap, rate, slip, speed, kept)[0]
        yield from evaluator.guards(gap, rate, slip, normal, kept).tolist()


def _named_outputs(
    law: ContactLaw, bench: Bench, longer: float = 1.0, scaled: bool = False
) -> Iterator[tuple[float, str]]:
    """Yield answers of a law, with their units, to the states of a bench, or to these in other units.

    What has been kept is larger by a factor than what the history of the bench's law leads to, and impacts
    are slower by it.
    """

    def put(value: float, units: str) -> float:
        return value * _scale(units) if scaled else value

    evaluator, variables = Evaluator(law), bench.law.internal_variables
    if longer == LONGER[-1]:
        # What is declared of the variables has the law's own numbers in it.
        yield from zip(evaluator.initial.tolist(), (item.units for item in variables), strict=True)
    yield from (_of_impacts if bench.rigid else _of_states)(evaluator, bench, longer, put)


def _of_impacts(evaluator: Evaluator, bench: Bench, longer: float, put: Put) -> Iterator[tuple[float, str]]:
    """Yield the results of a rigid law for drawn impacts and normal forces."""
    usual, kinds = bench.law, (*["m s-1"] * 2, *["kg-1"] * 3)
    kept = np.array([put(item.initial + longer - 1.0, item.units) for item in usual.internal_variables])
    length = put(usual.default_contact_step, "s")
    for impact in islice(drawn_impacts(usual.friction_limit), 200):
        own = tuple(put(x, unit) for x, unit in zip(impact, kinds, strict=True))
        p_n, p_t = evaluator.impact(own, kept)
        yield from ((p_n, "N s"), (p_t, "N s"))
        rates = evaluator.rates(0.0, own[0], own[1], p_n / length, kept).tolist()
        yield from zip(rates, (_per_second(item.units) for item in usual.internal_variables), strict=True)
    for normal, slip in islice(drawn_pressures(), 50):
        yield evaluator.bound(put(normal, "N"), put(slip, "m s-1"), kept), "N"


def _of_states(evaluator: Evaluator, bench: Bench, longer: float, put: Put) -> Iterator[tuple[float, str]]:
    """Yield the answers of a compliant law to the states that its history leads to."""
    units = [item.units for item in bench.law.internal_variables]
    for gap, rate, slip, speed, before in states_of(bench):
        kept = np.array([put(longer * x, unit) for x, unit in zip(before, units, strict=True)])
        place = put(gap, "m"), put(rate, "m s-1"), put(slip, "m s-1")
        normal, bound, stored, loss = evaluator.force(*place, put(speed / longer, "m s-1"), kept)
        yield from ((normal, "N"), (bound, "N"), (stored, "J"), (loss, "W"))
        if evaluator.has_friction:
            drag, _, energy, _ = evaluator.friction(*place, normal, kept)
            yield from ((drag, "N"), (energy, "J"))
        if units:
            rates = evaluator.rates(*place, normal, kept)
            # Another number of variables than there are units is a ValueError here.
            yield from zip(rates.tolist(), map(_per_second, units), strict=True)
            jumped = evaluator.jumped(AT_TOUCH, *place, normal, kept)
            yield from zip(jumped.tolist(), units, strict=True)
        yield from ((limit, "m") for limit in evaluator.limits(kept))


def _per_second(unit: str) -> str:
    return "s-1" if unit == "1" else f"{unit} s-1"


@cache
def _scale(units: str) -> float:
    """Return what a number in SI units is multiplied by to be one in other units of `SCALES`."""
    scale = 1.0
    for name, power in dimensions(from_cf(units)).items():
        scale *= SCALES[name] ** power
    return scale


def _in_other_units(owner: Any) -> Any:
    """Return a law or a part with every declared number in other units of length, mass and time."""
    changed: dict[str, Any] = {}
    kind: type = type(owner)
    declared = declared_fields(kind)
    for field in fields(owner):
        value, text = getattr(owner, field.name), declared[field.name].parameter
        if is_dataclass(value):
            changed[field.name] = _in_other_units(value)
        elif isinstance(value, float) and text is not None:
            changed[field.name] = value * _scale(text.units)
    return replace(owner, **changed)
