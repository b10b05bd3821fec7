"""Elastic normal forces of a composed law: smooth bodies after Hertz, and springs."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import exp, log, pi, sqrt
from typing import Annotated, final

import scipy

from contactlab.compiler.kernels import inner_kernel, kernel
from contactlab.laws.base import NormalForce
from contactlab.laws.declaration import Coefficient
from contactlab.laws.memory import AT_TOUCH, InternalVariable
from contactlab.parameter import positive

STEEL = 210e9 / (2.0 * (1.0 - 0.3**2))
"""Effective modulus of steel on steel [Pa]."""

EFFECTIVE_MODULUS = positive("E*", "Pa", "effective modulus")

MOST_SLENDER = 1e12
"""Largest ratio of radii; its ellipse is 1e8 times as long as it is wide, which is no contact of a point."""

ROUND = 1e-5
"""Relative difference of radii below which the contact is circular: F_2 differs by its square from 1."""


@kernel
def hertz_elastic(depth, stiffness):
    """Return force [N], energy [J], stiffness [N/m], its slope [N/m^2] of N = K d^(3/2)."""
    root = sqrt(depth)
    force = stiffness * depth * root
    tangent = 1.5 * stiffness * root
    slope = 0.5 * tangent / depth if depth > 0.0 else 0.0
    return force, 0.4 * force * depth, tangent, slope


@final
@dataclass(frozen=True)
class HertzPoint(NormalForce):
    """A circular point contact; `contactlab.laws.hertz_stiffness` gives K from radii and moduli."""

    name = "hertz_point"
    equation = "N = K d^1.5"
    source = "Hertz (1881); Johnson, Contact Mechanics (1985), eq. 4.23"
    validity = "contact radius well below the radii; no yield (Johnson 1985, ch. 4)"

    stiffness: Annotated[float, positive("K", "N m-1.5", "contact stiffness")] = 1e10

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
    validity = "contact ellipse well below the radii; no yield (Johnson 1985, ch. 4)"

    radius_along: Annotated[float, positive("R'", "m", "relative radius")] = 5e-3
    radius_across: Annotated[float, positive("R''", "m", "relative radius")] = 4.2e-3
    effective_modulus: Annotated[float, EFFECTIVE_MODULUS] = STEEL

    elastic = staticmethod(hertz_elastic)

    def __post_init__(self) -> None:
        super().__post_init__()
        if max(self._radii) > MOST_SLENDER * min(self._radii):
            raise ValueError(
                f"{self.name}: radius_along is {self.radius_along:g} m and radius_across is "
                f"{self.radius_across:g} m; their ratio must be at most {MOST_SLENDER:g}. A roller "
                "has the normal force line."
            )

    @property
    def _radii(self) -> tuple[float, float]:
        return self.radius_along, self.radius_across

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return the stiffness K of N = K d^1.5."""
        mean = sqrt(self.radius_along * self.radius_across)
        shape = approach_factor(max(self._radii) / min(self._radii))
        return {"stiffness": 4.0 / 3.0 * self.effective_modulus * sqrt(mean) * shape**-1.5}


@cache
def approach_factor(ratio: float) -> float:
    """Return F_2 of the ratio R'/R'' >= 1 of relative radii [1]: approach over that of R_e both ways."""
    if ratio - 1.0 < ROUND:
        return 1.0

    def terms(slenderness: float) -> tuple[float, float, float]:
        """Return (a/b)^2 E - K, K - E and K of the ellipse with log a/b."""
        # Of a slender ellipse 1 - (b/a)^2 keeps no digit of (b/a)^2, on which K depends.
        rest = exp(-2.0 * slenderness)
        first, second = float(scipy.special.ellipkm1(rest)), float(scipy.special.ellipe(1.0 - rest))
        return exp(2.0 * slenderness) * second - first, first - second, first

    def missing(slenderness: float) -> float:
        over, under, _ = terms(slenderness)
        return over / under - ratio

    # Nearly two thirds of log(R'/R'').
    size = log(ratio)
    slenderness = scipy.optimize.brentq(missing, 0.4 * size, 0.8 * size, xtol=1e-15 * size, rtol=1e-14)
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
    validity = "steel rollers in raceways: Palmgren's rule within 2 %"

    length: Annotated[float, positive("L", "m", "length of the line")] = 16e-3
    effective_modulus: Annotated[float, EFFECTIVE_MODULUS] = STEEL

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return the stiffness K of N = K d^(10/9)."""
        return {"stiffness": self.effective_modulus * (self.length**0.8 / 1.36) ** (10.0 / 9.0)}

    @staticmethod
    @kernel
    def elastic(depth, stiffness):
        force = stiffness * depth ** (10.0 / 9.0)
        tangent = 10.0 / 9.0 * force / depth if depth > 0.0 else 0.0
        slope = tangent / (9.0 * depth) if depth > 0.0 else 0.0
        return force, 9.0 / 19.0 * force * depth, tangent, slope


@final
@dataclass(frozen=True)
class Linear(NormalForce):
    """A flat punch, or a linearised contact."""

    name = "linear"
    equation = "N = k d"
    source = "Johnson, Contact Mechanics (1985), sec. 11.5"
    validity = "flat faces, or small changes of the depth"

    stiffness: Annotated[float, positive("k", "N m-1", "contact stiffness")] = 1e7

    @staticmethod
    @kernel
    def elastic(depth, stiffness):
        force = stiffness * depth
        return force, 0.5 * force * depth, stiffness, 0.0


BY_DEPTH, SOFT, PASSAGE, HARD = -1.0, 0.0, 1.0, 2.0
"""Stages of a lining; before a contact it is that of the depth."""

DEEPER, SHALLOWER = 0, 1
"""Guards: the depth has left the stage."""

PAST = 1e-9
"""Way over the passage by which the depth has left a stage: at rest on its edge it keeps it."""


@inner_kernel
def stage_at(beyond, passage):
    """Return the stage at a depth [m] beyond the lining's."""
    if beyond <= 0.0:
        return SOFT
    return PASSAGE if beyond < passage else HARD


@inner_kernel
def lining_at(stage, depth, beyond, soft_stiffness, hard_stiffness, passage):
    """Return force, energy, stiffness and slope of a stage, which goes on where another is."""
    more = hard_stiffness - soft_stiffness
    slope = more / passage
    inside = 0.0 if stage == SOFT else passage if stage == HARD else beyond
    through = beyond - passage if stage == HARD else 0.0
    force, energy = soft_stiffness * depth, 0.5 * soft_stiffness * depth * depth
    force += 0.5 * slope * inside * inside + more * through
    energy += slope * inside**3 / 6.0 + 0.5 * more * through * (passage + through)
    return force, energy, soft_stiffness + slope * inside, slope if SOFT < stage < HARD else 0.0


@final
@dataclass(frozen=True)
class Lining(NormalForce):
    """Two stages: the two-stage spring of piecewise linear oscillators, with a passage of finite width.

    The passage has a width because a stiffness that jumps is no material's and takes the order of any
    integration. Where a stage ends a step ends too: up to there, and for up to w beyond, the force goes on as
    it was, without a kink within the step.
    """

    name = "lining"
    smooth_stiffness = False
    equation = "dN/dd = k_1 for d < d_1, k_2 for d > d_1 + w, linear in between"
    source = "after Shaw and Holmes (1983), J. Sound Vib. 90, 129"

    soft_stiffness: Annotated[float, positive("k_1", "N m-1", "stiffness of the lining")] = 5e6
    hard_stiffness: Annotated[float, positive("k_2", "N m-1", "stiffness of what is behind")] = 5e7
    lining_depth: Annotated[float, positive("d_1", "m", "depth of the lining")] = 5e-7
    passage: Annotated[float, positive("w", "m", "width of the passage")] = 1e-7

    internal_variables = (
        InternalVariable("stage", "", "1", "0 lining, 1 passage, 2 what is behind", BY_DEPTH, discrete=True),
    )
    guards = 2

    @staticmethod
    @kernel
    def elastic(depth, stage, soft_stiffness, hard_stiffness, lining_depth, passage):
        beyond = depth - lining_depth
        parameters = soft_stiffness, hard_stiffness, passage
        if stage >= SOFT and (stage - 2.0) * passage <= beyond <= (stage + 1.0) * passage:
            result = lining_at(stage, depth, beyond, *parameters)
            if result[0] >= 0.0 and result[2] > 0.0:
                return result
        return lining_at(stage_at(beyond, passage), depth, beyond, *parameters)

    @staticmethod
    @kernel
    def guard(which, depth, stage, lining_depth, passage):
        if stage < SOFT:
            return -1.0
        if which == DEEPER:
            return lining_depth + (stage + PAST) * passage - depth if stage < HARD else 1.0
        return depth - lining_depth - (stage - PASSAGE - PAST) * passage if stage > SOFT else 1.0

    @staticmethod
    @kernel
    def jump(which, event, depth, stage, lining_depth, passage):
        if event == DEEPER and stage >= SOFT:
            return min(stage + 1.0, HARD)
        if event == SHALLOWER and stage >= SOFT:
            return max(stage - 1.0, SOFT)
        return stage if AT_TOUCH < event < DEEPER else stage_at(depth - lining_depth, passage)
