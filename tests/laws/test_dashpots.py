"""Dashpots whose constant follows the elastic force: impacts against closed forms and a plain integration."""

from math import exp, sqrt

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


def rebound_of_tsuji(alpha: float) -> float:
    """Restitution of d'' = -d^1.5 - alpha d^0.25 d', released without pull, by SciPy."""

    def motion(t: float, y: np.ndarray) -> list[float]:
        depth = max(y[0], 0.0)
        return [y[1], -(depth**1.5) - alpha * depth**0.25 * y[1]]

    def pushes(t: float, y: np.ndarray) -> float:
        # The force over d^0.25, which is zero at the touch too.
        return float(max(y[0], 0.0) ** 1.25 + alpha * y[1])

    pushes.terminal, pushes.direction = True, -1  # type: ignore[attr-defined]
    done = solve_ivp(motion, (0.0, 1e4), [0.0, 1.0], "DOP853", events=pushes, rtol=1e-12, atol=1e-14)
    return -float(done.y[1, -1])


@pytest.mark.parametrize("e", [0.95, 0.7, 0.4, exp(-2.0), 0.05])
def test_alpha_of_tsuji_has_its_restitution_by_a_plain_integration(e: float) -> None:
    assert rebound_of_tsuji(sqrt(5.0) * damping_ratio(e)) == pytest.approx(e, rel=1e-7)


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
