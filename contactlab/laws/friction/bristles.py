"""Friction of bristles that bend: LuGre and its elasto-plastic sister."""

from dataclasses import dataclass
from math import exp, pi, sin
from types import MappingProxyType
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import RATE_DEPENDENT, Friction
from contactlab.laws.friction.coulomb import STATIC_RATIO
from contactlab.laws.memory import ODD, InternalVariable
from contactlab.parameter import Parameter, not_negative, positive

BREAKAWAY = Parameter("z_ba/z_ss", "1", "deflection at which it drags", above=0.0, below=1.0)


@dataclass(frozen=True)
class Bristles(Friction):
    """Bristles of stiffness and damping in proportion to the normal force.

    g(v) = mu + (mu_s - mu) exp(-(v/v_s)^2) is the coefficient of steady slip.
    """

    friction_kind = RATE_DEPENDENT
    exact_stick = False
    internal_variables = (InternalVariable("deflection", "z", "m", "deflection of the bristles", parity=ODD),)
    violations = MappingProxyType(
        {
            "friction_opposes_slip": "bent bristles grow stiffer with the normal force, which gives them "
            "energy that nothing brought."
        }
    )

    static_ratio: Annotated[float, STATIC_RATIO] = 1.0
    bristle_stiffness: Annotated[float, positive("sigma_0", "m-1", "bristle stiffness over N")] = 1e6
    bristle_damping: Annotated[float, not_negative("sigma_1", "s m-1", "bristle damping over N")] = 0.1
    stribeck_velocity: Annotated[float, positive("v_s", "m s-1", "Stribeck velocity")] = 1e-2


@kernel
def stribeck(slip, friction_coefficient, static_ratio, stribeck_velocity):
    """Return the coefficient g(v) of steady slip [1]."""
    lifted = static_ratio - 1.0
    return float(friction_coefficient * (1.0 + lifted * exp(-((slip / stribeck_velocity) ** 2))))


@kernel
def bristle_force(normal, deflection, rate, bristle_stiffness, bristle_damping):
    """Return the friction [N], the rate of the deflection [m/s], the stored energy [J] and no stiffness."""
    pressed = max(normal, 0.0)
    force = -pressed * (bristle_stiffness * deflection + bristle_damping * rate)
    return force, rate, 0.5 * pressed * bristle_stiffness * deflection * deflection, 0.0


@final
@dataclass(frozen=True)
class LuGre(Bristles):
    """Bristles that drag at any load; they bend by mu/sigma_0. g(v) = mu + (mu_s - mu) exp(-(v/v_s)^2).

    Source: in proportion to N as Canudas de Wit and Tsiotras (1999) have it.
    """

    name = "lugre"
    equation = "F = -N (sigma_0 z + sigma_1 dz/dt), dz/dt = v - sigma_0 |v| z / g(v)"
    source = "Canudas de Wit et al. (1995), IEEE Trans. Autom. Control 40, 419"
    validity = "loads that do not swing inside of mu N: it drifts"

    @staticmethod
    @kernel
    def state(
        normal,
        slip,
        deflection,
        friction_coefficient,
        static_ratio,
        bristle_stiffness,
        bristle_damping,
        stribeck_velocity,
    ):
        drag = stribeck(slip, friction_coefficient, static_ratio, stribeck_velocity)
        rate = slip - bristle_stiffness * abs(slip) * deflection / drag if drag > 0.0 else 0.0
        return bristle_force(normal, deflection, rate, bristle_stiffness, bristle_damping)


@final
@dataclass(frozen=True)
class ElastoPlastic(Bristles):
    """`lugre` with a range of deflections in which nothing drags, so that a small load does not drift.

    alpha is 0 for |z| below z_ba or while the slip lets z return, 1 above z_ss = g/sigma_0, and half a
    sine in between.
    """

    name = "elasto_plastic"
    equation = "F = -N (sigma_0 z + sigma_1 dz/dt), dz/dt = v (1 - alpha(z) sigma_0 |z| / g(v))"
    source = "Dupont et al. (2002), IEEE Trans. Autom. Control 47, 787"

    breakaway_ratio: Annotated[float, BREAKAWAY] = 0.7

    @staticmethod
    @kernel
    def state(
        normal,
        slip,
        deflection,
        friction_coefficient,
        static_ratio,
        bristle_stiffness,
        bristle_damping,
        stribeck_velocity,
        breakaway_ratio,
    ):
        drag = stribeck(slip, friction_coefficient, static_ratio, stribeck_velocity)
        bent = bristle_stiffness * abs(deflection) / drag if drag > 0.0 else 1.0
        alpha = 0.0
        if slip * deflection > 0.0 and bent > breakaway_ratio:
            passage = pi * ((bent - breakaway_ratio) / (1.0 - breakaway_ratio) - 0.5)
            alpha = 1.0 if bent >= 1.0 else 0.5 + 0.5 * sin(passage)
        rate = slip * (1.0 - alpha * bent) if drag > 0.0 else 0.0
        return bristle_force(normal, deflection, rate, bristle_stiffness, bristle_damping)
