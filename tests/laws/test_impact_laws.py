"""The kernels of the laws with restitution alone: closed forms, small steps of the process, energy."""

from math import sqrt

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st
from support.impacts import Delassus, after, contact_energy, impact_of, loss, round_off
from support.kernels import stepped

from contactlab.laws import LagrangeStick, MoreauJean, MultiplierLaw, Newton, Poisson, Stronge
from contactlab.laws.base import STICK

Law = type[Newton] | type[Poisson] | type[Stronge] | type[MoreauJean]

RESTITUTIONS: tuple[Law, ...] = (Newton, Poisson, Stronge, MoreauJean)
PROCESSES: tuple[type[Poisson] | type[Stronge], ...] = (Poisson, Stronge)

all_laws = pytest.mark.parametrize("law", RESTITUTIONS, ids=lambda law: law.name)
processes = pytest.mark.parametrize("law", PROCESSES, ids=lambda law: law.name)

# Whole micrometres a second: zero and everything else, but no numbers near the end of the range.
rate = st.integers(-2_000_000, 2_000_000).map(lambda x: 1e-6 * x)
approach = st.integers(-2_000_000, -1).map(lambda x: 1e-6 * x)
share = st.floats(0.0, 1.0)

REVERSING: Delassus = (1000.0, 800.0, 1000.0)
"""With mu = 0.6 a slip along -t ends in compression and reverses: d_nt > mu d_tt."""


@st.composite
def impact(draw: st.DrawFn, jams: bool = False) -> tuple[float, Delassus]:
    """A friction coefficient and a positive definite matrix, with d_nn > mu |d_nt| unless slip may jam."""
    mu = draw(st.floats(0.0, 2.0))
    d_nn, d_tt = (10.0 ** draw(st.floats(1.0, 4.0)) for _ in range(2))
    most = 0.99 * sqrt(d_nn * d_tt)
    if not jams:
        most = min(most, 0.99 * d_nn / max(mu, 1e-12))
    return mu, (d_nn, draw(st.floats(-1.0, 1.0)) * most, d_tt)


@all_laws
@settings(deadline=None)
@given(approach, rate, share, impact())
def test_without_friction_every_restitution_is_that_of_the_gap_rate(
    law: Law, normal: float, tangential: float, e: float, drawn: tuple[float, Delassus]
) -> None:
    _, d = drawn
    result = impact_of(law(0.0, e), normal, tangential, d)
    assert result[1] == 0.0
    end, _ = after(normal, tangential, d, result)
    assert end == pytest.approx(-e * normal, abs=round_off(normal, tangential, d, result))


@settings(deadline=None)
@given(approach, share, share, impact())
def test_where_slip_does_not_end_newton_poisson_and_stronge_are_one(
    normal: float, more: float, e: float, drawn: tuple[float, Delassus]
) -> None:
    mu, d = drawn
    # The slip that friction would end just then, and some more.
    p_n = -(1.0 + e) * normal / (d[0] - mu * d[1])
    slip = max((mu * d[2] - d[1]) * p_n, 0.0) * (1.0 + more) + 1e-6
    expected = (p_n, -mu * p_n)
    for law in (Newton, Poisson, Stronge):
        result = impact_of(law(mu, e), normal, slip, d)
        assert result[:2] == pytest.approx(expected, rel=1e-9, abs=0.0), law.name


def test_where_slip_reverses_the_restitutions_differ_and_newtons_creates_energy() -> None:
    mu, e, normal, slip = 0.6, 0.9, -0.1, -0.08
    gains = {}
    ends = {}
    before = contact_energy(normal, slip, REVERSING)
    for law in (Newton, Poisson, Stronge):
        result = impact_of(law(mu, e), normal, slip, REVERSING)
        gains[law] = -loss(normal, slip, REVERSING, result) / before
        ends[law] = after(normal, slip, REVERSING, result)[0]
    print("energy made, over that of the contact velocity:", {k.name: gains[k] for k in gains})
    # Newton's ends the slip: v' D^-1 v = (e v_n)^2 d_tt/det, against v_n^2/d_nn at this slip.
    assert gains[Newton] == pytest.approx(e**2 * 1.0 / 0.36 - 1.0, rel=1e-12)
    assert gains[Poisson] < 0.0
    assert gains[Stronge] < 0.0
    assert ends[Newton] == pytest.approx(0.09, rel=1e-12)
    assert ends[Poisson] < 0.9 * ends[Newton]
    assert ends[Stronge] < 0.9 * ends[Newton]
    assert ends[Poisson] != pytest.approx(ends[Stronge], rel=0.02)


@processes
@settings(deadline=None, max_examples=500)
@given(approach, rate, share, impact(jams=True))
def test_a_process_with_friction_creates_no_energy(
    law: type[Poisson] | type[Stronge],
    normal: float,
    tangential: float,
    e: float,
    drawn: tuple[float, Delassus],
) -> None:
    mu, d = drawn
    result = impact_of(law(mu, e), normal, tangential, d)
    error = round_off(normal, tangential, d, result)
    assert result[0] > 0.0
    assert abs(result[1]) <= mu * result[0] * (1.0 + 1e-15)
    assert after(normal, tangential, d, result)[0] >= -error
    assert -loss(normal, tangential, d, result) <= (result[0] + abs(result[1])) * error


@settings(deadline=None)
@given(approach, rate, share, impact())
def test_the_normal_impulse_of_stronge_gives_back_the_square_of_e_of_its_work(
    normal: float, tangential: float, e: float, drawn: tuple[float, Delassus]
) -> None:
    # The plastic impact of the same process is its compression.
    mu, d = drawn
    results = [impact_of(Stronge(mu, k), normal, tangential, d) for k in (0.0, e)]
    taken, kept = (-_normal_work(normal, tangential, mu, d, result[0]) for result in results)
    error = max(result[0] * round_off(normal, tangential, d, result) for result in results)
    assert kept == pytest.approx((1.0 - e * e) * taken, abs=error)


def _normal_work(normal: float, slip: float, mu: float, d: Delassus, p_n: float) -> float:
    """Work of the normal impulse up to p_n, by the trapezia between the ends of its stages [J]."""
    s = np.sign(slip)
    fall = s * d[1] - mu * d[2]
    end = min(-s * slip / fall, p_n) if s != 0.0 and fall < 0.0 else 0.0 if s == 0.0 else p_n
    middle = normal + (d[0] - s * mu * d[1]) * end
    ratio = -np.clip(d[1] / d[2], -mu, mu)
    last = middle + (d[0] + ratio * d[1]) * (p_n - end)
    return float(0.5 * (normal + middle) * end + 0.5 * (middle + last) * (p_n - end))


def _brute(law: MultiplierLaw, normal: float, slip: float, d: Delassus, dp: float) -> tuple[float, float]:
    """Impulses of the process in small equal steps of the normal impulse, each with implicit friction."""
    mu, e = law.parameters()
    p_n = p_t = work = compressed = taken = 0.0
    while True:
        push = float(np.clip(-(slip + d[1] * dp) / d[2], -mu * dp, mu * dp))
        end = normal + d[0] * dp + d[1] * push
        work += 0.5 * (normal + end) * dp
        normal, slip = end, slip + d[1] * dp + d[2] * push
        p_n, p_t = p_n + dp, p_t + push
        if compressed == 0.0 and normal >= 0.0:
            compressed, taken = p_n, work
        if compressed > 0.0:
            enough = p_n >= (1.0 + e) * compressed
            if enough if isinstance(law, Poisson) else work >= (1.0 - e * e) * taken:
                return p_n, p_t


@processes
def test_the_closed_form_is_the_process_in_small_steps(law: type[Poisson] | type[Stronge]) -> None:
    rng = np.random.default_rng(3)
    counts = (200, 600, 1800)
    errors = np.zeros(len(counts))
    seen: set[tuple[bool, bool]] = set()
    for _ in range(60):
        mu, e = rng.uniform(0.05, 1.0), rng.uniform()
        d_nn, d_tt = 10.0 ** rng.uniform(2.0, 3.0, 2)
        d_nt = rng.uniform(-1.0, 1.0) * min(0.9 * sqrt(d_nn * d_tt), 0.9 * d_nn / mu)
        d = (d_nn, d_nt, d_tt)
        normal, slip = -0.1, rng.normal() * 0.1
        chosen = law(mu, e)
        result = impact_of(chosen, normal, slip, d)
        for k, count in enumerate(counts):
            p_n, p_t = _brute(chosen, normal, slip, d, -normal / d_nn / count)
            error = max(abs(p_n - result[0]), abs(p_t - result[1])) / result[0]
            errors[k] = max(errors[k], error)
        turned = slip * after(normal, slip, d, result)[1] < -1e-12
        seen.add((bool(turned), result[2] == STICK))
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    print(f"{law.name}: worst impulse in small steps, relative: {errors}, order {order:.3f}")
    # The instants of a process lie somewhere in a step: the worst of many cases falls with the step, but
    # for where in it they happen to lie; an error of one case would stay.
    assert 0.8 <= order <= 1.2
    # Slip that lasts, slip that reverses, stick.
    assert seen == {(False, False), (True, False), (False, True)}


@all_laws
@settings(deadline=None)
@given(approach, rate, share, impact())
def test_without_restitution_an_impact_is_the_plastic_one(
    law: Law, normal: float, tangential: float, begun: float, drawn: tuple[float, Delassus]
) -> None:
    mu, d = drawn
    # No slip can reverse where friction can hold what the normal impulse drives.
    assume(abs(d[1]) < mu * d[2])
    plastic = stepped(LagrangeStick(mu), normal, tangential, normal, tangential, *d)
    chosen = law(mu, 0.0)
    # Whatever part of the approach is there at the start of the step.
    result = stepped(chosen, normal, tangential, begun * normal, tangential, *d)
    error = round_off(normal, tangential, d, plastic)
    assert result[0] == pytest.approx(plastic[0], abs=error / (d[0] - d[1] ** 2 / d[2]))
    assert after(normal, tangential, d, result) == pytest.approx(
        after(normal, tangential, d, plastic), abs=error
    )


@all_laws
@pytest.mark.parametrize("gap_rate", [0.0, 1e-18, -1e-18])
@pytest.mark.parametrize("d", [(900.0, 20.0, 2000.0), REVERSING])
def test_contact_that_lasts_has_no_restitution(law: Law, gap_rate: float, d: Delassus) -> None:
    chosen, plastic = law(0.6, 0.8), LagrangeStick(0.6)
    for slip in (-1e-3, 0.0, 1e-3):
        requested = (-1e-3, slip, gap_rate, slip, *d)
        result = stepped(chosen, *requested)
        expected = stepped(plastic, *requested)
        assert result[2] == expected[2]
        assert result[:2] == pytest.approx(expected[:2], rel=1e-12, abs=1e-20)


@all_laws
@pytest.mark.parametrize("gained", [-0.02, 0.03])
def test_forces_within_the_step_are_not_given_back(law: Law, gained: float) -> None:
    d, e = (1000.0, 0.0, 1000.0), 0.5
    chosen = law(0.3, e)
    p_n, _, _ = stepped(chosen, -0.1 + gained, 0.0, -0.1, 0.0, *d)
    end = -0.1 + gained + d[0] * p_n
    # That before the forces act on it, of an approach that they have not taken away themselves; of Moreau and
    # Jean the rate at the end of the step.
    begins = min(-0.1 + gained, 0.0) if gained > 0.0 else -0.1
    expected = -e * -0.1 if law is MoreauJean else -e * begins + min(gained, 0.0)
    assert end == pytest.approx(expected, rel=1e-12)


@processes
def test_parting_bodies_are_released_not_pulled(law: type[Poisson] | type[Stronge]) -> None:
    # The pull that would be needed tells the engine when the force ended.
    d = (900.0, 20.0, 2000.0)
    chosen = law(0.3, 0.5)
    assert stepped(chosen, 0.1, 0.4, 0.0, 0.4, *d)[0] < 0.0
    assert stepped(chosen, 0.1, 0.4, -0.1, 0.4, *d)[0] < 0.0
