"""The paper's first law: a rigid contact that always slips."""

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, final

from contactlab.compiled import kernel
from contactlab.laws.base import SLIP, MultiplierLaw
from contactlab.laws.declaration import FRICTION_COEFFICIENT


@final
@dataclass(frozen=True)
class LagrangeSlip(MultiplierLaw):
    """Lagrange multiplier with Coulomb slip, eqs. 37, 43, 47-51 and 59 of the paper.

    The sign is that of the slip when the step begins, in the impact step as well, whatever the
    friction impulse then does to it. It reverses the slip in nearly every impact of the paper's
    motor, and where the bodies would stick it chatters at the step: there is no slip-only
    solution there. Where the friction of that slip presses the bodies together more than the normal
    impulse parts them, d_nn <= mu |d_nt|, nothing stops an approach (Painleve), and the run ends. The
    impact is one step, so the peak force is impulse / step and grows without bound as the step
    shrinks; the impulse converges.
    """

    name = "lagrange_slip"
    equation = "g = 0, N >= 0, F = -mu N sign(v)"
    source = "Andersen, Blanke and Helbo (2001), eqs. 49-59"
    default_contact_step = 5e-8
    exact_stick = False
    violations = MappingProxyType(
        {
            "friction_opposes_slip": "the friction impulse of an impact is mu p_n whatever slip there is "
            "to end, and reverses the slip in nearly every impact of the paper's motor.",
            "dissipates": "the slip that it reverses can carry away more than was brought.",
        }
    )

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    @staticmethod
    @kernel
    def solve(normal_rate, tangential_rate, gap_rate, slip, d_nn, d_nt, d_tt, parameters):
        """See `MultiplierLaw.solve`."""
        mu = parameters[0]
        s = 1.0 if slip > 0.0 else -1.0 if slip < 0.0 else 0.0
        if d_nn <= s * mu * d_nt:
            # No slip meets an approach; what opens by itself is released.
            return -abs(normal_rate) / d_nn, 0.0, SLIP
        p_n = -normal_rate / (d_nn - s * mu * d_nt)
        return p_n, -s * mu * p_n, SLIP
