"""Tustin (1947), Armstrong-Helouvry et al. (1994): friction that falls with the slip."""

from math import exp, log

from contactlab.laws import Composed, Linear
from contactlab.laws.friction import Stribeck
from contactlab.testing.claim import Claims, close
from contactlab.testing.closed_forms import SPRING, WEIGHT, resting
from contactlab.testing.plants import first, run


def stop(mu: float = 0.3, ratio: float = 1.5, slow: float = 0.05, start: float = 0.12) -> Claims:
    """A block of 1 kg stops after (v_s/(mu g)) ln[(mu e^(v_0/v_s) + dmu)/(mu + dmu)], for p = 1."""
    more = mu * (ratio - 1.0)
    time = slow / (mu * WEIGHT) * log((mu * exp(start / slow) + more) / (mu + more))
    law = Composed(Linear(SPRING), friction=Stribeck(mu, ratio, slow, 1.0))
    made = run(resting(velocity=start), law, 1.5 * time, 1e-3)
    result = first(made, "duration") - first(made, "stick_duration")
    yield close("time until it stops", result, time, 1e-6, "s")
