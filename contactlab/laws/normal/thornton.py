"""The elastic, perfectly plastic sphere: Hertz until it yields, a straight line, Hertz of a flatter one."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi, sqrt
from typing import Annotated, final

from contactlab.compiler.kernels import inner_kernel, kernel
from contactlab.laws.base import NormalForce
from contactlab.laws.declaration import Coefficient
from contactlab.laws.memory import AT_TOUCH, InternalVariable, dependent
from contactlab.laws.normal.elastic import EFFECTIVE_MODULUS, STEEL
from contactlab.parameter import positive

YIELDS = 0
"""Place of `yields` among the internal variables."""

BEGINS, STOPS = 0, 1
"""Guards: it yields where the depth is again its largest, and no longer where it does not grow."""


@inner_kernel
def flattened(largest_depth, stiffness, yield_depth):
    """Return dent d_p [m], force [N] and elastic part of the depth [m] at the largest depth.

    With r = sqrt(d*/d_y) the contact radius is a_y r, N* = N_y (3 r^2 - 1)/2 and d* - d_p = 3 N*/(4 E* a).
    """
    ratio = sqrt(largest_depth / yield_depth)
    force = 0.5 * stiffness * yield_depth * sqrt(yield_depth) * (3.0 * ratio * ratio - 1.0)
    # The difference d* - 3 N*/(4 E* a) without its cancellation: nothing is left of what has not yielded.
    dent = 0.5 * yield_depth * (ratio - 1.0) ** 2 * (2.0 * ratio + 1.0) / ratio
    return dent, force, largest_depth - dent


@final
@dataclass(frozen=True)
class Thornton(NormalForce):
    """A sphere whose contact pressure is nowhere above p_y: the profile of Hertz, cut off.

    It yields from d_y = R (pi p_y/2 E*)^2 on, without a jump of the stiffness, and comes back as a sphere of
    the radius R_p that has the same contact circle under the same force. It is elastic until its largest
    depth is reached again. What can be got back is stored; V = 2/5 N (d - d_p) on every path. A contact
    makes one dent, and the next begins on fresh material once the gap is clear of it. p_y is 1.6 times the
    yield stress where plastic flow begins, and near 3 times where it is full: a constant is no more than a
    mean of them.
    """

    name = "thornton"
    equation = "N = K d^1.5, N_y + pi p_y R (d - d_y) as it yields, 4/3 E* sqrt(R_p) (d - d_p)^1.5 after it"
    source = "Thornton (1997), J. Appl. Mech. 64, 383; Thornton and Ning (1998), Powder Technol. 99, 154"
    validity = "p_y between 1.6 and 3 times the yield stress, a mean over the depth"

    radius: Annotated[float, positive("R", "m", "relative radius")] = 4.2e-3
    effective_modulus: Annotated[float, EFFECTIVE_MODULUS] = STEEL
    yield_pressure: Annotated[float, positive("p_y", "Pa", "largest contact pressure")] = 1e9

    guards = 2

    @property
    def yield_depth(self) -> float:
        """The depth d_y at which it yields [m]."""
        return self.radius * (pi * self.yield_pressure / (2.0 * self.effective_modulus)) ** 2

    @dependent
    def internal_variables(self) -> tuple[InternalVariable, ...]:
        """Whether it yields, and how deep it has been."""
        return (
            InternalVariable("yields", "", "1", "whether the contact yields", discrete=True),
            InternalVariable("largest_depth", "d*", "m", "depth to which it is elastic", self.yield_depth),
        )

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return the stiffness K of N = K d^1.5 [N m^-1.5] and the depth of yield [m]."""
        stiffness = 4.0 / 3.0 * self.effective_modulus * sqrt(self.radius)
        return {"stiffness": stiffness, "yield_depth": self.yield_depth}

    @staticmethod
    @kernel
    def force(depth, depth_rate, yields, largest_depth, stiffness, yield_depth):
        if yields == 0.0:
            dent, force, elastic = flattened(largest_depth, stiffness, yield_depth)
            left = max(depth - dent, 0.0)
            root = sqrt(left / elastic)
            force *= root**3
            tangent = 1.5 * force / left if left > 0.0 else 0.0
            slope = 0.5 * tangent / left if left > 0.0 else 0.0
            return force, 0.4 * force * left, tangent, slope, 0.0
        tangent = 1.5 * stiffness * sqrt(yield_depth)
        _, force, elastic = flattened(max(depth, yield_depth), stiffness, yield_depth)
        # The elastic part of the depth grows as N*/sqrt(d*).
        growth = tangent / force - 0.5 / max(depth, yield_depth)
        released = 0.4 * elastic * (tangent + force * growth)
        return force, 0.4 * force * elastic, tangent, 0.0, (force - released) * depth_rate

    @staticmethod
    @kernel
    def guard(which, depth, depth_rate, yields, largest_depth):
        if which == BEGINS:
            return largest_depth - depth if yields == 0.0 else 1.0
        return depth_rate if yields != 0.0 else 1.0

    @staticmethod
    @kernel
    def jump(which, event, depth, yields, largest_depth):
        if event == BEGINS:
            return 1.0 if which == YIELDS else largest_depth
        if event in (STOPS, AT_TOUCH):
            # A contact that begins under load has been loaded.
            return 0.0 if which == YIELDS else max(depth, largest_depth)
        return yields if which == YIELDS else largest_depth

    @staticmethod
    @kernel
    def limits(largest_depth, stiffness, yield_depth):
        dent, _, _ = flattened(largest_depth, stiffness, yield_depth)
        return -dent, -dent
