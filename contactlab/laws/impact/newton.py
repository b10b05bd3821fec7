"""Rigid impacts with a restitution of the velocity."""

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import MultiplierLaw
from contactlab.laws.declaration import FRICTION_COEFFICIENT, RESTITUTION
from contactlab.laws.lagrange import stick_or_slip_impulse

OF_THE_GAP_RATE = MappingProxyType(
    {
        "dissipates": "the rebound is that of the whole approach, also where friction has ended the slip "
        "and taken its share of the approach with it (Kane and Levinson 1985)."
    }
)
"""What laws break whose restitution is that of the gap rate."""


@dataclass(frozen=True)
class ImpactLaw(MultiplierLaw):
    """A rigid law with a restitution, whichever of velocity, impulse or energy it is of."""

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    restitution: Annotated[float, RESTITUTION] = 0.5


@kernel
def newton_impulse(approach, slip, d_nn, d_nt, d_tt, friction_coefficient, restitution):
    """Return the impulses [N s] of the plastic impact, to the rebound in place of zero."""
    missing = approach + restitution * approach
    return stick_or_slip_impulse(missing, slip, d_nn, d_nt, d_tt, friction_coefficient)


@final
@dataclass(frozen=True)
class Newton(ImpactLaw):
    """A rigid impact that gives back a share of the approach, with set-valued friction; g = 0 after it.

    The slip v+ of the friction law is that after the impact. Where slip ends or reverses in the impact the
    restitution can create energy: Kane and Levinson (1985), Dynamics: Theory and Applications. The Newtonian
    impact of Wang and Mason (1992) has the same impulses but where the slip reverses: there it follows the
    slip through the impact, as `poisson` does.
    """

    name = "newton"
    equation = "gdot+ = -e gdot-, N >= 0, |F| <= mu N, F = -mu N sign(v+) where v+ != 0"
    source = "Newton (1687), Principia, scholium to the laws of motion"
    validity = "e measured at the speed of the impacts; slip that ends or reverses can create energy"
    violations = OF_THE_GAP_RATE

    impact = staticmethod(newton_impulse)


@final
@dataclass(frozen=True)
class MoreauJean(ImpactLaw):
    """The constraint of a closed gap on velocities only, with Newton's restitution of every step.

    The impulses are those of `newton`. No displacement is put back onto the closed gap: the contact
    penetrates by O(step), at first by what the impact step travels, and lasts, in the end without
    impulse, until a step begins with an open gap. A gap that opens from rest as the cube of time has its
    contact longer by O(step^(1/3)) for that; state and impulses converge at order one.

    Source: Moreau (1988), Unilateral contact and dry friction in finite freedom dynamics; Jean (1999).
    """

    name = "moreau_jean"
    equation = "0 <= p _|_ gdot_end + e gdot_start >= 0 where g <= 0, |p_t| <= mu p, p_t = -mu p sign(v_end)"
    source = "Moreau (1988); Jean (1999), Comput. Methods Appl. Mech. Eng. 177, 235"
    validity = "as newton; the contact penetrates by O(step)"
    projects = False
    violations = OF_THE_GAP_RATE

    impact = staticmethod(newton_impulse)
