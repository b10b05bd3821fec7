"""Mindlin and Deresiewicz (1953): the microslip of spheres, which Iwan's elements sum up."""

from math import pi

from contactlab.laws import Composed, Linear
from contactlab.laws.friction import Iwan
from contactlab.testing.claim import Claims, close
from contactlab.testing.closed_forms import SPRING, WEIGHT, resting
from contactlab.testing.plants import HEAVY, run


def microslip(mu: float = 0.3, whole: float = 4e-7, share: float = 0.6, elements: int = 20) -> Claims:
    """A cycle loses 24/5 mu N x_s {1 - (1 - t)^(5/3) - 5/6 t [1 + (1 - t)^(2/3)]} (Johnson 1985, 7.4)."""
    t, rate = 1.0 - (1.0 - share) ** 1.5, 2.0 * pi * 50.0
    bracket = 1.0 - (1.0 - t) ** (5 / 3) - 5 / 6 * t * (1.0 + (1.0 - t) ** (2 / 3))
    heavy = resting(HEAVY, velocity=rate * share * whole, stiffness=HEAVY * rate**2)
    law = Composed(Linear(SPRING), friction=Iwan(mu, elements=elements, full_slip=whole))
    loss = run(heavy, law, 0.06, 1e-4, 0.02).series["friction_loss"]
    # What is between the elements goes with 1/n^2.
    error, expected = 4.0 / elements**2, 4.8 * mu * WEIGHT * whole * bracket
    yield close("loss in a cycle", loss[3] - loss[2], expected, error, "J")
