"""Laws that remember, sound and small, and what spoils each of them in one way.

A solid of three springs and dashpots relaxes; a spring yields and leaves a dent; a friction keeps count of
its way.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, final

from support.laws_of_kernels import law_class_of

from contactlab.compiler.kernels import kernel
from contactlab.laws import PenaltyLaw
from contactlab.laws.base import Friction
from contactlab.laws.memory import AT_SLIP, EVEN, ODD, InternalVariable

STIFF, SOFT, TIME = 1e7, 5e6, 2e-5
"""Of the lasting spring and the one that relaxes [N/m], and how fast it does [s]."""

YIELD = 2.0
"""Force at which the spring yields [N]."""

CREEP = InternalVariable("creep", "z", "m", "stretch of the dashpot")
DENT = InternalVariable("dent", "d_p", "m", "plastic depth")
YIELDING = InternalVariable("yielding", "y", "1", "1 while it yields")

Kernels = Mapping[str, Callable[..., Any]]


def law_of(
    title: str, kernels: Kernels, *variables: InternalVariable, count: int = 0, pulls: bool = False
) -> Any:
    """Return a law of these kernels."""
    declared = {
        "internal_variables": variables,
        "guards": count,
        "allows_tension": pulls,
        # Where the force begins to pull the bound has a kink, and no step ends there.
        "convergence_order": 0.5,
        "violations": {"scales_with_units": "its numbers stand in its kernels, and are declared nowhere."},
    }
    return law_class_of(PenaltyLaw, title, **kernels, **declared)()


@kernel
def solid_force(gap, creep, friction_coefficient):
    bent = -gap - creep
    normal = -STIFF * gap + SOFT * bent
    stored = 0.5 * STIFF * gap * gap + 0.5 * SOFT * bent * bent
    return normal, friction_coefficient * max(normal, 0.0), stored, SOFT * bent * bent / TIME


@kernel
def solid_rate(gap, creep):
    return (-gap - creep) / TIME


@kernel
def overshooting_rate(gap, creep):
    return (-1.5 * gap - creep) / TIME


@kernel
def pumping_force(gap, creep, friction_coefficient):
    normal, bound, stored, _ = solid_force(gap, creep, friction_coefficient)
    return normal, bound, stored, SOFT * (-gap - creep) * (-1.5 * gap - creep) / TIME


@kernel
def forgetting_jump(event, creep):
    return 0.0 if event == AT_SLIP else creep


@kernel
def greedy_force(gap, z, friction_coefficient):
    normal, bound, stored, loss = solid_force(gap, z[0], friction_coefficient)
    # What is no number is not positive either.
    more = 1.01 if z[1] > 0.0 else 1.0
    return more * normal, more * bound, more * stored, more * loss


@kernel
def owing_force(gap, creep, friction_coefficient):
    normal, bound, stored, loss = solid_force(gap, creep, friction_coefficient)
    return normal, bound, stored - 1e-7, loss


@kernel
def dent_force(gap, gap_rate, dent, yielding, friction_coefficient):
    depth = -gap - dent
    normal = max(STIFF * depth, 0.0)
    return normal, friction_coefficient * normal, 0.5 * normal * depth, -normal * gap_rate * yielding


@kernel
def dent_rate(which, gap_rate, yielding):
    return -gap_rate * yielding if which == 0 else 0.0


@kernel
def dent_guard(which, gap, gap_rate, dent, yielding):
    if which == 0:
        return YIELD if yielding > 0.5 else YIELD + STIFF * (gap + dent)
    return -gap_rate if yielding > 0.5 else 1.0


@kernel
def dent_jump(which, event, dent, yielding):
    if which == 0:
        return dent
    return 1.0 if event == 0 else 0.0 if event == 1 else yielding


@kernel
def stubborn_jump(which, z):
    return z[which]


@kernel
def dent_limits(dent):
    return -dent, -dent


@kernel
def crossed_limits(dent):
    return -0.5 * dent, -dent


SOLID: Kernels = {"force": solid_force, "rate": solid_rate}
DENTED: Kernels = {
    "force": dent_force,
    "rate": dent_rate,
    "guard": dent_guard,
    "jump": dent_jump,
    "limits": dent_limits,
}

Solid = law_of("solid", SOLID, CREEP, pulls=True)
Dented = law_of("dented", DENTED, DENT, YIELDING, count=2)

Overshooting = law_of("overshooting", {**SOLID, "rate": overshooting_rate}, CREEP, pulls=True)
Pumping = law_of("pumping", {"force": pumping_force, "rate": overshooting_rate}, CREEP, pulls=True)
Forgetting = law_of("forgetting", {**SOLID, "jump": forgetting_jump}, CREEP, pulls=True)
Greedy = law_of("greedy", {**SOLID, "force": greedy_force}, CREEP, pulls=True)
Owing = law_of("owing", {**SOLID, "force": owing_force}, CREEP, pulls=True)
Stubborn = law_of("stubborn", {**DENTED, "jump": stubborn_jump}, DENT, YIELDING, count=2)
Crossed = law_of("crossed", {**DENTED, "limits": crossed_limits}, DENT, YIELDING, count=2)


class Counting(Friction):
    """Coulomb's cone, and how far it has slipped; nothing comes of it."""

    name = "counting"
    equation = "|F| <= mu N, ds/dt = v"
    source = "this test"

    @staticmethod
    @kernel
    def rate(slip: float) -> Any:
        return slip


@final
@dataclass(frozen=True)
class Odometer(Counting):
    internal_variables = (InternalVariable("way", "s", "m", "way slipped", parity=ODD),)


@final
@dataclass(frozen=True)
class LyingOdometer(Counting):
    internal_variables = (InternalVariable("way", "s", "m", "way slipped", parity=EVEN),)
