"""Stronge's restitution of energy in a rigid impact."""

from dataclasses import dataclass
from math import sqrt
from typing import final

from contactlab.compiled import inner_kernel, kernel
from contactlab.laws.impact_process import (
    ImpactProcess,
    complete,
    compression,
    impact_approach,
    stages_of,
)
from contactlab.laws.lagrange_stick import stick_or_slip_impulse


@inner_kernel
def restituted(approach, d_nn, d_nt, stages, e):
    """Normal impulse at which the share e^2 of the work of compression has been given back [N s].

    Args:
        approach, d_nn, d_nt, stages: as in `compression`.
        e: restitution [1].
    """
    end, before, after, _ = stages
    p_c = compression(approach, d_nn, d_nt, stages)
    first, second = d_nn + d_nt * before, d_nn + d_nt * after
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


@final
@dataclass(frozen=True)
class Stronge(ImpactProcess):
    """A rigid impact that gives back a share of the work of compression, up to gdot(p_c) = 0.

    Friction can only take energy; the normal impulse gives back no more than it took. So no impact
    creates energy.
    """

    name = "stronge"
    equation = "int_pc^p gdot dp = -e^2 int_0^pc gdot dp, dp_t = -mu dp sign(v) or v = 0"
    source = "Stronge (1990), Proc. R. Soc. A 431, 169"

    @staticmethod
    @kernel
    def solve(normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, parameters):
        """See `MultiplierLaw.solve`."""
        approach = impact_approach(normal_rate, gap_rate)
        if approach == 0.0:
            return stick_or_slip_impulse(
                normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, parameters
            )
        stages = stages_of(tangential_rate, d_nt, d_tt, parameters[0])
        p_n = restituted(approach, d_nn, d_nt, stages, parameters[1])
        remainder = normal_rate - approach
        return complete(
            p_n, stages, remainder, normal_rate, tangential_rate, d_nn, d_nt, d_tt, parameters
        )
