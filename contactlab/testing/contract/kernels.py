"""Properties of a law by itself: what it declares, and what its kernel answers to drawn states."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf, isfinite, sqrt
from typing import final

import numpy as np
from numpy.typing import NDArray

from contactlab.laws import ContactLaw, MultiplierLaw, PenaltyLaw
from contactlab.laws.base import ELASTOPLASTIC, SLIP, STICK
from contactlab.laws.composed import Composed
from contactlab.laws.friction.coulomb import cone_bound
from contactlab.laws.intake import guarded, misfits
from contactlab.testing.claim import Claim, at_most
from contactlab.testing.contract.bench import Bench

Array = NDArray[np.float64]

STATES = 500
"""States that a kernel of force or friction is asked about."""

STEPS = 2000
"""Steps that a rigid law is asked about: a fault beyond the critical friction shows in few."""

ROUND_OFF = 1e-9
"""Share of the quantities that take part; the checks subtract numbers of their size."""


def declares_its_parameters(bench: Bench) -> Iterator[Claim]:
    """Every field has symbol, unit and meaning, what is out of range is refused, words are there."""
    law = bench.law
    declared = law.declared()
    names = list(law.describe())
    missing = [
        name
        for name in names
        if name not in declared or not (declared[name].symbol and declared[name].units)
    ]
    yield at_most(f"parameters without declaration {missing}", len(missing), 0)
    words = [w for w in ("name", "equation", "source") if not getattr(law, w, "")]
    yield at_most(f"declarations that are missing {words}", len(words), 0)
    taken = [name for name in declared if not _refuses(law, name, inf)]
    yield at_most(f"parameters that take an infinite value {taken}", len(taken), 0)


def kernel_is_consistent(bench: Bench) -> Iterator[Claim]:
    """What the kernel says of drawn states agrees with itself and with its family."""
    if isinstance(bench.law, PenaltyLaw):
        yield from _force_is_consistent(bench.law)
        yield from _friction_is_consistent(bench.law)
    elif isinstance(bench.law, MultiplierLaw):
        yield from _impulse_is_consistent(bench.law)


def parts_keep_apart(bench: Bench) -> Iterator[Claim]:
    """A composed law is its parts, each asked alone with its own coefficients and nothing behind them."""
    law = bench.law
    if not isinstance(law, Composed):
        return
    rng = np.random.default_rng(0)
    parameters = law.parameters()
    normal, damping, friction = (guarded(np.array(given)) for given in law.coefficients)
    elastic, damped, state, rub = (
        law.normal.elastic,
        law.damping.damped,
        law.friction.state,
        law.friction_force,
    )
    pressed, bounded, rubbed = 0.0, 0.0, 0.0
    for _ in range(STATES):
        depth = 10.0 ** rng.uniform(-9.0, -5.0)
        rate, slip = rng.normal(size=2) * 0.3
        slip *= rng.random() < 0.8
        speed, memory = abs(rng.normal()) * 0.3, rng.normal() * 1e-6
        spring, stored, stiffness, slope = elastic(depth, normal, 0)
        alone = damped(spring, -rate, speed, damping, 0)
        expected = (alone, stored, (spring - alone) * rate)
        force, bound, *found = law.force(-depth, rate, slip, speed, parameters)
        pressed = _farther(pressed, (force, *found), expected)
        bounded = _farther(bounded, (bound,), (cone_bound(alone, slip, friction, 0),))
        if state is not None and rub is not None:
            asked = (alone, stiffness, -slope * rate, slip, memory, friction, 0)
            answer = rub(-depth, rate, slip, alone, memory, parameters)
            rubbed = _farther(rubbed, answer, state(*asked))
    words = "of the composed law less that of its parts alone, relative"
    yield at_most(f"normal force, energy and loss {words}", pressed, ROUND_OFF)
    yield at_most(f"friction bound {words}", bounded, ROUND_OFF)
    yield at_most(f"friction {words}", rubbed, ROUND_OFF)


def _farther(worst: float, found: Sequence[float], expected: Sequence[float]) -> float:
    """The largest relative difference so far; infinite once there is no number."""
    for one, other in zip(found, expected, strict=True):
        change = abs(one - other) / (abs(one) + abs(other) + 1e-300)
        worst = max(worst, change) if isfinite(change) else inf
    return worst


def _refuses(law: ContactLaw, name: str, value: float) -> bool:
    """Whether the law refuses a value of one parameter."""
    try:
        law.changed(name, value)
    except ValueError:
        return True
    return False


def _force_is_consistent(law: PenaltyLaw) -> Iterator[Claim]:
    """N >= 0, 0 <= bound <= mu N, loss >= 0, loss = -(N + dV/dg) gdot, same question, same answer."""
    rng = np.random.default_rng(0)
    parameters = law.parameters()
    given = parameters.copy()
    pull, excess, gain, potential, changed = 0.0, 0.0, 0.0, 0.0, 0
    for _ in range(STATES):
        gap = -(10.0 ** rng.uniform(-9.0, -5.0))
        rate, slip = rng.normal(size=2) * 0.3
        slip *= rng.random() < 0.8
        speed = abs(rng.normal()) * 0.3
        normal, bound, _, loss = law.force(gap, rate, slip, speed, parameters)
        h = 1e-4 * gap
        ahead, behind = (
            law.force(gap + s * h, rate, slip, speed, parameters)[2] for s in (1.0, -1.0)
        )
        slope = (ahead - behind) / (2.0 * h)
        size = abs(normal) + abs(slope) + 1e-300
        if not law.allows_tension:
            pull = max(pull, -normal / size)
        excess = max(excess, -bound / size, (bound - law.friction_limit * abs(normal)) / size)
        gain = max(gain, -loss / (size * abs(rate)))
        potential = max(potential, abs(loss + (normal + slope) * rate) / (size * abs(rate)))
        asked = [law.force(gap, rate, slip, speed, parameters) for _ in range(2)]
        changed += asked[0] != asked[1]
    changed += not np.array_equal(given, parameters, equal_nan=True)
    yield at_most("pull of the kernel, over the force", pull, 0.0)
    yield at_most("friction bound outside of [0, mu N], over the force", excess, ROUND_OFF)
    yield at_most("negative normal loss, over the power", gain, ROUND_OFF)
    # Central differences of V: (h/gap)^2 and less.
    yield at_most("loss less -(N + dV/dg) gdot, over the power", potential, 1e-6)
    yield at_most("answers that change when asked again", changed, 0)


def _friction_is_consistent(law: PenaltyLaw) -> Iterator[Claim]:
    """A spring's F = -k z and E = 1/2 k z^2; no creep that pushes; nothing stored without memory."""
    found = list(misfits(law))
    yield at_most(f"contradictions in what is said of friction {found}", len(found), 0)
    rub = law.friction_force
    if rub is None:
        return
    rng = np.random.default_rng(0)
    parameters = law.parameters()
    given = parameters.copy()
    spring, stored, gained, changed = 0.0, 0.0, 0.0, 0
    for _ in range(STATES):
        gap = -(10.0 ** rng.uniform(-9.0, -5.0))
        rate, slip = rng.normal(size=2) * 0.3
        memory = rng.normal() * 1e-6
        normal = law.force(gap, rate, slip, 0.3, parameters)[0]
        asked = (gap, rate, slip, normal)
        force, _, energy, stiffness = rub(*asked, memory, parameters)
        size = abs(force) + stiffness * abs(memory) + abs(normal) + 1e-300
        stored = max(stored, -energy / (size * 1e-6), abs(rub(*asked, 0.0, parameters)[2]) / size)
        if law.friction_kind == ELASTOPLASTIC:
            spring = max(spring, abs(force + stiffness * memory) / size)
            miss = energy - 0.5 * stiffness * memory**2
            spring = max(spring, abs(miss) / (size * abs(memory)))
        else:
            gained = max(gained, rub(*asked, 0.0, parameters)[0] * slip / (size * abs(slip)))
        changed += rub(*asked, memory, parameters) != rub(*asked, memory, parameters)
    changed += not np.array_equal(given, parameters, equal_nan=True)
    yield at_most("spring force less -k z, over the force", spring, ROUND_OFF)
    yield at_most("energy stored without memory, or negative, over the force", stored, ROUND_OFF)
    yield at_most("power of creep without memory on the slip, over the power", gained, ROUND_OFF)
    yield at_most("friction that changes when asked again", changed, 0)


def _impulse_is_consistent(law: MultiplierLaw) -> Iterator[Claim]:
    """|p_t| <= mu p_n, no approach left, what opens let go, same question, same answer."""
    worst = answers_of(law)
    yield at_most("impulse outside of the cone, over the impulse", worst.excess, ROUND_OFF)
    yield at_most("approach that is left, over the velocities", worst.approach, ROUND_OFF)
    yield at_most("contacts that are held though they open by themselves", worst.held, 0)
    yield at_most("answers without numbers or mode, or that change when asked again", worst.odd, 0)


@final
@dataclass
class Answers:
    """The worst of a rigid law's answers to drawn steps, each over the size of what takes part.

    Args:
        excess: friction impulse outside of the cone.
        approach: approach that is left.
        pushed: friction impulse times the slip that it leaves, where it pushes.
        gain: energy that the step makes.
        held: contacts that open by themselves, which no friction can prevent, and are held.
        odd: answers that are not finite or without a mode, or that change when asked again.
    """

    excess: float = 0.0
    approach: float = 0.0
    pushed: float = 0.0
    gain: float = 0.0
    held: int = 0
    odd: int = 0


def answers_of(law: MultiplierLaw) -> Answers:
    """Ask a rigid law about drawn steps: impacts, and contacts that last, approach or open.

    Beyond the critical friction, mu |d_nt| >= d_nn, an approach may have no answer and what opens by
    itself may be held (Painleve); there the law may release or hold, and a run tells of both.
    """
    rng = np.random.default_rng(0)
    parameters = law.parameters()
    given = parameters.copy()
    limit = law.friction_limit
    worst = Answers()
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
        asked = (rate, end_slip, rate if impact else 0.0, start_slip, d_nn, d_nt, d_tt, parameters)
        p_n, p_t, mode = law.solve(*asked)
        finite = isfinite(p_n) and isfinite(p_t)
        worst.odd += (
            not finite or mode not in (SLIP, STICK) or law.solve(*asked) != (p_n, p_t, mode)
        )
        if not finite:
            continue
        if p_n <= 0.0:
            if rate < 0.0 and not critical:
                worst.approach = 1.0
            continue
        worst.held += rate >= 0.0 and not critical
        terms = np.abs((rate, end_slip, d_nn * p_n, d_tt * p_t, d_nt * p_n, d_nt * p_t))
        size, impulse = float(terms.max()), p_n + abs(p_t)
        left = rate + d_nn * p_n + d_nt * p_t
        left_slip = end_slip + d_nt * p_n + d_tt * p_t
        work = 0.5 * (p_n * (rate + left) + p_t * (end_slip + left_slip))
        worst.excess = max(worst.excess, (abs(p_t) - limit * p_n) / impulse)
        worst.approach = max(worst.approach, -left / size)
        worst.pushed = max(worst.pushed, p_t * left_slip / (impulse * size))
        worst.gain = max(worst.gain, work / (impulse * size))
    worst.odd += not np.array_equal(given, parameters, equal_nan=True)
    return worst
