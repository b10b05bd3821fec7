"""What is published of these laws, a function each by the law's own word."""

from math import atanh, exp, pi, sqrt

import numpy as np
from compliant_laws import KelvinVoigt, Power, Tsuji
from frictions import SmoothCone, SolidFriction, Tustin
from rigid_laws import TurningImpact, ViscoelasticImpact

from contactlab.laws import Composed, Linear
from contactlab.testing.claim import Claims, close
from contactlab.testing.plants import HEAVY, block, first, last, run

MASS, SPEED, WEIGHT, SPRING, MU = 2e-3, 0.1, 10.0, 1e7, 0.3

ball = block(MASS, height=1e-6, gap_rate=-SPEED)


def rebound(law) -> float:
    """Give the restitution of the ball's first impact."""
    return first(run(ball, law, 1e-3), "separation_velocity") / SPEED


def dragged(friction, speed: float, way: float):
    """Drag a body that nothing disturbs over a way from rest of the contact [m]; the end of the run."""
    body = block(HEAVY, height=-WEIGHT / SPRING, weight=WEIGHT, velocity=speed)
    return run(body, Composed(Linear(SPRING), friction=friction), way / speed, 1e-4, 0.01 * way / speed)


def power(exponent: float = 2.5) -> Claims:
    """A ball goes in until P d^(n + 1) / ((n + 1) d_0^n) is its energy (Johnson 1985, sec. 11.4)."""
    found = first(run(ball, Composed(Power(10.0, 1e-6, exponent)), 1e-3), "max_penetration")
    expected = 1e-6 * (0.5 * MASS * SPEED**2 * (exponent + 1.0) / 10.0e-6) ** (1.0 / (exponent + 1.0))
    yield close("power: largest depth", found, expected, 1e-6, "m")


def kelvin_voigt(ratio: float = 0.1) -> Claims:
    """A ball comes back with e = exp(-pi z / sqrt(1 - z^2)), z the ratio of damping (Goldsmith 1960)."""
    law = KelvinVoigt(SPRING, 2.0 * ratio * sqrt(MASS * SPRING))
    yield close("kelvin_voigt: restitution", rebound(law), exp(-pi * ratio / sqrt(1.0 - ratio**2)), 1e-6)


def tsuji() -> Claims:
    """A ball comes back with the restitution of alpha, at any speed (Antypov and Elliott 2011)."""
    for e in (0.8, 0.3):
        yield close(f"tsuji: restitution for {e:g}", rebound(Tsuji(restitution=e)), e, 1e-6)


def tustin(speed: float = 0.02) -> Claims:
    """It drags at N (mu + (mu_s - mu) exp(-v/v_s)) in steady slip (Tustin 1947)."""
    found = -last(dragged(Tustin(MU, 1.5, 0.05), speed, 1e-4), "friction_force")
    expected = WEIGHT * MU * (1.0 + 0.5 * exp(-speed / 0.05))
    yield close("tustin: drag", found, expected, 1e-9, "N")


def solid_friction(way: float = 5e-7, sigma: float = 1e6) -> Claims:
    """After a way x from rest it is mu N X/(1 + X), X = sigma x / mu (Dahl 1968, exponent 2)."""
    found = last(dragged(SolidFriction(MU, sigma), 1e-3, way), "internal_bend")
    bent = sigma * way / MU
    yield close("solid_friction: bend after a way", found, MU / sigma * bent / (1.0 + bent), 1e-6, "m")


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
        found = last(run(thrown, law, 1.1e-5, 1e-9), "slip_velocity")
        yield close(f"turning_impact: slip after {slip:g} m/s", found, expected, 1e-9, "m s-1")


def viscoelastic_impact(loss: float = 0.5) -> Claims:
    """Each impact has e = 1 - C v^(1/5) of its own speed (Kuwabara and Kono 1987)."""
    dropped = block(1.0, height=0.05, weight=9.81)
    speeds = -run(dropped, ViscoelasticImpact(0.0, loss), 0.27, 1e-9).contacts["approach_velocity"][:3]
    for one, other in zip(speeds, np.diff(speeds), strict=False):
        yield close(
            f"viscoelastic_impact: e at {one:.3g} m/s", 1.0 + other / one, 1.0 - loss * one**0.2, 1e-6
        )
