"""Rigid impacts with a ratio of the impulses, that create no energy."""

from dataclasses import dataclass
from math import sqrt
from typing import final

from contactlab.compiled import inner_kernel, kernel
from contactlab.laws.base import SLIP, STICK
from contactlab.laws.impact.newton import ImpactLaw
from contactlab.laws.impact.step import approach_of, with_forces
from contactlab.laws.lagrange import stick_or_slip_impulse


@inner_kernel
def impulse_ratio(approach, slip, d_nn, d_nt, d_tt, mu, e):
    """Return p_t/p_n and the mode, where r = p_t/p_n and u = -approach.

        slip+  ~  slip d_nn + (1 + e) u d_nt + r ((1 + e) u d_tt + slip d_nt)
        loss   ~  ((1 - e) u - 2 r slip)(d_nn + r d_nt) - r (d_nt + r d_tt)(1 + e) u

    both over what is positive, d_nn + r d_nt. A ratio against slip+ never meets its zero.
    """
    turned = (1.0 + e) * (-approach)
    free, per_ratio = slip * d_nn + turned * d_nt, turned * d_tt + slip * d_nt
    if free == 0.0:
        return 0.0, STICK
    s = -1.0 if free > 0.0 else 1.0
    # Where the rate does not fall by friction, no ratio is critical.
    sticks = abs(free) <= mu * per_ratio
    size, mode = (abs(free) / per_ratio, STICK) if sticks else (mu, SLIP)
    c_0 = (1.0 - e) * (-approach) * d_nn
    c_1 = -2.0 * s * (slip * d_nn - e * approach * d_nt)
    c_2 = -2.0 * slip * d_nt - turned * d_tt
    if c_0 + (c_1 + c_2 * size) * size >= 0.0:
        return s * size, mode
    # The loss is not negative at zero and is at this ratio: between them it has one zero.
    root = sqrt(c_1 * c_1 - 4.0 * c_0 * c_2)
    size = 2.0 * c_0 / (root - c_1) if c_1 <= 0.0 else -0.5 * (root + c_1) / c_2
    return s * size, SLIP


@final
@dataclass(frozen=True)
class Brach(ImpactLaw):
    """An impact with Newton's restitution and the ratio of the impulses, as large as friction can make it.

    The ratio is mu, or the critical one that ends the slip, or the one at which the loss is zero:
    whichever is least. The third is what `newton` does not know. The loss of a ball of mass m is, with r the
    ratio of slip to approach v,

        m v^2/2 (1 + e)(1 - e + 2 mu r - (1 + e) d_tt m mu^2)

    with d_tt m = 1 for a point, 7/2 for a solid ball, whose critical ratio is 2/7 r/(1 + e). Contact that
    lasts has no restitution and is that of `lagrange_stick`.
    """

    name = "brach"
    equation = "gdot+ = -e gdot-, |p_t| = min(mu, mu_c, mu_T) p_n, slip+(mu_c) = 0, loss(mu_T) = 0"
    source = "Brach (1989), J. Appl. Mech. 56, 133; Brach (1991), Mechanical Impact Dynamics"

    @staticmethod
    @kernel
    def solve(
        normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, friction_coefficient, restitution
    ):
        mu, e = friction_coefficient, restitution
        approach = approach_of(normal_rate, gap_rate)
        if approach == 0.0:
            return stick_or_slip_impulse(normal_rate, tangential_rate, slip, d_nn, d_nt, d_tt, mu)
        ratio, mode = impulse_ratio(approach, tangential_rate, d_nn, d_nt, d_tt, mu, e)
        p_n = -(1.0 + e) * approach / (d_nn + ratio * d_nt)
        p_t = ratio * p_n
        # Round-off is no slip.
        left = 0.0 if mode == STICK else tangential_rate + d_nt * p_n + d_tt * p_t
        return with_forces(normal_rate, approach, left, p_n, p_t, mode, d_nn, d_nt, d_tt, mu)
