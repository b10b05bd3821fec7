"""Friction that remembers: what is kept within a contact, what ends with it, and where its energy is."""

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from support.kernels import state_of

from contactlab.laws.base import FREE, Friction
from contactlab.laws.composed import Composed
from contactlab.laws.friction import BoucWen, Dahl, ElastoPlastic, LuGre, Mindlin
from contactlab.laws.normal import Linear, WaltonBraun
from contactlab.testing.plants import block, run

WEIGHT, STIFFNESS, MU = 10.0, 1e7, 0.3

REMEMBERING = pytest.mark.parametrize(
    "friction", [Mindlin(), LuGre(), ElastoPlastic()], ids=lambda friction: friction.name
)


def test_the_energy_of_a_stretched_spring_is_stored_and_not_lost() -> None:
    """A block swings on Mindlin's spring without sliding: contact energy 1/2 k_t z^2, no friction loss."""
    ratio = 0.5
    law = Composed(Linear(STIFFNESS), friction=Mindlin(MU, ratio))
    period = 2.0 * np.pi / np.sqrt(ratio * STIFFNESS)
    push = 0.4 * MU * WEIGHT
    motor = block(1.0, height=-WEIGHT / STIFFNESS, weight=WEIGHT, push=push)
    series = run(motor, law, 2.0 * period, 1e-5, period / 64.0).series
    rate = np.sqrt(ratio * STIFFNESS)
    time = np.arange(series["gap"].size) * period / 64.0
    way = push / (ratio * STIFFNESS) * (1.0 - np.cos(rate * time))
    stored = 0.5 * ratio * STIFFNESS * way**2
    pressed = 0.5 * WEIGHT**2 / STIFFNESS
    assert_allclose(series["contact_energy"] - pressed, stored, atol=1e-6 * stored.max())
    assert np.abs(series["friction_loss"]).max() < 1e-6 * stored.max()


@REMEMBERING
def test_every_touch_down_begins_without_memory(friction: Friction) -> None:
    """Two equal throws: the second contact is the first, though the first has stretched its spring."""
    law = Composed(Linear(STIFFNESS), friction=friction)
    mass, speed = 2e-3, 0.1
    rate = 2.0 * np.pi * 40.0

    def thrown(velocity: float) -> dict[str, np.ndarray]:
        motor = block(mass, gap_rate=-speed, velocity=velocity, normal_stiffness=mass * rate**2)
        return run(motor, law, 0.03, 1e-6).contacts

    contacts = thrown(0.02)
    assert contacts["start_time"].size > 1
    # What comes down the second time has the slip that the first contact left.
    again = thrown(0.02 + contacts["friction_impulse"][0] / mass)
    assert_allclose(contacts["friction_impulse"][1], again["friction_impulse"][0], rtol=1e-6)


def bounces_on_its_dent(normal: WaltonBraun, friction: Any, end: float) -> list[np.ndarray]:
    """A body over its dent by itself: depth, its rate, slip and deflection at every release.

    It loads along k_1 until it first stops; from there on it meets the dent along k_2. The deflection stays
    while it is apart.
    """
    soft, stiff = normal.loading_stiffness, normal.unloading_stiffness

    def motion(t: float, y: np.ndarray, stiffness: float, dent: float) -> list[float]:
        pressed = stiffness * max(y[0] - dent, 0.0)
        push, rate, _, _ = state_of(friction, pressed, y[2], y[3], stiffness)
        return [y[1], (BOUNCING_WEIGHT - pressed) / BOUNCING, push / BOUNCING, rate if pressed > 0.0 else 0.0]

    def stops(t: float, y: np.ndarray, *_: float) -> float:
        return float(y[1])

    def crosses(t: float, y: np.ndarray, stiffness: float, dent: float) -> float:
        return float(y[0] - dent)

    stops.terminal = crosses.terminal = True  # type: ignore[attr-defined]
    tight: Any = {"method": "DOP853", "rtol": 1e-12, "atol": [1e-18, 1e-13, 1e-13, 1e-18]}
    made = solve_ivp(motion, (0.0, end), [0.0, IMPACT, SLIP, 0.0], events=stops, args=(soft, 0.0), **tight)
    time, y, inside, releases = made.t[-1], made.y[:, -1], True, []
    dent = y[0] * (1.0 - soft / stiff)
    while time < end:
        crosses.direction = -1.0 if inside else 1.0  # type: ignore[attr-defined]
        made = solve_ivp(motion, (time, end), y, events=crosses, args=(stiff, dent), max_step=2e-7, **tight)
        time, y = made.t[-1], made.y[:, -1]
        if inside and time < end:
            releases.append(y)
        inside = not inside
    return releases


BOUNCING, BOUNCING_WEIGHT, IMPACT, SLIP = 2e-3, 5.0, 0.1, 0.2
"""A body that stays below the edge of its dent [kg], [N], [m/s], [m/s]."""

OVER_A_DENT = pytest.mark.parametrize("friction", [Dahl(MU), BoucWen(MU)], ids=lambda each: each.name)


@OVER_A_DENT
def test_friction_goes_on_over_a_dent_where_it_ended(friction: Friction) -> None:
    normal, end = WaltonBraun(1e7, 1e8), 1e-4
    releases = bounces_on_its_dent(normal, friction, end)
    thrown = {"gap_rate": -IMPACT, "velocity": SLIP, "weight": BOUNCING_WEIGHT}
    made = run(block(BOUNCING, **thrown), Composed(normal, friction=friction), end, record_interval=1e-6)
    rows, slips = made.contacts, np.array([SLIP, *(y[2] for y in releases)])
    assert rows["start_time"].size == len(releases) == 2
    assert_allclose(rows["internal_deflection"], [y[3] for y in releases], rtol=1e-7)
    assert_allclose(rows["friction_impulse"], BOUNCING * np.diff(slips), rtol=1e-7)
    # Nothing is left stored in flight, and the books are closed.
    apart = made.contact_mode == FREE
    ended = rows["start_time"][0] + rows["duration"][0]
    assert_allclose(made.series["internal_deflection"][apart & (made.time > ended)][0], releases[0][3])
    assert np.abs(made.series["contact_energy"][apart]).max() == 0.0
    energy = 0.5 * BOUNCING * (IMPACT**2 + SLIP**2)
    assert np.abs(made.series["energy_residual"]).max() < 1e-9 * energy
    lost = made.series["friction_loss"][-1] + made.series["contact_loss"][-1]
    assert_allclose(rows["energy_loss"].sum(), lost, rtol=1e-12)


@OVER_A_DENT
def test_friction_begins_anew_once_the_gap_is_clear_of_the_dent(friction: Friction) -> None:
    thrown = block(BOUNCING, gap_rate=-IMPACT, velocity=SLIP)
    made = run(thrown, Composed(WaltonBraun(1e7, 1e8), friction=friction), 2e-4, record_interval=1e-6)
    gap, deflection = made.series["gap"], made.series["internal_deflection"]
    over_the_dent = (made.contact_mode == FREE) & (gap < 0.0)
    assert np.all(deflection[over_the_dent & (made.time > 0.0)] > 0.0)
    # It is forgotten at the end of a flight step.
    assert gap[-1] > 1e-6
    assert deflection[-1] == 0.0
