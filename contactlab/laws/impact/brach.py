"""Rigid impacts with a ratio of the impulses, that create no energy."""

from dataclasses import dataclass
from math import sqrt
from typing import final

from contactlab.compiler.kernels import kernel
from contactlab.laws.impact.newton import ImpactLaw
from contactlab.laws.lagrange import stick_impulse


@kernel
def brach_impulse(approach, slip, d_nn, d_nt, d_tt, friction_coefficient, restitution):
    """Return the impulses [N s] of an impact.

    With its rebound, d_nn p_n + d_nt p_t = (1 + e) u = t, are

        d_nn slip+ = d_nn slip + d_nt t + det(D) p_t
        2 d_nn loss = (1 - e^2) u^2 - 2 (d_nn slip + d_nt u) p_t - det(D) p_t^2,   u = -approach

    and |p_t| grows with the ratio p_t/p_n as long as friction does not press more than p_n parts. The least
    of three |p_t| is thus of the least ratio, and none of them is a quotient of what friction nearly cancels.
    """
    mu, e = friction_coefficient, restitution
    turned, determinant = (1.0 + e) * (-approach), d_nn * d_tt - d_nt * d_nt
    free = slip * d_nn + turned * d_nt
    if free == 0.0:
        return turned / d_nn, 0.0
    s = -1.0 if free > 0.0 else 1.0
    kept, half = (1.0 - e * e) * approach * approach, s * (slip * d_nn - approach * d_nt)
    root = sqrt(half * half + determinant * kept)
    lossless = kept / (root + half) if half > 0.0 else (root - half) / determinant
    critical, parting = abs(free) / determinant, d_nn + s * mu * d_nt
    if mu * turned < min(critical, lossless) * parting:
        p_n = turned / parting
        return p_n, s * mu * p_n
    if critical <= lossless:
        return stick_impulse(-turned, slip, d_nn, d_nt, d_tt)
    return (turned - s * lossless * d_nt) / d_nn, s * lossless


@final
@dataclass(frozen=True)
class Brach(ImpactLaw):
    """An impact with Newton's restitution and the ratio of the impulses, as large as friction can make it.

    The ratio is mu, or the critical one that ends the slip, or the one at which the loss is zero:
    whichever is least. The third is what `newton` does not know. The loss of a ball of mass m is, with r the
    ratio of slip to approach v,

        m v^2/2 (1 + e)(1 - e + 2 mu r - (1 + e) d_tt m mu^2)

    with d_tt m = 1 for a point, 7/2 for a solid ball, whose critical ratio is 2/7 r/(1 + e).
    """

    name = "brach"
    equation = "gdot+ = -e gdot-, |p_t| = min(mu, mu_c, mu_T) p_n, slip+(mu_c) = 0, loss(mu_T) = 0"
    source = "Brach (1989), J. Appl. Mech. 56, 133; Brach (1991), Mechanical Impact Dynamics"
    validity = "impacts without tangential restitution"

    impact = staticmethod(brach_impulse)
