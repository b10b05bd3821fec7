"""Wen (1976): a hysteresis of four constants."""

from math import exp, pi

from scipy.special import lambertw

from contactlab.laws import Composed, Linear
from contactlab.laws.friction import BoucWen
from contactlab.testing.claim import Claims, close
from contactlab.testing.closed_forms import SPRING, WEIGHT, resting
from contactlab.testing.plants import HEAVY, run


def loop(mu: float = 0.3, yields: float = 3e-6, swing: float = 5.0) -> Claims:
    """With n = 1, beta = gamma a cycle loses 2 mu N (2 X - 2 Y Z - Y Z^2/2), Z = 1 - W(e^(1 - 2 X/Y))."""
    top, rate = 1.0 - lambertw(exp(1.0 - 2.0 * swing)).real, 2.0 * pi * 50.0
    heavy = resting(HEAVY, velocity=rate * swing * yields, stiffness=HEAVY * rate**2)
    law = Composed(Linear(SPRING), friction=BoucWen(mu, yields, 0.5, 1.0))
    loss = run(heavy, law, 0.2, 1e-4, 0.02, tolerance=1e-10).series["friction_loss"]
    expected = 2.0 * mu * WEIGHT * yields * (2.0 * swing - 2.0 * top - 0.5 * top**2)
    yield close("loss in a cycle", loss[10] - loss[9], expected, 1e-6, "J")
