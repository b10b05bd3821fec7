"""A law that pulls, as none of the package does."""

from dataclasses import dataclass
from typing import Annotated, final

from contactlab.compiler.kernels import kernel
from contactlab.laws import PenaltyLaw
from contactlab.parameter import not_negative, positive


@final
@dataclass(frozen=True)
class TensileDashpot(PenaltyLaw):
    """A linear spring and dashpot that pulls before the gap opens, d = -g = 0. No friction."""

    name = "tensile_dashpot"
    equation = "N = k d + c ddot"
    source = "Johnson, Contact Mechanics (1985), sec. 11.5"
    default_contact_step = 4e-6
    allows_tension = True

    stiffness: Annotated[float, positive("k", "N m-1", "contact stiffness")]
    damping: Annotated[float, not_negative("c", "N s m-1", "contact damping")]

    @staticmethod
    @kernel
    def force(gap, gap_rate, slip, impact_speed, parameters):
        elastic, loss = -parameters[0] * gap, parameters[1] * gap_rate * gap_rate
        return elastic - parameters[1] * gap_rate, 0.0, -0.5 * elastic * gap, loss
