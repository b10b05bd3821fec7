"""Impacts whose outcome is known in closed form."""

from collections.abc import Iterator
from math import atan2, exp, pi, sqrt

import numpy as np
from scipy.special import gamma

from contactlab.engine.plant import delassus, plant_of
from contactlab.laws import (
    ContactLaw,
    HertzPenalty,
    LagrangeSlip,
    LagrangeStick,
    MoreauJean,
    Newton,
    Poisson,
    Stronge,
)
from contactlab.motor.geometry import contact_frame
from contactlab.motor.motor import Motor
from contactlab.testing.claim import Claim, close
from contactlab.testing.laws import SpringDashpot, TensileDashpot
from contactlab.testing.plants import block, coupled_body
from contactlab.testing.runs import first, run
from contactlab.trajectory import Trajectory

INSTANT = 1e-12
"""Contact step [s] at which a rigid impact is one."""

RESTITUTIONS = (Newton, Poisson, Stronge, MoreauJean)
"""Laws with friction and restitution; collinear impacts do not tell one from the other."""


def restitution(trajectory: Trajectory) -> float:
    """Separation over approach of the first contact."""
    return -first(trajectory, "separation_velocity") / first(trajectory, "approach_velocity")


def hertz_impact(
    mass: float = 2e-3, speed: float = 0.4, stiffness: float = 1e10
) -> Iterator[Claim]:
    """A ball against a Hertz contact (Johnson 1985, sec. 11.4).

    d_max = (5 m v^2 / 4 K)^(2/5), duration 2 (d_max/v) int_0^1 dx / sqrt(1 - x^(5/2))
    """
    law = HertzPenalty(stiffness, 0.0)
    depth = (1.25 * mass * speed**2 / stiffness) ** 0.4
    # The integral is sqrt(pi) Gamma(7/5) / Gamma(9/10) = 1.471640...
    duration = 2.0 * depth / speed * sqrt(pi) * gamma(1.4) / gamma(0.9)
    trajectory = run(block(mass, height=1e-6, gap_rate=-speed), law, 1e-6 / speed + 2.0 * duration)
    peak = stiffness * depth**1.5
    for name, expected, units in (
        ("max_penetration", depth, "m"),
        ("peak_normal_force", peak, "N"),
        ("duration", duration, "s"),
        ("normal_impulse", 2.0 * mass * speed, "N s"),
    ):
        words = f"Hertz impact: {name.replace('_', ' ')}"
        yield close(words, first(trajectory, name), expected, 1e-6, units=units)
    yield close("Hertz impact: restitution", restitution(trajectory), 1.0, 1e-9)


def dashpot_impacts(mass: float = 1e-2, speed: float = 0.5, ratio: float = 0.3) -> Iterator[Claim]:
    """A ball against a spring and dashpot of damping ratio z, released at F = 0 or at d = 0.

    e = exp[-(b/w)(pi - atan2(2 b w, w^2 - b^2))] or exp(-pi b/w),  b = z w0, w = w0 sqrt(1 - z^2)
    """
    stiffness = 1e7
    rate = sqrt(stiffness / mass)
    b, w = ratio * rate, rate * sqrt(1.0 - ratio**2)
    damping = 2.0 * b * mass
    ball = block(mass, height=1e-6, gap_rate=-speed)
    duration = 1e-6 / speed + 2.0 * pi / w
    pushed = run(ball, SpringDashpot(stiffness, damping), duration)
    angle = pi - atan2(2.0 * b * w, w * w - b * b)
    expected = exp(-b / w * angle)
    yield close(
        "spring and dashpot released at N = 0: restitution",
        restitution(pushed),
        expected,
        1e-6,
        scale=1.0,
    )
    pulled = run(ball, TensileDashpot(stiffness, damping), duration)
    yield close(
        "spring and dashpot released at d = 0: restitution",
        restitution(pulled),
        exp(-pi * b / w),
        1e-6,
        scale=1.0,
    )
    yield close(
        "spring and dashpot released at d = 0: duration",
        first(pulled, "duration"),
        pi / w,
        1e-6,
        units="s",
    )


def oblique_impacts(mass: float = 0.1, speed: float = 0.2, mu: float = 0.3) -> Iterator[Claim]:
    """A ball at a slant: dv_t = -sign(v_t) min(|v_t|, mu (1 + e) v_n); slip-only takes no min."""
    laws: tuple[tuple[ContactLaw, float, float | None], ...] = (
        (HertzPenalty(1e10, mu), 1.0, None),
        (LagrangeStick(mu), 0.0, INSTANT),
        *((law(mu, 0.5), 0.5, INSTANT) for law in RESTITUTIONS),
        (LagrangeSlip(mu), 0.0, INSTANT),
    )
    for law, e, step in laws:
        kick = mu * (1.0 + e) * speed
        for sideways, word in ((5.0 * kick, "slips"), (-0.4 * kick, "ends the slip")):
            ball = block(mass, height=1e-6, gap_rate=-speed, velocity=sideways)
            duration = 1e-6 / speed + 2e-3 if step is None else 1e-6 / speed + 10.0 * step
            trajectory = run(ball, law, duration, step)
            taken = kick if isinstance(law, LagrangeSlip) else min(abs(sideways), kick)
            yield close(
                f"oblique impact that {word}, {law.name}: slip after it",
                float(trajectory.series["slip_velocity"][-1]),
                sideways - np.sign(sideways) * taken,
                1e-9,
                scale=abs(sideways),
                units="m s-1",
            )


def modal_impacts(seed: int = 1) -> Iterator[Claim]:
    """A body of coupled modes against a rotor: p_n = (1 + e) m_eff v, loss (1 - e^2) m_eff v^2 / 2.

    m_eff = 1/(G M^-1 G'), frictionless; with stick, loss = v' D^-1 v / 2 with v = (gdot, slip).
    """
    motor = coupled_body(seed)
    laws: tuple[tuple[ContactLaw, float], ...] = (
        (LagrangeStick(0.0), 0.0),
        (LagrangeSlip(0.0), 0.0),
        *((law(0.0, 0.6), 0.6) for law in RESTITUTIONS),
    )
    plant = plant_of(motor)
    _, n_u, n_th, t_u, t_th = contact_frame(
        0.0, 0.0, plant.geometry.tip_length, plant.geometry.radius, 0.0
    )
    d_nn, d_nt, d_tt = delassus(plant, n_u, n_th, t_u, t_th)
    for law, e in laws:
        struck = strike(motor, law)
        speed = first(struck, "approach_velocity")
        words = f"modal impact, e = {e:g}, {law.name}"
        impulse, loss = -(1.0 + e) * speed / d_nn, 0.5 * (1.0 - e * e) * speed**2 / d_nn
        found = first(struck, "normal_impulse")
        yield close(f"{words}: impulse", found, impulse, 1e-6, units="N s")
        found = first(struck, "energy_loss")
        yield close(f"{words}: energy loss", found, loss, 1e-6, units="J")
    struck = strike(motor, LagrangeStick(100.0))
    slip = float(struck.series["slip_velocity"][0])
    velocity = np.array([first(struck, "approach_velocity"), slip])
    lost = 0.5 * velocity @ np.linalg.solve([[d_nn, d_nt], [d_nt, d_tt]], velocity)
    yield close(
        "modal impact that sticks, lagrange_stick: energy loss",
        first(struck, "energy_loss"),
        float(lost),
        1e-6,
        units="J",
    )


def strike(motor: Motor, law: ContactLaw) -> Trajectory:
    """The run that ends with its first impact."""
    touch = first(run(motor, law, 1e-8, INSTANT), "start_time")
    return run(motor, law, touch + INSTANT, INSTANT)


def bouncing_ball(height: float = 0.05, e: float = 0.5, gravity: float = 9.81) -> Iterator[Claim]:
    """A ball that is dropped comes to rest at sqrt(2 h/g) (1 + e)/(1 - e), after any number of bounces."""
    fall = sqrt(2.0 * height / gravity)
    rest = fall * (1.0 + e) / (1.0 - e)
    ball = block(1.0, height=height, weight=gravity)
    for law in RESTITUTIONS:
        trajectory = run(ball, law(0.0, e), rest + 1e-5, 1e-9)
        words = f"bouncing ball, {law.name}"
        yield close(
            f"{words}: time of the first bounce",
            first(trajectory, "start_time"),
            fall,
            1e-12,
            units="s",
        )
        yield close(
            f"{words}: time at which it rests",
            float(trajectory.contacts["start_time"][-1]),
            rest,
            1e-6,
            units="s",
        )
        yield close(
            f"{words}: height at rest",
            float(trajectory.series["gap"][-1]),
            0.0,
            1e-12,
            scale=height,
        )


CLAIMS = (
    hertz_impact,
    dashpot_impacts,
    oblique_impacts,
    modal_impacts,
    bouncing_ball,
)
