"""Adhesion between soft and hard spheres: Hertz, and a constant stress on a ring around the contact."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import atan2, cos, pi, sin, sqrt
from typing import Annotated, final

import scipy

from contactlab.compiler.kernels import inner_kernel, kernel
from contactlab.laws.base import NormalForce
from contactlab.laws.declaration import Coefficient
from contactlab.laws.normal.elastic import EFFECTIVE_MODULUS, STEEL
from contactlab.laws.normal.jkr import ADHESION, RADIUS, STEEPEST, root_of_radius
from contactlab.parameter import Parameter

PER_TABOR = 32.0 / (9.0 * sqrt(3.0)) / (16.0 / 9.0 * pi) ** (1.0 / 3.0)
"""lambda over Tabor's number, 1.157, with sigma_0 = 16 w/(9 sqrt(3) z_0) of Lennard-Jones surfaces."""

RING = 8.0 / (3.0 * pi)
"""Radius over lambda at which a ring without contact is about to break."""

SMALL = 1e-8
"""Last change of b over b, and b dG/db at which the break is reached: their squares are round-off."""

STEPS = 60
"""More than Newton's method takes: next to the break, where two roots meet, each step halves the error."""


@inner_kernel
def balance(a, b, transition):
    """Return G, the gap at c over h_0 less 1, dG/db at constant d and dG/dd at constant b = sqrt(c^2 - a^2).

    Everything is in the units of `Maugis.coefficients`, with d = a^2 - 4/3 lambda b.
    """
    c = sqrt(a * a + b * b)
    angle, half, lens = atan2(b, a), a * b / (c * c), b * b / (c * c * (a + c))
    square = transition * transition
    excess = 0.5 * transition * (a * b + (b * b - a * a) * angle) - 1.0
    excess += 4.0 / 3.0 * square * (b * angle - b * b / (a + c))
    along = transition * b * (half + angle) - 8.0 / 9.0 * square * transition * lens
    along += square * (2.0 * half + (2.0 * angle - 4.0 * b / c) / 3.0)
    return excess, along, 0.5 * transition * (half - angle) - 2.0 / 3.0 * square * lens


@inner_kernel
def ring(depth, transition):
    """Return a and b = sqrt(c^2 - a^2) of the stable ring at a depth; a = 0 where the bodies do not touch.

    By Newton's method for G(b) = 0 at constant d, from the lesser b of the limits where a = 0 and of JKR.
    """
    weak = RING * transition
    b = weak + sqrt(max(weak * weak + 2.0 * depth + 4.0 / (pi * transition), 0.0))
    growth = 4.0 / 3.0 * transition
    if depth + growth * b <= 0.0:
        return 0.0, b
    # In the limit of JKR a = 6^(1/3) q^2 and b = sqrt(3 a/2)/lambda, with its depth in units of 6^(2/3).
    jkr = 4.5 ** (1.0 / 3.0) * root_of_radius(depth / 6.0 ** (2.0 / 3.0)) / transition
    b = max(min(b, jkr), -depth / growth)
    for _ in range(STEPS):
        excess, along, _ = balance(sqrt(max(depth + growth * b, 0.0)), b, transition)
        if along * b <= SMALL:
            break
        change = excess / along
        b -= change
        if abs(change) <= SMALL * b:
            break
    return sqrt(max(depth + growth * b, 0.0)), b


@inner_kernel
def potential(depth, a, b, transition):
    """Return the energy over that of bodies far apart: of the strains, and of the surfaces in the ring."""
    c = sqrt(a * a + b * b)
    angle, lens = atan2(b, a), b * b / (a + c)
    strain = 0.75 * a * (depth * (depth - 2.0 / 3.0 * a * a) + 0.2 * a**4)
    drawn = depth * (a * b - c * c * angle) + 0.25 * (c**4 * angle - a * b * (a * a - b * b))
    return strain + transition * drawn - c * c - 4.0 / 9.0 * (transition * lens) ** 2 * (a + 2.0 * c)


@cache
def landmarks(transition: float) -> tuple[float, float]:
    """Return the depth at which the bodies part, and the energy at which they meet, in units of the law."""

    def of_angle(angle: float) -> tuple[float, float]:
        """Return a and b at the root c of G, which is quadratic in c."""
        x, y = cos(angle), sin(angle)
        linear = 2.0 / 3.0 * transition**2 * (angle * y - y * y / (1.0 + x))
        c = 1.0 / (linear + sqrt(linear**2 + 0.5 * transition * (x * y + (y * y - x * x) * angle)))
        return c * x, c * y

    def steepness(angle: float) -> float:
        return float(balance(*of_angle(angle), transition)[1])

    reach = 2.0 / (pi * transition)
    least = -reach - 0.5 * (RING * transition) ** 2
    if steepness(0.5 * pi) < 0.0:
        # They part before they have ceased to touch; in the limit of JKR at an angle of 1.65/lambda.
        a, b = of_angle(scipy.optimize.brentq(steepness, 0.5 / transition, 0.5 * pi, xtol=1e-15, rtol=1e-14))
        least = a * a - 4.0 / 3.0 * transition * b
    a, b = ring(-reach, transition)
    return least, potential(-reach, a, b, transition)


@final
@dataclass(frozen=True)
class Maugis(NormalForce):
    """Spheres between `jkr` and `dmt`: around the contact, of radius a, a stress sigma_0 pulls as far as c.

    The surfaces pull up to a gap h_0 = w/sigma_0, that at the radius c, with sigma_0 = 16 w/(9 sqrt(3) z_0),
    the largest stress of Lennard-Jones surfaces of the equilibrium distance z_0. Tabor's number is
    mu_T = (R w^2/(E*^2 z_0^3))^(1/3), see `contactlab.tabor_number`.

    A contact begins at the gap h_0 = 0.974 z_0, where the surfaces begin to pull, and lasts as long as a ring
    is stable. For mu_T above 0.811 it breaks while the bodies touch, below that after a = 0, where they pull
    without touching. V is zero where a contact begins, and what is left at the break is lost, whatever the
    speed: for mu_T = 100 within 1 % the loss of jkr; it falls to nothing with the fifth power of mu_T.
    """

    name = "maugis"
    equation = (
        "N = 4 E* a^3/(3 R) - 2 sigma_0 (a b + c^2 theta), d = a^2/R - 2 sigma_0 b/E*, "
        "w/sigma_0 = (a b + (b^2 - a^2) theta)/(pi R) + 4 sigma_0 (b theta + a - c)/(pi E*), "
        "a = c cos(theta), b = c sin(theta)"
    )
    source = "Maugis (1992), J. Colloid Interface Sci. 150, 243; Johnson and Greenwood (1997), ibid. 192, 326"
    validity = "Tabor number 0.01 to 100; contact radius and pulled ring well below R"
    allows_tension = True
    convergence_order = 0.8

    radius: Annotated[float, RADIUS] = 4.2e-3
    effective_modulus: Annotated[float, EFFECTIVE_MODULUS] = STEEL
    work_of_adhesion: Annotated[float, ADHESION] = 0.1
    tabor_number: Annotated[float, Parameter("mu_T", "1", "Tabor's number", at_least=1e-2, at_most=1e2)] = 5.0

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return lambda = 2 sigma_0 (R/(pi w K^2))^(1/3), units of force and depth, and landmarks in them.

        Units are pi w R [N] and (pi^2 w^2 R/K^2)^(1/3) [m], with K = 4/3 E*; that of radii is the geometric
        mean of R and the latter.
        """
        transition = PER_TABOR * self.tabor_number
        force = pi * self.work_of_adhesion * self.radius
        depth = (force / (4.0 / 3.0 * self.effective_modulus)) ** (2.0 / 3.0) / self.radius ** (1.0 / 3.0)
        least, zero = landmarks(transition)
        units = {"force_unit": force, "depth_unit": depth}
        return {"transition": transition, **units, "least_depth": least, "zero_energy": zero}

    @staticmethod
    @kernel
    def elastic(depth, transition, force_unit, depth_unit, least_depth, zero_energy):
        d = max(depth / depth_unit, least_depth)
        a, b = ring(d, transition)
        stored = force_unit * depth_unit * (potential(d, a, b, transition) - zero_energy)
        per_depth, weak = force_unit / depth_unit, RING * transition
        if a == 0.0:
            way = max(b - weak, STEEPEST * b)
            pull = pi * transition * b
            slope = pi * transition * weak / way**3
            return (
                -0.5 * force_unit * pull * b,
                stored,
                -per_depth * pull / way,
                per_depth / depth_unit * slope,
            )
        c = sqrt(a * a + b * b)
        angle, sine, cosine = atan2(b, a), b / c, a / c
        _, along, across = balance(a, b, transition)
        along = max(along, STEEPEST / b)
        # Derivatives with respect to the depth; lens is (c - a)/c^2.
        db = -across / along
        da = (0.5 + 2.0 / 3.0 * transition * db) / a
        turn, dc = (cosine * db - sine * da) / c, cosine * da + sine * db
        lens = sine * sine / (a + c)
        dlens = (sine * db - lens * c * da) / (c * c) - 2.0 * lens * dc / c
        square = transition * transition
        dacross = -transition * sine * sine * turn - 2.0 / 3.0 * square * dlens
        dalong = transition * (db * (sine * cosine + angle) + 2.0 * b * cosine * cosine * turn)
        dalong += square * turn * (4.0 * cosine * cosine - 4.0 / 3.0 * (1.0 + cosine))
        dalong -= 8.0 / 9.0 * square * transition * dlens
        bend = -(dacross + dalong * db) / along
        arm = b + 2.0 / 3.0 * transition
        force = a**3 - transition * (a * b + c * c * angle)
        stiffness = 1.5 * a - transition * angle * (1.0 + 2.0 * arm * db)
        slope = 1.5 * da - transition * turn * (1.0 + 2.0 * arm * db)
        slope -= 2.0 * transition * angle * (bend * arm + db * db)
        return force_unit * force, stored, per_depth * stiffness, per_depth / depth_unit * slope

    @staticmethod
    @kernel
    def limits(transition, depth_unit, least_depth):
        return 2.0 / (pi * transition) * depth_unit, -least_depth * depth_unit
