"""What is published of these laws, a function each by the law's own word."""

from math import atanh

import numpy as np
from compliant_laws import Tsuji
from frictions import SmoothCone
from rigid_laws import TurningImpact, ViscoelasticImpact

from contactlab.laws import Composed, Linear
from contactlab.testing.claim import Claims, close
from contactlab.testing.plants import block, first, last, run

MASS, SPEED, WEIGHT, SPRING, MU = 2e-3, 0.1, 10.0, 1e7, 0.3

ball = block(MASS, height=1e-6, gap_rate=-SPEED)


def rebound(law) -> float:
    """Return the restitution of the ball's first impact."""
    return first(run(ball, law, 1e-3), "separation_velocity") / SPEED


def tsuji() -> Claims:
    """A ball comes back with the restitution of alpha, at any speed (Antypov and Elliott 2011)."""
    for e in (0.8, 0.3):
        yield close(f"tsuji: restitution for {e:g}", rebound(Tsuji(restitution=e)), e, 1e-6)


def smooth_cone(share: float = 0.6) -> Claims:
    """A block under the share p of mu N creeps at v_0 artanh(p) (Andersson et al. 2007)."""
    motor = block(1.0, height=-WEIGHT / SPRING, weight=WEIGHT, push=share * MU * WEIGHT)
    made = run(motor, Composed(Linear(SPRING), friction=SmoothCone(MU, 1e-3)), 0.02, 1e-4)
    yield close("smooth_cone: creep", last(made, "slip_velocity"), 1e-3 * atanh(share), 1e-6, "m s-1")


def turning_impact(beta: float = 0.4) -> Claims:
    """A ball turns its slip by -beta, or slides with mu (1 + e) v_n (Foerster et al. 1994)."""
    law = TurningImpact(MU, 0.5, beta)
    for slip, expected in ((0.02, -beta * 0.02), (0.2, 0.2 - MU * 1.5 * SPEED)):
        thrown = block(MASS, height=1e-6, gap_rate=-SPEED, velocity=slip)
        result = last(run(thrown, law, 1.1e-5, 1e-9), "slip_velocity")
        yield close(f"turning_impact: slip after {slip:g} m/s", result, expected, 1e-9, "m s-1")


def viscoelastic_impact(loss: float = 0.5) -> Claims:
    """Each impact has e = 1 - C v^(1/5) of its own speed (Kuwabara and Kono 1987)."""
    dropped = block(1.0, height=0.05, weight=9.81)
    speeds = -run(dropped, ViscoelasticImpact(0.0, loss), 0.27, 1e-9).contacts["approach_velocity"][:3]
    for each, other in zip(speeds, np.diff(speeds), strict=False):
        yield close(
            f"viscoelastic_impact: e at {each:.3g} m/s", 1.0 + other / each, 1.0 - loss * each**0.2, 1e-6
        )
