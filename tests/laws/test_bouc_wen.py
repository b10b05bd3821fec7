"""Bouc's and Wen's hysteresis: its deflection, and Wen's own equation."""

from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from support.closed_forms import SPRING, WEIGHT, resting

from contactlab.laws.composed import Composed
from contactlab.laws.friction import BoucWen
from contactlab.laws.normal import Linear
from contactlab.testing.plants import HEAVY, run

MU, YIELD = 0.3, 3e-6
LIMIT = MU * WEIGHT


@pytest.mark.parametrize("coefficient", [0.0, 1e-12, MU])
@pytest.mark.parametrize("speed", [5.0, 500.0, 5e4])
def test_a_deflection_is_followed_whatever_friction_it_brings(coefficient: float, speed: float) -> None:
    """Without a coefficient no force tells of it; over the way Y it is tanh(v t/Y) of Y."""
    law = Composed(Linear(SPRING), friction=BoucWen(coefficient, YIELD, 2.0, 2.0))
    made = run(resting(HEAVY, velocity=speed * YIELD), law, 5.0 / speed, 1e-2, 0.5 / speed)
    way = 0.5 * np.arange(11)
    assert_allclose(made.series["internal_deflection"], YIELD * np.tanh(way), atol=1e-7 * YIELD)


WEN = [(1.0, 0.5, 0.5, 1.0), (2.0, 4e5, 1e5, 1.0), (1.5, 3e11, -1e11, 2.0), (1.0, 1e17, 1e17, 3.0)]
"""A [1], beta and gamma [m^-n], n."""


@pytest.mark.parametrize(("a", "beta", "gamma", "n"), WEN[1:])
def test_a_run_follows_wens_equation_of_four_constants(a: float, beta: float, gamma: float, n: float) -> None:
    """dz/dt = A v - beta |v| |z|^(n-1) z - gamma v |z|^n, friction mu N z/z_u along a swing."""
    ultimate, rate = (a / (beta + gamma)) ** (1.0 / n), 2.0 * pi * 50.0
    swing = 3.0 * ultimate / a

    def rates(t: float, y: np.ndarray) -> list[float]:
        v, z = rate * swing * np.cos(rate * t), y[0]
        return [a * v - beta * abs(v) * abs(z) ** (n - 1.0) * z - gamma * v * abs(z) ** n, z]

    times = np.linspace(0.0, 0.03, 13)
    solved = solve_ivp(rates, (0.0, 0.03), [0.0, 0.0], "DOP853", times, rtol=1e-11, atol=1e-18, max_step=5e-5)
    friction = BoucWen.of_wen(MU, a, beta, gamma, n)
    heavy = resting(HEAVY, velocity=rate * swing, stiffness=HEAVY * rate**2)
    law = Composed(Linear(SPRING), friction=friction)
    series = run(heavy, law, 0.03, 1e-4, times[1]).series
    expected = -LIMIT * np.diff(solved.y[1]) / times[1] / ultimate
    assert_allclose(series["friction_force"][1:], expected, atol=1e-5 * LIMIT)


@pytest.mark.parametrize(
    ("constants", "reason"),
    [
        ((1.0, 0.2, 0.8, 1.0), "shape is 0.2; it must be at least 0.5"),
        ((1.0, 0.2, -0.8, 1.0), "beta \\+ gamma -0.6; both must be greater than 0"),
        ((0.0, 0.5, 0.5, 1.0), "A is 0 and"),
    ],
)
def test_constants_that_make_energy_or_no_friction_are_refused(
    constants: tuple[float, float, float, float], reason: str
) -> None:
    with pytest.raises(ValueError, match=reason):
        BoucWen.of_wen(MU, *constants)
