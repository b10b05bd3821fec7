"""The reference solver meets the known numbers of the motor, closed forms, and its own balances.

Unless a test says otherwise, a reference number is met within one unit of its last printed digit.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from oracle import OracleMotor, OracleRun, shapes, solve_hertz, solve_rigid_stick
from oracle.motor import Contact, Mechanics
from oracle.rigid import stick_or_slip
from oracle.run import Event, Stepper, run_phase
from scipy.linalg import expm
from support.command_line import cases

DURATION = 5e-3
STIFFNESS = 1e10
PLACEMENT_1 = OracleMotor(patch_start=15.968e-3, patch_end=25.065e-3)
PLACEMENT_2 = OracleMotor()
CASE_A = OracleMotor(frequency=3210.0)
CASE_A_SMOOTH = OracleMotor(frequency=3210.0, friction_coefficient=0.0)
LOADED = OracleMotor(load_torque=2e-3, rotor_damping=1e-4, initial_velocity=-0.9, clearance=0.0)
STRONG = OracleMotor(voltage_1=400.0, voltage_2=300.0, friction_coefficient=0.8)
SILENT = {"voltage_1": 0.0, "voltage_2": 0.0, "mass_damping": 0.0, "stiffness_damping": 0.0}

Solver = Callable[[OracleMotor], OracleRun]


@cache
def hertz(motor: OracleMotor) -> OracleRun:
    return solve_hertz(motor, STIFFNESS, DURATION)


@cache
def rigid(motor: OracleMotor) -> OracleRun:
    return solve_rigid_stick(motor, DURATION)


def test_shapes_are_the_textbook_clamped_beam_shapes() -> None:
    length = PLACEMENT_2.length
    x = np.linspace(0.0, length, 101)
    roots = [4.730040744862704, 7.853204624095838, 10.995607838001671, 14.137165491257464]
    for index, root in enumerate(roots):
        z = root * x / length
        s = (np.cosh(root) - np.cos(root)) / (np.sinh(root) - np.sin(root))
        expected = [
            np.cosh(z) - np.cos(z) - s * (np.sinh(z) - np.sin(z)),
            root / length * (np.sinh(z) + np.sin(z) - s * (np.cosh(z) - np.cos(z))),
            (root / length) ** 2 * (np.cosh(z) + np.cos(z) - s * (np.sinh(z) + np.sin(z))),
        ]
        for derivative, values in enumerate(expected):
            # The textbook form loses digits to cancellation: 1e-9 of the largest value.
            error = np.abs(shapes(x, 4, length, derivative)[index] - values).max()
            assert error < 1e-9 * np.abs(values).max()


@pytest.mark.parametrize(
    ("motor", "coupling", "frequencies"),
    [
        (PLACEMENT_1, (-0.016, -0.057, 0.006), (2.02e3, 5.38e3)),
        (PLACEMENT_2, (0.021, 0.027, 0.005), (3.21e3, 5.46e3)),
    ],
)
def test_table_1_is_met_to_its_printed_digits(
    motor: OracleMotor, coupling: tuple[float, ...], frequencies: tuple[float, ...]
) -> None:
    # Half a unit of the last printed digit.
    assert motor.resonator().coupling[:3, 0] == pytest.approx(coupling, abs=0.5e-3)
    assert motor.natural_frequencies()[:2] == pytest.approx(frequencies, abs=5.0)


def test_resonator_meets_the_identified_numbers() -> None:
    first = PLACEMENT_1.resonator().coupling[:3, 0]
    second = PLACEMENT_2.resonator().coupling[:3, 0]
    assert first == pytest.approx([-0.01558, -0.05710, 0.00605], abs=1e-5)
    assert second == pytest.approx([0.02069, 0.02727, 0.00492], abs=1e-5)
    assert PLACEMENT_1.natural_frequencies()[:2] == pytest.approx([2019.861, 5380.508], abs=1e-3)
    frequencies = PLACEMENT_2.natural_frequencies()
    assert frequencies[:2] == pytest.approx([3210.121, 5460.688], abs=1e-3)
    assert frequencies[2:] == pytest.approx([13202.46, 17786.32], abs=0.01)
    eight = OracleMotor(shapes=8).natural_frequencies()
    assert eight[:2] == pytest.approx([2692.0, 4606.0], abs=1.0)


def test_mirrored_set_couples_with_the_parity_of_the_shapes() -> None:
    coupling = PLACEMENT_2.resonator().coupling
    assert coupling[:, 1] == pytest.approx(coupling[:, 0] * [1.0, -1.0, 1.0, -1.0], rel=1e-12)


# Case A: rotor velocity, u, theta, time in contact, second touch-down; then one unit of each.
HERTZ_ENDS = [-0.4468048, -2.3727588e-6, 1.0026338e-4, 9.908710e-4, 424.7e-6]
SMOOTH_ENDS = [0.0, -2.3728353e-6, 1.0207838e-4, 9.908446e-4, 424.7e-6]
HERTZ_DIGITS = [1e-7, 1e-13, 1e-11, 1e-10, 1e-7]
RIGID_ENDS = [-0.448569, -2.331869e-6, 9.901627e-5, 5.198480e-4, 430.4e-6]
RIGID_DIGITS = [1e-6, 1e-12, 1e-11, 1e-10, 1e-7]


@pytest.mark.parametrize(
    ("solve", "motor", "reference", "digits"),
    [
        (hertz, CASE_A, HERTZ_ENDS, HERTZ_DIGITS),
        (hertz, CASE_A_SMOOTH, SMOOTH_ENDS, HERTZ_DIGITS),
        (rigid, CASE_A, RIGID_ENDS, RIGID_DIGITS),
    ],
    ids=["hertz", "hertz_smooth", "rigid"],
)
def test_case_a_ends_where_the_reference_ends(
    solve: Solver, motor: OracleMotor, reference: list[float], digits: list[float]
) -> None:
    run = solve(motor)
    assert len(run.start_time) == 16
    assert run.start_time[0] == pytest.approx(131.07e-6, abs=0.01e-6)
    found = [run.rotor_velocity, run.u, run.theta, run.time_in_contact, run.start_time[1]]
    for value, expected, digit in zip(found, reference, digits, strict=True):
        assert value == pytest.approx(expected, abs=digit)


def test_case_a_sticks_and_peaks_as_the_reference() -> None:
    run = hertz(CASE_A)
    assert run.stick_duration.sum() == pytest.approx(2.483e-4, abs=1e-7)
    assert 8.0 < run.peak_normal_force.max() < 10.0


@pytest.mark.parametrize(
    ("solve", "motor", "impulse"),
    [(hertz, CASE_A, 4.532969e-3), (hertz, CASE_A_SMOOTH, 4.532533e-3), (rigid, CASE_A, 3.381372e-3)],
)
def test_case_a_normal_impulse_is_the_reference_within_its_quadrature(
    solve: Solver, motor: OracleMotor, impulse: float
) -> None:
    # The reference sums agree with a trapezoid over solver steps of 2 us: low by 4e-4 where the
    # force is an arch (Hertz), high by 3e-4 where it falls (rigid).  What the impulse is, the
    # momentum balance below decides.
    assert solve(motor).normal_impulse.sum() == pytest.approx(impulse, rel=5e-4)


def test_frictionless_hertz_meets_a_fixed_step_integration_and_the_momentum_balance() -> None:
    mechanics, step, count = Mechanics(CASE_A_SMOOTH), 2e-7, 5000
    n, res, y = mechanics.shapes, mechanics.resonator, mechanics.initial_state()

    def rate(t: float, state: np.ndarray) -> np.ndarray:
        return mechanics.derivative(t, state, lambda c: (STIFFNESS * max(-c.gap, 0) ** 1.5, 0.0))

    history = [y]
    for k in range(count):
        t = k * step
        k1 = rate(t, y)
        k2 = rate(t + 0.5 * step, y + 0.5 * step * k1)
        k3 = rate(t + 0.5 * step, y + 0.5 * step * k2)
        k4 = rate(t + step, y + step * k3)
        y = y + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        history.append(y)
    run = solve_hertz(CASE_A_SMOOTH, STIFFNESS, count * step)
    u, theta, *_ = mechanics.tip_state(y)
    # The fixed step knows no touch-down: its error is of the order (step/contact)^2.5.
    assert (run.u, run.theta) == pytest.approx((u, theta), rel=1e-6)

    # M r' + C r + K int r - Gamma int U = S' (impulses on u and slope); the normal is -u to 1e-8.
    volts = [mechanics.voltages(k * step) for k in range(count + 1)]
    r_integral = np.trapezoid([state[:n] for state in history], dx=step, axis=0)
    left = res.mass @ y[n : 2 * n] + res.damping @ y[:n] + res.stiffness @ r_integral
    left -= res.coupling @ np.trapezoid(volts, dx=step, axis=0)
    on_tip = np.linalg.lstsq(res.tip.T, left, rcond=None)[0]
    assert run.normal_impulse.sum() == pytest.approx(-on_tip[0], rel=1e-5)


def test_free_flight_is_the_harmonic_response_plus_the_exact_transient() -> None:
    motor = OracleMotor(clearance=1e-3, initial_velocity=0.5)
    run, mechanics, res = hertz(motor), Mechanics(motor), motor.resonator()
    n = motor.shapes
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
    assert len(run.start_time) == 0
    assert run.rotor_velocity == 0.5
    assert (run.u, run.theta) == pytest.approx(tuple(res.tip @ expected[:n]), rel=1e-9)


@pytest.mark.parametrize(
    "motor",
    cases([CASE_A, CASE_A_SMOOTH, LOADED, STRONG, PLACEMENT_1], [CASE_A, CASE_A_SMOOTH, LOADED]),
    ids=["case_a", "smooth", "loaded", "strong", "placement_1"],
)
@pytest.mark.parametrize("solve", [hertz, rigid])
def test_energy_ledger_closes(solve: Solver, motor: OracleMotor) -> None:
    run = solve(motor)
    # Measured 1e-10 to 7e-10 (rtol 1e-10).
    assert abs(run.energy_residual) < 2e-9 * (abs(run.drive_work) + run.initial_energy)
    assert run.damping_loss > 0.0
    assert run.friction_loss >= 0.0
    assert run.contact_loss >= 0.0


@pytest.mark.parametrize("solve", [hertz, rigid])
def test_friction_impulse_is_what_the_rotor_gained(solve: Solver) -> None:
    run, m = solve(LOADED), LOADED
    outside = -m.rotor_damping * run.rotor_angle - m.load_torque * DURATION
    gained = m.rotor_inertia * (run.rotor_velocity - m.initial_velocity)
    assert gained == pytest.approx(outside - m.rotor_radius * run.friction_impulse.sum(), rel=1e-9)
    bound = m.friction_coefficient * run.normal_impulse
    assert np.all(np.abs(run.friction_impulse) <= bound * (1.0 + 1e-12))


@pytest.mark.parametrize("compliant", cases([True, False], [True]), ids=["hertz", "rigid"])
def test_smaller_steps_and_tolerance_do_not_move_the_result(compliant: bool) -> None:
    options = {"rtol": 1e-11, "flight_step": 1e-6, "contact_step": 4e-7}
    if compliant:
        run, fine = hertz(STRONG), solve_hertz(STRONG, STIFFNESS, DURATION, **options)
    else:
        run, fine = rigid(STRONG), solve_rigid_stick(STRONG, DURATION, **options)
    assert len(run.start_time) == len(fine.start_time)
    assert run.rotor_velocity == pytest.approx(fine.rotor_velocity, rel=1e-8)
    assert run.stick_duration.sum() == pytest.approx(fine.stick_duration.sum(), rel=1e-6)


def test_hertz_rebound_has_the_closed_form_duration_and_speed() -> None:
    depth = 1e-6
    # One shape with next to no stiffness is a free mass 1/D_nn.
    soft = {"shapes": 1, "steel_modulus": 1.0, "piezo_bending_modulus": 1.0, "frequency": 1e3}
    motor = OracleMotor(clearance=-depth, **soft, **SILENT)
    mechanics = Mechanics(motor)
    mass = 1.0 / mechanics.contact(0.0, mechanics.initial_state()).dnn
    run = solve_hertz(motor, STIFFNESS, 1e-4)
    speed = np.sqrt(0.8 * STIFFNESS / mass) * depth**1.25
    assert run.u_rate == pytest.approx(-speed, rel=1e-6)
    # Half of the full impact, 2.94328 depth/speed.
    assert run.duration == pytest.approx([0.5 * 2.94328 * depth / speed], rel=1e-5)
    assert run.peak_normal_force == pytest.approx([STIFFNESS * depth**1.5], rel=1e-12)


def test_a_dip_shorter_than_a_step_is_a_contact() -> None:
    depth, limit = 1e-12, 4e-4
    high = Mechanics(OracleMotor(clearance=1e-5))
    lowest = Event(lambda t, y: high.contact(t, y).gap_rate, +1, terminal=False)
    stepper = Stepper("DOP853", 1e-11, high.tolerances(1e-11), 1e-6, 1e-6)
    flight = run_phase(high, None, [lowest], 0.0, high.initial_state(), limit, stepper)
    t, y = min(flight.hits[0], key=lambda hit: high.contact(*hit).gap)
    bottom = high.contact(t, y)
    run = solve_hertz(OracleMotor(clearance=1e-5 - bottom.gap - depth), STIFFNESS, limit)
    # The dip is a parabola; the indentation of 1e-12 m does not push back yet.
    assert run.duration == pytest.approx([np.sqrt(8.0 * depth / bottom.normal_bias)], rel=1e-2)
    assert run.duration[0] < 0.1 * 2e-6
    assert run.start_time[0] + 0.5 * run.duration[0] == pytest.approx(t, abs=1e-9)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_contact_accelerations_are_the_time_derivatives_of_the_rates(seed: int) -> None:
    motor = OracleMotor(load_torque=2e-3, rotor_damping=1e-3)
    mechanics, rng = Mechanics(motor), np.random.default_rng(seed)
    # Slopes of 0.1 rad and 100 rad/s: the curvature terms count.
    y = mechanics.initial_state()
    y[:4], y[4:8], y[8] = 5e-4 * rng.normal(size=4), 0.5 * rng.normal(size=4), rng.normal()
    t, h = 1e-4, 1e-8
    rate = mechanics.derivative(t, y, None)
    ahead, behind, c = (mechanics.contact(t, y + k * h * rate) for k in (1, -1, 0))
    gap_rate = (ahead.gap - behind.gap) / (2 * h)
    normal_bias = (ahead.gap_rate - behind.gap_rate) / (2 * h)
    slip_bias = (ahead.slip - behind.slip) / (2 * h)
    assert gap_rate == pytest.approx(c.gap_rate, rel=1e-6, abs=1e-7)
    assert normal_bias == pytest.approx(c.normal_bias, rel=1e-5, abs=1e-2)
    assert slip_bias == pytest.approx(c.slip_bias, rel=1e-5, abs=1e-2)


@settings(max_examples=200, deadline=None)
@given(
    approach=st.floats(1e-6, 1.0),
    slip=st.floats(-1.0, 1.0),
    mu=st.floats(0.01, 1.5),
    skew=st.floats(-0.99, 0.99),
    ratio=st.floats(0.1, 10.0),
)
def test_rigid_impact_solves_the_contact_conditions(
    approach: float, slip: float, mu: float, skew: float, ratio: float
) -> None:
    dnn, dtt = 1000.0, 1000.0 * ratio
    # The solver refuses D_nn <= mu |D_nt|.
    dnt = skew * min(np.sqrt(dnn * dtt), dnn / mu)
    c = Contact(0.0, -approach, slip, 0.0, 0.0, dnn, dnt, dtt, (0.0, 0.0), (0.0, 0.0))
    mode, p_n, p_t = stick_or_slip(c, -approach, slip, mu)
    rate_after = -approach + dnn * p_n + dnt * p_t
    slip_after = slip + dnt * p_n + dtt * p_t
    size = 1e-9 * (approach + abs(slip)) * (1.0 + mu * ratio) / (1.0 - abs(skew))
    assert abs(rate_after) < size
    assert p_n >= 0.0
    assert abs(p_t) <= mu * p_n * (1.0 + 1e-12)
    if mode == 0:
        assert abs(slip_after) < size
    else:
        assert p_t == -mode * mu * p_n
        assert mode * slip_after > -size
    assert p_n * (-approach + rate_after) + p_t * (slip + slip_after) <= size * (p_n + abs(p_t))


def test_impossible_starts_are_refused_with_a_sentence() -> None:
    with pytest.raises(ValueError, match="clearance"):
        solve_rigid_stick(OracleMotor(clearance=-1e-6), DURATION)
    with pytest.raises(ValueError, match="stiffness"):
        solve_hertz(PLACEMENT_2, 0.0, DURATION)
    skewed = Contact(0.0, -1.0, 9.0, 0.0, 0.0, 1.0, -0.9, 1.0, (0.0, 0.0), (0.0, 0.0))
    with pytest.raises(ValueError, match="no unique solution"):
        stick_or_slip(skewed, -1.0, 9.0, 1.5)
