"""Newton's restitution of velocities in a rigid impact."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, final

from contactlab.arrays import Array
from contactlab.compiled import kernel
from contactlab.laws.base import Impulses
from contactlab.laws.impact_process import ImpactLaw
from contactlab.laws.lagrange_stick import stick_or_slip_impulse

VIOLATIONS = MappingProxyType(
    {
        "dissipates": "the rebound is that of the whole approach, also where friction has ended the slip "
        "and taken its share of the approach with it (Kane and Levinson 1985)."
    }
)
"""Of laws whose restitution is that of the gap rate."""


@kernel
def newton_impulse(
    normal_rate: float,
    tangential_rate: float,
    gap_rate: float,
    slip: float,
    d_nn: float,
    d_nt: float,
    d_tt: float,
    parameters: Array,
) -> Impulses:
    """Impulses [N s] and mode; arguments as in `MultiplierLaw.solve`."""
    # The plastic law to the rate that is asked for in place of zero.
    missing = normal_rate + parameters[1] * min(gap_rate, 0.0)
    return stick_or_slip_impulse(
        missing, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, parameters
    )


@final
@dataclass(frozen=True)
class Newton(ImpactLaw):
    """A rigid impact that gives back a share of the approach, with set-valued friction; g = 0 after it.

    The slip v+ of the friction law is that after the impact. A rebound that ends within the step is
    none. Where slip ends or reverses in the impact the restitution can create energy: Kane and Levinson
    (1985), Dynamics: Theory and Applications.
    """

    name: ClassVar[str] = "newton"
    equation: ClassVar[str] = (
        "gdot+ = -e gdot-, N >= 0, |F| <= mu N, F = -mu N sign(v+) where v+ != 0"
    )
    source: ClassVar[str] = "Newton (1687), Principia, scholium to the laws of motion"
    violations: ClassVar[Mapping[str, str]] = VIOLATIONS

    solve = staticmethod(newton_impulse)
