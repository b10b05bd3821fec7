"""A loss factor of the approach after Flores."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, final

from contactlab.laws.damping.hysteresis import ACHIEVED_RESTITUTION, LEAST_SPEED, closing_number
from contactlab.laws.damping.lankarani_nikravesh import approach_damped
from contactlab.laws.part import DampedKernel, Damping, NormalForce


@final
@dataclass(frozen=True)
class Flores(Damping):
    """N = f(d) max(1 + D (dd/dt)/v, 0), v the speed of each approach, for soft bodies as well.

    D is solved for the restitution of a free impact; the published D = 8 (1 - e_n)/(5 e_n) reaches
    any, and e_n is then not what is achieved.

    Source: Flores, Machado, Silva and Martins (2011), Multibody Syst. Dyn. 25, 357.

    Args:
        restitution: e of a free impact [1].
        least_speed: v_min, taken for v below it [m/s].
    """

    name: ClassVar[str] = "flores"
    equation: ClassVar[str] = "N = f(d) max(1 + D(e) (dd/dt)/v, 0)"
    source: ClassVar[str] = "Flores et al. (2011), Multibody Syst. Dyn. 25, 357"

    restitution: Annotated[float, ACHIEVED_RESTITUTION] = 0.8
    least_speed: Annotated[float, LEAST_SPEED] = 1e-3

    def coefficients(self, normal: NormalForce) -> tuple[float, ...]:
        """D [1] and the least speed."""
        return closing_number(self.restitution), self.least_speed

    @property
    def damped(self) -> DampedKernel:
        """The kernel; see `Damping.damped`."""
        return approach_damped
