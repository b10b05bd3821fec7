"""Friction of rate and state: it grows with the logarithm of the slip and of the contact's age.

The friction is that of `StateFriction` under every law of evolution: Dieterich's, here, and those of
`contactlab.laws.friction.evolution`.
"""

from dataclasses import dataclass
from math import asinh, copysign, exp, log, log1p, sqrt
from typing import Annotated, final

from contactlab.compiler.kernels import inner_kernel, kernel
from contactlab.laws.base import RATE_DEPENDENT, Friction
from contactlab.laws.memory import InternalVariable, dependent
from contactlab.parameter import not_negative, positive

FASTEST = 10.0
"""Slip [m/s] up to which `friction_limit` is meant."""


@inner_kernel
def asinh_of(slip, exponent):
    """Return asinh(slip exp(exponent)) [1]; the exponential itself may be beyond all numbers."""
    if slip == 0.0:
        return 0.0
    whole = exponent + log(abs(slip))
    if whole < 1.0:
        return asinh(copysign(exp(whole), slip))
    return copysign(whole + log1p(sqrt(1.0 + exp(-2.0 * whole))), slip)


@inner_kernel
def state_friction(slip, strength, direct_effect, reference_velocity, creep_velocity):
    """Return -F/N = a asinh(v/(2 v_0) exp(f/a)) [1] of a strength f [1]; below v_c it falls to zero."""
    exponent = strength / direct_effect - log(2.0 * reference_velocity)
    slower = max(exponent + log(creep_velocity), 0.0)
    risen = asinh_of(slip, exponent - slower)
    risen += slower * slip / sqrt(slip * slip + creep_velocity * creep_velocity)
    return direct_effect * risen


@dataclass(frozen=True)
class StateFriction(Friction):
    """Friction of a contact of age theta, |F|/N = mu + a ln(|v|/v_0) + b z with z = ln(v_0 theta/D).

    A subclass says how z evolves. In steady slip z = -ln(|v|/v_0), so that mu is the friction at v_0.
    """

    validity = "slips well above v_c and below 10 m/s"
    friction_kind = RATE_DEPENDENT
    exact_stick = False

    direct_effect: Annotated[float, positive("a", "1", "d(F/N)/d ln v at once")] = 0.01
    evolution_effect: Annotated[float, not_negative("b", "1", "d(F/N)/d ln theta")] = 0.015
    renewal_distance: Annotated[float, positive("D", "m", "slip that renews the contact")] = 1e-6
    reference_velocity: Annotated[float, positive("v_0", "m s-1", "steady slip with F = mu N")] = 1e-6
    fresh_age: Annotated[float, positive("theta_0", "s", "age at touch-down")] = 1e-6
    creep_velocity: Annotated[float, positive("v_c", "m s-1", "slip that is as good as rest")] = 1e-9

    @dependent
    def internal_variables(self) -> tuple[InternalVariable, ...]:
        """The age, as a logarithm: it may change by ten powers of ten."""
        fresh = log(self.reference_velocity * self.fresh_age / self.renewal_distance)
        return (InternalVariable("age", "z", "1", "ln(v_0 theta/D) of the age theta", fresh),)

    @property
    def friction_limit(self) -> float:
        """Largest |F|/N [1] of slips up to 10 m/s in contacts with z < 0."""
        return self.friction_coefficient + self.direct_effect * log(1.0 + FASTEST / self.reference_velocity)


@final
@dataclass(frozen=True)
class RateAndState(StateFriction):
    """A contact of age theta that ages at rest and is renewed by a slip of D: Dieterich's ageing law.

    Of a faster slip friction rises by a ln(v_2/v_1) at once, and falls by b ln(v_2/v_1) over the way D;
    at steady slip F/N = mu + (a - b) ln(v/v_0), so that with b > a fast slip is easy. mu is that at v_0. It
    never sticks: at rest it creeps with a slip that falls as exp(-mu/a), a few pm/s and less, where the
    round-off of a motor's slip is felt. Below v_c, which no surface can tell from rest, friction therefore
    falls to zero in proportion to the slip: what of the exponent makes the creep slower than v_c is
    multiplied by v/sqrt(v^2 + v_c^2), which far above v_c is nothing. Nothing is stored.

    |F|/N has no largest value; `friction_limit` is that of slips up to 10 m/s in contacts younger than D/v_0.

    Source: the asinh is that of Lapusta et al. (2000), J. Geophys. Res. 105, 23765, after Rice and Ben-Zion
    (1996); without it F would be infinite at rest.
    """

    name = "rate_and_state"
    equation = "F = -N a asinh(v/(2 v_0) exp((mu + b ln(v_0 theta/D))/a)), dtheta/dt = 1 - |v| theta/D"
    source = "Dieterich (1979), J. Geophys. Res. 84, 2161; Ruina (1983), J. Geophys. Res. 88, 10359"

    @staticmethod
    @kernel
    def state(
        normal,
        slip,
        age,
        friction_coefficient,
        direct_effect,
        evolution_effect,
        renewal_distance,
        reference_velocity,
        creep_velocity,
    ):
        strength = friction_coefficient + evolution_effect * age
        ratio = state_friction(slip, strength, direct_effect, reference_velocity, creep_velocity)
        ageing = (reference_velocity * exp(-age) - abs(slip)) / renewal_distance
        return -max(normal, 0.0) * ratio, ageing, 0.0, 0.0
