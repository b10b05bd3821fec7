"""Springs: a linear one, and a soft lining that is pressed through to what lies behind it."""

from dataclasses import dataclass
from typing import Annotated, final

from contactlab.compiled import kernel
from contactlab.laws.part import NormalForce
from contactlab.parameter import Parameter


@final
@dataclass(frozen=True)
class Linear(NormalForce):
    """A flat punch, or a linearised contact."""

    name = "linear"
    equation = "N = k d"
    source = "Johnson, Contact Mechanics (1985), sec. 11.5"

    stiffness: Annotated[float, Parameter("k", "N m-1", "contact stiffness", above=0.0)] = 1e7

    @staticmethod
    @kernel
    def elastic(depth, parameters, at):
        """See `NormalForce.elastic`."""
        force = parameters[at] * depth
        return force, 0.5 * force * depth, parameters[at], 0.0


@final
@dataclass(frozen=True)
class Lining(NormalForce):
    """Two stages: the two-stage spring of piecewise linear oscillators, with a passage of finite width.

    The passage has a width because a stiffness that jumps is no material's and takes the order of any
    integration.
    """

    name = "lining"
    equation = "dN/dd = k_1 for d < d_1, k_2 for d > d_1 + w, linear in between"
    source = "after Shaw and Holmes (1983), J. Sound Vib. 90, 129"

    soft_stiffness: Annotated[float, Parameter("k_1", "N m-1", "of the lining", above=0.0)] = 5e6
    hard_stiffness: Annotated[float, Parameter("k_2", "N m-1", "of what is behind", above=0.0)] = (
        5e7
    )
    lining_depth: Annotated[float, Parameter("d_1", "m", "depth of the lining", above=0.0)] = 5e-7
    passage: Annotated[float, Parameter("w", "m", "width of the passage", above=0.0)] = 1e-7

    @staticmethod
    @kernel
    def elastic(depth, parameters, at):
        """See `NormalForce.elastic`."""
        soft, width = parameters[at], parameters[at + 3]
        more = parameters[at + 1] - soft
        force, energy = soft * depth, 0.5 * soft * depth * depth
        beyond = depth - parameters[at + 2]
        if beyond <= 0.0:
            return force, energy, soft, 0.0
        inside = min(beyond, width)
        slope = more / width
        through = beyond - inside
        force += 0.5 * slope * inside * inside + more * through
        energy += slope * inside**3 / 6.0 + 0.5 * more * through * (width + through)
        if through > 0.0:
            return force, energy, soft + more, 0.0
        return force, energy, soft + slope * inside, slope
