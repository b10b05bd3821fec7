"""Properties of a law by itself: what it declares, and what its kernels answer to drawn states."""

from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import lru_cache
from math import inf, isfinite, sqrt
from typing import Any

import numpy as np

from contactlab.arrays import Array
from contactlab.laws import PenaltyLaw
from contactlab.laws.base import ELASTOPLASTIC, SLIP, STICK
from contactlab.laws.composed import Composed
from contactlab.laws.friction import cone_bound
from contactlab.laws.intake import guarded, misfits
from contactlab.testing.claim import PROPERTIES, Claims, at_most, proof
from contactlab.testing.contract import Bench

STATES = 500
"""States that a kernel of force or friction is asked about."""

STEPS = 2000
"""Steps that a rigid law is asked about: a fault beyond the critical friction shows in few."""

ROUND_OFF = 1e-9
"""Share of the quantities that take part; the checks subtract numbers of their size."""

TINY = 1e-300
"""Added to what is divided by, and may be zero."""


class Worst(defaultdict[str, float]):
    """The largest of each figure so far, from zero; infinite once one is no number."""

    def take(self, **figures: float) -> None:
        """Take more figures by their names."""
        for name, figure in figures.items():
            self[name] = max(self[name], figure) if isfinite(figure) else inf

    def differ(self, name: str, found: tuple[float, ...], expected: tuple[float, ...]) -> None:
        """Take the relative differences of some numbers."""
        for one, other in zip(found, expected, strict=True):
            self.take(**{name: abs(one - other) / (abs(one) + abs(other) + TINY)})


def asked_twice(kernel: Callable[..., Any], parameters: Array, worst: Worst) -> Callable[..., Any]:
    """Give a kernel with its parameters, whose answers must not change; `changed` counts those that do."""
    row = guarded(parameters)

    def ask(*state: float) -> Any:
        answer = kernel(*state, row)
        worst["changed"] += kernel(*state, row) != answer
        return answer

    return ask


def drawn_states() -> Iterator[tuple[float, float, float, float, float]]:
    """Draw gaps [m], gap rates, slips (a fifth zero), impact speeds [m/s] and internal variables."""
    rng = np.random.default_rng(0)
    for _ in range(STATES):
        gap = -(10.0 ** rng.uniform(-9.0, -5.0))
        rate, slip = rng.normal(size=2) * 0.3
        slip *= rng.random() < 0.8
        yield gap, rate, slip, abs(rng.normal()) * 0.3, rng.normal() * 1e-6


@proof(PROPERTIES)
def declares_its_parameters(bench: Bench) -> Claims:
    """Every field has symbol, unit and meaning, what is out of range is refused, words are there."""
    law, taken = bench.law, []
    declared = {name: said for name, _, said in law.effective() if said is not None}
    said = {name for name, given in declared.items() if given.symbol and given.units}
    missing = [name for name in law.describe() if name not in said]
    yield at_most(f"parameters without declaration {missing}", len(missing), 0)
    words = [w for w in ("name", "equation", "source") if not getattr(law, w, "")]
    yield at_most(f"declarations that are missing {words}", len(words), 0)
    for name in declared:
        with suppress(ValueError):
            law.changed(name, inf)
            taken.append(name)
    yield at_most(f"parameters that take an infinite value {taken}", len(taken), 0)


@proof(PROPERTIES)
def declares_what_it_breaks(bench: Bench) -> Claims:
    """A violation is declared by the name of a property, and with a reason."""
    given = bench.law.violations
    odd = sorted(name for name in given if name not in PROPERTIES or not given[name])
    yield at_most(f"declared violations without property or reason {odd}", len(odd), 0)


@proof(PROPERTIES)
def kernel_is_consistent(bench: Bench) -> Claims:
    """What the kernel says of drawn states agrees with itself and with its family."""
    if isinstance(bench.law, PenaltyLaw):
        yield from _force_is_consistent(bench.law)
        yield from _friction_is_consistent(bench.law)
    else:
        worst = answers_of(bench)
        yield at_most("impulse outside of the cone, over the impulse", worst["excess"], ROUND_OFF)
        yield at_most("approach that is left, over the velocities", worst["approach"], ROUND_OFF)
        yield at_most("contacts that are held though they open by themselves", worst["held"], 0)
        words = "answers without numbers or mode, or that change when asked again"
        yield at_most(words, worst["odd"] + worst["changed"], 0)


@proof(PROPERTIES)
def parts_keep_apart(bench: Bench) -> Claims:
    """A composed law is its parts, each asked alone with its own coefficients and nothing behind them."""
    law = bench.law
    if not isinstance(law, Composed):
        return
    parameters, worst = law.parameters(), Worst(float)
    normal, damping, friction = (guarded(np.array(given)) for given in law.coefficients)
    elastic, damped, state = law.normal.elastic, law.damping.damped, law.friction.state
    for gap, rate, slip, speed, z in drawn_states():
        spring, stored, stiffness, slope = elastic(-gap, normal, 0)
        alone = damped(spring, -rate, speed, damping, 0)
        force, bound, *found = law.force(gap, rate, slip, speed, parameters)
        worst.differ("pressed", (force, *found), (alone, stored, (spring - alone) * rate))
        worst.differ("bounded", (bound,), (cone_bound(alone, slip, friction, 0),))
        if state is not None and law.friction_force is not None:
            expected = state(alone, stiffness, -slope * rate, slip, z, friction, 0)
            found_friction = law.friction_force(gap, rate, slip, alone, z, parameters)
            worst.differ("dragged", found_friction, expected)
    words = "of the composed law less that of its parts alone, relative"
    yield at_most(f"normal force, energy and loss {words}", worst["pressed"], ROUND_OFF)
    yield at_most(f"friction bound {words}", worst["bounded"], ROUND_OFF)
    yield at_most(f"friction {words}", worst["dragged"], ROUND_OFF)


def _force_is_consistent(law: PenaltyLaw) -> Claims:
    """N >= 0, 0 <= bound <= mu N, loss >= 0, loss = -(N + dV/dg) gdot, same question, same answer."""
    worst = Worst(float)
    force = asked_twice(law.force, law.parameters(), worst)
    for gap, rate, slip, speed, _ in drawn_states():
        normal, bound, _, loss = force(gap, rate, slip, speed)
        ahead, behind = (gap * (1.0 + s * 1e-4) for s in (1.0, -1.0))
        energies = [force(g, rate, slip, speed)[2] for g in (ahead, behind)]
        slope = (energies[0] - energies[1]) / (ahead - behind)
        size = abs(normal) + abs(slope) + TINY
        worst.take(
            pull=0.0 if law.allows_tension else -normal / size,
            excess=max(-bound, bound - law.friction_limit * abs(normal)) / size,
            gain=-loss / (size * abs(rate)),
            potential=abs(loss + (normal + slope) * rate) / (size * abs(rate)),
        )
    yield at_most("pull of the kernel, over the force", worst["pull"], 0.0)
    yield at_most("friction bound outside of [0, mu N], over the force", worst["excess"], ROUND_OFF)
    yield at_most("negative normal loss, over the power", worst["gain"], ROUND_OFF)
    # Central differences of V: (h/gap)^2 and less.
    yield at_most("loss less -(N + dV/dg) gdot, over the power", worst["potential"], 1e-6)
    yield at_most("answers that change when asked again", worst["changed"], 0)


def _friction_is_consistent(law: PenaltyLaw) -> Claims:
    """A spring's F = -k z and E = 1/2 k z^2; no creep that pushes; nothing stored at z = 0."""
    found, worst = list(misfits(law)), Worst(float)
    yield at_most(f"contradictions in what is said of friction {found}", len(found), 0)
    if law.friction_force is None:
        return
    force = asked_twice(law.force, law.parameters(), worst)
    friction = asked_twice(law.friction_force, law.parameters(), worst)
    for gap, rate, slip, _, z in drawn_states():
        asked = gap, rate, slip, force(gap, rate, slip, 0.3)[0]
        drag, _, energy, stiffness = friction(*asked, z)
        fresh, _, at_once, _ = friction(*asked, 0.0)
        size = abs(drag) + stiffness * abs(z) + abs(asked[-1]) + TINY
        worst.take(stored=max(-energy / (size * 1e-6), abs(at_once) / size))
        if law.friction_kind == ELASTOPLASTIC:
            miss = energy - 0.5 * stiffness * z**2
            worst.take(spring=abs(drag + stiffness * z) / size)
            worst.take(spring=abs(miss) / (size * abs(z)))
        else:
            worst.take(gained=fresh * slip / (size * abs(slip) + TINY))
    yield at_most("spring force less -k z, over the force", worst["spring"], ROUND_OFF)
    yield at_most("energy stored at z = 0, or negative, over the force", worst["stored"], ROUND_OFF)
    words = "power of creep at z = 0 on the slip, over the power"
    yield at_most(words, worst["gained"], ROUND_OFF)
    yield at_most("friction that changes when asked again", worst["changed"], 0)


@lru_cache(maxsize=1)
def answers_of(bench: Bench) -> Worst:
    """Ask a rigid law about drawn steps: impacts, and contacts that last, approach or open.

    Beyond the critical friction, mu |d_nt| >= d_nn, an approach may have no answer and what opens by
    itself may be held (Painleve); there the law may release or hold, and a run tells of both.

    Returns:
        The worst of its answers, each over the size of what takes part: `excess` of friction over the
        cone, `approach` that is left, friction impulse times the slip that it leaves where it has
        `pushed`, `gain` of energy; and the numbers of contacts that open by themselves and are `held`,
        of `odd` answers, not finite or without a mode, and of those that `changed` when asked again.
    """
    law: Any = bench.law
    rng, limit, worst = np.random.default_rng(0), law.friction_limit, Worst(float)
    solve = asked_twice(law.solve, law.parameters(), worst)
    for _ in range(STEPS):
        share = rng.uniform(-0.999, 0.999)
        d_nn, d_tt = 10.0 ** rng.uniform(1.0, 4.0, 2)
        if limit > 0.0 and rng.random() < 0.5:
            # Whatever the law's friction is: between a tenth and ten times the critical one.
            d_nn = d_tt * (share * limit / 10.0 ** rng.uniform(-1.0, 1.0)) ** 2
        d_nt = share * sqrt(d_nn * d_tt)
        critical = limit * abs(d_nt) >= d_nn
        rate, end_slip, start_slip = rng.normal(size=3) * 10.0 ** rng.uniform(-3.0, 0.0, 3)
        if impact := rng.random() < 0.5:
            rate, start_slip = -abs(rate), end_slip
        elif rng.random() < 0.5:
            start_slip = 0.0
        start_rate = rate if impact else 0.0
        p_n, p_t, mode = solve(rate, end_slip, start_rate, start_slip, d_nn, d_nt, d_tt)
        finite = isfinite(p_n) and isfinite(p_t)
        worst["odd"] += not finite or mode not in (SLIP, STICK)
        if not finite:
            continue
        if p_n <= 0.0:
            worst.take(approach=float(rate < 0.0 and not critical))
            continue
        worst["held"] += rate >= 0.0 and not critical
        terms = np.abs((rate, end_slip, d_nn * p_n, d_tt * p_t, d_nt * p_n, d_nt * p_t))
        size, impulse = float(terms.max()), p_n + abs(p_t)
        left = rate + d_nn * p_n + d_nt * p_t
        left_slip = end_slip + d_nt * p_n + d_tt * p_t
        work = 0.5 * (p_n * (rate + left) + p_t * (end_slip + left_slip))
        worst.take(
            excess=(abs(p_t) - limit * p_n) / impulse,
            approach=-left / size,
            pushed=p_t * left_slip / (impulse * size),
            gain=work / (impulse * size),
        )
    return worst
