"""A viscoelastic foundation: a spring and up to three Maxwell arms, a Prony series in time."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, final

from contactlab.compiler.kernels import inner_kernel, kernel
from contactlab.laws.base import NormalForce
from contactlab.laws.declaration import Coefficient
from contactlab.laws.memory import InternalVariable, dependent
from contactlab.parameter import not_negative, positive

MOST = 3
"""Arms that can be given."""


@inner_kernel
def free_depth(z, relaxed_stiffness, arm_stiffness):
    """Return the depth of a surface that nothing presses [m]."""
    whole, carried = relaxed_stiffness, 0.0
    for i in range(len(arm_stiffness)):
        whole += arm_stiffness[i]
        carried += arm_stiffness[i] * z[i]
    return carried / whole


@final
@dataclass(frozen=True)
class Prony(NormalForce):
    """A lining of relaxing stiffness k(t) = k_inf + sum k_i exp(-t/tau_i); with one arm the standard solid.

    Each arm is a spring k_i on a dashpot k_i tau_i that has gone the way z_i. One arm a decade of time
    covers a range; an arm of zero stiffness is none. The lining does not pull: the body leaves it where N
    would, while it is still in by sum k_i z_i/(k_inf + sum k_i), and from there it recovers by itself, on
    in flight, until the body is back, at its surface as it then is. It is one place that is met again, as
    the tip's own. What is stored at a release is lost, but for what the next contact finds of it. A sphere
    whose contact grows and shrinks has another force; this is that of a flat face.
    """

    name = "prony"
    equation = "N = k_inf d + sum k_i (d - z_i), dz_i/dt = (d - z_i)/tau_i"
    source = "Christensen, Theory of Viscoelasticity (1982), sec. 1.6; Simo and Hughes (1998), sec. 10.2"
    validity = "flat faces of a linear viscoelastic lining"

    relaxed_stiffness: Annotated[float, positive("k_inf", "N m-1", "stiffness of slow loads")] = 5e6
    first_stiffness: Annotated[float, positive("k_1", "N m-1", "stiffness of the first arm")] = 5e6
    first_time: Annotated[float, positive("tau_1", "s", "relaxation time")] = 1e-5
    second_stiffness: Annotated[float, not_negative("k_2", "N m-1", "stiffness of the second arm")] = 0.0
    second_time: Annotated[float, positive("tau_2", "s", "relaxation time")] = 1e-4
    third_stiffness: Annotated[float, not_negative("k_3", "N m-1", "stiffness of the third arm")] = 0.0
    third_time: Annotated[float, positive("tau_3", "s", "relaxation time")] = 1e-3

    @property
    def arms(self) -> tuple[tuple[float, float], ...]:
        """Stiffness [N/m] and relaxation time [s] of each arm there is."""
        first = self.first_stiffness, self.first_time
        others = (self.second_stiffness, self.second_time), (self.third_stiffness, self.third_time)
        return first, *(arm for arm in others if arm[0] > 0.0)

    @dependent
    def internal_variables(self) -> tuple[InternalVariable, ...]:
        """The way of each dashpot."""
        return tuple(
            InternalVariable(f"creep_{i}", f"z_{i}", "m", f"way of the dashpot of arm {i}", life="run")
            for i in range(1, len(self.arms) + 1)
        )

    def coefficients(self) -> Mapping[str, Coefficient]:
        """Return k_inf, and stiffness and relaxation time of each arm."""
        stiffnesses, times = zip(*self.arms, strict=True)
        return {"relaxed_stiffness": self.relaxed_stiffness, "arm_stiffness": stiffnesses, "arm_time": times}

    @staticmethod
    @kernel
    def force(depth, z, relaxed_stiffness, arm_stiffness, arm_time):
        force, stiffness = relaxed_stiffness * depth, relaxed_stiffness
        energy, loss = 0.5 * force * depth, 0.0
        for i in range(len(arm_stiffness)):
            arm, stretch = arm_stiffness[i], depth - z[i]
            force += arm * stretch
            stiffness += arm
            energy += 0.5 * arm * stretch * stretch
            loss += arm * stretch * stretch / arm_time[i]
        return force, energy, stiffness, 0.0, loss

    @staticmethod
    @kernel
    def rate(which, depth, z, relaxed_stiffness, arm_stiffness, arm_time):
        free = free_depth(z, relaxed_stiffness, arm_stiffness)
        return (max(depth, free) - z[which]) / arm_time[which]

    @staticmethod
    @kernel
    def limits(z, relaxed_stiffness, arm_stiffness):
        free = free_depth(z, relaxed_stiffness, arm_stiffness)
        return -free, -free
