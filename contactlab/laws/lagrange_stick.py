"""The paper's second law: a rigid contact that slips or sticks."""

from dataclasses import dataclass
from typing import Annotated, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from contactlab.compiled import kernel
from contactlab.laws.base import SLIP, STICK, MultiplierKernel, MultiplierLaw
from contactlab.laws.parameter import FRICTION_COEFFICIENT

Array = NDArray[np.float64]


@final
@dataclass(frozen=True)
class LagrangeStick(MultiplierLaw):
    """Lagrange multiplier with set-valued Coulomb friction.

        g = 0,  N >= 0,  |F| <= mu N,  slip != 0 => F = -mu N sign(slip)

    Each step tries stick, p = -D^-1 (normal rate, tangential rate), and keeps it inside the cone;
    otherwise it slips in the direction that is left at the end of the step. The rotor is part of
    the Delassus matrix, which is what eliminating it into M_stick = M + (J/R^2) G_t' G_t does,
    and the stick force carries load torque and rotor damping (eqs. 62-63 drop them; the
    sign(v_T) of eqs. 63-66 would let the mass lose definiteness and the stick create energy).
    The impact is one step and may stick; its peak force is impulse / step.

    Source: Andersen, Blanke and Helbo (2001), eqs. 60-66, in the consistent form above.

    Args:
        friction_coefficient: mu [1].
    """

    name: ClassVar[str] = "lagrange_stick"
    equation: ClassVar[str] = "g = 0, N >= 0, |F| <= mu N, F = -mu N sign(v) where v != 0"
    source: ClassVar[str] = "Andersen, Blanke and Helbo (2001), eqs. 60-66"
    default_contact_step: ClassVar[float] = 5e-8

    friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

    @property
    def solve(self) -> MultiplierKernel:
        """The kernel; see `MultiplierLaw.solve`."""
        return stick_or_slip_impulse


@kernel
def stick_or_slip_impulse(
    normal_rate: float,
    tangential_rate: float,
    gap_rate: float,
    slip: float,
    d_nn: float,
    d_nt: float,
    d_tt: float,
    parameters: Array,
) -> tuple[float, float, int]:
    """Impulses [N s] and mode; arguments as in `MultiplierLaw.solve`."""
    mu = parameters[0]
    determinant = d_nn * d_tt - d_nt * d_nt
    p_n = (d_nt * tangential_rate - d_tt * normal_rate) / determinant
    p_t = (d_nt * normal_rate - d_nn * tangential_rate) / determinant
    # Not strict: on the cone's surface the contact still sticks.
    if p_n >= 0.0 and abs(p_t) <= mu * p_n:
        return p_n, p_t, STICK
    # The slip that the frictionless impact would leave names the direction; where friction
    # couples back into the normal direction strongly the other one may be the consistent one.
    p_free = -normal_rate / d_nn
    s = 1.0 if tangential_rate + d_nt * p_free >= 0.0 else -1.0
    for _ in range(2):
        p_n = -normal_rate / (d_nn - s * mu * d_nt)
        p_t = -s * mu * p_n
        if s * (tangential_rate + d_nt * p_n + d_tt * p_t) >= 0.0:
            return p_n, p_t, SLIP
        s = -s
    p_n = -normal_rate / (d_nn - s * mu * d_nt)
    return p_n, -s * mu * p_n, SLIP
