"""Christensen, Theory of Viscoelasticity (1982), sec. 1.6: the standard solid."""

from math import exp

from contactlab.laws import Composed, Coulomb
from contactlab.laws.normal import Prony
from contactlab.testing.claim import Claims, close
from contactlab.testing.plants import block, last, run


def creep(weight: float = 5.0, relaxed: float = 5e6, arm: float = 5e6, time: float = 1e-3) -> Claims:
    """Under a weight W it creeps as W/k_inf [1 - k_1/k exp(-t k_inf/(k tau))], k = k_inf + k_1."""
    whole = relaxed + arm
    slow = whole * time / relaxed
    law = Composed(Prony(relaxed, arm, time), friction=Coulomb(0.0))
    # It begins where the weight presses at once, with the rate of the creep.
    begin = weight / whole
    motor = block(1e-4, height=-begin, gap_rate=-begin * arm / (whole * time), weight=weight)
    result = -last(run(motor, law, slow), "gap")
    expected = weight / relaxed * (1.0 - arm / whole * exp(-1.0))
    yield close("depth after a retardation time", result, expected, 1e-5, "m")
