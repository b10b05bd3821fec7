"""Normal losses of a composed law: a dashpot beside the contact, or in proportion to the elastic force.

In proportion, N = f(d) (1 + a dd/dt), an impact of free bodies at the speed v, whatever f and the masses,
has a restitution e with

    (1 + e) D = ln((1 + D) / (1 - e D)),   D = a v

from m u du / (1 + a u) = -f dd over compression and restitution. The published models say D as a function
of a nominal restitution, and achieve it near 1 only; here D is solved for the required restitution.

    Hunt-Crossley         a = 3 (1 - e_n) / (2 v)       v a constant of the contact
    Lankarani-Nikravesh   a = 3 (1 - e_n^2) / (4 v)     v the speed of each impact
    Flores                a = 8 (1 - e_n) / (5 e_n v)   v the speed of each impact

A model whose largest nominal D, that of e_n = 0, is smaller than required raises an error.

A dashpot along s = sqrt(2 V), V the stored energy, N = f(d) + 2 zeta sqrt(m) (f/s) dd/dt, makes an impact
that of a linear oscillator, u du/ds = -s/m - 2 zeta u / sqrt(m), at any speed. Released at N = 0 it has

    -ln e = 2 zeta arccos(zeta) / sqrt(1 - zeta^2),   arcosh and sqrt(zeta^2 - 1) where zeta > 1
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import acos, acosh, cosh, exp, inf, log, log1p, sqrt
from typing import Annotated, Any, final

import numpy as np
import scipy

from contactlab.arrays import Array
from contactlab.compiler.kernels import kernel
from contactlab.laws.base import Damping, NormalForce
from contactlab.laws.declaration import Coefficient, names_of
from contactlab.parameter import Parameter, not_negative, positive

ACHIEVED_RESTITUTION = Parameter("e", "1", "restitution of a free impact", above=0.0, at_most=1.0)

LEAST_SPEED = positive("v_min", "m s-1", "slowest approach that is distinguished")
"""A contact that begins without approach has no speed to divide by."""

NEARLY_PLASTIC, NEARLY_ELASTIC = 0.025, 1e-6
"""e below which 1 - e D is less than the unit of D, and 1 - e below which D is linear in it."""

INTEGRATION = 1e-12
"""Tolerance of the impact that is solved for a dashpot's coefficient."""


@final
@dataclass(frozen=True)
class Undamped(Damping):
    """The elastic force alone: restitution 1."""

    name = "none"
    equation = "no loss"
    source = "Hertz (1881)"
    validity = "bodies without material damping"

    @staticmethod
    @kernel
    def damped(elastic_force):
        return elastic_force


@final
@dataclass(frozen=True)
class LinearDamping(Damping):
    """A dashpot: a jump of the force at touch-down, and none that pulls at the end. After Kelvin and Voigt.

    c is solved so that a free impact of the given mass at the given speed has the given restitution; it
    has another one at another mass, and with an f that is not linear at another speed.
    """

    name = "linear"
    equation = "N = max(f(d) + c dd/dt, 0), c solved for e of (m, v)"
    source = "Johnson, Contact Mechanics (1985), sec. 11.5"
    validity = "impacts of one mass at one speed"
    any_force = False

    restitution: Annotated[float, ACHIEVED_RESTITUTION] = 0.8
    effective_mass: Annotated[float, positive("m", "kg", "mass of the impact")] = 2e-3
    impact_speed: Annotated[float, positive("v", "m s-1", "speed of the impact")] = 0.1

    def solved(self, normal: NormalForce) -> Mapping[str, Coefficient]:
        """Return the coefficient c [N s/m]."""
        return {"damping_coefficient": damping_coefficient(self, normal)}

    @staticmethod
    @kernel
    def damped(elastic_force, depth_rate, damping_coefficient):
        return float(max(elastic_force + damping_coefficient * depth_rate, 0.0))


@cache
def damping_coefficient(damping: LinearDamping, normal: NormalForce) -> float:
    """Return the c [N s/m] at which a free impact has the restitution of the damping."""
    if damping.restitution == 1.0:
        return 0.0
    mass, speed = damping.effective_mass, damping.impact_speed
    known: Any = {**{each.name: each.initial for each in normal.internal_variables}, **normal.coefficients()}
    kernel: Any = normal.elastic
    place = names_of(kernel).index("depth")
    others = [known[name] for name in names_of(kernel) if name != "depth"]

    def elastic(depth: float) -> tuple[float, float]:
        """Return force [N] and stored energy [J]."""
        force, energy, *_ = kernel(*others[:place], depth, *others[place:])
        return force, energy

    energy = 0.5 * mass * speed**2

    def beyond(exponent: float) -> float:
        """Return the logarithm of the energy that a depth stores, over that of the impact."""
        return float(np.log(elastic(10.0**exponent)[1] / energy))

    # Depth and speed are the units.
    depth = float(10.0 ** scipy.optimize.brentq(beyond, -20.0, 2.0, xtol=1e-12))
    unit = depth / (mass * speed**2)

    def excess(ratio: float) -> float:
        c = ratio * (mass * speed / depth)

        def force(_: float, y: Array) -> float:
            spring = elastic(max(y[0], 0.0) * depth)[0]
            return float(unit * (spring + c * speed * y[1]))

        def motion(t: float, y: Array) -> list[float]:
            return [y[1], -force(t, y)]

        # The impact ends where the force does.
        end: Any = force
        end.terminal, end.direction = True, -1.0
        accuracy = {"rtol": INTEGRATION, "atol": INTEGRATION}
        done = scipy.integrate.solve_ivp(motion, (0.0, 1e9), [0.0, 1.0], "DOP853", events=end, **accuracy)
        return -float(done.y[1, -1]) - damping.restitution

    # A loss below the integration's error.
    if excess(0.0) <= 0.0:
        return 0.0
    right = 1.0
    while excess(right) > 0.0:
        right *= 2.0
    return float(scipy.optimize.brentq(excess, 0.0, right, xtol=1e-13) * (mass * speed / depth))


@cache
def loss_number(restitution: float) -> float:
    """Return D = a v at which a free impact has a restitution, 0 < e <= 1 [1].

    With D = x/(1 + e x), x in (0, inf): (1 + e) D = ln(1 + (1 + e) x), free of cancellation. At the ends
    D is 1/e and 3/2 (1 - e) to double precision.
    """
    e = restitution
    if e < NEARLY_PLASTIC:
        return 1.0 / e
    if 1.0 - e < NEARLY_ELASTIC:
        return 1.5 * (1.0 - e)

    def missing(logarithm: float) -> float:
        x = exp(logarithm)
        return (1.0 + e) * x / (1.0 + e * x) - log1p((1.0 + e) * x)

    # Halved to the last bit, from an x that is too small by far to one that is too large.
    low, high = log(1.0 - e), 2.0 / e + 2.0
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if missing(middle) > 0.0 else (low, middle)
    x = exp(low)
    return x / (1.0 + e * x)


@dataclass(frozen=True)
class Hysteretic(Damping):
    """A loss in proportion to the elastic force, solved for the restitution of a free impact."""

    any_force = False
    largest = inf
    """The D that the published model has at a nominal restitution of 0."""
    restitution: Annotated[float, ACHIEVED_RESTITUTION] = 0.8

    def __post_init__(self) -> None:
        super().__post_init__()
        e, most = self.restitution, self.largest
        if loss_number(e) > most:
            least = scipy.optimize.brentq(lambda e: loss_number(e) - most, e, 1.0, xtol=1e-12)
            raise ValueError(
                f"{self.name}: restitution is {e}; it must be at least {least:.6g}, which the model "
                "achieves with a nominal one of 0. Take flores, which has no such bound."
            )


@final
@dataclass(frozen=True)
class HuntCrossley(Hysteretic):
    """A constant a: restitution falls with the speed of impact, and is e at v."""

    name = "hunt_crossley"
    equation = "N = f(d) max(1 + a dd/dt, 0), a v = D(e)"
    source = "Hunt and Crossley (1975), J. Appl. Mech. 42, 440"
    validity = "impacts near the speed v"
    largest = 1.5

    impact_speed: Annotated[float, positive("v", "m s-1", "speed at which e is achieved")] = 0.1

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return the loss factor a [s/m]."""
        return {"loss_factor": loss_number(self.restitution) / self.impact_speed}

    @staticmethod
    @kernel
    def damped(elastic_force, depth_rate, loss_factor):
        return float(elastic_force * max(1.0 + loss_factor * depth_rate, 0.0))


@dataclass(frozen=True)
class SpeedHysteresis(Hysteretic):
    """A loss by the speed v of each impact, which v_min bounds from below."""

    least_speed: Annotated[float, LEAST_SPEED] = 1e-3

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return D [1] and v_min [m/s]."""
        return {"loss_number": loss_number(self.restitution), "least_speed": self.least_speed}

    @staticmethod
    @kernel
    def damped(elastic_force, depth_rate, impact_speed, loss_number, least_speed):
        factor = loss_number / max(impact_speed, least_speed)
        return float(elastic_force * max(1.0 + factor * depth_rate, 0.0))


@final
@dataclass(frozen=True)
class LankaraniNikravesh(SpeedHysteresis):
    """A loss by the speed of each impact: one restitution at all speeds.

    The published D = 3/4 (1 - e_n^2) reaches 3/4 at most and leaves at least e = 0.663. Above that the
    model, so solved, is `flores`.
    """

    name = "lankarani_nikravesh"
    equation = "N = f(d) max(1 + D(e) (dd/dt)/v, 0), D <= 3/4"
    source = "Lankarani and Nikravesh (1990), J. Mech. Des. 112, 369"
    validity = "restitution above 0.663"
    largest = 0.75


@final
@dataclass(frozen=True)
class Flores(SpeedHysteresis):
    """A loss by the speed of each impact, for soft bodies as well.

    The published D = 8 (1 - e_n)/(5 e_n) reaches any, and e_n is then not what is achieved.
    """

    name = "flores"
    equation = "N = f(d) max(1 + D(e) (dd/dt)/v, 0)"
    source = "Flores et al. (2011), Multibody Syst. Dyn. 25, 357"
    validity = "any restitution above zero, at any speed"


@cache
def damping_ratio(restitution: float) -> float:
    """Return zeta at which a linear oscillator, released at N = 0, has a restitution, 0 < e <= 1 [1]."""
    loss = -log(restitution)

    def excess(zeta: float) -> float:
        if zeta == 1.0:
            return 2.0 - loss
        angle = acos(zeta) if zeta < 1.0 else acosh(zeta)
        return 2.0 * zeta * angle / sqrt(abs((1.0 - zeta) * (1.0 + zeta))) - loss

    return float(scipy.optimize.brentq(excess, 0.0, cosh(0.5 * loss), xtol=1e-20, rtol=1e-15))


@final
@dataclass(frozen=True)
class Tsuji(Damping):
    """A dashpot that stiffens with the contact: one restitution at all speeds of impact, at the mass m.

    With Hertz's f = K d^1.5 it is the published alpha sqrt(m K) d^(1/4) dd/dt, alpha = sqrt(5) zeta; with
    f = k d it is a constant dashpot. zeta is solved for a contact that is released at N = 0. One that pulls
    until d = 0 has alpha = -sqrt(5) ln e / sqrt(ln(e)^2 + pi^2) (Antypov and Elliott 2011, EPL 94, 50004).
    """

    name = "tsuji"
    equation = "N = max(f(d) + 2 zeta(e) sqrt(m/(2 V)) f(d) dd/dt, 0), V = int f dd"
    source = "Tsuji, Tanaka and Ishida (1992), Powder Technol. 71, 239"
    validity = "impacts of one mass, at any speed"
    any_force = False

    restitution: Annotated[float, ACHIEVED_RESTITUTION] = 0.8
    effective_mass: Annotated[float, positive("m", "kg", "mass of the impact")] = 2e-3

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return 2 zeta sqrt(m) [kg^(1/2)]."""
        return {"root_damping": 2.0 * damping_ratio(self.restitution) * sqrt(self.effective_mass)}

    @staticmethod
    @kernel
    def damped(elastic_force, elastic_energy, elastic_stiffness, depth_rate, root_damping):
        # f/sqrt(2V) of a force that begins linearly is sqrt(k) at the touch.
        twice = 2.0 * elastic_energy
        slope = elastic_force / sqrt(twice) if twice > 0.0 else sqrt(elastic_stiffness)
        return float(max(elastic_force + root_damping * slope * depth_rate, 0.0))


@final
@dataclass(frozen=True)
class KuwabaraKono(Damping):
    """Viscoelastic bodies that follow their contact at once: the dashpot is in proportion to the stiffness.

    With Hertz's f = K d^1.5 it is the published 3/2 A K d^(1/2) dd/dt. A is a time of the material, from its
    bulk and shear viscosities (Brilliantov et al. 1996, Phys. Rev. E 53, 5382). Restitution falls with the
    speed v of an impact of a mass m, with y = 3/2 A (K/m)^(2/5) v^(1/5) << 1 as

        e = 1 - 1.15345 y + 0.79827 y^2 + 4/15 y^(5/2) + O(y^3)

    (Schwager and Poeschel 1998, Phys. Rev. E 57, 650); the last term is that of a release at N = 0.
    """

    name = "kuwabara_kono"
    equation = "N = max(f(d) + A (df/dd) dd/dt, 0)"
    source = "Kuwabara and Kono (1987), Jpn. J. Appl. Phys. 26, 1230"
    validity = "viscoelastic bodies that relax much faster than an impact lasts"
    any_force = False

    viscous_time: Annotated[float, not_negative("A", "s", "viscous time of the material")] = 2e-6

    @staticmethod
    @kernel
    def damped(elastic_force, elastic_stiffness, depth_rate, viscous_time):
        return float(max(elastic_force + viscous_time * elastic_stiffness * depth_rate, 0.0))


DAMPINGS: dict[str, type[Damping]] = {
    part.name: part
    for part in (*(Undamped, LinearDamping, HuntCrossley, LankaraniNikravesh, Flores), *(Tsuji, KuwabaraKono))
}
