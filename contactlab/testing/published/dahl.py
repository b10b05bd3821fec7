"""Dahl (1968, 1976): friction of the way alone."""

from math import pi, tanh

from contactlab.laws import Composed, Linear
from contactlab.laws.friction import Dahl
from contactlab.testing.claim import Claims, close
from contactlab.testing.closed_forms import SPRING, WEIGHT, resting
from contactlab.testing.plants import HEAVY, run


def loop(mu: float = 0.3, sigma: float = 1e5, swing: float = 4.0) -> Claims:
    """A cycle loses 4 F_c (X - (F_c/sigma) tanh(sigma X/F_c)) at any frequency (Dahl 1976)."""
    way, rate = mu / sigma, 2.0 * pi * 50.0
    heavy = resting(HEAVY, velocity=rate * swing * way, stiffness=HEAVY * rate**2)
    law = Composed(Linear(SPRING), friction=Dahl(mu, sigma))
    loss = run(heavy, law, 0.12, 1e-4, 0.02, tolerance=1e-10).series["friction_loss"]
    expected = 4.0 * mu * WEIGHT * way * (swing - tanh(swing))
    yield close("loss in a cycle", loss[6] - loss[5], expected, 1e-6, "J")
