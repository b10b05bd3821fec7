"""Laws of evolution of rate and state: steps of the velocity, rest, and a block on a spring."""

from collections.abc import Callable
from math import exp, log, sqrt
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp

import contactlab as cl
from contactlab.laws.friction.rate_and_state import StateFriction
from contactlab.testing.plants import block, run

MU, A, B, D, V0, NORMAL = 0.4, 0.01, 0.015, 1e-5, 1e-6, 5.0
B2, D2, C = -0.004, 2.5e-6, 2.0
COMMON: dict[str, Any] = {
    "friction_coefficient": MU,
    "direct_effect": A,
    "evolution_effect": B,
    "renewal_distance": D,
    "reference_velocity": V0,
    "creep_velocity": 1e-14,
}
KINDS: dict[str, Callable[..., StateFriction]] = {
    "rate_and_state": cl.RateAndState,
    "ruina": cl.Ruina,
    "perrin_rice_zheng": cl.PerrinRiceZheng,
    "nagata": lambda **keys: cl.Nagata(stress_weakening=C, **keys),
    "two_state": lambda **keys: cl.TwoState(second_effect=B2, second_distance=D2, **keys),
}
NAMES = list(KINDS)


def made(name: str, **changes: float) -> StateFriction:
    """Return a friction whose least creep is far below all slips here."""
    return KINDS[name](**COMMON | changes)


def steady(speed: float, name: str = "") -> float:
    """Return |F|/N in steady slip."""
    return MU + (A - B - (B2 if name == "two_state" else 0.0)) * log(speed / V0)


def stepped(name: str, before: float, after: float, times: np.ndarray) -> np.ndarray:
    """Return |F|/N at times after a step of the velocity from steady slip, in closed form.

    The slip law has z exponential in slip. The ageing law has theta exponential; Nagata's over (1 + c) D and
    from an age that the leap of the stress has changed. Of Perrin, Rice and Zheng
    theta = (2 D/v) tanh(v t/(2 D) + artanh(v theta/(2 D))), with coth for a contact that is older.
    """
    leap, way = log(after / before), after * times
    if name in ("ruina", "two_state"):
        first = B * leap * -np.expm1(-way / D)
        second = B2 * leap * -np.expm1(-way / D2) if name == "two_state" else 0.0
        return steady(before, name) + A * leap - first - second
    if name == "perrin_rice_zheng":
        # (1 - q)/(1 + q) of q = v theta/(2 D) falls as exp(-v t/D).
        q = after / before
        left = (1.0 - q) / (1.0 + q) * np.exp(-way / D)
        return steady(after) + B * np.log((1.0 - left) / (1.0 + left))
    c = C if name == "nagata" else 0.0
    # ln(v theta/D) right behind the step.
    age = leap - c / B * A * leap / (1.0 + c)
    return steady(after) + B * np.log1p(np.expm1(age) * np.exp(-way / ((1.0 + c) * D)))


def fresh_age(name: str, speed: float) -> float:
    """Return the age [s] of the contact in steady slip, of Nagata that under mu which has the same state."""
    if name == "nagata":
        return D / speed * exp(C / B * (steady(speed) - MU))
    return (2.0 if name == "perrin_rice_zheng" else 1.0) * D / speed


def steps(name: str, *speeds: float, ways: float = 12.0) -> tuple[np.ndarray, np.ndarray]:
    """Drive a friction by steps of the velocity, each over some D; return times of records and |F|/N."""
    law = cl.Composed(cl.Linear(1e7), friction=made(name, fresh_age=fresh_age(name, speeds[0])))
    lengths = [ways * D / speed for speed in speeds]
    time = np.append(0.0, np.cumsum(lengths))
    way = np.append(0.0, np.cumsum(np.multiply(lengths, speeds)))
    result = cl.drive(law, time, gap=-NORMAL / 1e7, slip=way, degree=1, record_interval=min(lengths) / 1000.0)
    assert result.complete
    return result["time"].values, -(result["friction_force"] / result["normal_force"]).values[1:]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("factor", [10.0, 0.1])
def test_a_step_of_the_velocity_is_its_closed_form(name: str, factor: float) -> None:
    before, after = V0, factor * V0
    time, ratio = steps(name, before, after)
    middle, step = 0.5 * (time[1:] + time[:-1]), 12.0 * D / before
    # Records are means over their interval, which a curve has over its middle but for its curvature.
    shift = 0.5 * (time[1] - time[0]) * sqrt(1.0 / 3.0)
    inside = middle > step + shift
    # The second of two states begins with the age of the first, and is soon steady.
    assert_allclose(ratio[(middle > 0.9 * step) & (middle < step - shift)], MU, rtol=1e-9)
    points = [stepped(name, before, after, middle[inside] - step + side * shift) for side in (-1.0, 1.0)]
    assert_allclose(ratio[inside], np.mean(points, axis=0), atol=1e-8)
    # At once, and in the end.
    share = 1.0 + C if name == "nagata" else 1.0
    at_once = float(stepped(name, before, after, np.zeros(1))[0])
    assert at_once - MU == pytest.approx(A * log(factor) / share, rel=1e-9)
    assert float(stepped(name, before, after, np.array([1e5]))[0]) == pytest.approx(steady(after, name))


def test_steps_up_and_down_are_mirror_images_over_slip_but_of_laws_with_ageing() -> None:
    """Ruina (1983). tanh and coth of Perrin, Rice and Zheng are such images, too."""
    way = np.linspace(0.0, 5.0, 51) * D
    for name in NAMES:
        up, down = (
            stepped(name, V0, speed, way / speed) - steady(speed, name) for speed in (30.0 * V0, V0 / 30.0)
        )
        mirrored = bool(np.abs(up + down).max() < 1e-12)
        assert mirrored == (name not in ("rate_and_state", "nagata")), name


@pytest.mark.parametrize(
    ("name", "share"), [("rate_and_state", 1.0), ("perrin_rice_zheng", 0.5), ("ruina", 0.0)]
)
@pytest.mark.parametrize("hold", [1e2, 1e4])
def test_rest_heals_by_b_a_fold_of_time_but_not_under_the_slip_law(
    name: str, share: float, hold: float
) -> None:
    """From steady slip at v_0 theta grows by the time: b ln(1 + v_0 t/D), with 2 D after Perrin et al."""
    law = cl.Composed(cl.Linear(1e7), friction=made(name, fresh_age=fresh_age(name, V0)))
    slides = 3.0 * D / V0
    time, way = np.array([0.0, slides, slides + hold]), np.array([0.0, 3.0 * D, 3.0 * D])
    result = cl.drive(law, time, gap=-NORMAL / 1e7, slip=way, degree=1)
    healed = B * float(result["internal_age"][-1])
    assert healed == pytest.approx(B * log(1.0 + share * V0 * hold / D), abs=1e-9)


def swinging(
    name: str, stiffness: float, mass: float, speed: float, off: float, times: np.ndarray
) -> np.ndarray:
    """Integrate the slip velocity [m/s] of a block on a belt, by the laws as they are published, in theta."""
    second = name == "two_state"
    size = 2.0 * D if name == "perrin_rice_zheng" else D

    def flow(_: float, y: np.ndarray) -> list[float]:
        stretch, slip, theta = y[0], np.exp(y[1]), np.exp(y[2])
        other = np.exp(y[3]) if second else 1.0
        ratio = MU + A * log(slip / V0) + B * log(V0 * theta / size)
        ratio += B2 * log(V0 * other / D2) if second else 0.0
        pulled = stiffness * stretch / mass - NORMAL * ratio / mass
        x = slip * theta / D
        rate, more = 1.0 - x, 0.0
        if name in ("ruina", "two_state"):
            rate, y2 = -x * log(x), slip * other / D2
            more = -y2 * log(y2) if second else 0.0
        elif name == "perrin_rice_zheng":
            rate = 1.0 - 0.25 * x * x
        elif name == "nagata":
            # 1 - v theta/D - (c theta/b) (a dv/dt/v + b dtheta/dt/theta), solved for dtheta/dt.
            rate = (rate - C * theta / B * A * pulled / slip) / (1.0 + C)
        return [speed - slip, pulled / slip, rate / theta, more / other]

    drag = steady(speed, name)
    begins = [NORMAL * drag / stiffness + off, log(speed), log(size / speed), log(fresh_age(name, speed))]
    solved = solve_ivp(flow, (0.0, times[-1]), begins, "Radau", times, rtol=1e-10, atol=1e-13)
    return np.exp(solved.y[1])


@pytest.mark.parametrize("name", NAMES)
def test_a_block_on_a_spring_swings_as_the_published_law_in_theta(name: str) -> None:
    speed, mass = 1e-3, 2e-3
    law = cl.Composed(cl.Linear(1e7), friction=made(name, fresh_age=fresh_age(name, speed)))
    # Near the critical stiffness of the ageing law, N (b - a)/D.
    stiffness, off, drag = 1.1 * NORMAL * (B - A) / D, 2e-6, NORMAL * steady(speed, name)
    motor = block(
        mass,
        height=-NORMAL / 1e7,
        weight=NORMAL,
        way=drag / stiffness + off,
        stiffness=stiffness,
        belt_velocity=speed,
    )
    duration = 12.0 * D / speed
    result = run(motor, law, duration, duration / 400.0, duration / 400.0)
    expected = swinging(name, stiffness, mass, speed, off, result.time)
    assert expected.max() / expected.min() > 1.2
    assert_allclose(np.abs(result.series["slip_velocity"]), expected, rtol=1e-6)
