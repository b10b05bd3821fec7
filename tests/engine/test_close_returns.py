"""A gap that opens for an instant within a contact: the touch-down right after a release is not late.

The contact is so soft that it does not push: the motion is the free flight's throughout, below zero
as well, and the times at which the gap opens and closes are known.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq
from support.flights import Flight, flight_of
from support.motors import default_motor, hertz, run

from contactlab.motor.drive import Drive

SOFT = hertz(0.0, stiffness=1e-6)
"""Pushes with 1e-15 N at the depths below."""


@cache
def highest_point() -> tuple[Flight, float, float]:
    """A flight, when its gap has a maximum closer to the rotor than at rest, and its fall there."""
    volts = 100.0 * np.exp(1j * np.array([[1.5, 0.0], [1.5, 0.0]]))
    motor = replace(default_motor(clearance=1e-5), drive=Drive(np.array([1000.0, 9000.0]), volts))
    flight = flight_of(motor)
    time, gap, rate = flight.on_grid(1e-3)
    turns = (rate[:-1] > 0.0) & (rate[1:] < 0.0) & (gap[:-1] < 1e-5) & (time[:-1] > 5e-5)
    i = int(np.flatnonzero(turns)[0])
    when = zero(flight, 1, float(time[i]), float(time[i + 1]))
    rates = flight.at(np.array([when - 1e-8, when + 1e-8]))[1]
    return flight, when, float(rates[0] - rates[1]) / 2e-8


def zero(flight: Flight, which: int, left: float, right: float) -> float:
    """Where the gap (0) or its rate (1) vanishes [s]."""
    return float(brentq(lambda t: float(flight.at(t)[which]), left, right, xtol=1e-19, rtol=1e-15))


@pytest.mark.parametrize("height", [1e-10, 1e-12, 1e-13])
def test_a_touch_down_right_after_a_release_is_where_the_gap_closes(height: float) -> None:
    vibration, when, fall = highest_point()
    flight = vibration.lowered_to(height, when)
    half = np.sqrt(2.0 * height / fall)
    opens = zero(flight, 0, when - 1.5 * half, when)
    closes = zero(flight, 0, when, when + 1.5 * half)
    # Steps in contact are 4 us, and the gap opens for 1 us to 0.04 us between their nodes.
    trajectory = run(flight.motor, SOFT, when + 1e-6, 1e-5)
    contacts, counts = trajectory.contacts, trajectory.statistics
    assert contacts["start_time"].size == 2
    steps = counts["flight_steps"] + counts["contact_steps"]
    digit = flight.round_off(when, steps) / (fall * half)
    assert digit < 0.01 * half
    assert contacts["start_time"][1] == pytest.approx(closes, rel=0.0, abs=digit)
    released = contacts["start_time"][0] + contacts["duration"][0]
    assert released == pytest.approx(opens, rel=0.0, abs=digit)
    rate = float(flight.at(closes)[1])
    assert contacts["approach_velocity"][1] == pytest.approx(rate, rel=0.0, abs=fall * digit)
