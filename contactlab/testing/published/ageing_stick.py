"""Dieterich (1972): static friction grows with the logarithm of the time of stick."""

from math import log1p

from scipy.optimize import brentq

from contactlab.laws import Composed, Linear
from contactlab.laws.friction import AgeingStick
from contactlab.testing.claim import Claims, close
from contactlab.testing.closed_forms import SPRING, WEIGHT, resting
from contactlab.testing.plants import first, run


def breakaway(mu: float = 0.3, delta: float = 0.05, onset: float = 1e-3, belt: float = 0.1) -> Claims:
    """On a belt it breaks away where k v_b t = N (mu + delta ln(1 + t/t_0)) (Dieterich 1972)."""
    stiffness = 100.0

    def excess(t: float) -> float:
        return stiffness * belt * t - WEIGHT * (mu + delta * log1p(t / onset))

    expected = float(brentq(excess, delta * WEIGHT / (stiffness * belt), 1e3, xtol=1e-14))
    law = Composed(Linear(SPRING), friction=AgeingStick(mu, delta, onset))
    motor = resting(stiffness=stiffness, velocity=belt, belt_velocity=belt)
    result = first(run(motor, law, expected + 0.05, 1e-3), "stick_duration")
    yield close("time of the first stick on a belt", result, expected, 1e-6, "s")
