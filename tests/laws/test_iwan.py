"""Iwan's elements: the microslip of Mindlin and Deresiewicz, and their hysteresis loops."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.testing import assert_allclose
from support.published import spheres_friction, spheres_loss

from contactlab.driving import drive
from contactlab.engine import simulate
from contactlab.laws import Composed, HertzPoint
from contactlab.laws.damping import HuntCrossley
from contactlab.laws.friction import Coulomb, Iwan
from contactlab.laws.friction.iwan import REVERSE, YIELD
from contactlab.laws.normal import Linear
from contactlab.motor import belt
from contactlab.testing.plants import block

Array = np.ndarray

MU, WHOLE, NORMAL = 0.3, 4e-7, 5.0
LIMIT = MU * NORMAL


class Driven:
    """Elements that are moved along a path under a constant normal force, by guards and jumps alone."""

    def __init__(self, friction: Iwan) -> None:
        self.friction, self.limits = friction, np.array(friction.coefficients()["limit"])
        self.z = np.zeros(len(friction.internal_variables))
        self.work, self.events = 0.0, 0

    def force(self) -> float:
        """The force against the slip [N]."""
        return -float(self.friction.evaluate("state", normal=NORMAL, z=self.z)[0])

    def ask(self, kernel: str, z: Array, which: int, **more: float) -> float:
        """A kernel at internal variables z."""
        return float(self.friction.evaluate(kernel, which=which, z=z, sliding=z[-1], **more))

    def move(self, way: float) -> float:
        """Move by a way [m] at 1 m/s; gives the force at its end."""
        slip, left = float(np.copysign(1.0, way)), abs(way)
        while True:
            rates = np.array([self.ask("rate", self.z, k, slip=slip) for k in range(self.z.size)])
            if self.ask("guard", self.z, 1, slip=slip) < 0.0:
                self.jump(1)
                continue
            # The guard of the next limit is that of a stretch that moves evenly: a way [m].
            ahead = self.ask("guard", self.z + left * rates, 0, slip=slip)
            step = left
            if ahead < 0.0:
                low, high = 0.0, left
                while high - low > 1e-16 * left and (middle := 0.5 * (low + high)) not in (low, high):
                    there = self.ask("guard", self.z + middle * rates, 0, slip=slip)
                    low, high = (middle, high) if there > 0.0 else (low, middle)
                step = high
            before = self.force()
            self.z = self.z + step * rates
            self.work += 0.5 * (before + self.force()) * step * slip
            left -= step
            if ahead >= 0.0:
                return self.force()
            self.jump(0)

    def jump(self, event: int) -> None:
        self.z = np.array([self.ask("jump", self.z, k, event=event) for k in range(self.z.size)])
        self.events += 1


def width(elements: int, least: float = 0.01) -> float:
    """Relative width of an element: d of the class."""
    first = np.arcsin(np.sqrt(least / 3.0))
    return float(2.0 * np.log(0.5 * np.pi / first) / (elements - 1))


def root_mean_square(errors: Array) -> float:
    return float(np.sqrt(np.mean(errors**2)))


def test_first_loading_is_that_of_spheres_in_the_second_order_of_the_number_of_elements() -> None:
    ways = np.linspace(0.0, 1.2 * WHOLE, 61)[1:]
    errors = []
    for n in (8, 16, 32):
        driven = Driven(Iwan(MU, n, WHOLE))
        forces = np.array([driven.move(way) for way in np.diff(ways, prepend=0.0)])
        errors.append(root_mean_square(forces / LIMIT - spheres_friction(ways / WHOLE)))
        # At x_s all slides.
        assert forces[-1] == pytest.approx(LIMIT, rel=1e-9)
    assert errors[-1] < width(32) ** 2 / 16.0
    assert_allclose(errors[:-1] / np.array(errors[1:]), [(15 / 7) ** 2, (31 / 15) ** 2], rtol=0.1)


def elements_loss(friction: Iwan, amplitude: float) -> float:
    """Loss [J] of a cycle of all elements, each of 4 f (A - f/k) as it begins to slide."""
    values = friction.coefficients()
    limits, stiffnesses = np.array(values["limit"]), NORMAL * np.array(values["stiffness"])
    return float(4.0 * np.sum(stiffnesses * limits * np.maximum(amplitude - limits, 0.0)))


def test_loss_of_a_cycle_is_that_of_spheres_in_the_second_order_of_the_number_of_elements() -> None:
    shares = np.linspace(0.05, 1.0, 200)
    closed = LIMIT * WHOLE * spheres_loss(shares)
    errors = []
    for n in (10, 20, 40, 80):
        result = np.array([elements_loss(Iwan(MU, n, WHOLE), share * WHOLE) for share in shares])
        errors.append(root_mean_square(result - closed) / closed[-1])
    assert errors[0] < 0.1 * width(10) ** 2
    orders = [(19 / 9) ** 2, (39 / 19) ** 2, (79 / 39) ** 2]
    assert_allclose(errors[:-1] / np.array(errors[1:]), orders, rtol=0.1)


def test_an_inner_loop_closes_and_the_outer_one_goes_on_as_if_there_had_been_none() -> None:
    plain, looped = Driven(Iwan(MU, 30, WHOLE)), Driven(Iwan(MU, 30, WHOLE))
    corner, _ = (driven.move(0.6 * WHOLE) for driven in (plain, looped))
    looped.move(-0.5 * WHOLE)
    before = looped.events
    assert looped.move(0.5 * WHOLE) == pytest.approx(corner, rel=1e-8)
    end = [driven.move(0.2 * WHOLE) for driven in (plain, looped)]
    assert end[1] == pytest.approx(end[0], rel=1e-8)
    # Those that slid within the loop do so one by one; those of before it slide on together, in one event.
    shares = looped.limits / WHOLE
    first = np.count_nonzero((shares < 0.25) | ((shares > 0.6) & (shares < 0.8)))
    assert looped.events - before <= first + 2


@settings(max_examples=15, deadline=None)
@given(
    st.lists(st.floats(-1.5, 1.5).filter(lambda x: abs(x) > 1e-3), min_size=1, max_size=12),
    st.integers(1, 15),
)
def test_guards_and_jumps_are_the_return_map_of_every_element(path: list[float], n: int) -> None:
    driven = Driven(Iwan(MU, n, WHOLE))
    limits, stretches = driven.limits, np.zeros(n)
    for way in path:
        force = driven.move(way * WHOLE)
        stretches = np.clip(stretches + way * WHOLE, -limits, limits)
        assert_allclose(driven.z[:n], stretches, atol=1e-9 * WHOLE)
        assert abs(force) <= LIMIT * (1.0 + 1e-9)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("elements", [1, 10, 77])
def test_elements_that_slid_have_a_way_to_go_once_the_slip_turns(elements: int, sense: float) -> None:
    """Else the turn and the next yield fire one after the other at the same instant, for ever."""
    law = Iwan(0.3, elements=elements, full_slip=5e-8)
    limit, full = np.array(law.coefficients()["limit"]), 5e-8
    beyond = sense * limit * (1.0 + 1e-9)
    turned = [
        Iwan.jump.py_func(which, REVERSE, beyond, sense * elements, limit, full)
        for which in range(elements + 1)
    ]
    assert turned[-1] == 0.0
    assert Iwan.guard.py_func(YIELD, -sense, np.array(turned[:-1]), 0.0, limit, full) > 0.0


def swings(stiffness: float, load: float, whole: float, start: float, count: int) -> Array:
    """Amplitudes [m] after each swing over a surface on which all elements slide every time.

    Of k (a^2 - b^2)/2 = L (a + b) - d for the friction L; d is what the elements save as they are stretched,
    int L (1 - x/x_s)^(3/2) dx at first, and by Masing's rule four times as much from then on.
    """
    amplitudes, a = [], start
    for saved in 0.4 * load * whole * np.r_[1.0, np.full(count - 1, 4.0)]:
        terms = [0.5 * stiffness, load, load * a - 0.5 * stiffness * a * a - saved]
        a = float(np.roots(terms).max())
        amplitudes.append(a)
    return np.array(amplitudes)


def test_elements_that_yield_one_after_the_other_are_no_chatter() -> None:
    """A body bounces eleven times within the pace of its first flight, with a hundred elements each."""
    speed, mass, flight = 0.1, 1e-3, 7e-4
    motor = block(mass, gap_rate=-speed, weight=2.0 * speed * mass / flight, belt_velocity=1.0)
    bounces = [
        simulate(
            motor,
            Composed(Linear(1e7), HuntCrossley(0.85, speed), friction),
            duration=6.0 * flight,
            record_interval=6.0 * flight,
        )
        for friction in (Iwan(0.1, 100, 1e-7), Coulomb(0.1))
    ]
    assert all(each.complete for each in bounces), bounces[0].message
    assert_allclose(*(each.contacts["separation_velocity"] for each in bounces), rtol=1e-6)
    assert bounces[0].contacts["start_time"].size == 11


def test_a_block_on_a_hundred_elements_swings_less_by_what_they_lose() -> None:
    whole, start, count = 1e-3, 15e-3, 12
    law = Composed(HertzPoint(1e10), friction=Iwan(MU, 100, whole))
    depth = (10.0 / 1e10) ** (2 / 3)
    motor = belt(1.0, 1e4, weight=10.0, belt_velocity=0.0, penetration=depth, displacement=start)
    half = np.pi / 100.0
    steps = {"record_interval": half / 100.0, "contact_step": 3e-3}
    ran = simulate(motor, law, duration=1.01 * count * half, **steps)
    assert ran.complete, ran.message
    x = np.abs(ran.series["tip_tangential_displacement"])
    turns = x[1:-1][(x[1:-1] > x[:-2]) & (x[1:-1] >= x[2:])]
    assert_allclose(turns, swings(1e4, MU * 10.0, whole, start, count), rtol=1e-3)


@pytest.mark.parametrize("amplitude", [1.0, 0.3, 0.1, 0.03, 0.01])
def test_a_cycle_of_any_amplitude_that_is_resolved_loses_what_spheres_lose(amplitude: float) -> None:
    """The bounds are those that the class derives; the engine runs half a cycle of a prescribed slip."""
    friction = Iwan(MU, full_slip=WHOLE)
    time = np.linspace(0.0, 1.0, 201)
    way = amplitude * WHOLE * np.sin(2.0 * np.pi * time)
    run = drive(
        Composed(Linear(1e7), friction=friction),
        time[:-1],
        normal=NORMAL,
        slip=way[:-1],
        degree=7,
        period=1.0,
    )
    loss = 2.0 * float(np.diff(np.interp([0.25, 0.75], run["time"], run["friction_loss"]))[0])
    d = width(friction.elements, friction.least_ratio)
    assert -0.6 * d**2 < loss / (LIMIT * WHOLE * spheres_loss(amplitude)) - 1.0 < d**2 / 6.0 + 0.02


@pytest.mark.parametrize(("elements", "least"), [(25, 0.01), (50, 0.01), (25, 0.1), (100, 1e-3)])
def test_the_loss_of_a_cycle_keeps_its_bounds_from_the_least_amplitude_on(
    elements: int, least: float
) -> None:
    d, friction = width(elements, least), Iwan(MU, elements, WHOLE, least)
    shares = np.geomspace(least, 1.0, 500)
    losses = np.array([elements_loss(friction, share * WHOLE) for share in shares])
    errors = losses / (LIMIT * WHOLE * spheres_loss(shares)) - 1.0
    assert -0.6 * d**2 < errors.min() < 0.0 < errors.max() < d**2 / 6.0 + 0.02
