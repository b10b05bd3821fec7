"""Small plants do what their equations say, and need nothing but themselves."""

from collections.abc import Callable
from math import pi, sqrt
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.interpolate import PPoly

import contactlab as cl
from contactlab.motor.bodies import way_of


def test_a_ball_that_falls_bounces_to_the_square_of_its_restitution() -> None:
    height, e = 0.01, 0.8
    fall = sqrt(2.0 * height / 9.81)
    run = cl.simulate(cl.ball(0.1, height=height), cl.Newton(0.0, e), duration=3.0 * fall)
    assert_allclose(run.contacts.start_time[0], fall, rtol=1e-9)
    assert_allclose(run.contacts.separation_velocity[0], e * 9.81 * fall, rtol=1e-6)
    assert_allclose(run["gap"].where(run["time"] > 1.1 * fall).max(), e**2 * height, rtol=1e-4)


@pytest.mark.parametrize("gyration", [0.4, 2.0 / 3.0])
def test_a_spinning_ball_that_grips_rolls_on(gyration: float) -> None:
    motor = cl.ball(1e-3, speed=0.1, velocity=0.02, spin=0.03, gyration=gyration, gravity=0.0)
    run = cl.simulate(motor, cl.LagrangeStick(friction_coefficient=0.9), duration=1e-5, record_interval=1e-6)
    assert_allclose(run["slip_velocity"][0], 0.05, rtol=1e-12)
    assert_allclose(run["slip_velocity"][-1], 0.0, atol=1e-15)
    # Of the slip the centre gives its share by mass, the rotation the rest.
    slip_taken = 0.05 * 1e-3 / (1.0 + 1.0 / gyration)
    assert_allclose(-run.contacts.friction_impulse.sum(), slip_taken, rtol=1e-9)


def test_an_oscillator_swings_as_its_equation_says_until_the_stop() -> None:
    mass, stiffness, gap, start = 2.0, 800.0, 1e-3, -2e-3
    omega = sqrt(stiffness / mass)
    motor = cl.oscillator(mass, stiffness, gap=gap, displacement=start)
    run = cl.simulate(motor, cl.Newton(0.0, 0.5), duration=0.15, record_interval=1e-4)
    touch = (pi - np.arccos(0.5)) / omega
    assert_allclose(run.contacts.start_time[0], touch, rtol=1e-9)
    assert_allclose(run.contacts.approach_velocity[0], start * omega * sqrt(0.75), rtol=1e-9)
    before = run["time"].values < touch
    way = run["tip_normal_displacement"].values[before]
    assert_allclose(way, start * np.cos(omega * run["time"].values[before]), atol=1e-12)


def test_a_driven_oscillator_has_the_force_that_was_asked_for() -> None:
    motor = cl.oscillator(2.0, 800.0, damping=0.4, gap=1.0, force=3.0, frequency=2.0)
    run = cl.simulate(motor, cl.Newton(), duration=0.01, record_interval=1e-3)
    # From rest, before the spring knows: F t^2 / 2 m.
    assert_allclose(run["tip_normal_displacement"][-1], 3.0 * 0.01**2 / 4.0, rtol=1e-2)


def test_a_mass_on_a_belt_sticks_until_its_spring_tears_it_off() -> None:
    mass, stiffness, weight, mu, speed = 1.0, 1e3, 10.0, 0.3, 0.05
    motor = cl.belt(mass, stiffness, weight=weight, belt_velocity=speed, velocity=speed)
    run = cl.simulate(motor, cl.LagrangeStick(mu), duration=0.08, contact_step=1e-5, record_interval=1e-4)
    tears = mu * weight / stiffness / speed
    sticks = run["time"].values < 0.99 * tears
    assert_allclose(way_of(run["tip_slope"].values)[sticks], speed * run["time"].values[sticks], atol=1e-9)
    assert_allclose(run["friction_force"].max(), mu * weight, rtol=1e-6)
    assert (run["slip_velocity"].values[run["time"].values > 1.05 * tears] < 0.0).all()
    assert abs(float(run["energy_residual"][-1])) < 1e-5


def test_a_cantilever_has_the_textbooks_modes() -> None:
    length, thickness, steel = 0.1, 1e-3, cl.Steel()
    motor = cl.cantilever(length, 0.01, thickness, modes=20)
    unit = sqrt(steel.youngs_modulus * thickness**2 / (12.0 * steel.density)) / length**2 / (2.0 * pi)
    result = motor.modes.natural_frequency / unit
    assert_allclose(result[:4], [3.51602, 22.0345, 61.6972, 120.902], rtol=1e-5)
    # Under a force at its end L^3 / 3 E I; the slope L^2 / 2 E I, of which modes beyond n have 0.13 / n^2.
    modes, rigidity = motor.modes, steel.youngs_modulus * 0.01 * thickness**3 / 12.0
    deflection = (modes.tip_displacement**2 / modes.stiffness).sum()
    slope = (modes.tip_displacement * modes.tip_slope / modes.stiffness).sum()
    assert_allclose(deflection, length**3 / (3.0 * rigidity), rtol=1e-4)
    assert_allclose(slope, length**2 / (2.0 * rigidity), rtol=1e-3)
    # A clamp that is shaken slowly bends it as its weight would: L^4 rho A / 8 E I.
    bent = -(modes.tip_displacement * modes.coupling[:, 0] / modes.stiffness).sum()
    assert_allclose(bent, steel.density * 0.01 * thickness * length**4 / (8.0 * rigidity), rtol=1e-6)


@pytest.mark.parametrize(
    ("make", "key"),
    [
        (lambda: cl.ball(0.0), "mass"),
        (lambda: cl.ball(gyration=-1.0), "gyration"),
        (lambda: cl.belt(1.0, belt_mass=0.0), "belt_mass"),
        (lambda: cl.cantilever(modes=0), "modes"),
        (lambda: cl.cantilever(thickness=np.inf), "thickness"),
    ],
)
def test_a_body_of_impossible_dimensions_is_refused(make: Callable[[], cl.Motor], key: str) -> None:
    with pytest.raises(ValueError, match=key):
        make()


def loaded(*velocity: float, until: tuple[float, ...], start: float = 0.0) -> cl.Waveform:
    """A load point with velocities from time to time."""
    return cl.Waveform(PPoly(np.array(velocity)[None, :, None], np.array([0.0, *until])), start=start)


def test_a_load_point_that_goes_is_a_belt_that_comes() -> None:
    speed, law, duration = 0.01, cl.LagrangeStick(friction_coefficient=0.3), 1.0
    comes = cl.block(weight=10.0, stiffness=1e3, belt_velocity=-speed, velocity=-speed)
    goes = cl.block(weight=10.0, stiffness=1e3, load_velocity=loaded(speed, until=(duration,)))
    runs = [cl.simulate(motor, law, duration=duration, record_interval=1e-3) for motor in (comes, goes)]
    assert {1, 2} <= set(runs[1]["contact_mode"].values.tolist())
    assert_allclose(runs[1]["friction_force"], runs[0]["friction_force"], rtol=0.0, atol=1e-9)


def test_what_sticks_is_drawn_by_the_spring_to_where_its_load_point_rests() -> None:
    stiffness, velocity = 1e3, loaded(2e-3, -1e-3, until=(1.0, 1.5), start=0.25)
    motor = cl.block(weight=10.0, stiffness=stiffness, load_velocity=velocity)
    run = cl.simulate(motor, cl.LagrangeStick(0.3), duration=2.0, record_interval=1e-3)
    time = run["time"].values + 0.25
    way = np.interp(time, [0.0, 1.0, 1.5], [0.0, 2e-3, 1.5e-3])
    # Means over the record interval, which the corners do not cut.
    assert_allclose(run["friction_force"][1:], -stiffness * 0.5 * (way[1:] + way[:-1]), rtol=1e-9)
    assert abs(run["energy_residual"]).max() < 1e-12


def test_steps_of_the_load_velocity_lead_rate_and_state_from_one_steady_friction_to_the_next() -> None:
    law = cl.Composed(cl.Linear(1e9), friction=cl.RateAndState(0.6))
    slow, fast, ways = 1e-5, 1e-4, 2e-5
    velocity = loaded(slow, fast, until=(ways / slow, ways / slow + ways / fast))
    motor = cl.block(weight=10.0, height=-1e-8, stiffness=1e6, load_velocity=velocity)
    run = cl.simulate(motor, law, duration=float(velocity.pieces.x[-1]), record_interval=1e-3)
    part = law.friction
    steady = 0.6 + (part.direct_effect - part.evolution_effect) * np.log(
        np.array([slow, fast]) / part.reference_velocity
    )
    coefficient = -run["friction_force"].sel(time=velocity.pieces.x[1:], method="nearest") / 10.0
    assert_allclose(coefficient, steady, rtol=1e-5)


@pytest.mark.parametrize(
    ("key", "changes"),
    [
        ("stiffness", {"stiffness": 0.0}),
        ("periodic", {"load_velocity": cl.Waveform(PPoly(np.ones((1, 1, 1)), [0.0, 1.0]), periodic=True)}),
        ("load_velocity", {"load_velocity": cl.Waveform(PPoly(np.ones((1, 1, 2)), [0.0, 1.0]))}),
    ],
)
def test_a_load_point_without_a_spring_or_a_way_is_refused(key: str, changes: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=key):
        cl.block(**{"stiffness": 1.0, "load_velocity": loaded(1.0, until=(1.0,)), **changes})
