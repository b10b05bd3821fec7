"""Contacts of smooth bodies after Hertz: point, ellipse and line."""

from dataclasses import dataclass
from functools import cache
from math import exp, log, pi, sqrt
from typing import Annotated, final

from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from contactlab.compiled import kernel
from contactlab.laws.part import NormalForce
from contactlab.parameter import Parameter

STEEL = 210e9 / (2.0 * (1.0 - 0.3**2))
"""Effective modulus of steel on steel [Pa]."""

EFFECTIVE_MODULUS = Parameter("E*", "Pa", "effective modulus", above=0.0)

ROUND = 1e-5
"""Relative difference of radii below which the contact is circular: F_2 differs by its square from 1."""


@kernel
def hertz_elastic(depth, parameters, at):
    """Force [N], energy [J], stiffness [N/m], its slope [N/m^2] of N = K d^(3/2)."""
    root = sqrt(depth)
    force = parameters[at] * depth * root
    stiffness = 1.5 * parameters[at] * root
    slope = 0.5 * stiffness / depth if depth > 0.0 else 0.0
    return force, 0.4 * force * depth, stiffness, slope


@final
@dataclass(frozen=True)
class HertzPoint(NormalForce):
    """A circular point contact; `contactlab.laws.hertz_stiffness` gives K from radii and moduli."""

    name = "hertz_point"
    equation = "N = K d^1.5"
    source = "Hertz (1881); Johnson, Contact Mechanics (1985), eq. 4.23"

    stiffness: Annotated[float, Parameter("K", "N m-1.5", "contact stiffness", above=0.0)] = 1e10

    elastic = staticmethod(hertz_elastic)


@final
@dataclass(frozen=True)
class HertzElliptic(NormalForce):
    """A point contact of bodies with two different relative principal radii R', R'', in any order.

    F_2 of R'/R'' is exact, from the complete elliptic integrals; F_2 = 1 where the radii are equal. A
    spherical tip of radius r on a rotor of radius R has 1/R' = 1/r and 1/R'' = 1/r + 1/R;
    1/E* = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2.
    """

    name = "hertz_elliptic"
    equation = "N = 4/3 E* sqrt(R_e) (d / F_2(R'/R''))^1.5, R_e = sqrt(R' R'')"
    source = "Hertz (1881); Johnson, Contact Mechanics (1985), eqs. 4.26 to 4.28"

    radius_along: Annotated[float, Parameter("R'", "m", "relative radius", above=0.0)] = 5e-3
    radius_across: Annotated[float, Parameter("R''", "m", "relative radius", above=0.0)] = 4.2e-3
    effective_modulus: Annotated[float, EFFECTIVE_MODULUS] = STEEL

    elastic = staticmethod(hertz_elastic)

    def coefficients(self) -> tuple[float, ...]:
        """Give the stiffness K of N = K d^1.5."""
        mean = sqrt(self.radius_along * self.radius_across)
        large, small = sorted((self.radius_along, self.radius_across), reverse=True)
        shape = approach_factor(large / small)
        return (4.0 / 3.0 * self.effective_modulus * sqrt(mean) * shape**-1.5,)


@cache
def approach_factor(ratio: float) -> float:
    """Give F_2 of the ratio R'/R'' >= 1 of relative radii [1]: approach over that of R_e both ways."""
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


@final
@dataclass(frozen=True)
class Line(NormalForce):
    """The line contact of a roller of finite length, d = 1.36 (N/E*)^0.9 / L^0.8.

    The approach of a line contact depends on what lies behind it, by a logarithm; this power law stands
    for rollers in raceways. With steel it is Palmgren's rule within 2 %.
    """

    name = "line"
    equation = "N = E* (d L^0.8 / 1.36)^(10/9)"
    source = "Lundberg and Sjovall (1958); Palmgren (1959)"

    length: Annotated[float, Parameter("L", "m", "length of the line", above=0.0)] = 16e-3
    effective_modulus: Annotated[float, EFFECTIVE_MODULUS] = STEEL

    def coefficients(self) -> tuple[float, ...]:
        """Give the stiffness K of N = K d^(10/9)."""
        return (self.effective_modulus * (self.length**0.8 / 1.36) ** (10.0 / 9.0),)

    @staticmethod
    @kernel
    def elastic(depth, parameters, at):
        """See `NormalForce.elastic`."""
        force = parameters[at] * depth ** (10.0 / 9.0)
        stiffness = 10.0 / 9.0 * force / depth if depth > 0.0 else 0.0
        slope = stiffness / (9.0 * depth) if depth > 0.0 else 0.0
        return force, 9.0 / 19.0 * force * depth, stiffness, slope
