"""Frictions of a composed law: Coulomb's cone, exact or smeared out, a spring and a slider, and bristles."""

from dataclasses import dataclass
from math import exp, pi, sin, sqrt
from types import MappingProxyType
from typing import Annotated, final

from contactlab.arrays import Array
from contactlab.compiled import kernel
from contactlab.laws.base import ELASTOPLASTIC, RATE_DEPENDENT, Friction
from contactlab.parameter import Parameter, not_negative, positive

STATIC_RATIO = Parameter("mu_s/mu", "1", "static over kinetic coefficient", at_least=1.0)
BREAKAWAY = Parameter("z_ba/z_ss", "1", "deflection at which it drags", above=0.0, below=1.0)


@kernel
def cone_bound(normal: float, slip: float, parameters: Array, at: int) -> float:
    """Give the largest friction [N]: mu_s N in stick, where the slip [m/s] is exactly zero, else mu N.

    A pull N < 0 gives no friction. From the place `at` on stand mu and mu_s / mu.
    """
    ratio = parameters[at + 1] if slip == 0.0 else 1.0
    return float(parameters[at] * ratio * max(normal, 0.0))


@final
@dataclass(frozen=True)
class Coulomb(Friction):
    """Set-valued friction: exact stick."""

    name = "coulomb"
    equation = "|F| <= mu_s N, F = -mu N sign(v) where v != 0"
    source = "Coulomb (1785); Moreau (1988)"

    static_ratio: Annotated[float, STATIC_RATIO] = 1.0


@final
@dataclass(frozen=True)
class Regularised(Friction):
    """A contact that creeps under any tangential load, and never sticks.

    At v_0 friction has reached 0.71 of mu N. A run costs more steps the smaller v_0 is, in proportion to
    its logarithm, as long as it is above the slip's round-off. The source compares such functions.
    """

    name = "regularised"
    equation = "F = -mu N v / sqrt(v^2 + v_0^2)"
    source = "Mostaghel and Davis (1997), Earthquake Eng. Struct. Dyn. 26, 593"
    friction_kind = RATE_DEPENDENT
    exact_stick = False

    creep_velocity: Annotated[float, positive("v_0", "m s-1", "creep velocity")] = 1e-3

    @staticmethod
    @kernel
    def state(normal, stiffness, stiffness_rate, slip, z, parameters, at):
        """See `Friction.state`; there is no internal variable, and nothing is stored."""
        bound = parameters[at] * max(normal, 0.0)
        return -bound * slip / sqrt(slip * slip + parameters[at + 2] ** 2), 0.0, 0.0, 0.0


@final
@dataclass(frozen=True)
class Mindlin(Friction):
    """A Jenkins element: a spring of stiffness k_t = kappa dN/dd that slides at mu N.

        F = -k_t z,  |F| <= mu N,  dz/dt = v - z max(dk_t/dt, 0) / k_t - (sliding)

    While the contact grows, what it gains in stiffness is new and carries nothing: the force stays,
    the stretch z shrinks. While it shrinks, what it loses takes its share of the force along. Either
    way 1/2 z^2 |dk_t/dt| is lost, and no cycle of load makes energy (Elata and Berryman 1996), as it
    would with a force that stays in unloading. Microslip is left out: the contact slides as a whole.

    Source: Mindlin (1949) for kappa = 2 (1 - nu)/(2 - nu) between equal bodies, 0.82 for steel; Thornton
    and Randall (1988) and Elata and Berryman (1996), Mech. Mater. 24, 229, for the unloading.
    """

    name = "mindlin"
    equation = "F = -kappa (dN/dd) z, |F| <= mu N, dz/dt = v - sliding"
    source = "Mindlin (1949), J. Appl. Mech. 16, 259; Elata and Berryman (1996)"
    friction_kind = ELASTOPLASTIC
    exact_stick = False
    internal_variables = ("stretch of the spring [m]",)

    stiffness_ratio: Annotated[float, positive("kappa", "1", "tangential over normal stiffness")] = 0.82

    @staticmethod
    @kernel
    def state(normal, stiffness, stiffness_rate, slip, z, parameters, at):
        """See `Friction.state`; z is the stretch [m]."""
        tangential = parameters[at + 2] * stiffness
        growth = max(stiffness_rate, 0.0) / stiffness if stiffness > 0.0 else 0.0
        force = -tangential * z
        return force, slip - growth * z, -0.5 * force * z, tangential


@dataclass(frozen=True)
class Bristles(Friction):
    """Bristles of stiffness and damping in proportion to the normal force.

    g(v) = mu + (mu_s - mu) exp(-(v/v_s)^2) is the coefficient of steady slip.
    """

    friction_kind = RATE_DEPENDENT
    exact_stick = False
    # The bristles have a kink where the slip reverses, and no step ends there.
    convergence_order = 0.5
    internal_variables = ("deflection of the bristles [m]",)
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
def stribeck(slip, parameters, at):
    """Give the coefficient g(v) of steady slip [1]."""
    mu = parameters[at]
    lifted = parameters[at + 1] - 1.0
    return float(mu * (1.0 + lifted * exp(-((slip / parameters[at + 4]) ** 2))))


@kernel
def bristle_force(normal, z, rate, parameters, at):
    """Give the friction [N], the rate of z [m/s], the stored energy [J] and no stiffness."""
    pressed = max(normal, 0.0)
    sigma = parameters[at + 2]
    force = -pressed * (sigma * z + parameters[at + 3] * rate)
    return force, rate, 0.5 * pressed * sigma * z * z, 0.0


@final
@dataclass(frozen=True)
class LuGre(Bristles):
    """Bristles that drag at any load; they bend by mu/sigma_0. g(v) = mu + (mu_s - mu) exp(-(v/v_s)^2).

    Source: in proportion to N as Canudas de Wit and Tsiotras (1999) have it.
    """

    name = "lugre"
    equation = "F = -N (sigma_0 z + sigma_1 dz/dt), dz/dt = v - sigma_0 |v| z / g(v)"
    source = "Canudas de Wit et al. (1995), IEEE Trans. Autom. Control 40, 419"

    @staticmethod
    @kernel
    def state(normal, stiffness, stiffness_rate, slip, z, parameters, at):
        """See `Friction.state`; z is the deflection [m]."""
        drag = stribeck(slip, parameters, at)
        rate = slip - parameters[at + 2] * abs(slip) * z / drag if drag > 0.0 else 0.0
        return bristle_force(normal, z, rate, parameters, at)


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
    def state(normal, stiffness, stiffness_rate, slip, z, parameters, at):
        """See `Friction.state`; z is the deflection [m]."""
        drag, away = stribeck(slip, parameters, at), parameters[at + 5]
        bent = parameters[at + 2] * abs(z) / drag if drag > 0.0 else 1.0
        alpha = 0.0
        if slip * z > 0.0 and bent > away:
            passage = pi * ((bent - away) / (1.0 - away) - 0.5)
            alpha = 1.0 if bent >= 1.0 else 0.5 + 0.5 * sin(passage)
        rate = slip * (1.0 - alpha * bent) if drag > 0.0 else 0.0
        return bristle_force(normal, z, rate, parameters, at)


FRICTIONS: dict[str, type[Friction]] = {
    part.name: part for part in (Coulomb, Regularised, Mindlin, LuGre, ElastoPlastic)
}
