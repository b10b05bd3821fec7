"""A spring with Maxwell arms: harmonic moduli, and impacts against SciPy."""

from math import pi
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from support.closed_form_memory import Swelling
from support.closed_forms import restitution

from contactlab.laws import Composed, Prony
from contactlab.testing.plants import block, first, last, run

MASS, HEAVY = 2e-3, 1e6
LINING = Prony(5e6, 8e6, 1e-5, 3e6, 1e-4, 2e6, 1e-3)
ARMS = LINING.arms
TIGHT: Any = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-18}


@pytest.mark.parametrize("frequency", [300.0, 1.6e4])
def test_a_harmonic_depth_has_the_storage_and_loss_moduli_of_the_arms(frequency: float) -> None:
    """k' = k_inf + sum k_i x^2/(1 + x^2), k'' = sum k_i x/(1 + x^2), x = w tau_i; loss pi A^2 k''."""
    centre, swing, w = 2e-6, 5e-7, 2.0 * pi * frequency
    stiffness, period = HEAVY * w**2, 1.0 / frequency
    # The arms forget where they began in the slowest time.
    cycles = int(8e-3 * frequency) + 1
    body = block(HEAVY, height=-centre - swing, weight=stiffness * centre, normal_stiffness=stiffness)
    made = run(body, Composed(LINING), (cycles + 1) * period, 0.02 * period, 0.25 * period)
    lost = np.diff(made.series["contact_loss"][-5:][[0, 4]])[0]
    x = np.array([w * tau for _, tau in ARMS])
    k = np.array([arm for arm, _ in ARMS])
    assert_allclose(lost, pi * swing**2 * (k * x / (1.0 + x * x)).sum(), rtol=1e-3)
    # Impulses of the quarters about the deepest and the least deep: 2 sqrt 2 A k'/w apart at eighths.
    quarters = made.series["normal_force"][-4:] * 0.25 * period
    # Over a quarter from the deepest on, cos and sin both integrate to 1/w.
    storage = LINING.relaxed_stiffness + (k * x * x / (1.0 + x * x)).sum()
    first_half = quarters[0] - quarters[2], quarters[3] - quarters[1]
    assert_allclose(sum(first_half) * w / (4.0 * swing), storage, rtol=1e-3)


def integrated(
    lining: Prony, speed: float, mass: float, weight: float, end: float
) -> tuple[Any, list[float]]:
    """Follow a body and its lining by themselves; gives the last state and the times of touch and release."""
    k, tau = (np.array(each) for each in zip(*lining.arms, strict=True))
    whole = lining.relaxed_stiffness + k.sum()

    def force(t: float, y: np.ndarray) -> float:
        return float(whole * y[0] - k @ y[2:])

    def motion(t: float, y: np.ndarray, touching: bool) -> list[float]:
        pressed = force(t, y) if touching else 0.0
        surface = y[0] if touching else k @ y[2:] / whole
        return [y[1], (weight - pressed) / mass, *((surface - y[2:]) / tau)]

    y, time, touching, switches = np.array([0.0, speed, *np.zeros(k.size)]), 0.0, True, []
    while time < end:

        def switch(t: float, y: np.ndarray, touching: bool) -> float:
            return force(t, y)

        switch.terminal, switch.direction = True, -1.0 if touching else 1.0  # type: ignore[attr-defined]
        result = solve_ivp(motion, (time, end), y, events=switch, args=(touching,), **TIGHT)
        y, time, touching = result.y[:, -1], float(result.t[-1]), not touching
        switches.append(time)
    return y, switches


@pytest.mark.parametrize("speed", [1e-3, 1.0])
def test_an_impact_is_that_of_an_integration_by_itself(speed: float) -> None:
    state, (left, *_) = integrated(LINING, speed, MASS, 0.0, 1e-4)
    ball = block(MASS, height=1e-9, gap_rate=-speed)
    made = run(ball, Composed(LINING), 1e-9 / speed + 1e-4, tolerance=1e-10)
    assert_allclose(first(made, "duration"), left, rtol=1e-6)
    assert_allclose(restitution(made), -state[1] / speed, rtol=1e-6)
    assert abs(last(made, "energy_residual")) < 1e-6 * first(made, "energy_loss")


def test_a_lining_recovers_in_flight_and_is_met_where_it_then_is() -> None:
    lining, speed, weight, end = Prony(5e6, 2e7, 1e-4), 0.33, 20.0, 4e-4
    state, switches = integrated(lining, speed, MASS, weight, end)
    made = run(block(MASS, height=0.0, gap_rate=-speed, weight=weight), Composed(lining), end)
    touches = switches[1:-1:2]
    assert made.contacts["start_time"].size == len(touches) + 1 == 6
    assert_allclose(made.contacts["start_time"][1:], touches, rtol=1e-9)
    assert_allclose(-last(made, "gap"), state[0], rtol=1e-8)
    assert np.abs(made.series["energy_residual"]).max() < 1e-6 * last(made, "contact_loss")


@pytest.mark.parametrize(("fast", "error"), [(1e-4, 1e-9), (1e-6, 1e-9), (1e-12, 1e-6)])
def test_a_touch_down_is_where_a_parabola_meets_the_exponentials_of_the_surface(
    fast: float, error: float
) -> None:
    """Every flight by itself, from the rows of the contact before: no error of a contact adds to it."""
    lining, weight = Prony(5e6, 2e7, fast, 1e7, 3e-4), 20.0
    made = run(block(MASS, gap_rate=-0.33, weight=weight), Composed(lining), 4e-4)
    rows, (arms, times) = made.contacts, np.transpose(lining.arms)
    whole = lining.relaxed_stiffness + arms.sum()
    # Some versions of NumPy say complex of every matrix that is not symmetric.
    system = (np.ones((2, 1)) * arms / whole - np.eye(2)) / times[:, None]
    decay, shapes = (each.real for each in np.linalg.eig(system))
    flights = np.diff(rows["start_time"]) - rows["duration"][:-1]
    assert flights.size > 1
    for i, flight in enumerate(flights):
        creep = [rows[f"internal_creep_{k}"][i] for k in (1, 2)]
        parts = (arms @ shapes / whole) * np.linalg.solve(shapes, creep)
        leaves = rows["separation_velocity"][i]

        def over(
            t: float, parts: np.ndarray = parts, leaves: float = leaves, decay: np.ndarray = decay
        ) -> float:
            return float(leaves * t - 0.5 * weight / MASS * t**2 + parts @ np.expm1(decay * t))

        lands = brentq(over, 0.5 * flight, 1.5 * flight, xtol=1e-18, rtol=1e-14)
        assert_allclose(flight, lands, rtol=error)
        # It is the first one.
        assert min(over(t) for t in np.geomspace(1e-3, 0.999, 500) * lands) > 0.0


def test_a_surface_that_rises_faster_than_the_body_leaves_is_met_while_the_gap_opens() -> None:
    """A lining that is heated swells: w approaches 1 um, and meets a body that retreats."""
    law, retreat = Swelling(), 0.01
    made = run(block(MASS, height=1e-7, gap_rate=retreat), law, 2e-4, record_interval=1e-7)
    lands = brentq(
        lambda t: 1e-7 + retreat * t + law.height * np.expm1(-t / law.time), 1e-7, 5e-5, xtol=1e-18
    )
    assert_allclose(made.contacts["start_time"], lands, rtol=1e-9)
    assert_allclose(made.contacts["approach_velocity"], retreat, rtol=1e-12)
    assert first(made, "separation_velocity") > retreat


def test_what_a_lining_gives_back_to_nobody_is_lost_by_the_contact_that_stored_it() -> None:
    made = run(block(MASS, height=1e-6, gap_rate=-0.1), Composed(Prony()), 3e-3)
    lost = 0.5 * MASS * (0.1**2 - first(made, "separation_velocity") ** 2)
    assert_allclose(made.contacts["energy_loss"], lost, rtol=1e-5)
    # What the end of the run finds stored is not lost yet.
    short = run(block(MASS, height=1e-6, gap_rate=-0.1), Composed(Prony()), 7e-5)
    assert last(short, "contact_energy") > 1e-3 * lost
    assert_allclose(short.contacts["energy_loss"] + last(short, "contact_energy"), lost, rtol=1e-5)
