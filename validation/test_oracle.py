"""The independent solver meets the known numbers of the motor, closed forms, and its own balances."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from oracle.composed import Judge, Parts
from oracle.friction_parts import SetValued
from oracle.motor import Mechanics, OracleMotor
from oracle.normal_parts import Jkr, Power, elliptic_stiffness, loss_number
from oracle.rigid import RigidJudge, Rough, newton
from scipy.linalg import expm

from references import HERTZ_CASE_A, RIGID_CASE_A

DURATION = 5e-3
STIFFNESS = 1e10


@pytest.mark.parametrize("mu", HERTZ_CASE_A)
def test_hertz_of_case_a_ends_where_the_reference_ends(mu: float) -> None:
    motor = OracleMotor(frequency=3210.0, friction_coefficient=mu)
    made = Judge(motor, Parts(Power(STIFFNESS, 1.5), SetValued(mu)), 1e-11).run(DURATION)
    velocity, displacement, _, impulse, duration, _ = HERTZ_CASE_A[mu]
    assert len(made.starts) == 16
    assert made.rotor_velocity == pytest.approx(velocity, abs=1e-7)
    assert made.u == pytest.approx(displacement, abs=1e-13)
    assert sum(made.normal_impulses) == pytest.approx(impulse, rel=1e-6)
    assert sum(made.durations) == pytest.approx(duration, abs=1e-10)


def test_rigid_contact_of_case_a_ends_where_the_reference_ends() -> None:
    made = RigidJudge(OracleMotor(frequency=3210.0), newton(0.3, 0.0), Rough(0.3), 1e-10).run(DURATION)
    assert len(made.starts) == 16
    result = made.rotor_velocity, sum(made.normal_impulses), sum(made.durations)
    assert result == pytest.approx([value for value, _, _ in RIGID_CASE_A.values()], rel=2e-6)


def test_friction_impulse_is_what_the_rotor_gained() -> None:
    motor = OracleMotor(load_torque=2e-3, initial_velocity=-0.9, clearance=0.0)
    for made in (
        Judge(motor, Parts(Power(STIFFNESS, 1.5), SetValued(0.3)), 1e-10).run(DURATION),
        RigidJudge(motor, newton(0.3, 0.0), Rough(0.3), 1e-10).run(DURATION),
    ):
        gained = motor.rotor_inertia * (made.rotor_velocity - motor.initial_velocity)
        outside = -motor.load_torque * DURATION
        pushed = motor.rotor_radius * sum(made.friction_impulses)
        assert gained == pytest.approx(outside - pushed, rel=1e-8)
        assert np.all(np.abs(made.friction_impulses) <= 0.3 * np.array(made.normal_impulses) * (1.0 + 1e-9))


def test_free_flight_is_the_harmonic_response_plus_the_exact_transient() -> None:
    motor = OracleMotor(clearance=1e-3, initial_velocity=0.5)
    made = Judge(motor, Parts(Power(STIFFNESS, 1.5), SetValued(0.3)), 1e-10).run(DURATION)
    mechanics, res, n = Mechanics(motor), motor.resonator(), motor.shapes
    inverse = np.linalg.inv(res.mass)
    system = np.zeros((2 * n, 2 * n))
    system[:n, n:] = np.eye(n)
    system[n:] = -inverse @ np.hstack([res.stiffness, res.damping])

    def steady(t: float) -> np.ndarray:
        total = np.zeros(2 * n, dtype=complex)
        w1 = 2.0 * np.pi * mechanics.frequency
        both = 100.0 * np.exp(1j * motor.phase)
        for w, volts in ((w1, [both, both]), (2.0 * w1, [100.0, -100.0])):
            dynamic = res.stiffness - w**2 * res.mass + 1j * w * res.damping
            r = np.linalg.solve(dynamic, res.coupling @ volts)
            total += np.concatenate([r, 1j * w * r]) * np.exp(1j * w * t)
        return total.imag

    expected = steady(DURATION) - expm(system * DURATION) @ steady(0.0)
    assert (len(made.starts), made.rotor_velocity) == (0, 0.5)
    assert made.u == pytest.approx(float(res.tip[0] @ expected[:n]), rel=1e-9)


def test_the_parts_have_their_published_numbers() -> None:
    radius, modulus, work = 4e-3, 1e11, 0.1
    neck, pull_off = Jkr(radius, modulus, work), 1.5 * np.pi * work * radius
    assert neck.spring(0, 0.0, 0.0, [])[0] == pytest.approx(-8.0 / 9.0 * pull_off, rel=1e-12)
    assert neck.spring(0, neck.break_depth, 0.0, [])[0] == pytest.approx(-5.0 / 9.0 * pull_off, rel=1e-12)
    sphere = elliptic_stiffness(radius, radius, modulus)
    assert sphere == pytest.approx(4.0 / 3.0 * modulus * radius**0.5, rel=1e-12)
    assert elliptic_stiffness(radius, 1.001 * radius, modulus) == pytest.approx(
        sphere * 1.001**0.25, rel=1e-6
    )
    # Nearly elastic: D = 3/2 (1 - e).
    assert loss_number(0.9999) == pytest.approx(1.5e-4, rel=1e-3)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_contact_accelerations_are_the_time_derivatives_of_the_rates(seed: int) -> None:
    motor = OracleMotor(load_torque=2e-3, rotor_damping=1e-3)
    mechanics, rng = Mechanics(motor), np.random.default_rng(seed)
    # Slopes of 0.1 rad and 100 rad/s: the curvature terms count.
    y = mechanics.initial_state()
    y[:4], y[4:8], y[8] = 5e-4 * rng.normal(size=4), 0.5 * rng.normal(size=4), rng.normal()
    t, h = 1e-4, 1e-8
    rate = mechanics.derivative(t, y, lambda _: (0.0, 0.0))
    ahead, behind, c = (mechanics.contact(t, y + k * h * rate) for k in (1, -1, 0))
    gap_rate = (ahead.gap - behind.gap) / (2 * h)
    normal_bias = (ahead.gap_rate - behind.gap_rate) / (2 * h)
    slip_bias = (ahead.slip - behind.slip) / (2 * h)
    assert gap_rate == pytest.approx(c.gap_rate, rel=1e-6, abs=1e-7)
    assert normal_bias == pytest.approx(c.normal_bias, rel=1e-5, abs=1e-2)
    assert slip_bias == pytest.approx(c.slip_bias, rel=1e-5, abs=1e-2)
