"""Rigid impacts with a restitution, and an impact as a process over its normal impulse.

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
from math import inf
from types import MappingProxyType
from typing import Annotated

from contactlab.compiled import inner_kernel
from contactlab.laws.base import SLIP, STICK, MultiplierLaw
from contactlab.laws.declaration import FRICTION_COEFFICIENT, RESTITUTION
from contactlab.laws.lagrange_stick import stick_or_slip_impulse


@dataclass(frozen=True)
class ImpactLaw(MultiplierLaw):
    """A rigid law with a restitution, whichever of velocity, impulse or energy it is of."""

    default_contact_step = 5e-8

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    restitution: Annotated[float, RESTITUTION] = 0.5


@dataclass(frozen=True)
class ImpactProcess(ImpactLaw):
    """Its friction impulse follows the slip through the impact: |dp_t| <= mu dp, F against any slip.

    Contact that lasts has no restitution and is that of `lagrange_stick`.
    """

    violations = MappingProxyType(
        {
            "friction_opposes_slip": "friction opposes the slip at every instant of an impact, but where "
            "the slip reverses in it the sum of friction may have the direction of the slip that is left."
        }
    )


Stages = tuple[float, float, float, int]
"""Normal impulse at which the slip ends [N s], dp_t/dp before and after that, mode after that."""


@inner_kernel
def impact_approach(normal_rate, gap_rate):
    """The gap rate [m/s] that is an impact, not positive.

    Args:
        normal_rate: gap rate that the step would end with [m/s].
        gap_rate: gap rate that it begins with [m/s].

    What forces bring within the step is no impact, or contact that lasts would bounce in every step;
    and what they take away before its end need not be stopped.
    """
    return min(max(gap_rate, normal_rate), 0.0)


@inner_kernel
def stages_of(slip, d_nt, d_tt, mu):
    """The two stages of a process that begins with a slip [m/s]; d as in `MultiplierLaw.solve`."""
    mode = STICK if abs(d_nt) <= mu * d_tt else SLIP
    after = -d_nt / d_tt if mode == STICK else -mu if d_nt > 0.0 else mu
    if slip == 0.0:
        return 0.0, after, after, mode
    before = -mu if slip > 0.0 else mu
    change = d_nt + d_tt * before
    return (-slip / change if slip * change < 0.0 else inf), before, after, mode


@inner_kernel
def compression(approach, d_nn, d_nt, stages):
    """Normal impulse at which the gap rate is zero [N s].

    Args:
        approach: gap rate at the beginning, negative [m/s].
        d_nn, d_nt: as in `MultiplierLaw.solve`.
        stages: of the process.

    Slip may press the bodies together (d_nn < s mu d_nt), but such slip ends, and what follows does not.
    """
    end, before, after, _ = stages
    growth = d_nn + d_nt * before
    if approach + growth * end >= 0.0:
        return -approach / growth
    return end - (approach + growth * end) / (d_nn + d_nt * after)


@inner_kernel
def complete(p_n, stages, remainder, normal_rate, tangential_rate, d_nn, d_nt, d_tt, parameters):
    """Impulses [N s] and mode of a step with an impact.

    Args:
        p_n: normal impulse at which the process ends [N s].
        stages: of the process.
        remainder: change of the gap rate by forces, which is no part of the impact, not positive [m/s].
        normal_rate, tangential_rate, d_nn, d_nt, d_tt, parameters: as in `MultiplierLaw.solve`.

    A rebound that forces end within the step is none: the contact lasts, without restitution.
    """
    end, before, after, mode = stages
    p_t = before * min(p_n, end) + after * max(p_n - end, 0.0)
    if p_n < end:
        mode = SLIP
    rebound = normal_rate + d_nn * p_n + d_nt * p_t
    if remainder == 0.0 or rebound >= 0.0:
        return p_n, p_t, mode
    # Round-off is no slip.
    slip = 0.0 if mode == STICK else tangential_rate + d_nt * p_n + d_tt * p_t
    more_n, more_t, mode = stick_or_slip_impulse(
        rebound, slip, 0.0, slip, d_nn, d_nt, d_tt, parameters
    )
    return p_n + more_n, p_t + more_t, mode
