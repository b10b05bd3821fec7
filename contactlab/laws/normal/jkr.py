"""Adhesion of soft, large spheres: a contact that begins at a touch and has to be pulled off."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi, sqrt
from typing import Annotated, final

from contactlab.checks import checked_arguments
from contactlab.compiler.kernels import inner_kernel, kernel
from contactlab.laws.base import NormalForce
from contactlab.laws.declaration import Coefficient
from contactlab.laws.normal.elastic import EFFECTIVE_MODULUS, STEEL
from contactlab.parameter import positive

RADIUS = positive("R", "m", "relative radius")
ADHESION = positive("w", "J m-2", "work of adhesion")

BREAK = -0.75 * 4.0 ** (-1.0 / 3.0)
"""Depth at which it breaks, over a_0^2/R."""

STEEPEST = 1e-9
"""Least share of dd/dq: at the break the stiffness has no bound."""


@inner_kernel
def root_of_radius(depth):
    """Return q >= 4^(-1/3) with q^4 - q = x, of the depth x; at the break and beyond that of the break.

    By Ferrari: (q^2 + m)^2 = 2 m (q + 1/4m)^2 with m^3 + x m = 1/8, whose discriminant is zero at the break.
    """
    x = max(depth, BREAK)
    third = x / 3.0
    t = (0.0625 + sqrt(max(0.00390625 + third**3, 0.0))) ** (1.0 / 3.0)
    # Neither form subtracts what is nearly equal.
    m = 0.125 / (t * t + third + (third / t) ** 2) if x > 0.0 else t - third / t
    return 0.5 * (sqrt(2.0 * m) + sqrt(max(sqrt(2.0 / m) - 2.0 * m, 0.0)))


@final
@dataclass(frozen=True)
class Jkr(NormalForce):
    """Hertz with the energy of the surfaces in the contact circle of radius a.

    A contact begins at a gap of zero, where a = a_0 = (2 pi w R^2/E*)^(1/3) at once and N = -8/9 F_c, and
    lasts to the gap 3/4^(4/3) a_0^2/R, where it breaks at N = -5/9 F_c. F_c = 3/2 pi w R is the largest
    pull; a constant one beyond it parts the bodies. V is zero at the touch, below it while the surfaces
    pull, and what is left at the break is lost: 7.09 (w^5 R^4/E*^2)^(1/3), whatever the speed. A body that
    brings less never leaves. Valid where the neck is much higher than the range of the surfaces' forces,
    at a `contactlab.tabor_number` above 5; see dmt below 0.1, and maugis in between. a is small against R.
    """

    name = "jkr"
    equation = "N = 4 E* a^3/(3 R) - sqrt(8 pi w E* a^3), d = a^2/R - sqrt(2 pi w a/E*)"
    source = "Johnson, Kendall and Roberts (1971), Proc. R. Soc. A 324, 301; Thornton and Ning (1998)"
    validity = "Tabor number above 5; contact radius well below R"
    allows_tension = True
    convergence_order = 0.9

    radius: Annotated[float, RADIUS] = 4.2e-3
    effective_modulus: Annotated[float, EFFECTIVE_MODULUS] = STEEL
    work_of_adhesion: Annotated[float, ADHESION] = 0.1

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return the units of force, 2 pi w R [N], and of depth, a_0^2/R [m]."""
        force = 2.0 * pi * self.work_of_adhesion * self.radius
        depth = (force * self.radius / self.effective_modulus) ** (2.0 / 3.0) / self.radius
        return {"force_unit": force, "depth_unit": depth}

    @staticmethod
    @kernel
    def elastic(depth, force_unit, depth_unit):
        # a = a_0 q^2.
        q = root_of_radius(depth / depth_unit)
        cube = q**3
        way = max(4.0 * cube - 1.0, STEEPEST)
        ratio = q * q * (8.0 * cube - 6.0) / way
        bend = (q * (40.0 * cube - 12.0) - 12.0 * q * q * ratio) / (way * way)
        energy = q**4 * (cube * (8.0 / 15.0 * cube - 4.0 / 3.0) + 0.5) + 0.3
        pressed = cube * (4.0 / 3.0 * cube - 2.0)
        stiffness, slope = force_unit / depth_unit * ratio, force_unit / depth_unit**2 * bend
        return force_unit * pressed, force_unit * depth_unit * energy, stiffness, slope

    @staticmethod
    @kernel
    def limits(depth_unit):
        return 0.0, -BREAK * depth_unit


@checked_arguments()
def tabor_number(
    radius: Annotated[float, positive("R", "m", "relative radius")],
    effective_modulus: Annotated[float, positive("E*", "Pa", "effective modulus")],
    work_of_adhesion: Annotated[float, positive("w", "J m-2", "work of adhesion")],
    equilibrium_distance: Annotated[float, positive("z_0", "m", "equilibrium distance of the surfaces")],
) -> float:
    """Return Tabor's number, the height of an adhesive neck over the range of the surfaces' forces [1].

        mu_T = (R w^2 / (E*^2 z_0^3))^(1/3)

    `jkr` applies above about 5, `dmt` below about 0.1 (Tabor 1977, J. Colloid Interface Sci. 58, 2; Johnson
    and Greenwood 1997, J. Colloid Interface Sci. 192, 326); `maugis` spans what is in between.
    All arguments are positive: R relative radius, E* effective modulus, w work of adhesion, z_0 equilibrium
    distance of the surfaces, 0.16 to 0.4 nm as a rule.

        >>> import contactlab as cl
        >>> f"{cl.tabor_number('4.2 mm', '115 GPa', 0.1, '0.2 nm'):.2f}"
        '7.35'
    """
    return float(
        (radius * work_of_adhesion**2 / (effective_modulus**2 * equilibrium_distance**3)) ** (1.0 / 3.0)
    )
