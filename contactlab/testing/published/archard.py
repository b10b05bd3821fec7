"""Archard (1953): wear in proportion to load and way."""

from contactlab.laws.archard import Archard
from contactlab.testing.claim import Claims, close
from contactlab.testing.plants import HEAVY, block, last, run


def worn(depth: float = 1e-6, speed: float = 0.5, time: float = 2e-3) -> Claims:
    """A body held at a depth d wears off w, (d - w)^-0.5 = d^-0.5 + k K v t/(2 H A) (Archard 1953)."""
    law = Archard(wear_coefficient=1e-3)
    pace = law.wear_coefficient * law.stiffness * speed / (law.hardness * law.apparent_area)
    expected = depth - (depth**-0.5 + 0.5 * pace * time) ** -2.0
    # So heavy that neither load nor friction moves it.
    made = run(block(HEAVY, height=-depth, velocity=speed), law, time, 1e-5)
    yield close("depth worn off", last(made, "internal_wear"), expected, 1e-6, "m")
