"""Rate and state: steady slip, steps of the slip, ageing, and the stability of a slider on a spring."""

from math import exp, log, sqrt

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from support.kernels import state_of

from contactlab.engine import simulate
from contactlab.laws.composed import Composed
from contactlab.laws.friction import RateAndState
from contactlab.laws.normal import Linear
from contactlab.testing.plants import block, paper_motor, run
from contactlab.trajectory import Trajectory

Array = np.ndarray

MU, A, B, D, V0, NORMAL = 0.4, 0.01, 0.015, 1e-6, 1e-6, 5.0
SLOW = RateAndState(MU, A, B, D, V0, creep_velocity=1e-14)
"""Of which the least creep is far below all slips here."""


def response(friction: RateAndState, slip: float, z: float) -> tuple[float, float]:
    """F/N against the slip, and the rate of z [1/s]."""
    force, rate, stored, _ = state_of(friction, NORMAL, slip, z)
    assert stored == 0.0
    return -force / NORMAL, rate


def aged(slip: float, z: float, duration: float) -> float:
    """Let z flow at a constant slip."""

    def flow(_: float, y: Array) -> list[float]:
        return [response(SLOW, slip, float(y[0]))[1]]

    return float(solve_ivp(flow, (0.0, duration), [z], "LSODA", rtol=1e-10, atol=1e-12).y[0, -1])


@pytest.mark.parametrize(("before", "after"), [(1e-6, 1e-5), (1e-2, 1e-4)])
def test_a_step_of_the_slip_has_its_direct_effect_and_evolves_over_the_distance(
    before: float, after: float
) -> None:
    """F/N rises by a ln(v2/v1), then theta = D/v2 + (theta_1 - D/v2) exp(-v2 t/D) takes b ln(v2/v1) off."""
    z, leap = log(V0 / before), log(after / before)
    steady = response(SLOW, before, z)[0]
    assert response(SLOW, after, z)[0] - steady == pytest.approx(A * leap, rel=1e-8)
    for ways in (0.3, 1.0, 3.0):
        theta = D / after + (D / before - D / after) * exp(-ways)
        result = aged(after, z, ways * D / after)
        assert result == pytest.approx(log(V0 * theta / D), abs=1e-8)
        evolved = steady + A * leap + B * log(theta * before / D)
        assert response(SLOW, after, result)[0] == pytest.approx(evolved, abs=1e-9)
    gone = aged(after, z, 40.0 * D / after)
    assert response(SLOW, after, gone)[0] - steady == pytest.approx((A - B) * leap, rel=1e-7)


def test_at_rest_the_age_is_the_time_so_that_static_friction_grows_with_its_logarithm() -> None:
    ages = np.array([1e-6, 1e-3, 1.0])
    grown = [aged(0.0, log(V0 * 1e-6 / D), age) for age in ages]
    assert_allclose(np.exp(grown) * D / V0, 1e-6 + ages, rtol=1e-7)


def test_least_creep_changes_nothing_of_faster_slips_and_levels_no_other_friction() -> None:
    """v_c takes (v_c/v)^2 / 2 of the part of the exponent that is slower, and no answer overflows."""
    for z in (-14.0, -7.0, 0.0, 5.0, 40.0):
        for slip in (1e-6, 1e-3, 1.0):
            assert response(RateAndState(MU), slip, z)[0] == pytest.approx(
                response(SLOW, slip, z)[0], rel=1e-6
            )
        slips = np.logspace(-16.0, 1.0, 300)
        forces = [response(RateAndState(MU), slip, z)[0] for slip in slips]
        assert np.all(np.isfinite(forces))
        assert np.all(np.diff(forces) > 0.0)
        assert forces[0] < 1e-4


def characteristic(stiffness: float, mass: float, speed: float) -> Array:
    """Rates of small motions about steady slip [1/s]: of the way x, the slip v and z.

    m dv/dt = -k x - N (a v/v_s + b z),  dx/dt = v,  dz/dt = -(v_s z + v)/D
    """
    rows = [
        [0.0, 1.0, 0.0],
        [-stiffness / mass, -NORMAL * A / (speed * mass), -NORMAL * B / mass],
        [0.0, -1.0 / D, -speed / D],
    ]
    return np.linalg.eigvals(rows)


SPEED, SPRING = 1e-3, 1e7
CRITICAL = NORMAL * (B - A) / D


def slider(share: float, off: float, periods: float, mass: float) -> Trajectory:
    """A block on a belt, held by a spring of a share of the critical stiffness, near its steady slip."""
    stiffness = share * CRITICAL
    age = D / SPEED
    friction = RateAndState(MU, A, B, D, V0, age, 1e-12)
    drag = NORMAL * (MU + (A - B) * log(SPEED / V0))
    motor = block(
        mass,
        height=-NORMAL / SPRING,
        weight=NORMAL,
        way=drag / stiffness + off,
        stiffness=stiffness,
        belt_velocity=SPEED,
    )
    period = 2.0 * np.pi * D / SPEED / sqrt((B - A) / A)
    law = Composed(Linear(SPRING), friction=friction)
    return run(motor, law, periods * period, 0.005 * period, 0.005 * period)


def swings(made: Trajectory) -> Array:
    """Amplitude [m] of each further swing of the spring's force, by its turning points."""
    force = made.series["friction_force"][1:] / CRITICAL
    inner = (force[1:-1] - force[:-2]) * (force[2:] - force[1:-1]) < 0.0
    return np.abs(np.diff(force[1:-1][inner]))


@pytest.mark.parametrize("share", [0.9, 1.2])
def test_a_slider_swings_up_below_the_critical_stiffness_and_calms_down_above(share: float) -> None:
    """Ruina (1983): k_c = N (b - a)/D; the rate follows from the characteristic equation.

    The mass lifts k_c by m v_s^2/(N a D) (Rice and Ruina 1983, J. Appl. Mech. 50, 343), here by 4%.
    """
    mass = 2e-3
    roots = characteristic(share * CRITICAL, mass, SPEED)
    root = roots[np.argmax(roots.imag)]
    assert (root.real > 0.0) == (share < 1.0)
    lifted = characteristic((1.0 + mass * SPEED**2 / (NORMAL * A * D)) * CRITICAL, mass, SPEED)
    assert np.abs(lifted.real).min() < 1e-6 * np.abs(lifted.imag).max()
    result = swings(slider(share, 2e-9, 2.6, mass))
    assert result.size >= 4
    assert_allclose(result[2:] / result[1:-1], exp(root.real * np.pi / root.imag), rtol=1e-2)


def test_at_the_critical_stiffness_swings_of_any_size_go_on_as_they_are() -> None:
    """Ranjith and Rice (1999), J. Mech. Phys. Solids 47, 1207: under the ageing law they are periodic.

    That is without inertia; with this mass the critical stiffness is larger by 0.4%, and a tenth of that is
    left in the swings.
    """
    mass = 2e-4
    made = slider(1.0 + mass * SPEED**2 / (NORMAL * A * D), 6e-7, 2.2, mass)
    result = swings(made)
    speeds = np.abs(made.series["slip_velocity"])
    # Far from linear: the slip goes to half of the belt's and nearly to twice.
    assert speeds.max() / speeds.min() > 2.9
    assert result.size >= 4
    assert_allclose(result[2:], result[1], rtol=1e-3)


def test_a_motor_runs_with_a_small_direct_effect_in_a_few_hundred_steps_a_contact() -> None:
    for friction in (RateAndState(0.3, 0.01), RateAndState(0.5, 0.005, 0.008)):
        made = simulate(paper_motor(), Composed(friction=friction), duration=1e-3, record_interval=1e-5)
        assert made.complete, made.message
        assert made.statistics["contact_steps"] < 300 * made.statistics["touchdowns"]
        residual = np.abs(made.series["energy_residual"]).max()
        assert residual < 1e-8 * made.series["drive_work"].max()
