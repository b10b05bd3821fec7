"""Properties of a law by itself: its declarations, its kernels at drawn states, and those of its parts."""

from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from math import inf, isfinite, sqrt
from typing import Any, NamedTuple

import numpy as np

from contactlab.arrays import Array
from contactlab.laws import PenaltyLaw
from contactlab.laws.base import ELASTOPLASTIC, SLIP, STICK
from contactlab.laws.composed import Composed
from contactlab.laws.consistency import (
    ACCURATELY,
    NUDGE,
    ROUND_OFF,
    TINY,
    VALUES,
    approach_is_stopped,
    bound_in_cone,
    contradictions,
    loss_is_not_stored,
    spring_is_linear,
)
from contactlab.laws.memory import AT_SLIP, AT_STICK, AT_TOUCH
from contactlab.testing.claim import Claim, Claims, at_most
from contactlab.testing.flows import flow_of
from contactlab.testing.plants import Bench, Evaluator, viscous_friction

State = tuple[float, float, float, float, Array]
"""Gap [m], gap rate [m/s], slip [m/s], impact speed [m/s], and what is kept."""


class Worst(dict[str, Claim]):
    """The largest of each figure so far, from zero, as a claim of its bound; a NaN stays."""

    def take(self, statement: str, figure: float, bound: float = ROUND_OFF) -> None:
        """Take one more figure of what the words say."""
        before = self[statement].value if statement in self else 0.0
        self[statement] = at_most(statement, float(np.maximum(before, figure)) + 0.0, bound)

    def add(self, *claims: Claim) -> None:
        """Take the figures of upper bounds."""
        for claim in claims:
            self.take(claim.statement, claim.value, claim.expected)


def drawn_states() -> Iterator[tuple[float, float, float, float]]:
    """Draw 500 gaps [m], gap rates, slips (a fifth zero) and impact speeds [m/s]."""
    rng = np.random.default_rng(0)
    for _ in range(500):
        gap = -(10.0 ** rng.uniform(-9.0, -5.0))
        rate, slip = rng.normal(size=2) * 0.3
        slip *= rng.random() < 0.8
        yield gap, rate, slip, abs(rng.normal()) * 0.3


def states_of(bench: Bench) -> list[State]:
    """Return states of a compliant contact: drawn ones, or those that what it remembers leads to."""
    instants = flow_of(bench).instants
    if instants:
        return [(at.gap, at.rate, at.slip, at.speed, at.kept) for at in instants]
    initial = np.array([each.initial for each in bench.law.internal_variables], dtype=np.float64)
    return [(*state, initial) for state in drawn_states()]


def drawn_impacts(limit: float) -> Iterator[tuple[float, ...]]:
    """Draw what `MultiplierLaw.impact` takes: approach and slip [m/s], D_nn, D_nt, D_tt [1/kg].

    In half of them friction is a tenth to ten times the critical one, whatever the law's largest is:
    faults beyond it show in few of 2000.
    """
    rng = np.random.default_rng(0)
    for _ in range(2000):
        share = rng.uniform(-0.999, 0.999)
        d_nn, d_tt = 10.0 ** rng.uniform(1.0, 4.0, 2)
        if limit > 0.0 and rng.random() < 0.5:
            d_nn = d_tt * (share * limit / 10.0 ** rng.uniform(-1.0, 1.0)) ** 2
        approach, slip = rng.normal(size=2) * 10.0 ** rng.uniform(-3.0, 0.0, 2)
        yield -abs(approach), slip * (rng.random() < 0.8), d_nn, share * sqrt(d_nn * d_tt), d_tt


def drawn_pressures() -> Iterator[tuple[float, float]]:
    """Draw 200 normal forces [N] and slips [m/s], a third of them zero."""
    rng = np.random.default_rng(0)
    for _ in range(200):
        yield 10.0 ** rng.uniform(-3.0, 3.0), rng.normal() * 0.3 * (rng.random() < 0.66)


def declares_its_parameters(bench: Bench) -> Claims:
    """Every field has symbol, unit and meaning, what is out of range is refused, words are there."""
    law, taken = bench.law, []
    declared = {name: field for name, _, field in law.effective() if field is not None}
    documented = {name for name, field in declared.items() if field.symbol and field.units}
    missing = [name for name in law.describe() if name not in documented]
    names = [word for word in law.WORDS if not getattr(law, word, "")]
    for name in declared:
        # A number of pieces refuses what is not whole as of another kind.
        with suppress(ValueError, TypeError):
            law.changed(name, inf)
            taken.append(name)
    yield at_most(f"parameters without declaration {missing}", len(missing), 0)
    yield at_most(f"declarations that are missing {names}", len(names), 0)
    yield at_most(f"parameters that take an infinite value {taken}", len(taken), 0)


def every_result(
    evaluator: Evaluator, state: State, side: float = 1.0, signs: Array | float = 1.0
) -> list[float]:
    """Return every result of all kernels of a compliant law in a state.

    In the mirror the force along the rotor has the sign of a side, and the internal variables have signs.
    """
    gap, rate, slip, _, kept = state
    normal, bound, stored, loss = evaluator.force(*state)
    pressed = gap, rate, slip, normal, kept
    result = [normal, bound, stored, loss, *(signs * evaluator.rates(*pressed)), *evaluator.limits(kept)]
    if evaluator.law.guards:
        result += evaluator.guards(*pressed).tolist()
    if evaluator.has_friction:
        drag, _, friction_energy, stiffness = evaluator.friction(*pressed)
        result += [side * drag, friction_energy, stiffness]
    for event in range(AT_TOUCH, evaluator.law.guards):
        result += (signs * evaluator.jumped(event, *pressed)).tolist()
    return [float(each) for each in result]


class Anomalies(NamedTuple):
    """Numbers of states in which answers are not as they must be."""

    changed: int  # when asked again
    unsound: int  # no finite numbers
    beyond: int  # with what lies beyond the memory
    wild: int  # no finite numbers where what lies beyond is none


@lru_cache(maxsize=1)
def anomalies_of(bench: Bench) -> Anomalies:
    """Evaluate all kernels in all states: with each canary, and in another order after two other calls."""
    law, states = bench.law, [*(drawn_impacts(bench.law.friction_limit) if bench.rigid else states_of(bench))]
    first, *others = (Evaluator(law, canary) for canary in VALUES)

    def results_of(evaluator: Evaluator, *state: Any) -> list[float]:
        if bench.rigid:
            return [float(each) for each in evaluator.impact(state, evaluator.initial)]
        return every_result(evaluator, state)

    results, counts = [results_of(first, *state) for state in states], np.zeros(4, dtype=np.int64)
    for state, result in [*zip(states, results, strict=True)][::-1]:
        a, b, c, *rest = state
        results_of(first, 1.5 * a, -b, -c, *rest)
        results_of(first, 0.5 * a, 2.0 * b, 0.0, *rest)
        again, *elsewhere = (results_of(evaluator, *state) for evaluator in (first, *others))
        counts += (
            repr(again) != repr(result),
            not np.isfinite(elsewhere[0]).all(),
            any(repr(each) != repr(result) for each in elsewhere),
            not np.isfinite(result).all(),
        )
    return Anomalies(*counts.tolist())


def calls_leave_no_trace(bench: Bench) -> Claims:
    """Answers are finite, and the same in one order and in another with two more calls before each."""
    anomalies = anomalies_of(bench)
    yield at_most("answers that change when asked again", anomalies.changed, 0)
    yield at_most("answers that are no finite numbers", anomalies.unsound, 0)


def kernel_is_consistent(bench: Bench) -> Claims:
    """What the kernels say of drawn states agrees with itself and with their family.

    N >= 0, 0 <= bound <= mu (N + C), loss >= 0, without a memory loss = -(N + dV/dg) gdot; a spring's
    F = -k z and E = 1/2 k z^2, no creep that pushes, nothing stored at first; for a rigid law see
    `impacts_of`.
    """
    law, worst = bench.law, Worst()
    if not isinstance(law, PenaltyLaw):
        yield from impacts_of(bench)["kernel_is_consistent"].values()
        return
    result, evaluator = [*contradictions(law)], Evaluator(law)
    yield at_most(f"contradictions in what is said of friction {result}", len(result), 0)
    limit, offset = law.friction_limit, law.friction_offset
    for gap, rate, slip, speed, kept in states_of(bench):
        normal, bound, _, loss = evaluator.force(gap, rate, slip, speed, kept)
        size = abs(normal) + TINY
        if not law.allows_tension:
            worst.take("pull of the kernel, over the force", -normal / size, 0.0)
        worst.add(bound_in_cone(bound, limit * max(normal + offset, 0.0), size + offset))
        worst.take("negative normal loss, over the power", -loss / (size * abs(rate) + abs(loss)))
        if len(law.internal_variables) == law.coupled:

            def energy(gap: float, rest: tuple[Any, ...] = (rate, slip, speed, kept)) -> float:
                return evaluator.force(gap, *rest)[2]

            step = NUDGE * abs(gap)
            worst.add(loss_is_not_stored(energy, (normal, loss), gap, rate, step, ACCURATELY))
        if evaluator.has_friction:
            _judge_friction(evaluator, (gap, rate, slip, normal, kept), worst)
    yield from worst.values()


def _judge_friction(evaluator: Evaluator, state: State, worst: Worst) -> None:
    """Take what a kernel of friction says of one state; there the fourth number is the normal force [N]."""
    gap, rate, slip, normal, kept = state
    law, first = evaluator.law, kept.copy()
    # The friction's variables are the first, or all where the law is one piece.
    count = len(law.friction.internal_variables if isinstance(law, Composed) else law.internal_variables)
    first[:count] = evaluator.initial[:count]
    drag, _, energy, stiffness = evaluator.friction(gap, rate, slip, normal, kept)
    fresh, _, at_once, _ = evaluator.friction(gap, rate, slip, normal, first)
    z = float(kept[0]) if evaluator.own else 0.0
    size = abs(drag) + stiffness * abs(z) + abs(normal) + TINY
    stored = max(-energy / (size * 1e-6), abs(at_once) / size)
    worst.take("energy stored at first, or negative, over the force", stored)
    if law.friction_kind == ELASTOPLASTIC:
        spring = drag + viscous_friction(law) * slip
        worst.add(spring_is_linear(spring, energy, stiffness, z, size))
    else:
        gained = fresh * slip / (size * abs(slip) + TINY)
        worst.take("power of creep at first on the slip, over the power", gained)


@lru_cache(maxsize=1)
def impacts_of(bench: Bench) -> dict[str, Worst]:
    """Evaluate a rigid law on drawn impacts and its bound; return the worst violation of each property.

    Beyond the critical friction, mu |d_nt| >= d_nn, an approach may have no impulse that stops it (Painleve).
    """
    law, evaluator, length = bench.law, Evaluator(bench.law), bench.law.default_contact_step
    limit, offset = law.friction_limit, law.friction_offset
    sound, opposed, lossy = Worst(), Worst(), Worst()
    kept, before = evaluator.initial.copy(), SLIP
    for impact in drawn_impacts(limit):
        rate, slip, d_nn, d_nt, d_tt = impact
        # An impact begins a contact, with whatever the ones before have left.
        kept = evaluator.jumped(AT_TOUCH, 0.0, rate, slip, 0.0, kept)
        p_n, p_t = evaluator.impact(impact, kept)
        finite = isfinite(p_n) and isfinite(p_t)
        sound.take("impulses that are no numbers", not finite, 0)
        if not finite:
            continue
        sound.take("approaches that are not stopped", p_n <= 0.0 and limit * abs(d_nt) < d_nn, 0)
        if p_n <= 0.0:
            continue
        terms = np.abs((rate, slip, d_nn * p_n, d_tt * p_t, d_nt * p_n, d_nt * p_t))
        size, impulse = float(terms.max()), p_n + abs(p_t)
        left, left_slip = rate + d_nn * p_n + d_nt * p_t, slip + d_nt * p_n + d_tt * p_t
        power = 0.5 * (p_n * (rate + left) + p_t * (slip + left_slip)) / (impulse * size)
        sound.take("impulse outside of the cone, over it", (abs(p_t) - limit * p_n) / impulse)
        sound.add(approach_is_stopped(left, size))
        opposed.take("friction along the slip it leaves", p_t * left_slip / (impulse * size))
        lossy.take("energy made by an impact, over impulse times velocity", power)
        if law.internal_variables:
            mode = STICK if abs(left_slip) <= ROUND_OFF * size else SLIP
            force, left_slip = p_n / length, 0.0 if mode == STICK else left_slip
            kept = kept + length * evaluator.rates(0.0, left, left_slip, force, kept)
            if mode != before:
                event = AT_STICK if mode == STICK else AT_SLIP
                kept = evaluator.jumped(event, 0.0, left, left_slip, force, kept)
            before = mode
            sound.take("internal variables that are no numbers", not np.isfinite(kept).all(), 0)
    for normal, slip in drawn_pressures():
        bound, most = evaluator.bound(normal, slip, kept), limit * (normal + offset)
        sound.add(bound_in_cone(bound, most, normal + offset))
    return {"kernel_is_consistent": sound, "friction_opposes_slip": opposed, "dissipates": lossy}


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
    solved |= {"elastic_energy": stored, "elastic_stiffness": stiffness}
    alone = damping.evaluate("damped", **state, **solved)
    pressing = {**state, **bent, "normal": alone}
    two_sided = drag.bounds is not None
    bound = drag.evaluate("bounds", **pressing)[1] if two_sided else drag.evaluate("bound", **pressing)
    results = [alone, bound, stored, lost + (spring - alone) * rate]
    swept = {**state, **bent, "normal": alone, "normal_stiffness": stiffness}
    swept["normal_stiffness_rate"] = -slope * rate
    if drag.state is not None:
        friction, *others = drag.evaluate("state", **swept)
        of_three = count > drag.coupled
        results += [friction - viscous_friction(law) * slip, *([0.0] if of_three else []), *others]
    # A variable that is coupled with the friction is the only one that this has.
    sides = ((drag, swept, kept[drag.coupled : count]), (part, {**state, **pressed}, kept[count:]))
    for each, known, own in sides:
        for k in range(own.size):
            results.append(0.0 if each.rate is None else each.evaluate("rate", **known, which=k))
    for each, known, _ in sides:
        results += [each.evaluate("guard", **known, which=k) for k in range(each.guards)]
    results += (0.0, 0.0) if part.limits is None else part.evaluate("limits", **state, **pressed)
    for event in range(AT_TOUCH, law.guards):
        for each, known, own in sides:
            mine = event if event < 0 or each is drag else event - drag.guards
            theirs = event >= 0 and (event < drag.guards) != (each is drag)
            as_it_was = theirs or each.jump is None
            for k, value in enumerate(own.tolist()):
                results.append(value if as_it_was else each.evaluate("jump", **known, which=k, event=mine))
    return results


def _variables_of(part: Any, values: Array) -> dict[str, Any]:
    """Return the internal variables of a part by name, and as z."""
    named = zip(part.internal_variables, values.tolist(), strict=True)
    return {"z": np.array(values), **{variable.name: value for variable, value in named}}
