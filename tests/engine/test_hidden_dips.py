"""A gap that is open at every record and every end of a step, and closed in between, is a contact."""

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray
from support.flights import Flight, double_well, drive_through, flight_of
from support.motors import default_resonator, every_law, hertz, run

from contactlab.engine.plant import plant_of
from contactlab.engine.propagator import Propagator, Workspace
from contactlab.laws import ContactLaw, LagrangeSlip, LagrangeStick, MultiplierLaw
from contactlab.motor.motor import Motor

Array = NDArray[np.float64]

TONES = np.array([4e3, 8e3, 12e3, 16e3])
CURVATURE = 2e3
"""Of a single dip [m/s^2]: one of a nanometre is 2 us wide."""

laws = pytest.mark.parametrize("law", every_law(), ids=lambda law: law.name)


def ladder(motor: Motor, law: ContactLaw) -> Propagator:
    return Workspace().propagator(
        plant_of(motor), law.default_contact_step, 1.0, exact=isinstance(law, MultiplierLaw)
    )


def step_ends(motor: Motor, law: ContactLaw, duration: float) -> Array:
    """Ends of the steps of a flight from rest: they double up to the longest."""
    propagator = ladder(motor, law)
    steps = 0.5 ** np.arange(propagator.rule.fresh_level, 0, -1.0)
    lengths = np.append(steps, np.ones(int(duration / propagator.rule.longest) + 1))
    return np.append(0.0, propagator.rule.longest * np.cumsum(lengths))


def middle_of_step(law: ContactLaw, number: int) -> tuple[float, float]:
    """A time in the middle of a step under these tones, and the step's length [s]."""
    motor = shaped_motor(1e-4)
    ends = step_ends(motor, law, 1e-3)
    return float(ends[number : number + 2].mean()), float(ends[number + 1] - ends[number])


@cache
def shaped_motor(when: float) -> Motor:
    modes = default_resonator().modes
    u, th = np.array([np.nan, 0.0, -CURVATURE, 0.0]), np.zeros(4)
    return Motor(modes, drive_through(modes, TONES, when, u, th))


def assert_hidden(flight: Flight, law: ContactLaw, duration: float, interval: float) -> None:
    """Every sample up to the duration is open; the reference knows of a contact all the same."""
    ends = step_ends(flight.motor, law, duration)
    samples = np.append(ends[ends < duration], np.arange(0.0, duration, interval))
    assert flight.at(samples)[0].min() > 0.0
    assert flight.first_touch(duration) is not None


def assert_located(flight: Flight, law: ContactLaw, duration: float, interval: float) -> None:
    expected = flight.first_touch(duration)
    assert expected is not None
    trajectory = run(flight.motor, law, duration, interval)
    rate = abs(float(flight.at(expected)[1]))
    digit = flight.round_off(expected, trajectory.statistics["flight_steps"]) / rate
    assert digit < 1e-11
    result = trajectory.contacts["start_time"]
    assert result[0] == pytest.approx(expected, rel=0.0, abs=1e-15 + digit)


@laws
@pytest.mark.parametrize("depth", [1e-9, 1e-12, 1e-15])
def test_a_dip_within_one_step_is_found_however_shallow(law: ContactLaw, depth: float) -> None:
    when, step = middle_of_step(law, 30)
    flight = flight_of(shaped_motor(when)).lowered_to(-depth, when)
    assert_hidden(flight, law, when + 0.4 * step, step)
    assert_located(flight, law, when + 0.4 * step, step)


@laws
@pytest.mark.parametrize("tilt", [-4e-12, 0.0, 4e-12], ids=["second", "equal", "first"])
def test_of_two_dips_within_one_step_the_first_is_found(law: ContactLaw, tilt: float) -> None:
    when, step = middle_of_step(law, 30)
    half = 0.2 * step
    modes = default_resonator().modes
    well = double_well(modes, TONES, when, half, 1e-11, tilt)
    times, _ = well.minima(when + 2.0 * half)
    first, second = times[np.abs(times - when) < 2.0 * half]
    flight = well.lowered_to(-1e-12, float(first))
    assert_hidden(flight, law, when + 0.4 * step, step)
    assert float(flight.at(when)[0]) > 1e-12
    # Without tilt both dips count; with it the other one is deeper, or is none.
    assert np.sign(float(flight.at(second)[0])) == (1.0 if tilt > 0.0 else -1.0)
    expected = flight.first_touch(when + 0.4 * step)
    assert expected is not None
    assert expected < when
    assert_located(flight, law, when + 0.4 * step, step)


@laws
def test_a_first_dip_that_misses_does_not_hide_the_second(law: ContactLaw) -> None:
    when, step = middle_of_step(law, 30)
    half = 0.2 * step
    well = double_well(default_resonator().modes, TONES, when, half, 1e-11, -4e-12)
    times, _ = well.minima(when + 2.0 * half)
    flight = well.lowered_to(1e-13, float(times[np.abs(times - when + half).argmin()]))
    assert_hidden(flight, law, when + 0.4 * step, step)
    expected = flight.first_touch(when + 0.4 * step)
    assert expected is not None
    assert expected > when
    assert_located(flight, law, when + 0.4 * step, step)


@laws
def test_a_dip_within_the_very_first_step_is_found(law: ContactLaw) -> None:
    end = float(step_ends(shaped_motor(1e-4), law, 1e-6)[1])
    modes = default_resonator().modes
    # The tip rises from rest and falls again within 50 ns, which takes 150 kV.
    u, th = np.array([np.nan, 0.0, -CURVATURE]), np.zeros(3)
    drive = drive_through(modes, TONES, 0.5 * end, u, th)
    top = flight_of(Motor(modes, drive)).lowered_to(0.0, 0.5 * end)
    height = top.motor.geometry.clearance
    assert height > 1e-14
    flight = top.lowered_to(-0.3 * height, 0.5 * end)
    assert_hidden(flight, law, 1.5 * end, end)
    expected = flight.first_touch(end)
    assert expected is not None
    assert expected < 0.5 * end
    assert_located(flight, law, 1.5 * end, end)


@laws
@pytest.mark.parametrize("miss", [-1e-19, 1e-19])
def test_a_tangential_graze_is_decided_down_to_round_off(law: ContactLaw, miss: float) -> None:
    when, step = middle_of_step(law, 30)
    flight = flight_of(shaped_motor(when)).lowered_to(miss, when)
    result = run(flight.motor, law, when + 0.4 * step, step).contacts["start_time"]
    assert result.size == (1 if miss < 0.0 else 0)
    # The rate is 2e-8 m/s there, and the dip 20 ps wide.
    assert np.all(np.abs(result - when) < 2e-11)


@pytest.mark.parametrize("law", [LagrangeStick(0.3), LagrangeSlip(0.3)], ids=lambda law: law.name)
@pytest.mark.parametrize("depth", [1e-10, 1e-12])
def test_a_dip_within_one_step_in_time_pushes_back(law: ContactLaw, depth: float) -> None:
    when, step = middle_of_step(law, 30)
    flight = flight_of(shaped_motor(when)).lowered_to(-depth, when)
    contacts = run(flight.motor, law, when + 0.4 * step, step, contact_step=4e-6).contacts
    # At the end of a whole step the gap would be open again, as if nothing had been there.
    assert np.sqrt(8.0 * depth / CURVATURE) < 1e-6
    assert contacts["start_time"].size == 1
    assert contacts["normal_impulse"][0] > 0.0


def test_an_elastic_dip_is_left_where_the_flight_leaves_it() -> None:
    when, step = middle_of_step(hertz(), 30)
    flight = flight_of(shaped_motor(when)).lowered_to(-1e-13, when)
    contacts = run(flight.motor, hertz(), when + 0.4 * step, step).contacts
    # 1e-13 m do not push back yet: the contact is as long as the parabola is below zero.
    width = np.sqrt(8.0 * 1e-13 / CURVATURE)
    assert contacts["duration"] == pytest.approx([width], rel=1e-3)
    assert contacts["max_penetration"] == pytest.approx([1e-13], rel=1e-3)
