"""Viscous friction beside any friction, and a dashpot along Mindlin's spring, against closed forms."""

from math import log, pi, sqrt

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st
from numpy.testing import assert_allclose

import contactlab as cl
from contactlab.motor.bodies import way_of
from contactlab.testing.plants import block, run

STIFFNESS, WEIGHT, MU = 1e7, 10.0, 0.3
DEPTH = WEIGHT / STIFFNESS
PERIOD = 1e-3
TIME = np.linspace(0.0, PERIOD, 401)[:-1]
TURN = 2.0 * pi / PERIOD


def driven(friction: cl.Friction, sigma: float | None, swing: float, cycles: int = 1) -> cl.Solution:
    """A loop of friction under a constant gap."""
    law = cl.Composed(cl.Linear(STIFFNESS), friction=friction, viscous_friction=sigma)
    way = swing * np.sin(TURN * TIME)
    return cl.drive(law, TIME, gap=-DEPTH, slip=way, degree=7, period=PERIOD, duration=cycles * PERIOD)


@pytest.mark.parametrize("name", cl.law_names("friction"))
def test_it_adds_sigma_v_to_every_friction(name: str) -> None:
    """F - F_f = -sigma_2 v, whose loss in a cycle is sigma_2 pi omega X^2."""
    law = cl.law("composed", friction=name)
    assert isinstance(law, cl.Composed)
    kind = type(law.friction)
    sigma, swing = 40.0, 1e-6
    plain, viscous = (driven(kind(), each, swing) for each in (None, sigma))
    rate = np.diff(swing * np.sin(TURN * plain["time"].values)) / np.diff(plain["time"].values)
    beside = viscous["friction_force"].values[1:] - plain["friction_force"].values[1:]
    assert_allclose(beside, -sigma * rate, rtol=0.0, atol=1e-10 * WEIGHT)
    loss = float(viscous["friction_loss"][-1] - plain["friction_loss"][-1])
    assert_allclose(loss, sigma * pi * TURN * swing**2, rtol=1e-10)
    assert abs(float(viscous["energy_residual"][-1])) < 1e-11 * loss


@settings(max_examples=10)
@example(20.0, 0.1, 0.0)
@given(st.floats(1.0, 100.0), st.floats(0.01, 0.1), st.floats(1e-3, 0.5))
def test_a_sliding_block_comes_to_rest(sigma: float, speed: float, mu: float) -> None:
    """m dv/dt = -mu W - sigma_2 v: v = (v_0 + v_w) exp(-t/T) - v_w with T = m/sigma_2, v_w = mu W/sigma_2."""
    mass = 1.0
    law = cl.Composed(cl.Linear(STIFFNESS), friction=cl.Coulomb(mu), viscous_friction=sigma)
    decay, wall = mass / sigma, mu * WEIGHT / sigma
    rest = decay * log(1.0 + speed / wall) if mu > 0.0 else np.inf
    until = min(1.5 * rest, 2.0 * decay)
    made = run(
        block(mass, height=-DEPTH, velocity=speed, weight=WEIGHT), law, until, record_interval=until / 64
    )
    time, slip = made.time, made.series["slip_velocity"]
    expected = np.where(time < rest, (speed + wall) * np.exp(-time / decay) - wall, 0.0)
    assert_allclose(slip, expected, rtol=0.0, atol=1e-8 * speed)


def damped(time: np.ndarray, omega: float, ratio: float, push: float) -> np.ndarray:
    """Displacement of x'' + 2 ratio omega x' + omega^2 x = push from rest."""
    turn = omega * sqrt(1.0 - ratio**2)
    swing = np.cos(turn * time) + ratio * omega / turn * np.sin(turn * time)
    return push / omega**2 * (1.0 - np.exp(-ratio * omega * time) * swing)


@pytest.mark.parametrize("friction", [cl.Coulomb(0.0), cl.Mindlin(MU, 0.5)], ids=lambda part: part.name)
def test_it_damps_what_swings(friction: cl.Friction) -> None:
    """A block on a spring over a contact without friction, or held by Mindlin's spring."""
    mass, sigma, push = 1.0, 500.0, 0.2 * MU * WEIGHT
    elastic = friction.name == "mindlin"
    stiffness = 0.5 * STIFFNESS if elastic else 4e6
    law = cl.Composed(cl.Linear(STIFFNESS), friction=friction, viscous_friction=sigma)
    plant = block(mass, height=-DEPTH, weight=WEIGHT, push=push, stiffness=0.0 if elastic else stiffness)
    made = run(plant, law, 5e-3, record_interval=5e-5)
    omega = sqrt(stiffness / mass)
    expected = damped(made.time, omega, 0.5 * sigma / omega, push / mass)
    assert_allclose(way_of(made.series["tip_slope"]), expected, rtol=0.0, atol=2e-8 * push / stiffness)


def test_the_spring_alone_is_held_by_the_cone() -> None:
    """Pushed beyond the cone, a block ends at sigma_2 v = P - mu W, and its spring at mu W/k."""
    sigma, push = 200.0, 2.5 * MU * WEIGHT
    law = cl.Composed(cl.Linear(STIFFNESS), friction=cl.Mindlin(MU, 0.5), viscous_friction=sigma)
    made = run(block(1.0, height=-DEPTH, weight=WEIGHT, push=push), law, 0.2, record_interval=1e-3)
    assert_allclose(made.series["slip_velocity"][-1], (push - MU * WEIGHT) / sigma, rtol=1e-9)
    assert_allclose(made.series["internal_stretch"][-1], MU * WEIGHT / (0.5 * STIFFNESS), rtol=1e-9)
    assert_allclose(made.series["friction_force"][-1], -push, rtol=1e-9)


def test_a_dashpot_along_the_spring_damps_what_the_contact_holds() -> None:
    mass, tau, push = 1.0, 1e-4, 0.2 * MU * WEIGHT
    law = cl.Composed(cl.Linear(STIFFNESS), friction=cl.Mindlin(MU, 0.5, viscous_time=tau))
    made = run(block(mass, height=-DEPTH, weight=WEIGHT, push=push), law, 5e-3, record_interval=5e-5)
    omega = sqrt(0.5 * STIFFNESS / mass)
    expected = damped(made.time, omega, 0.5 * tau * omega, push / mass)
    assert_allclose(way_of(made.series["tip_slope"]), expected, rtol=0.0, atol=2e-8 * push / omega**2)


@pytest.mark.parametrize("tau", [1e-6, 3e-5, 1e-3])
def test_a_slider_relaxes_within_the_viscous_time(tau: float) -> None:
    """At a slip v the spring, from t_1 = max(Z/v - tau, 0), has z = Z - min(tau v, Z) exp(-(t - t_1)/tau)."""
    speed, stiffness = 1e-2, 0.5 * STIFFNESS
    most = MU * WEIGHT / stiffness
    law = cl.Composed(cl.Linear(STIFFNESS), friction=cl.Mindlin(MU, 0.5, viscous_time=tau))
    time = np.array([0.0, 4e-4])
    made = cl.drive(law, time, gap=-DEPTH, slip=speed * time, degree=1, record_interval=4e-6)
    moment = made["time"].values
    begins = max(most / speed - tau, 0.0)
    slid = most - min(tau * speed, most) * np.exp(-(moment - begins) / tau)
    expected = np.where(moment < begins, speed * moment, slid)
    assert_allclose(made["internal_stretch"], expected, rtol=0.0, atol=1e-8 * most)
    assert_allclose(made["friction_force"][moment > begins + 4e-6], -MU * WEIGHT, rtol=1e-8)


def test_the_dashpot_of_a_spring_that_holds_loses_its_share_of_a_cycle() -> None:
    """pi tau k omega X^2, where k X sqrt(1 + (tau omega)^2) is below mu N."""
    tau, swing = 5e-5, 2e-7
    made = driven(cl.Mindlin(MU, 0.5, viscous_time=tau), None, swing)
    assert_allclose(made["friction_loss"][-1], pi * tau * 0.5 * STIFFNESS * TURN * swing**2, rtol=1e-9)
