"""Johnson, Kendall and Roberts (1971); Thornton and Ning (1998) for the impact."""

from math import pi

import numpy as np

from contactlab.laws import Composed, Coulomb
from contactlab.laws.normal import Jkr
from contactlab.testing.claim import Claims, close
from contactlab.testing.plants import block, first, run


def pull_off(work: float = 0.1, radius: float = 4.2e-3, modulus: float = 115e9) -> Claims:
    """The largest pull is 3/2 pi w R, whatever the modulus (Johnson, Kendall and Roberts 1971)."""
    normal = Jkr(radius, modulus, work)
    _, ends = normal.evaluate("limits")
    depths = np.linspace(-ends, ends, 4001)
    result = -min(normal.evaluate("elastic", depth=float(d))[0] for d in depths)
    yield close("pull-off force", result, 1.5 * pi * work * radius, 1e-6, "N")


def lost(work: float = 0.1, radius: float = 4.2e-3, modulus: float = 115e9) -> Claims:
    """An impact loses 7.09 (w^5 R^4/E*^2)^(1/3), whatever its speed (Thornton and Ning 1998)."""
    expected = 7.09 * (work**5 * radius**4 / modulus**2) ** (1.0 / 3.0)
    # It brings a few times what it loses.
    mass = 2e-3
    speed = (8.0 * expected / mass) ** 0.5
    law = Composed(Jkr(radius, modulus, work), friction=Coulomb(0.0))
    made = run(block(mass, height=1e-9, gap_rate=-speed), law, 5e-9 / speed + 5e-3, 1e-6)
    # Half a unit of the printed digit.
    yield close("loss of an impact", first(made, "energy_loss"), expected, 0.005 / 7.09, "J")
