"""Dieterich (1972) on a rigid contact."""

from math import log1p

from scipy.optimize import brentq

from contactlab.laws import LagrangeAgeing
from contactlab.testing.claim import Claim, Claims
from contactlab.testing.plants import block, first, run


def breakaway(mu: float = 0.3, static: float = 0.4, delta: float = 0.02, step: float = 1e-4) -> Claims:
    """On a belt it breaks away where k v_b t = N (mu_s + delta ln(1 + t/t_0)), to a step or two."""
    weight, pull, onset = 9.81, 10.0, 1e-3

    def excess(t: float) -> float:
        return pull * t - weight * (static + delta * log1p(t / onset))

    expected = float(brentq(excess, 0.1, 2.0, xtol=1e-14))
    motor = block(weight=weight, stiffness=100.0, velocity=0.1, belt_velocity=0.1)
    made = run(motor, LagrangeAgeing(mu, static / mu, delta, onset), expected + 0.05, step)
    text = "time of the first stick on a belt"
    yield Claim(text, expected, first(made, "stick_duration"), 2.0 * step, units="s")
