"""Poisson's restitution of impulses in a rigid impact."""

from dataclasses import dataclass
from typing import final

from contactlab.compiled import kernel
from contactlab.laws.impact_process import (
    ImpactProcess,
    complete,
    compression,
    impact_approach,
    stages_of,
)
from contactlab.laws.lagrange_stick import stick_or_slip_impulse


@final
@dataclass(frozen=True)
class Poisson(ImpactProcess):
    """A rigid impact that gives back a share of the impulse of compression p_c, gdot(p_c) = 0."""

    name = "poisson"
    equation = "p = (1 + e) p_c, gdot(p_c) = 0, dp_t = -mu dp sign(v) or v = 0"
    source = "Routh (1891); Wang and Mason (1992), J. Appl. Mech. 59, 635"

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
        p_n = (1.0 + parameters[1]) * compression(approach, d_nn, d_nt, stages)
        remainder = normal_rate - approach
        return complete(
            p_n, stages, remainder, normal_rate, tangential_rate, d_nn, d_nt, d_tt, parameters
        )
