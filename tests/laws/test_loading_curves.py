"""Friction that builds up over a way, pressed by a constant force: its curve is the published one."""

from collections.abc import Callable
from math import cosh, exp, log

import numpy as np
import pytest
from numpy.testing import assert_allclose
from support.closed_forms import SPRING, WEIGHT, resting

from contactlab.laws.base import Friction
from contactlab.laws.composed import Composed
from contactlab.laws.friction import BoucWen, Dahl
from contactlab.laws.normal import Linear
from contactlab.testing.plants import HEAVY, run

MU, UNIT = 0.3, 3e-6
"""Friction coefficient, and the way along the first tangent to the limit [m]."""


def dahl(exponent: float) -> Callable[[float], float]:
    """Integral of F/F_c = 1 - (1 + (i - 1) s)^(-1/(i - 1)) over s = sigma x/F_c (Dahl 1976)."""
    k = exponent - 1.0
    if exponent == 1.0:
        return lambda s: s - 1.0 + exp(-s)
    if exponent == 2.0:
        return lambda s: s - log(1.0 + s)
    return lambda s: s - ((1.0 + k * s) ** (1.0 - 1.0 / k) - 1.0) / (k - 1.0)


def bouc_wen(exponent: float) -> Callable[[float], float]:
    """Integral of 1 - e^-s for n = 1, of tanh s for n = 2 (Wen 1976)."""
    return (lambda s: s + exp(-s)) if exponent == 1.0 else lambda s: log(cosh(s))


CURVES: dict[str, tuple[Friction, Callable[[float], float]]] = {
    **{f"dahl, i = {i:g}": (Dahl(MU, MU / UNIT, i), dahl(i)) for i in (1.0, 1.5, 2.0)},
    **{
        f"bouc_wen, n = {n:g}, beta {shape:g}": (BoucWen(MU, UNIT, shape, n), bouc_wen(n))
        for n in (1.0, 2.0)
        for shape in (0.5, 0.9)
    },
}
"""Law, and the integral of F/(mu N) over the way in units of UNIT."""


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("name", CURVES)
def test_the_curve_from_rest_is_the_published_one(name: str, way: float) -> None:
    friction, work = CURVES[name]
    law = Composed(Linear(SPRING), friction=friction)
    series = run(resting(HEAVY, velocity=way * 5.0 * UNIT), law, 1.0, 1e-2, 0.1).series
    # Recorded is the mean force over half of the unit.
    expected = np.diff([work(0.5 * k) for k in range(11)]) / 0.5
    assert_allclose(-way * series["friction_force"][1:] / (MU * WEIGHT), expected, atol=1e-9)
