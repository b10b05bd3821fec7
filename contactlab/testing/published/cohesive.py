"""Derjaguin (1934): friction at no load, as if a force of cohesion pressed too."""

from contactlab.laws import Composed, Linear
from contactlab.laws.friction import Cohesive
from contactlab.testing.claim import Claims, close
from contactlab.testing.closed_forms import SPRING, WEIGHT, resting
from contactlab.testing.plants import first, run


def stop(mu: float = 0.3, cohesion: float = 4.0, start: float = 0.2) -> Claims:
    """A block of 1 kg slows by mu (g + C/m) and stops after v_0 over that (Derjaguin 1934)."""
    time = start / (mu * (WEIGHT + cohesion))
    law = Composed(Linear(SPRING), friction=Cohesive(mu, 1.4, cohesion))
    made = run(resting(velocity=start), law, 1.25 * time, 1e-3)
    result = first(made, "duration") - first(made, "stick_duration")
    yield close("time until it stops", result, time, 1e-6, "s")
