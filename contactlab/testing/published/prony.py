"""Christensen, Theory of Viscoelasticity (1982), sec. 1.6: the standard solid."""

from math import exp

from contactlab.laws import Composed, Coulomb
from contactlab.laws.normal import Prony
from contactlab.testing.claim import Claims, close
from contactlab.testing.plants import block, last, run


def creep(weight: float = 5.0, relaxed: float = 5e6, arm: float = 5e6, time: float = 1e-3) -> Claims:
    """Under a weight it creeps to W/k_inf, as 1 - (k_1/(k_inf + k_1)) exp(-t k_inf/((k_inf + k_1) tau))."""
    whole = relaxed + arm
    slow = whole * time / relaxed
    law = Composed(Prony(relaxed, arm, time), friction=Coulomb(0.0))
    # So light that it follows; it begins where the weight presses at once.
    motor = block(1e-6, height=-weight / whole, weight=weight)
    found = -last(run(motor, law, slow, 1e-4), "gap")
    yield close(
        "depth after a retardation time", found, weight / relaxed * (1.0 - arm / whole * exp(-1.0)), 1e-4, "m"
    )
