"""Laws with internal variables, each a few lines whose motion is known in closed form."""

from dataclasses import dataclass
from math import atan2, cos, hypot, pi, sin, sqrt
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws import InternalVariable, MultiplierLaw, PenaltyLaw
from contactlab.laws.declaration import FRICTION_COEFFICIENT
from contactlab.laws.lagrange import stick_or_slip_impulse
from contactlab.laws.memory import AT_SLIP, AT_STICK, AT_TOUCH
from contactlab.parameter import Parameter, not_negative, positive

TIME = positive("T", "s", "a time")
CLOCK = InternalVariable("clock", "t", "s", "time since the touch-down")
WARMTH = InternalVariable("warmth", "z", "1", "what is left", initial=1.0, life="run")
DENTED = InternalVariable("dented", "s", "1", "1 once it is dented")


@dataclass(frozen=True)
class Spring(PenaltyLaw):
    """A linear spring."""

    equation = "N = k d"
    source = "this test"
    default_contact_step = 4e-6

    stiffness: Annotated[float, positive("k", "N m-1", "contact stiffness")] = 1e6

    @staticmethod
    @kernel
    def force(gap, stiffness):
        return -stiffness * gap, 0.0, 0.5 * stiffness * gap * gap, 0.0


@final
@dataclass(frozen=True)
class Softening(Spring):
    """A spring that loses half of its stiffness at a time T after the touch-down, and records when."""

    name = "softening"
    guards = 1
    internal_variables = (
        CLOCK,
        InternalVariable("soft", "s", "1", "1 once it is soft"),
        InternalVariable("switched", "t_s", "s", "clock where it became soft"),
    )

    time: Annotated[float, TIME] = 3e-5

    @staticmethod
    @kernel
    def force(gap, soft, stiffness):
        left = stiffness * (0.5 if soft > 0.5 else 1.0)
        return -left * gap, 0.0, 0.5 * left * gap * gap, 0.0

    @staticmethod
    @kernel
    def rate(which):
        return 1.0 if which == 0 else 0.0

    @staticmethod
    @kernel
    def guard(clock, soft, time):
        return time - clock if soft < 0.5 else 1.0

    @staticmethod
    @kernel
    def jump(which, event, clock, z):
        if event == 0 and which == 1:
            return 1.0
        return clock if event == 0 and which == 2 else z[which]


@final
@dataclass(frozen=True)
class Cooling(Spring):
    """A spring beside a variable that decays from 1 for the whole run, in contact and in flight."""

    name = "cooling"
    internal_variables = (WARMTH,)

    time: Annotated[float, TIME] = 2e-4

    @staticmethod
    @kernel
    def rate(warmth, time):
        return -warmth / time


@final
@dataclass(frozen=True)
class FreshDent(Spring):
    """A plastic spring that leaves half of its depth as a dent: N = k (d - d_p) from d = d_p on."""

    name = "fresh_dent"
    internal_variables = (InternalVariable("dent", "d_p", "m", "depth of the dent"), DENTED)
    guards = 1

    @staticmethod
    @kernel
    def force(gap, dent, stiffness):
        depth = -gap - dent
        return stiffness * depth, 0.0, 0.5 * stiffness * depth * depth, 0.0

    @staticmethod
    @kernel
    def guard(gap_rate, dented):
        return -gap_rate if dented < 0.5 else 1.0

    @staticmethod
    @kernel
    def jump(which, event, gap, dent, z):
        if event == 0:
            return 1.0 if which == 1 else 0.5 * (dent - gap)
        return 0.0 if event == AT_TOUCH and which == 1 else z[which]

    @staticmethod
    @kernel
    def limits(dent):
        return -dent, -dent


@final
@dataclass(frozen=True)
class Ledge(Spring):
    """A spring whose contact begins at a gap g_0 and ends at g_1: N = k (g_1 - g)."""

    name = "ledge"

    begin: Annotated[float, Parameter("g_0", "m", "gap of a touch-down")] = -1e-7
    end: Annotated[float, Parameter("g_1", "m", "gap of a release")] = -1e-7

    @staticmethod
    @kernel
    def force(gap, end, stiffness):
        depth = end - gap
        return stiffness * depth, 0.0, 0.5 * stiffness * depth * depth, 0.0

    @staticmethod
    @kernel
    def limits(begin, end):
        return begin, end


@final
@dataclass(frozen=True)
class RigidAgeing(MultiplierLaw):
    """A rigid law with cohesion and a restitution, that ages in stick and counts switches."""

    name = "rigid_ageing"
    equation = "|F| <= mu (N + C), gdot+ = -e gdot- in impacts"
    source = "this test"
    default_contact_step = 1e-6
    internal_variables = (
        InternalVariable("age", "t", "s", "time of stick"),
        WARMTH,
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
    def impact(approach, slip, d_nn, d_nt, d_tt, friction_coefficient, restitution):
        rate = approach + restitution * approach
        return stick_or_slip_impulse(rate, slip, d_nn, d_nt, d_tt, friction_coefficient)

    @staticmethod
    @kernel
    def bound(normal, friction_coefficient, cohesion):
        return friction_coefficient * (max(normal, 0.0) + cohesion)

    @staticmethod
    @kernel
    def rate(which, slip, warmth, time):
        if which == 1:
            return -warmth / time
        return 1.0 if which == 0 and slip == 0.0 else 0.0

    @staticmethod
    @kernel
    def jump(which, event, age, switches, z):
        if which == 0:
            return 0.0 if event in (AT_SLIP, AT_TOUCH) else age
        return switches + 1.0 if which == 2 and event in (AT_SLIP, AT_STICK) else z[which]


def softened_end(law: Softening, mass: float, speed: float) -> tuple[float, float]:
    """Return duration [s] and speed of rebound [m/s] of a ball on a spring that softens."""
    stiff, soft = sqrt(law.stiffness / mass), sqrt(0.5 * law.stiffness / mass)
    depth, rate = speed / stiff * sin(stiff * law.time), speed * cos(stiff * law.time)
    rebound = hypot(rate, soft * depth)
    return law.time + (pi - atan2(soft * depth, rate)) / soft, rebound


@final
@dataclass(frozen=True)
class TwoClocks(Spring):
    """A spring with two guards that fall within one step, the later one first in order."""

    name = "two_clocks"
    guards = 2
    internal_variables = (CLOCK, InternalVariable("order", "n", "1", "the guards that fell, as digits"))

    time: Annotated[float, TIME] = 3e-5

    @staticmethod
    @kernel
    def rate(which):
        return 1.0 if which == 0 else 0.0

    @staticmethod
    @kernel
    def guard(which, clock, order, time):
        if which == 0:
            return 1.001 * time - clock if order % 10.0 != 1.0 else 1.0
        return time - clock if order == 0.0 else 1.0

    @staticmethod
    @kernel
    def jump(which, event, order, z):
        return 10.0 * order + event + 1.0 if event >= 0 and which == 1 else z[which]


@final
@dataclass(frozen=True)
class Swelling(Spring):
    """A spring on a surface that rises by itself, from zero to a height h, by w = h (1 - exp(-t/T))."""

    name = "swelling"
    internal_variables = (InternalVariable("rise", "w", "m", "rise of the surface", life="run"),)

    time: Annotated[float, TIME] = 2e-5
    height: Annotated[float, positive("h", "m", "height")] = 1e-6

    @staticmethod
    @kernel
    def force(gap, rise, stiffness, height, time):
        normal = stiffness * (rise - gap)
        # What lifts the surface does work.
        return normal, 0.0, 0.5 * normal * (rise - gap), -normal * (height - rise) / time

    @staticmethod
    @kernel
    def rate(rise, height, time):
        return (height - rise) / time

    @staticmethod
    @kernel
    def limits(rise):
        return rise, rise


@final
@dataclass(frozen=True)
class RigidRenewal(MultiplierLaw):
    """A rigid law whose age grows with time and is renewed by slip; friction does not depend on it."""

    name = "rigid_renewal"
    equation = "|F| <= mu N, da/dt = 1 - |v| a / D"
    source = "Dieterich (1979), J. Geophys. Res. 84, 2161, of the ageing law"
    internal_variables = (InternalVariable("age", "a", "s", "age of the contact"),)

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3
    distance: Annotated[float, positive("D", "m", "slip that renews the contact")] = 1e-6

    impact = staticmethod(stick_or_slip_impulse)

    @staticmethod
    @kernel
    def rate(slip, age, distance):
        return 1.0 - abs(slip) * age / distance
