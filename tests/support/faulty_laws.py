"""Laws of a user's own that are wrong, each in its own way, and a sound one."""

from math import asinh, copysign, exp, nan

from support.laws_of_kernels import law_class_of

from contactlab.compiler.kernels import kernel
from contactlab.laws.base import RATE_DEPENDENT, MultiplierLaw, PenaltyLaw

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


Sound = law_class_of(PenaltyLaw, "sound", force=spring)
NoNumber = law_class_of(PenaltyLaw, "no_number", force=no_number)
NegativeBound = law_class_of(PenaltyLaw, "negative_bound", force=negative_bound)
NoLoss = law_class_of(PenaltyLaw, "no_loss", force=no_loss)
Unledgered = law_class_of(PenaltyLaw, "unledgered", force=dashpot)
SignOfSlip = law_class_of(
    PenaltyLaw, "sign_of_slip", force=spring, friction_force=sign_of_slip, friction_kind=RATE_DEPENDENT
)
RateAndState = law_class_of(
    PenaltyLaw, "rate_and_state", force=spring, friction_force=rate_and_state, friction_kind=RATE_DEPENDENT
)
NoImpulse = law_class_of(MultiplierLaw, "no_impulse", impact=no_impulse)
Rebound = law_class_of(MultiplierLaw, "rebound", impact=rebound)
