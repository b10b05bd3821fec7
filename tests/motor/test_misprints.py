"""What the paper prints and cannot mean: each equation as printed, and why it must be read otherwise.

Misprints of the resonator (eqs. 23, 27, 28, 31, the lever of the coupling) are in `test_resonator.py`.
"""

import numpy as np
import pytest
from support.motors import case_a, run

from contactlab.engine.plant import delassus, modes_of, plant_of
from contactlab.laws import ContactLaw, HertzPenalty, LagrangeSlip, LagrangeStick
from contactlab.motor.motor import Motor
from contactlab.testing.plants import FLAT, block, impulses_of

Array = np.ndarray


def contact_rows(motor: Motor, u: float, th: float) -> tuple[Array, Array]:
    """Normal and tangential row of resonator and rotor, mass-orthonormal coordinates [kg^-1/2]."""
    plant = plant_of(motor)
    _, n_u, n_th, t_u, t_th = motor.geometry.frame(u, th)
    modes = modes_of(plant)
    u, th = modes["row_u"], modes["row_th"]
    return n_u * u + n_th * th, t_u * u + t_th * th + modes["row_r"]


def test_eq_48_without_the_radius_does_not_keep_the_angular_momentum() -> None:
    # A mass that sticks to the rotor's rim: m v R + J Omega stays.
    mass, velocity, radius, inertia = 0.01, 0.5, 25e-3, 4.8e-5
    lever = radius**2 / inertia

    def after(arm: float) -> tuple[float, float]:
        """Velocities of mass and rim after the stick impulse, with the torque's arm as a factor of F."""
        p = -velocity / (1.0 / mass + radius * arm / inertia)
        return velocity + p / mass, -radius * arm * p / inertia

    kept = mass * velocity * radius
    tip, rim = after(radius)
    assert tip == pytest.approx(rim, rel=1e-14)
    assert mass * tip * radius + inertia * rim / radius == pytest.approx(kept, rel=1e-14)
    tip, rim = after(1.0)
    assert tip == pytest.approx(rim, rel=1e-14)
    assert mass * tip * radius + inertia * rim / radius > 5.0 * kept
    # The engine has the radius: what the rotor turns is its share of the Delassus matrix.
    _, tangential = contact_rows(case_a(), 0.0, 0.0)
    assert tangential[-1] ** 2 == pytest.approx(lever, rel=1e-14)


def test_eq_51_with_mu_twice_leaves_an_approach() -> None:
    mu, gap_rate = 0.3, -0.05
    plant = plant_of(case_a())
    _, n_u, n_th, t_u, t_th = case_a().geometry.frame(0.0, 1e-4)
    d_nn, d_nt, d_tt = delassus(plant, n_u, n_th, t_u, t_th)
    law = LagrangeSlip(mu)

    def left(friction_in_eq_51: float) -> float:
        """Gap rate after an impulse from eq. 51 with this factor before its friction term."""
        p_n = -gap_rate / (d_nn - friction_in_eq_51 * d_nt)
        return gap_rate + d_nn * p_n - mu * d_nt * p_n

    assert left(mu) == pytest.approx(0.0, abs=1e-16)
    assert abs(left(mu * mu)) > 1e-5 * abs(gap_rate)
    p_n, p_t = impulses_of(law, gap_rate, 1.0, (d_nn, d_nt, d_tt))
    assert gap_rate + d_nn * p_n + d_nt * p_t == pytest.approx(0.0, abs=1e-16)


@pytest.mark.parametrize("law", [HertzPenalty(1e9, 0.5), LagrangeStick(0.5)], ids=lambda x: x.name)
def test_eq_63_must_carry_the_load_or_the_rotor_runs_away_in_stick(law: ContactLaw) -> None:
    # A block that is tied to the ground sticks to a loaded belt: the friction holds the load.
    weight, load = 10.0, 2.0
    height = -((weight / 1e9) ** (2.0 / 3.0)) if isinstance(law, HertzPenalty) else 0.0
    motor = block(1.0, height=height, weight=weight, stiffness=1e9, belt_mass=1.0)
    rotor = motor.rotor
    loaded = Motor(
        motor.modes,
        motor.drive,
        motor.geometry,
        type(rotor)(inertia=rotor.inertia, load_torque=load * FLAT),
        motor.preload,
        motor.start,
    )
    trajectory = run(loaded, law, 0.02, 0.02, 1e-6)
    mean = trajectory.contacts["friction_impulse"][0] / trajectory.contacts["duration"][0]
    # J Omegadot = -R F - tau: at rest F = -tau/R. Dropped, the belt would have gone tau t / J.
    assert mean == pytest.approx(-load, rel=0.05)
    runaway = load * 0.02
    assert abs(FLAT * trajectory.series["rotor_velocity"][-1]) < 0.01 * runaway
