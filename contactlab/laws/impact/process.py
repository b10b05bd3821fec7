"""Rigid impacts as a process, with a restitution of impulse or energy.

The impulses of an impact grow in no time. Over the normal impulse p as the independent variable gap rate
and slip change linearly as long as the friction impulse grows in one ratio to it (Routh's diagram):

    slip in direction s         dp_t/dp = -s mu
    stick                       dp_t/dp = -d_nt/d_tt, which |d_nt| <= mu d_tt allows
    slip after that otherwise   dp_t/dp = -r mu, r = sign(d_nt)

The slip ends at most once: stick lasts, and r is the direction in which the normal impulse itself drives
the slip. So there are two stages at most. Compression ends where the gap rate is zero; how far the
process goes on is what a law of restitution says.

Source: Routh (1891), Dynamics of a System of Rigid Bodies, elementary part; Wang and Mason (1992),
J. Appl. Mech. 59, 635.
"""

from dataclasses import dataclass
from math import inf, sqrt
from types import MappingProxyType
from typing import final

from contactlab.compiler.kernels import inner_kernel, kernel
from contactlab.laws.impact.newton import ImpactLaw


@inner_kernel
def stages_of(slip, d_nt, d_tt, mu):
    """Return the two stages of a process that begins with a slip [m/s]; d as in `MultiplierLaw.impact`.

    They are the normal impulse at which the slip ends [N s], and dp_t/dp before and after.
    """
    after = -d_nt / d_tt if abs(d_nt) <= mu * d_tt else -mu if d_nt > 0.0 else mu
    if slip == 0.0:
        return 0.0, after, after
    before = -mu if slip > 0.0 else mu
    change = d_nt + d_tt * before
    return (-slip / change if slip * change < 0.0 else inf), before, after


@inner_kernel
def compression(approach, end, first, second):
    """Return the normal impulse at which the gap rate is zero [N s].

    The approach is the gap rate at the beginning [m/s], negative. It grows with the normal impulse by first
    [1/kg] until the slip ends, by second from there on. Slip may press the bodies together (first < 0),
    but such slip ends, and what follows does not.
    """
    if approach + first * end >= 0.0:
        return -approach / first
    return end - (approach + first * end) / second


@inner_kernel
def restituted(approach, end, first, second, p_c, e):
    """Return the normal impulse [N s] that gives back the share e^2 of the work of the compression p_c."""
    if p_c > end:
        # Compression outlasts the slip: triangles of work up to there and from there.
        rate = approach + first * end
        work = -0.5 * (approach + rate) * end + 0.5 * rate * rate / second
        return p_c + e * sqrt(2.0 * work / second)
    if (1.0 + e) * p_c <= end:
        return (1.0 + e) * p_c
    # The slip ends in restitution, at a rate that has given back a part; the rest is quadratic.
    rate = first * (end - p_c)
    rest = 0.5 * (e * approach * e * approach - rate * rate) / first
    return end + 2.0 * rest / (rate + sqrt(rate * rate + 2.0 * second * rest))


@inner_kernel
def process_impulse(approach, slip, d_nn, d_nt, d_tt, mu, e, of_energy):
    """Return impulses [N s]; the restitution is of the work of compression, or of its impulse."""
    end, before, after = stages_of(slip, d_nt, d_tt, mu)
    first, second = d_nn + d_nt * before, d_nn + d_nt * after
    p_n = compression(approach, end, first, second)
    p_n = restituted(approach, end, first, second, p_n, e) if of_energy else (1.0 + e) * p_n
    return p_n, before * min(p_n, end) + after * max(p_n - end, 0.0)


@dataclass(frozen=True)
class ImpactProcess(ImpactLaw):
    """Its friction impulse follows the slip through the impact: |dp_t| <= mu dp, F against any slip."""

    violations = MappingProxyType(
        {
            "friction_opposes_slip": "friction opposes the slip at every instant of an impact, but where "
            "the slip reverses in it the sum of friction may have the direction of the slip that is left."
        }
    )


@final
@dataclass(frozen=True)
class Poisson(ImpactProcess):
    """A rigid impact that gives back a share of the impulse of compression p_c, gdot(p_c) = 0.

    It has all modes of Wang and Mason: slip that lasts, ends in compression or in restitution, and then
    sticks or reverses.
    """

    name = "poisson"
    equation = "p = (1 + e) p_c, gdot(p_c) = 0, dp_t = -mu dp sign(v) or v = 0"
    source = "Routh (1891); Wang and Mason (1992), J. Appl. Mech. 59, 635"
    validity = "plane impacts; e measured at the speed of the impacts"

    @staticmethod
    @kernel
    def impact(approach, slip, d_nn, d_nt, d_tt, friction_coefficient, restitution):
        return process_impulse(approach, slip, d_nn, d_nt, d_tt, friction_coefficient, restitution, False)


@final
@dataclass(frozen=True)
class Stronge(ImpactProcess):
    """A rigid impact that gives back a share of the work of compression, up to gdot(p_c) = 0.

    Friction can only take energy; the normal impulse gives back no more than it took. So no impact
    creates energy.
    """

    name = "stronge"
    equation = "int_p_c^p gdot dp = -e^2 int_0^p_c gdot dp, dp_t = -mu dp sign(v) or v = 0"
    source = "Stronge (1990), Proc. R. Soc. A 431, 169"
    validity = "plane impacts; e measured at the speed of the impacts"

    @staticmethod
    @kernel
    def impact(approach, slip, d_nn, d_nt, d_tt, friction_coefficient, restitution):
        return process_impulse(approach, slip, d_nn, d_nt, d_tt, friction_coefficient, restitution, True)
