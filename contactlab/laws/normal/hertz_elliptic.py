"""Hertz's point contact of bodies with two different relative radii."""

from dataclasses import dataclass
from functools import cache
from math import exp, log, pi, sqrt
from typing import Annotated, ClassVar, final

from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from contactlab.laws.normal.hertz_point import hertz_elastic
from contactlab.laws.part import ElasticKernel, NormalForce
from contactlab.parameter import Parameter

STEEL = 210e9 / (2.0 * (1.0 - 0.3**2))
"""Effective modulus of steel on steel [Pa]."""

EFFECTIVE_MODULUS = Parameter("E*", "Pa", "effective modulus", above=0.0)

ROUND = 1e-5
"""Relative difference of radii below which the contact is circular: F_2 differs by its square from 1."""


@final
@dataclass(frozen=True)
class HertzElliptic(NormalForce):
    """N = 4/3 E* sqrt(R_e) (d / F_2)^(3/2) with R_e = sqrt(R' R'').

    F_2 of R'/R'' is exact, from the complete elliptic integrals; F_2 = 1 where the radii are equal. A
    spherical tip of radius r on a rotor of radius R has 1/R' = 1/r and 1/R'' = 1/r + 1/R.

    Source: Hertz (1881); K. L. Johnson, Contact Mechanics (1985), eqs. 4.26 to 4.28.

    Args:
        radius_along, radius_across: relative principal radii R', R'' [m], in any order.
        effective_modulus: E* [Pa], 1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2.
    """

    name: ClassVar[str] = "hertz_elliptic"
    equation: ClassVar[str] = "N = 4/3 E* sqrt(R_e) (d / F_2(R'/R''))^1.5, R_e = sqrt(R' R'')"
    source: ClassVar[str] = "Hertz (1881); Johnson, Contact Mechanics (1985), eqs. 4.26 to 4.28"

    radius_along: Annotated[float, Parameter("R'", "m", "relative radius", above=0.0)] = 5e-3
    radius_across: Annotated[float, Parameter("R''", "m", "relative radius", above=0.0)] = 4.2e-3
    effective_modulus: Annotated[float, EFFECTIVE_MODULUS] = STEEL

    def coefficients(self) -> tuple[float, ...]:
        """The stiffness K of N = K d^1.5."""
        mean = sqrt(self.radius_along * self.radius_across)
        large, small = sorted((self.radius_along, self.radius_across), reverse=True)
        shape = approach_factor(large / small)
        return (4.0 / 3.0 * self.effective_modulus * sqrt(mean) * shape**-1.5,)

    @property
    def elastic(self) -> ElasticKernel:
        """The kernel; see `NormalForce.elastic`."""
        return hertz_elastic


@cache
def approach_factor(ratio: float) -> float:
    """F_2 of the ratio R'/R'' >= 1 of relative radii [1]: approach over that of R_e in both directions."""
    if ratio - 1.0 < ROUND:
        return 1.0

    def terms(slenderness: float) -> tuple[float, float, float]:
        """(a/b)^2 E - K, K - E and K of the ellipse with log a/b."""
        squared = 1.0 - exp(-2.0 * slenderness)
        first, second = float(ellipk(squared)), float(ellipe(squared))
        return exp(2.0 * slenderness) * second - first, first - second, first

    def missing(slenderness: float) -> float:
        over, under, _ = terms(slenderness)
        return over / under - ratio

    # Nearly two thirds of log(R'/R'').
    size = log(ratio)
    slenderness = brentq(missing, 0.4 * size, 0.8 * size, xtol=1e-15 * size, rtol=1e-14)
    over, under, first = terms(slenderness)
    squared = 1.0 - exp(-2.0 * slenderness)
    cubed = 4.0 / (pi * squared) * exp(-1.5 * slenderness) * sqrt(over * under)
    return float(2.0 / pi * exp(-0.5 * slenderness) * cubed ** (-1.0 / 3.0) * first)
