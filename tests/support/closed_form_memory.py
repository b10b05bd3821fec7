"""Laws that remember, each a few lines whose motion is known in closed form."""

from dataclasses import dataclass
from math import atan2, cos, hypot, pi, sin, sqrt
from typing import Annotated, final

from contactlab.compiled import kernel
from contactlab.laws import InternalVariable, MultiplierLaw, PenaltyLaw
from contactlab.laws.base import SLIP
from contactlab.laws.declaration import FRICTION_COEFFICIENT
from contactlab.laws.lagrange import stick_or_slip_impulse
from contactlab.laws.memory import AT_SLIP, AT_STICK, AT_TOUCH
from contactlab.parameter import Parameter, not_negative, positive

STIFFNESS = positive("k", "N m-1", "contact stiffness")
TIME = positive("T", "s", "a time")


@final
@dataclass(frozen=True)
class Softening(PenaltyLaw):
    """A spring that loses half of its stiffness at a time T after the touch-down, and tells when that was."""

    name = "softening"
    equation = "N = k d for t < T, k d / 2 after that"
    source = "this test"
    default_contact_step = 4e-6
    guards = 1
    internal_variables = (
        InternalVariable("clock", "t", "s", "time since the touch-down"),
        InternalVariable("soft", "s", "1", "1 once it is soft"),
        InternalVariable("switched", "t_s", "s", "clock where it became soft"),
    )

    stiffness: Annotated[float, STIFFNESS] = 1e6
    time: Annotated[float, TIME] = 3e-5

    @staticmethod
    @kernel
    def force(gap, gap_rate, slip, impact_speed, z, parameters):
        stiffness = parameters[0] * (0.5 if z[1] > 0.5 else 1.0)
        return -stiffness * gap, 0.0, 0.5 * stiffness * gap * gap, 0.0

    @staticmethod
    @kernel
    def rate(which, gap, gap_rate, slip, normal, z, parameters):
        return 1.0 if which == 0 else 0.0

    @staticmethod
    @kernel
    def guard(which, gap, gap_rate, slip, normal, z, parameters):
        return parameters[1] - z[0] if z[1] < 0.5 else 1.0

    @staticmethod
    @kernel
    def jump(which, event, gap, gap_rate, slip, normal, z, parameters):
        if event == 0 and which == 1:
            return 1.0
        return z[0] if event == 0 and which == 2 else z[which]


@final
@dataclass(frozen=True)
class Cooling(PenaltyLaw):
    """A spring beside something that decays from 1 for the whole run, in contact and in flight."""

    name = "cooling"
    equation = "N = k d, dz/dt = -z/T"
    source = "this test"
    default_contact_step = 4e-6
    internal_variables = (InternalVariable("warmth", "z", "1", "what is left", initial=1.0, life="run"),)

    stiffness: Annotated[float, STIFFNESS] = 1e6
    time: Annotated[float, TIME] = 2e-4

    @staticmethod
    @kernel
    def force(gap, gap_rate, slip, impact_speed, z, parameters):
        return -parameters[0] * gap, 0.0, 0.5 * parameters[0] * gap * gap, 0.0

    @staticmethod
    @kernel
    def rate(which, gap, gap_rate, slip, normal, z, parameters):
        return -z[0] / parameters[1]


@dataclass(frozen=True)
class Denting(PenaltyLaw):
    """A plastic spring: it leaves half of its depth as a dent, and gives nothing back."""

    equation = "N = k (d - d_p), d_p = d/2 at the depth of a dent; it begins and ends at d = d_p"
    source = "this test"
    default_contact_step = 4e-6
    guards = 1

    stiffness: Annotated[float, STIFFNESS] = 1e6

    @staticmethod
    @kernel
    def force(gap, gap_rate, slip, impact_speed, z, parameters):
        depth = -gap - z[0]
        return parameters[0] * depth, 0.0, 0.5 * parameters[0] * depth * depth, 0.0

    @staticmethod
    @kernel
    def guard(which, gap, gap_rate, slip, normal, z, parameters):
        return -gap_rate if z[1] < 0.5 else 1.0

    @staticmethod
    @kernel
    def jump(which, event, gap, gap_rate, slip, normal, z, parameters):
        if event == 0:
            return 1.0 if which == 1 else 0.5 * (z[0] - gap)
        return 0.0 if event == AT_TOUCH and which == 1 else z[which]

    @staticmethod
    @kernel
    def limits(z, parameters):
        return -z[0], -z[0]


@final
@dataclass(frozen=True)
class LastingDent(Denting):
    """The dent stays for the run."""

    name = "lasting_dent"
    internal_variables = (
        InternalVariable("dent", "d_p", "m", "depth of the dent", life="run"),
        InternalVariable("dented", "s", "1", "1 once it is dented"),
    )


@final
@dataclass(frozen=True)
class FreshDent(Denting):
    """The next contact meets another place."""

    name = "fresh_dent"
    internal_variables = (
        InternalVariable("dent", "d_p", "m", "depth of the dent"),
        InternalVariable("dented", "s", "1", "1 once it is dented"),
    )


@final
@dataclass(frozen=True)
class Ledge(PenaltyLaw):
    """A spring that begins and ends at another gap than zero, and remembers nothing."""

    name = "ledge"
    equation = "N = k (g_1 - g), from g_0 on to g_1"
    source = "this test"
    default_contact_step = 4e-6

    begin: Annotated[float, Parameter("g_0", "m", "gap of a touch-down")] = -1e-7
    end: Annotated[float, Parameter("g_1", "m", "gap of a release")] = -1e-7
    stiffness: Annotated[float, STIFFNESS] = 1e6

    @staticmethod
    @kernel
    def force(gap, gap_rate, slip, impact_speed, parameters):
        depth = parameters[1] - gap
        return parameters[2] * depth, 0.0, 0.5 * parameters[2] * depth * depth, 0.0

    @staticmethod
    @kernel
    def limits(parameters):
        return parameters[0], parameters[1]


@final
@dataclass(frozen=True)
class Pad(PenaltyLaw):
    """A flat pad on an elastic foundation, 2 b wide, with a drag against spin."""

    name = "pad"
    equation = "N = k d, M = -k b^2/3 tilt - c spin"
    source = "Winkler (1867)"
    default_contact_step = 4e-6

    stiffness: Annotated[float, STIFFNESS] = 1e7
    half_width: Annotated[float, positive("b", "m", "half width")] = 2e-3
    drag: Annotated[float, not_negative("c", "N m s", "drag against spin")] = 0.0

    @staticmethod
    @kernel
    def force(gap, gap_rate, slip, impact_speed, parameters):
        return -parameters[0] * gap, 0.0, 0.5 * parameters[0] * gap * gap, 0.0

    @staticmethod
    @kernel
    def moment(tilt, spin, gap, normal, parameters):
        stiffness = parameters[0] * parameters[1] ** 2 / 3.0
        return -stiffness * tilt, -parameters[2] * spin, 0.5 * stiffness * tilt * tilt


@final
@dataclass(frozen=True)
class Told(MultiplierLaw):
    """A rigid law with cohesion and a restitution of impacts alone, that ages in stick and counts switches.

    |p_t| <= mu (p_n + C step): cohesion is a force.
    """

    name = "told"
    equation = "|F| <= mu (N + C), gdot+ = -e gdot- in impacts"
    source = "this test"
    default_contact_step = 1e-6
    internal_variables = (
        InternalVariable("age", "t", "s", "time of stick"),
        InternalVariable("warmth", "z", "1", "what is left", initial=1.0, life="run"),
        InternalVariable("switches", "n", "1", "switches of the friction"),
    )

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    cohesion: Annotated[float, not_negative("C", "N", "cohesion")] = 0.0
    restitution: Annotated[float, not_negative("e", "1", "restitution")] = 0.0
    time: Annotated[float, TIME] = 1e-2

    @property
    def friction_offset(self) -> float:
        return self.cohesion

    @staticmethod
    @kernel
    def solve(normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, step, impact, z, parameters):
        rate = normal_rate + (parameters[2] * gap_rate if impact else 0.0)
        p_n, p_t, mode = stick_or_slip_impulse(rate, tangential_rate, slip, d_nn, d_nt, d_tt, parameters[0])
        if mode == SLIP and p_n > 0.0 and not impact:
            p_t *= (p_n + parameters[1] * step) / p_n
        return p_n, p_t, mode

    @staticmethod
    @kernel
    def rate(which, gap, gap_rate, slip, normal, z, parameters):
        if which == 1:
            return -z[1] / parameters[3]
        return 1.0 if which == 0 and slip == 0.0 else 0.0

    @staticmethod
    @kernel
    def jump(which, event, gap, gap_rate, slip, normal, z, parameters):
        if which == 0:
            return 0.0 if event in (AT_SLIP, AT_TOUCH) else z[0]
        return z[2] + 1.0 if which == 2 and event in (AT_SLIP, AT_STICK) else z[which]


def softened_end(law: Softening, mass: float, speed: float) -> tuple[float, float]:
    """Give duration [s] and speed of rebound [m/s] of a ball on a spring that softens."""
    stiff, soft = sqrt(law.stiffness / mass), sqrt(0.5 * law.stiffness / mass)
    depth, rate = speed / stiff * sin(stiff * law.time), speed * cos(stiff * law.time)
    rebound = hypot(rate, soft * depth)
    return law.time + (pi - atan2(soft * depth, rate)) / soft, rebound


@final
@dataclass(frozen=True)
class TwoClocks(PenaltyLaw):
    """A spring with two guards that fall within one step, the later one asked first."""

    name = "two_clocks"
    equation = "N = k d"
    source = "this test"
    default_contact_step = 4e-6
    guards = 2
    internal_variables = (
        InternalVariable("clock", "t", "s", "time since the touch-down"),
        InternalVariable("order", "n", "1", "the guards that fell, as digits"),
    )

    stiffness: Annotated[float, STIFFNESS] = 1e6
    time: Annotated[float, TIME] = 3e-5

    @staticmethod
    @kernel
    def force(gap, gap_rate, slip, impact_speed, z, parameters):
        return -parameters[0] * gap, 0.0, 0.5 * parameters[0] * gap * gap, 0.0

    @staticmethod
    @kernel
    def rate(which, gap, gap_rate, slip, normal, z, parameters):
        return 1.0 if which == 0 else 0.0

    @staticmethod
    @kernel
    def guard(which, gap, gap_rate, slip, normal, z, parameters):
        if which == 0:
            return 1.001 * parameters[1] - z[0] if z[1] % 10.0 != 1.0 else 1.0
        return parameters[1] - z[0] if z[1] == 0.0 else 1.0

    @staticmethod
    @kernel
    def jump(which, event, gap, gap_rate, slip, normal, z, parameters):
        return 10.0 * z[1] + event + 1.0 if event >= 0 and which == 1 else z[which]


@final
@dataclass(frozen=True)
class Swelling(PenaltyLaw):
    """A spring on a surface that rises by itself, from zero to a height h, by w = h (1 - exp(-t/T))."""

    name = "swelling"
    equation = "N = k (w - g), dw/dt = (h - w)/T; it begins and ends at g = w"
    source = "this test"
    default_contact_step = 4e-6
    internal_variables = (InternalVariable("rise", "w", "m", "rise of the surface", life="run"),)

    stiffness: Annotated[float, STIFFNESS] = 1e6
    time: Annotated[float, TIME] = 2e-5
    height: Annotated[float, positive("h", "m", "height")] = 1e-6

    @staticmethod
    @kernel
    def force(gap, gap_rate, slip, impact_speed, z, parameters):
        normal = parameters[0] * (z[0] - gap)
        # What lifts the surface does work.
        return normal, 0.0, 0.5 * normal * (z[0] - gap), -normal * (parameters[2] - z[0]) / parameters[1]

    @staticmethod
    @kernel
    def rate(which, gap, gap_rate, slip, normal, z, parameters):
        return (parameters[2] - z[0]) / parameters[1]

    @staticmethod
    @kernel
    def limits(z, parameters):
        return z[0], z[0]
