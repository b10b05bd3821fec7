"""Properties of a law by itself: what it declares, and what its kernels answer to drawn states."""

from collections.abc import Iterator
from contextlib import suppress
from functools import lru_cache
from math import inf, isfinite, sqrt
from typing import Any

import numpy as np

from contactlab.laws import PenaltyLaw
from contactlab.laws.base import ELASTOPLASTIC, SLIP, STICK
from contactlab.laws.composed import Composed
from contactlab.laws.friction import cone_bound
from contactlab.laws.intake import guarded, misfits
from contactlab.testing.claim import Claim, Claims, at_most
from contactlab.testing.plants import Bench

ROUND_OFF = 1e-9
"""Share of the quantities that take part; the checks subtract numbers of their size."""

TINY = 1e-300
"""Added to what is divided by, and may be zero."""


class Worst(dict[str, Claim]):
    """The largest of each figure so far, from zero, as a claim of its bound; a NaN stays."""

    def take(self, words: str, figure: float, bound: float = ROUND_OFF) -> None:
        """Take one more figure of what the words say."""
        before = self[words].found if words in self else 0.0
        self[words] = at_most(words, float(np.maximum(before, figure)) + 0.0, bound)


def drawn_states() -> Iterator[tuple[float, float, float, float, float]]:
    """Draw 500 gaps [m], gap rates, slips (a fifth zero), impact speeds [m/s] and internal variables."""
    rng = np.random.default_rng(0)
    for _ in range(500):
        gap = -(10.0 ** rng.uniform(-9.0, -5.0))
        rate, slip = rng.normal(size=2) * 0.3
        slip *= rng.random() < 0.8
        yield gap, rate, slip, abs(rng.normal()) * 0.3, rng.normal() * 1e-6


def drawn_steps(limit: float) -> Iterator[tuple[float, ...]]:
    """Draw what `MultiplierLaw.solve` takes: impacts, and contacts that last, approach or open.

    In half of them friction is a tenth to ten times the critical one, whatever the law's largest is:
    faults beyond it show in few of 2000.
    """
    rng = np.random.default_rng(0)
    for _ in range(2000):
        share = rng.uniform(-0.999, 0.999)
        d_nn, d_tt = 10.0 ** rng.uniform(1.0, 4.0, 2)
        if limit > 0.0 and rng.random() < 0.5:
            d_nn = d_tt * (share * limit / 10.0 ** rng.uniform(-1.0, 1.0)) ** 2
        d_nt = share * sqrt(d_nn * d_tt)
        rate, end_slip, start_slip = rng.normal(size=3) * 10.0 ** rng.uniform(-3.0, 0.0, 3)
        start_rate = 0.0
        if rng.random() < 0.5:
            rate = start_rate = -abs(rate)
            start_slip = end_slip
        elif rng.random() < 0.5:
            start_slip = 0.0
        yield rate, end_slip, start_rate, start_slip, d_nn, d_nt, d_tt


def declares_its_parameters(bench: Bench) -> Claims:
    """Every field has symbol, unit and meaning, what is out of range is refused, words are there."""
    law, taken = bench.law, []
    declared = {name: said for name, _, said in law.effective() if said is not None}
    said = {name for name, given in declared.items() if given.symbol and given.units}
    missing = [name for name in law.describe() if name not in said]
    words = [word for word in law.WORDS if not getattr(law, word, "")]
    for name in declared:
        with suppress(ValueError):
            law.changed(name, inf)
            taken.append(name)
    yield at_most(f"parameters without declaration {missing}", len(missing), 0)
    yield at_most(f"declarations that are missing {words}", len(words), 0)
    yield at_most(f"parameters that take an infinite value {taken}", len(taken), 0)


def calls_leave_no_trace(bench: Bench) -> Claims:
    """The kernels answer alike in one order, and in another with two more questions before each."""
    law: Any = bench.law
    row, changed = guarded(law.parameters()), 0
    states: list[Any] = [*drawn_states()]
    if bench.rigid:
        asked = [(law.solve, [*drawn_steps(law.friction_limit)])]
    else:
        asked = [(law.force, [state[:4] for state in states]), (law.friction_force, states)]
    for kernel, states in asked:
        if kernel is None:
            continue
        answers = [kernel(*state, row) for state in states]
        for state, answer in [*zip(states, answers, strict=True)][::-1]:
            first, second, third, *others = state
            kernel(1.5 * first, -second, -third, *others, row)
            kernel(0.5 * first, 2.0 * second, 0.0, *others, row)
            changed += kernel(*state, row) != answer
    yield at_most("answers that change when asked again", changed, 0)


def kernel_is_consistent(bench: Bench) -> Claims:
    """What the kernels say of drawn states agrees with itself and with their family.

    N >= 0, 0 <= bound <= mu N, loss >= 0, loss = -(N + dV/dg) gdot; a spring's F = -k z and
    E = 1/2 k z^2, no creep that pushes, nothing stored at z = 0; for a rigid law see `answers_of`.
    """
    law, worst = bench.law, Worst()
    if not isinstance(law, PenaltyLaw):
        yield from answers_of(bench)["kernel_is_consistent"].values()
        return
    found, row = [*misfits(law)], guarded(law.parameters())
    yield at_most(f"contradictions in what is said of friction {found}", len(found), 0)
    for gap, rate, slip, speed, z in drawn_states():
        normal, bound, _, loss = law.force(gap, rate, slip, speed, row)
        ahead, behind = (gap * (1.0 + s * 1e-4) for s in (1.0, -1.0))
        energies = [law.force(g, rate, slip, speed, row)[2] for g in (ahead, behind)]
        slope = (energies[0] - energies[1]) / (ahead - behind)
        size = abs(normal) + abs(slope) + TINY
        power = size * abs(rate)
        if not law.allows_tension:
            worst.take("pull of the kernel, over the force", -normal / size, 0.0)
        excess = max(-bound, bound - law.friction_limit * abs(normal)) / size
        worst.take("friction bound outside of [0, mu N], over the force", excess)
        worst.take("negative normal loss, over the power", -loss / power)
        # Central differences of V: (h/gap)^2 and less.
        miss = abs(loss + (normal + slope) * rate) / power
        worst.take("loss less -(N + dV/dg) gdot, over the power", miss, 1e-6)
        if law.friction_force is None:
            continue
        drag, _, energy, stiffness = law.friction_force(gap, rate, slip, normal, z, row)
        fresh, _, at_once, _ = law.friction_force(gap, rate, slip, normal, 0.0, row)
        size = abs(drag) + stiffness * abs(z) + abs(normal) + TINY
        stored = max(-energy / (size * 1e-6), abs(at_once) / size)
        worst.take("energy stored at z = 0, or negative, over the force", stored)
        if law.friction_kind == ELASTOPLASTIC:
            misses = abs(drag + stiffness * z), abs(energy - 0.5 * stiffness * z**2) / abs(z)
            worst.take("spring less -k z and 1/2 k z^2, over the force", max(misses) / size)
        else:
            gained = fresh * slip / (size * abs(slip) + TINY)
            worst.take("power of creep at z = 0 on the slip, over the power", gained)
    yield from worst.values()


def parts_keep_apart(bench: Bench) -> Claims:
    """A composed law is its parts, each asked alone with its own coefficients and nothing behind them."""
    law, worst = bench.law, Worst()
    if not isinstance(law, Composed):
        return
    parameters = law.parameters()
    normal, damping, friction = (guarded(np.array(given)) for given in law.coefficients)
    for gap, rate, slip, speed, z in drawn_states():
        spring, stored, stiffness, slope = law.normal.elastic(-gap, normal, 0)
        alone = law.damping.damped(spring, -rate, speed, damping, 0)
        bound, loss = cone_bound(alone, slip, friction, 0), (spring - alone) * rate
        expected = [alone, bound, stored, loss]
        found = [*law.force(gap, rate, slip, speed, parameters)]
        if law.friction.state is not None and law.friction_force is not None:
            swept = -slope * rate
            expected += law.friction.state(alone, stiffness, swept, slip, z, friction, 0)
            found += law.friction_force(gap, rate, slip, alone, z, parameters)
        for one, other in zip(found, expected, strict=True):
            apart = abs(one - other) / (abs(one) + abs(other) + TINY)
            worst.take("answers of the composed law less those of its parts alone, relative", apart)
    yield from worst.values()


@lru_cache(maxsize=1)
def answers_of(bench: Bench) -> dict[str, Worst]:
    """Ask a rigid law about drawn steps; give the worst of its answers by the property that they are of.

    Beyond the critical friction, mu |d_nt| >= d_nn, an approach may have no answer and what opens by
    itself may be held (Painleve); there the law may release or hold, and a run tells of both.
    """
    law: Any = bench.law
    limit, row = law.friction_limit, guarded(law.parameters())
    sound, opposed, lossy = Worst(), Worst(), Worst()
    for step in drawn_steps(limit):
        rate, end_slip, _, _, d_nn, d_nt, d_tt = step
        critical = limit * abs(d_nt) >= d_nn
        p_n, p_t, mode = law.solve(*step, row)
        finite = isfinite(p_n) and isfinite(p_t)
        sound.take("answers without numbers or mode", not finite or mode not in (SLIP, STICK), 0)
        if not finite:
            continue
        released = p_n <= 0.0
        approach, held = released and rate < 0.0, not released and rate >= 0.0
        sound.take("approaches that are not stopped", approach and not critical, 0)
        sound.take("contacts held though they open by themselves", held and not critical, 0)
        if released:
            continue
        terms = np.abs((rate, end_slip, d_nn * p_n, d_tt * p_t, d_nt * p_n, d_nt * p_t))
        size, impulse = float(terms.max()), p_n + abs(p_t)
        left = rate + d_nn * p_n + d_nt * p_t
        left_slip = end_slip + d_nt * p_n + d_tt * p_t
        power = 0.5 * (p_n * (rate + left) + p_t * (end_slip + left_slip)) / (impulse * size)
        sound.take("impulse outside of the cone, over it", (abs(p_t) - limit * p_n) / impulse)
        sound.take("approach that is left, over the velocities", -left / size)
        opposed.take("friction along the slip it leaves", p_t * left_slip / (impulse * size))
        lossy.take("energy made by an impact, over impulse times velocity", power)
    return {"kernel_is_consistent": sound, "friction_opposes_slip": opposed, "dissipates": lossy}
