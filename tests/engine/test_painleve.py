"""Rigid contacts beyond the critical friction, where a step has several answers or, for slip alone, none."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from contactlab.arrays import Array
from contactlab.engine import simulate
from contactlab.laws import LagrangeSlip, LagrangeStick, MultiplierLaw, Newton, Poisson, Stronge
from contactlab.motor import NormalModes
from contactlab.motor.drive import Drive
from contactlab.motor.geometry import ContactGeometry
from contactlab.motor.motor import ModalState, Motor, Rotor
from contactlab.testing.plants import FLAT
from contactlab.trajectory import Ending, Trajectory

NORMAL, TANGENTIAL = 10.0, 30.0
"""Ways of the leaning strut's tip per way of the strut [kg^-1/2]; the critical friction is their ratio."""

RADIUS, TIP_LENGTH, INERTIA = 25e-3, 19e-3, 1e-6
STEP = 1e-6


def leaning_strut(
    approach: float, rotor_velocity: float, parting: float = 0.0, load_torque: float = 0.0
) -> Motor:
    """A strut that can only move along itself, aslant onto a rotor.

    Args:
        approach: speed at which the gap closes [m/s].
        rotor_velocity: at the start [rad/s].
        parting: acceleration along the strut that opens the gap [m/s^2 kg^1/2].
        load_torque: on the rotor [N m].
    """
    return Motor(
        modes=NormalModes(
            stiffness=np.zeros(1),
            damping=np.zeros(1),
            coupling=np.zeros((1, 2)),
            tip_displacement=np.array([NORMAL]),
            tip_slope=np.array([TANGENTIAL / TIP_LENGTH]),
            shape_coupling=np.zeros((1, 2)),
        ),
        geometry=ContactGeometry(TIP_LENGTH, RADIUS, clearance=1e-10),
        rotor=Rotor(INERTIA, load_torque=load_torque, initial_velocity=rotor_velocity),
        preload=np.array([-parting]),
        start=ModalState(np.zeros(1), np.array([approach / NORMAL])),
    )


def run(motor: Motor, law: MultiplierLaw, duration: float = 1e-4) -> Trajectory:
    return simulate(motor, law, duration=duration, record_interval=1e-6, contact_step=STEP)


def test_slip_alone_has_no_answer_to_an_approach_and_the_run_says_so() -> None:
    result = run(leaning_strut(0.1, -40.0), LagrangeSlip(1.0))
    assert result.ending is Ending.INCONSISTENT
    assert not result.complete
    # It stops at the touch-down: nothing has gone into the rotor.
    assert result.contacts["start_time"].size == 1
    assert result.time[-1] <= result.contacts["start_time"][0]


@pytest.mark.parametrize(("spin", "mu"), [(40.0, 1.0), (-40.0, 0.3)])
def test_the_other_direction_and_less_friction_are_answered_by_slip_alone(spin: float, mu: float) -> None:
    result = run(leaning_strut(0.1, spin), LagrangeSlip(mu))
    assert result.complete, result.message
    assert result.series["gap"].min() > -0.1 * STEP


@pytest.mark.parametrize(
    "law", [LagrangeStick(1.0), Newton(1.0, 0.5), Poisson(1.0, 0.5), Stronge(1.0, 0.5)], ids=repr
)
@pytest.mark.parametrize("spin", [40.0, -40.0])
def test_laws_with_stick_answer_every_approach(law: MultiplierLaw, spin: float) -> None:
    result = run(leaning_strut(0.1, spin), law)
    assert result.complete, result.message
    assert result.contacts["normal_impulse"][0] > 0.0
    assert result.series["gap"].min() > -0.1 * STEP


def test_a_strut_that_jams_holds_a_rotor_and_the_run_counts_its_steps() -> None:
    # The load alone holds it: friction presses more than what parts the bodies, inside the cone.
    wedged = leaning_strut(1e-3, 0.0, parting=1.0, load_torque=50.0 * INERTIA / RADIUS)
    stored = run(wedged, LagrangeStick(1.0))
    assert stored.complete, stored.message
    assert stored.contacts["duration"].size == 1
    assert stored.contact_mode[-1] == 2
    assert abs(stored.series["rotor_velocity"][-1]) < 1e-12
    assert stored.statistics["wedged_steps"] > 90
    # With too little friction it opens.
    released = run(wedged, LagrangeStick(0.3))
    assert released.contact_mode[-1] == 0
    assert released.statistics["wedged_steps"] == 0


def skew_motor(seed: int) -> tuple[Motor, float]:
    """A random motor whose modes couple both directions, as a rule beyond the critical friction; with it."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 5))
    omega = 2.0 * np.pi * np.sort(10.0 ** rng.uniform(2.5, 4.3, n))
    damping = 10.0 ** rng.uniform(-3.0, -0.7, n)
    along = rng.normal(size=n) * 20.0
    ratio = rng.uniform(1.2, 4.0) * rng.choice([-1, 1])
    across = ratio * along + rng.normal(size=n) * 20.0 * rng.uniform(0.1, 1.5)
    modes = NormalModes(
        stiffness=omega**2,
        damping=2.0 * damping * omega,
        coupling=rng.normal(size=(n, 2)),
        tip_displacement=along,
        tip_slope=-across / TIP_LENGTH,
    )
    frequency = 10.0 ** rng.uniform(3.0, 4.0, 1)
    voltage = (rng.normal(size=(2, 1)) + 1j * rng.normal(size=(2, 1))) * 10.0 ** rng.uniform(0.5, 2.0)
    critical = float(along @ along) / abs(float(along @ across))
    mu = critical * rng.uniform(1.1, 4.0) if rng.random() < 0.9 else 0.3
    rotor = Rotor(
        float(10.0 ** rng.uniform(-6.0, -4.3)),
        float(rng.choice([0.0, 1e-4])),
        float(rng.normal() * 1e-3),
        float(rng.normal() * rng.choice([0, 1])),
    )
    preload = along * 10.0 ** rng.uniform(-2.0, 0.7) * rng.choice([0, 1, 1])
    geometry = ContactGeometry(TIP_LENGTH, RADIUS, float(rng.choice([1e-6, 1e-7, 1e-8])))
    return Motor(modes, Drive(frequency, voltage), geometry, rotor, preload=preload), float(mu)


# Slip that collocation left when a stick ended; an excess between two nodes; a side of the polynomials alone;
# forces without digits left; and any other.
SEEDS = [3, 5, 25, 161, 66, 15, 29, *range(30, 40)]


@pytest.mark.parametrize("law", [LagrangeStick, lambda mu: Newton(mu, 0.6)], ids=["stick", "newton"])
@pytest.mark.parametrize("seed", SEEDS)
def test_beyond_the_critical_friction_the_error_falls_with_the_tolerance(
    seed: int, law: Callable[[float], MultiplierLaw]
) -> None:
    motor, mu = skew_motor(seed)
    ends = []
    for tolerance in (1e-8, 1e-10, 1e-12):
        result = simulate(motor, law(mu), duration=2e-3, record_interval=2e-5, tolerance=tolerance)
        assert result.complete, result.message
        ends.append(float(result.series["rotor_velocity"][-1]))
    scale = abs(ends[-1]) + 1e-3
    assert abs(ends[0] - ends[-1]) < 3e-6 * scale
    assert abs(ends[1] - ends[-1]) < 3e-8 * scale


@pytest.mark.parametrize("seed", [17, 88, 101, 105, 146])
def test_a_stick_that_cannot_slide_opens_where_it_leaves_its_cone(seed: int) -> None:
    """Against DOP853: a flat body on a heavy belt, held by its friction until that is not enough."""
    rng = np.random.default_rng(seed)
    omega = 2.0 * np.pi * np.sort(10.0 ** rng.uniform(2.7, 4.0, 3))
    stiffness, damping, along = omega**2, 0.04 * omega, rng.normal(size=3) * 20.0
    across = rng.choice([-1, 1]) * rng.uniform(1.5, 4.0) * along + rng.normal(size=3) * 10.0
    force, tone = rng.normal(size=3) * 80.0, 2.0 * np.pi * 10.0 ** rng.uniform(3.0, 3.7)
    weight, rows = along * rng.uniform(0.5, 3.0), np.array([-along, across])
    d = rows @ rows.T
    mu = 1.8 * d[0, 0] / abs(d[0, 1])

    def free(t: float, y: Array) -> Array:
        return -stiffness * y[:3] - damping * y[3:] + force * np.cos(tone * t) + weight

    def sticking_forces(t: float, y: Array) -> Array:
        return -np.linalg.solve(d, rows @ free(t, y))

    def room(t: float, y: Array) -> float:
        normal, friction = sticking_forces(t, y)
        return float(mu * normal - abs(friction))

    room.terminal, room.direction = True, -1.0  # type: ignore[attr-defined]
    accurate: dict[str, Any] = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-18}
    sticking = solve_ivp(
        lambda t, y: np.concatenate([y[3:], free(t, y) + rows.T @ sticking_forces(t, y)]),
        (0.0, 1e-3),
        np.zeros(6),
        events=room,
        max_step=2e-5,
        **accurate,
    )
    leaves, y = sticking.t[-1], sticking.y[:, -1]
    normal, friction = sticking_forces(leaves, y)
    assert normal > 0.1
    assert d[0, 0] + friction / normal * d[0, 1] < 0.0
    end = leaves + 3e-5
    flying = solve_ivp(lambda t, y: np.concatenate([y[3:], free(t, y)]), (leaves, end), y, **accurate)
    motor = Motor(
        NormalModes(stiffness, damping, np.array([force, 0.0 * force]).T.copy(), along, -across / FLAT),
        Drive(np.array([tone / (2.0 * np.pi)]), np.array([[1.0], [0.0]], dtype=complex)),
        ContactGeometry(FLAT, FLAT, 0.0),
        Rotor(1e18 * FLAT**2),
        preload=weight,
    )
    for tolerance in (1e-6, 1e-9, 1e-12):
        law = LagrangeStick(mu)
        result = simulate(motor, law, duration=end, record_interval=end, tolerance=tolerance)
        assert result.contacts["duration"] == pytest.approx([leaves], rel=1e-6)
        assert result.series["gap"][-1] == pytest.approx(
            rows[0] @ flying.y[:3, -1], rel=1e-3 * tolerance + 1e-11
        )
