"""A lightly damped resonator driven at resonance: what counts is how it moves, not how far it would go."""

from functools import cache
from math import pi

import numpy as np
import pytest
from support.motors import default_motor, hertz, run, total

from contactlab.engine.oscillator import impulse_integrals, response_from_rest
from contactlab.laws import LagrangeStick
from contactlab.motor.motor import Motor
from contactlab.trajectory import Trajectory

MASS_DAMPINGS = (10.0, 0.3, 0.01, 1e-4)
"""Dampings [1/s] whose steady states are a thousand to a hundred million times the static deflection."""


@cache
def resonant(mass_damping: float, voltage: float = 100.0) -> Motor:
    motor = default_motor(mass_damping=mass_damping, stiffness_damping=0.0)
    return default_motor(
        mass_damping=mass_damping,
        stiffness_damping=0.0,
        frequency=float(motor.modes.natural_frequency[0]),
        voltage_1=voltage,
        voltage_2=voltage,
    )


@cache
def ran(mass_damping: float, voltage: float = 100.0) -> Trajectory:
    return run(resonant(mass_damping, voltage), LagrangeStick(0.3))


@pytest.mark.parametrize("turns", [1e-9, 1e-4, 0.1, 0.5, 3.0])
@pytest.mark.parametrize("detuning", [-1e-2, -1e-6, 0.0, 1e-9, 1e-3])
@pytest.mark.parametrize("ratio", [0.0, 1e-9, 1e-3, 1e-2])
def test_the_answer_from_rest_is_that_of_the_power_series(
    turns: float, detuning: float, ratio: float
) -> None:
    rate = 2.0 * pi * 3210.0
    omega, damping = rate * (1.0 + detuning), 2.0 * ratio * rate
    if ratio == detuning == 0.0:
        damping = 1e-9
    time = turns / rate
    terms = 40
    integrals = np.zeros(terms + 2)
    impulse_integrals(rate**2, damping, time, terms, integrals)
    weights = (1j * omega) ** np.arange(terms)
    # The force exp(i omega s) is a sum of (i omega)^d s^d / d!, whose answers are I_(d+1) and I_d.
    q, v = weights @ integrals[2:], weights @ integrals[1:-1]
    result = response_from_rest(rate**2, damping, omega, time)
    eps = np.finfo(np.float64).eps
    assert abs(complex(*result[:2]) - q) <= 8.0 * eps * time / rate
    assert abs(complex(*result[2:]) - v) <= 8.0 * eps * max(turns, 1.0) * time


def test_the_weaker_the_damping_the_less_it_matters() -> None:
    # 5 ms are 16 periods: damping of 0.01/s takes 5e-5 of the motion in this time, and less of it less.
    reference = ran(1e-4)
    for damping, difference in ((0.3, 2e-2), (0.01, 1e-3)):
        assert ran(damping).contacts["start_time"].size == reference.contacts["start_time"].size
        for name in ("normal_impulse", "friction_impulse"):
            expected = pytest.approx(total(reference, name), rel=difference)
            assert total(ran(damping), name) == expected


@pytest.mark.parametrize("mass_damping", MASS_DAMPINGS)
def test_the_ledger_of_a_compliant_law_closes_at_resonance(mass_damping: float) -> None:
    trajectory = run(resonant(mass_damping), hertz())
    work = np.abs(trajectory.series["drive_work"]).max()
    assert np.abs(trajectory.series["energy_residual"]).max() <= 1e-8 * work
    assert trajectory.contacts["duration"].min() > 1e-9
