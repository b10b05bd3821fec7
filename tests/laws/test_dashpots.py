"""Dashpots whose constant follows the elastic force: impacts against closed forms and a plain integration."""

from collections.abc import Callable
from math import exp, gamma, pi, sqrt

import numpy as np
import pytest
from hypothesis import example, given, strategies as st
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import contactlab as cl
from contactlab.laws.damping import damping_ratio

MASS = 2e-3
BODY = [[1.0 / MASS, 0.0], [0.0, 3.5 / MASS]]


def rebounds(normal: cl.NormalForce, damping: cl.Damping, speeds: list[float]) -> np.ndarray:
    """Restitution of impacts of a ball in the engine."""
    law = cl.Composed(normal, damping, cl.Coulomb(0.0))
    after = [cl.impact(law, BODY, [-v, 0.0])["velocity_after"].values[0, 0] for v in speeds]
    return np.array(after) / speeds


def rebound_of(dashpot: Callable[[float], float]) -> float:
    """Restitution of d'' = -d^1.5 - c(d) d' from d' = 1, released without pull, by SciPy."""

    def force(t: float, y: np.ndarray) -> float:
        depth = max(y[0], 0.0)
        return float(depth**1.5 + dashpot(depth) * y[1])

    def pushes(t: float, y: np.ndarray) -> float:
        # At the touch, where there is no force yet, too.
        return force(t, y) if y[1] < 0.0 else 1.0

    pushes.terminal, pushes.direction = True, -1  # type: ignore[attr-defined]
    done = solve_ivp(
        lambda t, y: [y[1], -force(t, y)],
        (0.0, 1e4),
        [0.0, 1.0],
        "DOP853",
        events=pushes,
        rtol=1e-12,
        atol=1e-14,
    )
    return -float(done.y[1, -1])


@pytest.mark.parametrize("e", [0.95, 0.7, 0.4, exp(-2.0), 0.05])
def test_alpha_of_tsuji_has_its_restitution_by_a_plain_integration(e: float) -> None:
    alpha = sqrt(5.0) * damping_ratio(e)
    assert rebound_of(lambda depth: alpha * depth**0.25) == pytest.approx(e, rel=1e-7)


@example(1.0 - 1e-9)
@example(exp(-2.0))
@example(1e-300)
@given(st.floats(1e-6, 1.0))
def test_the_damping_ratio_solves_its_equation(e: float) -> None:
    """With zeta = (z + 1/z)/2, z complex: -ln e = 2 zeta ln(z) / ((z - 1/z)/2)."""
    zeta = damping_ratio(e)
    root = np.sqrt(complex(zeta * zeta - 1.0))
    loss = 2.0 if abs(root) < 1e-7 else (2.0 * zeta * np.arccosh(complex(zeta)) / root).real
    assert loss == pytest.approx(-np.log(e), rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("normal", [cl.HertzPoint(1e9), cl.Linear(), cl.Line(), cl.Lining()], ids=str)
@pytest.mark.parametrize("e", [0.9, 0.4, 0.1])
def test_tsujis_restitution_is_one_at_all_speeds_whatever_the_elastic_force(
    normal: cl.NormalForce, e: float
) -> None:
    assert_allclose(rebounds(normal, cl.Tsuji(e, MASS), [1e-3, 0.1, 5.0]), e, rtol=0.0, atol=1e-8)


@given(st.floats(1e-12, 1e-4), st.floats(-1.0, 1.0), st.floats(0.05, 0.99))
def test_tsujis_damping_of_a_hertzian_contact_is_as_published(depth: float, rate: float, e: float) -> None:
    """N = K d^1.5 + alpha sqrt(m K) d^(1/4) dd/dt where that is no pull."""
    stiffness, alpha = 1e10, sqrt(5.0) * damping_ratio(e)
    force, energy, tangent, _ = cl.HertzPoint(stiffness).evaluate("elastic", depth=depth)
    quantities = {"elastic_force": force, "elastic_energy": energy, "elastic_stiffness": tangent}
    normal = cl.Tsuji(e, MASS).evaluate("damped", depth_rate=rate, **quantities)
    dashpot = alpha * sqrt(MASS * stiffness) * depth**0.25 * rate
    assert normal == pytest.approx(max(force + dashpot, 0.0), rel=1e-12, abs=1e-12 * abs(dashpot))


def viscous(y: float, stiffness: float, speed: float) -> cl.KuwabaraKono:
    """The damping with y = 3/2 A (K/m)^(2/5) v^(1/5)."""
    return cl.KuwabaraKono(y / (1.5 * (stiffness / MASS) ** 0.4 * speed**0.2))


@pytest.mark.parametrize("y", [0.1, 0.5, 2.0])
def test_restitution_of_viscoelastic_spheres_is_that_of_a_plain_integration(y: float) -> None:
    """In units of d^1.5 and of the speed, c(d) = y d^(1/2); so e depends on y alone."""
    expected = rebound_of(lambda depth: y * sqrt(depth))
    for stiffness, speed in ((1e10, 0.1), (1e8, 3.0)):
        result = rebounds(cl.HertzPoint(stiffness), viscous(y, stiffness, speed), [speed])
        assert_allclose(result, expected, rtol=1e-7)


def test_viscoelastic_spheres_lose_in_slow_impacts_what_the_series_says() -> None:
    """1 - e = C y - 3/5 C^2 y^2 - 4/15 y^(5/2) + O(y^3), C = 1.15345, at speeds that make y."""
    c = gamma(0.6) * sqrt(pi) / (2.0**0.2 * 5.0**0.4 * gamma(2.1))
    y = np.array([0.01, 0.02, 0.04])
    damping, stiffness = viscous(0.04, 1e10, 1.0), 1e10
    e = rebounds(cl.HertzPoint(stiffness), damping, list((y / 0.04) ** 5))
    rest = e - (1.0 - c * y + 0.6 * (c * y) ** 2 + 4.0 / 15.0 * y**2.5)
    assert np.polyfit(np.log(y), np.log(np.abs(rest)), 1)[0] == pytest.approx(3.0, abs=0.2)
    assert np.all(np.abs(rest) < y**3)
