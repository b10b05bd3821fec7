"""Laws of a user's own that are wrong, each in its own way, and a sound one."""

from collections.abc import Callable
from dataclasses import dataclass
from math import asinh, copysign, exp, nan
from typing import Annotated, Any, ClassVar

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import RATE_DEPENDENT, MultiplierLaw, PenaltyLaw
from contactlab.laws.declaration import FRICTION_COEFFICIENT

STIFFNESS, DEPTH = 1e7, 1e-7
"""Of every compliant law [N/m], and the depth at which those change that change [m]."""


@kernel
def spring(gap, friction_coefficient):
    return -STIFFNESS * gap, -friction_coefficient * STIFFNESS * gap, 0.5 * STIFFNESS * gap * gap, 0.0


@kernel
def no_number(gap, friction_coefficient):
    force = -STIFFNESS * gap if gap > -DEPTH else nan
    return force, friction_coefficient * force, 0.5 * STIFFNESS * gap * gap, 0.0


@kernel
def negative_bound(gap, friction_coefficient):
    bound = friction_coefficient if gap > -DEPTH else -friction_coefficient
    return -STIFFNESS * gap, -bound * STIFFNESS * gap, 0.5 * STIFFNESS * gap * gap, 0.0


@kernel
def no_loss(gap, friction_coefficient):
    loss = 0.0 if gap > -DEPTH else nan
    return -STIFFNESS * gap, -friction_coefficient * STIFFNESS * gap, 0.5 * STIFFNESS * gap * gap, loss


@kernel
def dashpot(gap, gap_rate, friction_coefficient):
    # The loss is missing from the ledger; it acts at rates that the check before a run does not try.
    drag = 60.0 * gap_rate if abs(gap_rate) > 0.02 else 0.0
    force = max(-STIFFNESS * gap - drag, 0.0)
    return force, friction_coefficient * force, 0.5 * STIFFNESS * gap * gap, 0.0


@kernel
def sign_of_slip(slip, normal, friction_coefficient):
    friction = -friction_coefficient * normal * copysign(1.0, slip) if slip != 0.0 else 0.0
    return friction, 0.0, 0.0, 0.0


@kernel
def rate_and_state(slip, normal, friction_coefficient):
    # a = 0.01, v_0 = 1 um/s.
    return -0.01 * asinh(0.5e6 * slip * exp(friction_coefficient / 0.01)) * normal, 0.0, 0.0, 0.0


@kernel
def no_impulse(approach, d_nn):
    # The check before a run is slower than the motor's first approach.
    return -approach / d_nn, nan if approach < -0.011 else 0.0


@kernel
def rebound(approach, d_nn):
    # Whatever arrives leaves at 110 um/s, 60 of them after the weight of the step, and so arrives again.
    return (1.1e-4 - approach) / d_nn, 0.0


class Spring(PenaltyLaw):
    """N = k d."""

    equation: ClassVar[str] = "N = k d"
    source: ClassVar[str] = "this test"
    default_contact_step: ClassVar[float] = 4e-6


class Impulse(MultiplierLaw):
    """A rigid law."""

    equation: ClassVar[str] = "p_n"
    source: ClassVar[str] = "this test"
    default_contact_step: ClassVar[float] = 5e-8


def _law(title: str, base: type, **kernels: Callable[..., Any]) -> Any:
    """Return a law of these kernels."""
    members: dict[str, Any] = {name: staticmethod(function) for name, function in kernels.items()}
    members |= {
        "name": title,
        "__annotations__": {"friction_coefficient": Annotated[float, FRICTION_COEFFICIENT]},
    }
    members["friction_coefficient"] = 0.3
    if "friction_force" in kernels:
        members["friction_kind"] = RATE_DEPENDENT
    return dataclass(frozen=True)(type("Law", (base,), members))


Sound = _law("sound", Spring, force=spring)
NoNumber = _law("no_number", Spring, force=no_number)
NegativeBound = _law("negative_bound", Spring, force=negative_bound)
NoLoss = _law("no_loss", Spring, force=no_loss)
Unledgered = _law("unledgered", Spring, force=dashpot)
SignOfSlip = _law("sign_of_slip", Spring, force=spring, friction_force=sign_of_slip)
RateAndState = _law("rate_and_state", Spring, force=spring, friction_force=rate_and_state)
NoImpulse = _law("no_impulse", Impulse, impact=no_impulse)
Rebound = _law("rebound", Impulse, impact=rebound)
