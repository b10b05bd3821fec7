"""Laws with closed-form answers, to prove the engine on: a dashpot and an internal loss.

They are no part of the registry: nobody should run a motor with them by accident.
"""

from dataclasses import dataclass
from typing import Annotated, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel
from contactlab.laws.base import PenaltyKernel, PenaltyLaw
from contactlab.parameter import Parameter

Array = NDArray[np.float64]

_STIFFNESS = Parameter("k", "N m-1", "contact stiffness", above=0.0)
_DAMPING = Parameter("c", "N s m-1", "contact damping", at_least=0.0)


@final
@dataclass(frozen=True)
class SpringDashpot(PenaltyLaw):
    """A linear spring and dashpot that push only, with static and kinetic friction.

    N = max(k d + c ddot, 0),  d = -g;  |F| <= mu_s N in stick, F = -mu_k N sign(v) in slip
    """

    name: ClassVar[str] = "spring_dashpot"
    equation: ClassVar[str] = "N = max(k d + c ddot, 0), |F| <= mu_s N, F = -mu_k N sign(v)"
    source: ClassVar[str] = "Johnson, Contact Mechanics (1985), sec. 11.5; Coulomb (1785)"
    default_contact_step: ClassVar[float] = 4e-6
    # The force has a kink where it ends, and no step ends there.
    convergence_order: ClassVar[float] = 0.75

    stiffness: Annotated[float, _STIFFNESS]
    damping: Annotated[float, _DAMPING] = 0.0
    static_friction: Annotated[float, Parameter("mu_s", "1", "static", at_least=0.0)] = 0.0
    kinetic_friction: Annotated[float, Parameter("mu_k", "1", "kinetic", at_least=0.0)] = 0.0

    @property
    def friction_limit(self) -> float:
        """Largest |F|/N [1]."""
        return max(self.static_friction, self.kinetic_friction)

    @property
    def force(self) -> PenaltyKernel:
        """The kernel; see `PenaltyLaw.force`."""
        return spring_dashpot_force


@kernel
def spring_dashpot_force(
    gap: float, gap_rate: float, slip: float, approach: float, parameters: Array
) -> tuple[float, float, float, float]:
    """Normal force [N], friction bound [N], stored energy [J], normal loss [W]."""
    elastic = -parameters[0] * gap
    normal = max(elastic - parameters[1] * gap_rate, 0.0)
    mu = parameters[2] if slip == 0.0 else parameters[3]
    return normal, mu * normal, -0.5 * elastic * gap, (elastic - normal) * gap_rate


@final
@dataclass(frozen=True)
class TensileDashpot(PenaltyLaw):
    """The same normal force without its limit: it pulls before the gap opens. No friction.

    N = k d + c ddot
    """

    name: ClassVar[str] = "tensile_dashpot"
    equation: ClassVar[str] = "N = k d + c ddot"
    source: ClassVar[str] = "Johnson, Contact Mechanics (1985), sec. 11.5"
    default_contact_step: ClassVar[float] = 4e-6
    allows_tension: ClassVar[bool] = True

    stiffness: Annotated[float, _STIFFNESS]
    damping: Annotated[float, _DAMPING]

    @property
    def force(self) -> PenaltyKernel:
        """The kernel; see `PenaltyLaw.force`."""
        return tensile_dashpot_force


@kernel
def tensile_dashpot_force(
    gap: float, gap_rate: float, slip: float, approach: float, parameters: Array
) -> tuple[float, float, float, float]:
    """Normal force [N], friction bound [N], stored energy [J], normal loss [W]."""
    elastic = -parameters[0] * gap
    viscous = -parameters[1] * gap_rate
    return elastic + viscous, 0.0, -0.5 * elastic * gap, -viscous * gap_rate
