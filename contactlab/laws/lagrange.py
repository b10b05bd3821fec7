"""The paper's laws: a rigid contact that always slips, and one that slips or sticks."""

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, final

from contactlab.compiler.kernels import inner_kernel, kernel
from contactlab.laws.base import SLIP, STICK, MultiplierLaw
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
    def solve(normal_rate, slip, d_nn, d_nt, friction_coefficient):
        mu = friction_coefficient
        s = 1.0 if slip > 0.0 else -1.0 if slip < 0.0 else 0.0
        if d_nn <= s * mu * d_nt:
            # No slip meets an approach; what opens by itself is released.
            return -abs(normal_rate) / d_nn, 0.0, SLIP
        return slip_impulse(normal_rate, s, mu, d_nn, d_nt)


@kernel
def stick_or_slip_impulse(normal_rate, tangential_rate, slip, d_nn, d_nt, d_tt, friction_coefficient):
    """Return impulses [N s] and mode; arguments as in `MultiplierLaw.solve`.

    One approaching contact (normal rate < 0) has exactly one answer, for any positive definite D and
    any mu: with p = -D^-1 (normal rate, tangential rate) of stick outside of the cone,

        slip s = +-1:  p_n = -normal rate / (d_nn - s mu d_nt),  p_t = -s mu p_n
        leaves a slip of sign s where  d_nn > s mu d_nt  and  -s p_t >= mu p_n of stick.

    So s opposes the friction that stick would take; where slip that way would press the bodies together
    ever more (d_nn <= s mu d_nt), it is the other one. One that opens by itself (normal rate >= 0) is
    released, p_n <= 0, unless stick is consistent, too: see `wedges`.
    """
    mu = friction_coefficient
    p_n, p_t = stick_impulse(normal_rate, tangential_rate, d_nn, d_nt, d_tt)
    # Not strict: on the cone's surface the contact still sticks.
    if abs(p_t) <= mu * p_n and (normal_rate < 0.0 or abs(slip) <= abs(tangential_rate - slip)):
        return p_n, p_t, STICK
    s = -1.0 if p_t > 0.0 else 1.0 if p_t < 0.0 else 0.0
    if d_nn <= s * mu * d_nt:
        s = -s
    return slip_impulse(normal_rate, s, mu, d_nn, d_nt)


@inner_kernel
def slip_impulse(normal_rate, s, mu, d_nn, d_nt):
    """Return the impulses [N s] that leave no gap rate in a slip of the sign s, and the mode."""
    p_n = -normal_rate / (d_nn - s * mu * d_nt)
    return p_n, -s * mu * p_n, SLIP


@inner_kernel
def stick_impulse(normal_rate, tangential_rate, d_nn, d_nt, d_tt):
    """Return the impulses [N s] that leave neither gap rate nor slip, whatever their signs."""
    determinant = d_nn * d_tt - d_nt * d_nt
    p_n = (d_nt * tangential_rate - d_tt * normal_rate) / determinant
    return p_n, (d_nt * normal_rate - d_nn * tangential_rate) / determinant


@inner_kernel
def wedges(
    normal_rate: float, tangential_rate: float, d_nn: float, d_nt: float, d_tt: float, mu: float
) -> bool:
    """Return whether a contact that opens by itself is held by its own friction, if it once is (Painleve).

    Friction presses the bodies together more than the normal impulse parts them, mu |d_nt| > d_nn, and
    release, stick and a slip between the two all obey the law. None of them creates energy. The slip is no
    limit of a compliant contact: a little more force presses more, a little less releases. Release is the
    limit of one that slides, for it touches with no force; stick is that of one that stuck. The kernel
    knows which by the slip of the step's start: what the forces of this one step outweigh is none.

    Source: Painleve (1895), C. R. Acad. Sci. 121, 112; Genot and Brogliato (1999), Eur. J. Mech. A 18, 653.
    """
    p_n, p_t = stick_impulse(normal_rate, tangential_rate, d_nn, d_nt, d_tt)
    return bool(normal_rate >= 0.0 and p_n > 0.0 and abs(p_t) <= mu * p_n)


@final
@dataclass(frozen=True)
class LagrangeStick(MultiplierLaw):
    """Lagrange multiplier with set-valued Coulomb friction, eqs. 60-66 of the paper in a consistent form.

    Each step tries stick, p = -D^-1 (normal rate, tangential rate), and keeps it inside the cone;
    otherwise it slips in the direction that is left at the end of the step. An approach has exactly one
    such answer; where friction may hold together what opens (`wedges`) it releases what slides and
    holds what stuck. The rotor is part of the Delassus matrix, which is what eliminating it into
    M_stick = M + (J/R^2) G_t' G_t does, and the stick force carries load torque and rotor damping
    (eqs. 62-63 drop them; the sign(v_T) of eqs. 63-66 would let the mass lose definiteness and the
    stick create energy).
    The impact may stick; in time stepping it is one step, and its peak force is impulse / step.
    """

    name = "lagrange_stick"
    equation = "g = 0, N >= 0, |F| <= mu N, F = -mu N sign(v) where v != 0"
    source = "Andersen, Blanke and Helbo (2001), eqs. 60-66"

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    solve = staticmethod(stick_or_slip_impulse)
