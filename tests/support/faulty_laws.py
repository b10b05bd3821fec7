"""Laws of a user's own that are wrong, each in its own way."""

from dataclasses import dataclass
from math import asinh, copysign, exp, nan
from typing import Annotated, Any, ClassVar, final

import numpy as np

from contactlab.compiled import kernel
from contactlab.laws.base import RATE_DEPENDENT, SLIP, Kernel, MultiplierLaw, PenaltyLaw
from contactlab.laws.declaration import FRICTION_COEFFICIENT

STIFFNESS = 1e7
"""Of every compliant one [N/m]."""

DEPTH = 1e-7
"""At which those change that change [m]."""


class Spring(PenaltyLaw):
    """N = k d; what the others spoil."""

    equation: ClassVar[str] = "N = k d"
    source: ClassVar[str] = "this test"
    default_contact_step: ClassVar[float] = 4e-6


@kernel
def spring(gap: float, gap_rate: float, slip: float, parameters: np.ndarray) -> Any:
    return -STIFFNESS * gap, -parameters[0] * STIFFNESS * gap, 0.5 * STIFFNESS * gap * gap, 0.0


@kernel
def no_number(gap: float, gap_rate: float, slip: float, parameters: np.ndarray) -> Any:
    force = -STIFFNESS * gap if gap > -DEPTH else nan
    return force, parameters[0] * force, 0.5 * STIFFNESS * gap * gap, 0.0


@kernel
def negative_bound(gap: float, gap_rate: float, slip: float, parameters: np.ndarray) -> Any:
    bound = parameters[0] if gap > -DEPTH else -parameters[0]
    return -STIFFNESS * gap, -bound * STIFFNESS * gap, 0.5 * STIFFNESS * gap * gap, 0.0


@kernel
def no_loss(gap: float, gap_rate: float, slip: float, parameters: np.ndarray) -> Any:
    loss = 0.0 if gap > -DEPTH else nan
    return -STIFFNESS * gap, -parameters[0] * STIFFNESS * gap, 0.5 * STIFFNESS * gap * gap, loss


@kernel
def dashpot(gap: float, gap_rate: float, slip: float, parameters: np.ndarray) -> Any:
    # What the dashpot takes is kept from the ledger; it acts at rates that are not tried before a run.
    drag = 60.0 * gap_rate if abs(gap_rate) > 0.02 else 0.0
    force = max(-STIFFNESS * gap - drag, 0.0)
    return force, parameters[0] * force, 0.5 * STIFFNESS * gap * gap, 0.0


@kernel
def sign_of_slip(slip: float, normal: float, parameters: np.ndarray) -> Any:
    friction = -parameters[0] * normal * copysign(1.0, slip) if slip != 0.0 else 0.0
    return friction, 0.0, 0.0, 0.0


@kernel
def rate_and_state(slip: float, normal: float, parameters: np.ndarray) -> Any:
    # a = 0.01, v_0 = 1 um/s.
    grip = exp(parameters[0] / 0.01)
    friction = -0.01 * asinh(0.5e6 * slip * grip) * normal
    return friction, 0.0, 0.0, 0.0


@kernel
def no_impulse(
    normal_rate: float,
    tangential_rate: float,
    gap_rate: float,
    slip: float,
    d_nn: float,
    d_nt: float,
    d_tt: float,
    parameters: np.ndarray,
) -> Any:
    # What a law is asked before it runs is slower than the motor's first approach.
    return -normal_rate / d_nn, nan if gap_rate < -0.011 else 0.0, SLIP


@kernel
def rebound(
    normal_rate: float,
    tangential_rate: float,
    gap_rate: float,
    slip: float,
    d_nn: float,
    d_nt: float,
    d_tt: float,
    parameters: np.ndarray,
) -> Any:
    # Whatever arrives leaves at 60 um/s, and so arrives again.
    return (6e-5 - normal_rate) / d_nn if gap_rate < 0.0 else 0.0, 0.0, SLIP


def _penalty(title: str, normal: Kernel, friction: Kernel | None = None) -> type[PenaltyLaw]:
    """A law of these kernels."""

    @final
    @dataclass(frozen=True)
    class Law(Spring):
        name: ClassVar[str] = title
        friction_kind: ClassVar[int] = Spring.friction_kind if friction is None else RATE_DEPENDENT
        friction_coefficient: Annotated[float, FRICTION_COEFFICIENT] = 0.3

        @property
        def force(self) -> Kernel:
            return normal

        @property
        def friction_force(self) -> Kernel | None:
            return friction

    return Law


def _multiplier(title: str, impulse: Kernel) -> type[MultiplierLaw]:
    """A law of this kernel."""

    @final
    @dataclass(frozen=True)
    class Law(MultiplierLaw):
        name: ClassVar[str] = title
        equation: ClassVar[str] = "p_n"
        source: ClassVar[str] = "this test"
        default_contact_step: ClassVar[float] = 5e-8

        @property
        def solve(self) -> Kernel:
            return impulse

    return Law


Sound = _penalty("sound", spring)
NoNumber = _penalty("no_number", no_number)
NegativeBound = _penalty("negative_bound", negative_bound)
NoLoss = _penalty("no_loss", no_loss)
Unledgered = _penalty("unledgered", dashpot)
SignOfSlip = _penalty("sign_of_slip", spring, sign_of_slip)
RateAndState = _penalty("rate_and_state", spring, rate_and_state)
NoImpulse = _multiplier("no_impulse", no_impulse)
Rebound = _multiplier("rebound", rebound)
