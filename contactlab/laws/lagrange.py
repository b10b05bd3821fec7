"""The paper's laws: a rigid contact that always slips, and one that slips or sticks."""

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, final

from contactlab.compiler.kernels import inner_kernel, kernel
from contactlab.laws.base import MultiplierLaw
from contactlab.laws.declaration import FRICTION_COEFFICIENT


@final
@dataclass(frozen=True)
class LagrangeSlip(MultiplierLaw):
    """Lagrange multiplier with Coulomb slip, eqs. 37, 43, 47-51 and 59 of the paper.

    The sign is that of the slip when a step or an impact begins, whatever the friction impulse then
    does to it. It reverses the slip in nearly every impact of the paper's motor, and where the bodies
    would stick it chatters at the step of time stepping: there is no slip-only solution there, and what
    it tends to is a slip held at zero inside the cone. Where the friction of that slip presses the bodies
    together more than the normal impulse parts them, d_nn <= mu |d_nt|, nothing stops an approach
    (Painleve), and the run ends. In time stepping an impact is one step, so the peak force is impulse / step
    and grows without bound as the step shrinks; the impulse converges.
    """

    name = "lagrange_slip"
    equation = "g = 0, N >= 0, F = -mu N sign(v)"
    source = "Andersen, Blanke and Helbo (2001), eqs. 49-59"
    validity = "contacts that slide throughout; impacts that are short against the periods of the bodies"
    sticks = False
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
    def impact(approach, slip, d_nn, d_nt, friction_coefficient):
        s = 1.0 if slip > 0.0 else -1.0 if slip < 0.0 else 0.0
        if d_nn <= s * friction_coefficient * d_nt:
            # No slip stops the approach (Painleve).
            return 0.0, 0.0
        return slip_impulse(approach, s, friction_coefficient, d_nn, d_nt)


@kernel
def stick_or_slip_impulse(approach, slip, d_nn, d_nt, d_tt, friction_coefficient):
    """Return the impulses [N s] that leave no gap rate, with Coulomb friction of the slip that is left.

    Arguments as of `MultiplierLaw.impact`. An approach has exactly one such answer, for any positive definite
    D and any mu: p = -D^-1 (approach, slip) of stick inside the cone; outside of it slip against the friction
    of stick, where d_nn > mu |d_nt| (docs/theory/rigid.md, eqs. 4.5 and 4.6).
    """
    p_n, p_t = stick_impulse(approach, slip, d_nn, d_nt, d_tt)
    # Not strict: on the cone's surface the contact still sticks.
    if abs(p_t) <= friction_coefficient * p_n:
        return p_n, p_t
    return slip_impulse(approach, -1.0 if p_t > 0.0 else 1.0, friction_coefficient, d_nn, d_nt)


@inner_kernel
def slip_impulse(normal_rate, s, mu, d_nn, d_nt):
    """Return the impulses [N s] that leave no gap rate in a slip of the sign s."""
    p_n = -normal_rate / (d_nn - s * mu * d_nt)
    return p_n, -s * mu * p_n


@inner_kernel
def stick_impulse(
    normal_rate: float, tangential_rate: float, d_nn: float, d_nt: float, d_tt: float
) -> tuple[float, float]:
    """Return the impulses [N s] that leave neither gap rate nor slip, whatever their signs."""
    determinant = d_nn * d_tt - d_nt * d_nt
    p_n = (d_nt * tangential_rate - d_tt * normal_rate) / determinant
    return p_n, (d_nt * normal_rate - d_nn * tangential_rate) / determinant


@final
@dataclass(frozen=True)
class LagrangeStick(MultiplierLaw):
    """Lagrange multiplier with set-valued Coulomb friction, eqs. 60-66 of the paper in a consistent form.

    An impact tries stick, p = -D^-1 (gap rate, slip), and keeps it inside the cone; otherwise it slips in the
    direction that is left. An approach has exactly one such answer. The rotor is part of the Delassus matrix,
    which is what eliminating it into M_stick = M + (J/R^2) G_t' G_t does, and the stick force carries load
    torque and rotor damping (eqs. 62-63 drop them; the sign(v_T) of eqs. 63-66 would let the mass lose
    definiteness and the stick create energy).
    The impact may stick; in time stepping it is one step, and its peak force is impulse / step.
    """

    name = "lagrange_stick"
    equation = "g = 0, N >= 0, |F| <= mu N, F = -mu N sign(v) where v != 0"
    source = "Andersen, Blanke and Helbo (2001), eqs. 60-66"
    validity = "impacts that are short against the periods of the bodies, and plastic"

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    impact = staticmethod(stick_or_slip_impulse)
