"""The impulses of a step in rigid contact against all solutions that it may have.

One step of one contact is a complementarity problem in the plane,

    0 <= p_n  _|_  normal rate at the end >= 0
    |p_t| <= mu p_n,  slip at the end != 0 => p_t = -mu p_n sign(slip),

small enough to write out all of its answers: release, stick, and slip in either direction.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
import pytest
from support.kernels import stepped

from contactlab.laws import LagrangeStick
from contactlab.laws.base import SLIP, STICK


@dataclass(frozen=True)
class Step:
    """Rates at the end and at the start of a step, Delassus matrix and friction coefficient."""

    normal_rate: float
    tangential_rate: float
    gap_rate: float
    slip: float
    d_nn: float
    d_nt: float
    d_tt: float
    mu: float

    @property
    def arguments(self) -> tuple[float, ...]:
        """All but the friction coefficient."""
        return tuple(getattr(self, field.name) for field in fields(self))[:-1]

    def after(self, p_n: float, p_t: float) -> tuple[float, float]:
        """Gap rate and slip behind impulses [m/s]."""
        return (
            self.normal_rate + self.d_nn * p_n + self.d_nt * p_t,
            self.tangential_rate + self.d_nt * p_n + self.d_tt * p_t,
        )

    def round_off(self, p_n: float, p_t: float) -> float:
        """Round-off of a rate after impulses [m/s], that of the largest term over the conditioning of D."""
        terms = (*self.arguments[:4], self.d_nn * p_n, self.d_nt * p_t, self.d_nt * p_n, self.d_tt * p_t)
        return 1e-12 * max(map(abs, terms)) / (1.0 - self.d_nt**2 / (self.d_nn * self.d_tt))


def random_steps(count: int) -> list[Step]:
    """Steps of contacts that last, half of them beyond the critical friction."""
    rng = np.random.default_rng(7)
    d_nn, d_tt = 10.0 ** rng.uniform(1.0, 4.0, (2, count))
    d_nt = rng.uniform(-1.0, 1.0, count) * 0.999 * np.sqrt(d_nn * d_tt)
    mu = 10.0 ** rng.uniform(-1.0, 1.0, count) * d_nn / np.abs(d_nt)
    rates = rng.normal(size=(4, count)) * 10.0 ** rng.uniform(-4.0, 0.0, (4, count))
    rates[2] = 0.0
    rates[3] *= rng.integers(0, 2, count)
    columns = np.stack([*rates, d_nn, d_nt, d_tt, mu], axis=1)
    return [Step(*map(float, row)) for row in columns]


MANY = random_steps(5_000)


def solution_of(step: Step) -> tuple[float, float, int]:
    """Impulses and mode of the law with stick; without an impulse where it releases."""
    p_n, p_t, mode = stepped(LagrangeStick(step.mu), *step.arguments)
    return (p_n, p_t, mode) if not p_n <= 0.0 else (0.0, 0.0, SLIP)


def consistent_solutions(step: Step, margin: float = 0.0) -> list[tuple[float, float]]:
    """Every answer of the complementarity problem: those of release, stick and both slips that obey it.

    Args:
        margin: by which an answer may break an inequality, relative to round-off.
    """
    d = np.array([[step.d_nn, step.d_nt], [step.d_nt, step.d_tt]])
    rates = np.array([step.normal_rate, step.tangential_rate])
    candidates = [(0.0, 0.0, None)]
    candidates.append((*map(float, np.linalg.solve(d, -rates)), 0.0))
    for s in (-1.0, 1.0):
        growth = step.d_nn - s * step.mu * step.d_nt
        if growth != 0.0:
            p_n = -step.normal_rate / growth
            candidates.append((p_n, -s * step.mu * p_n, s))
    results = []
    for p_n, p_t, s in candidates:
        error = margin * step.round_off(p_n, p_t)
        normal, slip = step.after(p_n, p_t)
        if s is None:
            obeys = normal >= -error
        elif s == 0.0:
            obeys = p_n > 0.0 and abs(p_t) <= step.mu * p_n + error / step.d_tt
        else:
            obeys = p_n > 0.0 and s * slip >= -error
        if obeys:
            results.append((p_n, p_t))
    return results


def test_the_law_with_stick_gives_one_of_these_answers() -> None:
    stored = released = 0
    for step in MANY:
        result = solution_of(step)[:2]
        results = consistent_solutions(step, 1.0)
        size = max(abs(x) for value in results for x in value)
        assert any(result == pytest.approx(x, rel=1e-6, abs=1e-9 * size) for x in results), step
        if len(consistent_solutions(step, -1.0)) == 3:
            stored += result[0] > 0.0
            released += result[0] == 0.0
    assert min(stored, released) > 20


def test_what_stuck_is_held_and_what_slid_is_released() -> None:
    ambiguous = [step for step in MANY if len(consistent_solutions(step, -1.0)) == 3]
    assert len(ambiguous) > 50
    for step in ambiguous:
        assert solution_of(replace(step, slip=0.0))[2] == STICK
        slid = replace(step, slip=step.tangential_rate * 0.75)
        assert solution_of(slid)[0] == 0.0
