"""Dieterich (1979), Ruina (1983): friction of the slip and of the age of the contact."""

from math import log

from contactlab.laws import Composed, Linear
from contactlab.laws.friction import RateAndState
from contactlab.testing.claim import Claims, close
from contactlab.testing.closed_forms import SPRING, WEIGHT, resting
from contactlab.testing.plants import HEAVY, last, run


def steady_slip(mu: float = 0.4, a: float = 0.01, b: float = 0.015, speed: float = 1e-3) -> Claims:
    """Steady slip is dragged at N (mu + (a - b) ln(v/v_0)) (Dieterich 1979; Ruina 1983)."""
    distance = reference = 1e-6
    law = Composed(Linear(SPRING), friction=RateAndState(mu, a, b, distance, reference))
    made = run(resting(HEAVY, velocity=speed), law, 60.0 * distance / speed, 1e-4, 10.0 * distance / speed)
    expected = WEIGHT * (mu + (a - b) * log(speed / reference))
    yield close("drag in steady slip", -last(made, "friction_force"), expected, 1e-6, "N")
