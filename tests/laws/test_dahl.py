"""Dahl's friction: its curve from rest."""

from math import exp, log

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support.closed_forms import SPRING, WEIGHT, resting

from contactlab.laws.composed import Composed
from contactlab.laws.friction import Dahl
from contactlab.laws.normal import Linear
from contactlab.testing.plants import HEAVY, run

MU, SIGMA = 0.3, 1e5
YIELD, LIMIT = MU / SIGMA, MU * WEIGHT
"""Way along the first tangent to the limit [m], and the limit [N]."""


def work(share: float, exponent: float) -> float:
    """Integral of F/F_c over sigma x/F_c from rest, of F/F_c = 1 - (1 + (i - 1) s)^(-1/(i - 1))."""
    if exponent == 1.0:
        return share - 1.0 + exp(-share)
    if exponent == 2.0:
        return share - log(1.0 + share)
    k = exponent - 1.0
    return share - ((1.0 + k * share) ** (1.0 - 1.0 / k) - 1.0) / (k - 1.0)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("exponent", [1.0, 1.5, 2.0])
def test_the_curve_from_rest_is_dahls(exponent: float, way: float) -> None:
    law = Composed(Linear(SPRING), friction=Dahl(MU, SIGMA, exponent))
    series = run(resting(HEAVY, velocity=way * 5.0 * YIELD), law, 1.0, 1e-2, 0.1).series
    # Recorded is the mean force over half of the way that the first tangent takes to the limit.
    expected = np.diff([work(0.5 * k, exponent) for k in range(11)]) / 0.5
    assert_allclose(-way * series["friction_force"][1:] / LIMIT, expected, atol=1e-9)
