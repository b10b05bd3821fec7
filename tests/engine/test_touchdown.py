"""No contact is ever stepped over, and none is invented: the first touch of every flight is found."""

from functools import cache

import numpy as np
import pytest
from support.motors import case_a, default_motor, every_law, run

from contactlab.laws import ContactLaw
from contactlab.motor.motor import Motor
from contactlab.testing.flights import Flight, flight_of

TIME_DIGIT = 1e-12
"""Touch-downs are known to better than this [s]: gap round-off 1e-21 m over rates above 1e-8 m/s."""

DURATION = 1e-3


def touch_downs(motor: Motor, law: ContactLaw, duration: float, interval: float = 1e-6) -> list:
    return run(motor, law, duration, interval).contacts["start_time"].tolist()


@cache
def lowest_minimum() -> tuple[Flight, float]:
    """The vibration of case A under a rotor far away, and when its tip first comes highest."""
    far = flight_of(default_motor(clearance=1e-5))
    times, heights = far.minima(DURATION)
    return far, float(times[np.argmin(heights)])


def dipping(depth: float) -> tuple[Flight, float]:
    """Case A with a clearance at which the lowest point of the gap is -depth, and its time."""
    far, when = lowest_minimum()
    flight = far.lowered_to(-depth, when)
    assert float(flight.at(when)[0]) == pytest.approx(-depth, rel=1e-6)
    return flight, when


@pytest.mark.parametrize("law", every_law(), ids=lambda law: law.name)
@pytest.mark.parametrize("above", [1e-12, 1e-15])
def test_passing_a_picometre_above_the_rotor_is_no_contact(law: ContactLaw, above: float) -> None:
    flight, when = dipping(-above)
    assert touch_downs(flight.motor, law, when + 2e-5) == []


@pytest.mark.parametrize("law", every_law(), ids=lambda law: law.name)
@pytest.mark.parametrize("contact_step", [1e-8, 1e-6, 2e-5])
def test_first_touch_down_does_not_depend_on_law_or_step(law: ContactLaw, contact_step: float) -> None:
    expected = flight_of(case_a()).first_touch(2e-4)
    trajectory = run(case_a(), law, 2e-4, 1e-6, contact_step)
    assert trajectory.contacts["start_time"][0] == pytest.approx(expected, abs=TIME_DIGIT)


@pytest.mark.parametrize("law", every_law(), ids=lambda law: law.name)
def test_a_gap_that_closes_from_the_first_instant_is_touched_where_it_closes(law: ContactLaw) -> None:
    # The phase is such that the tip rises at once and never first opens the gap.
    motor = default_motor(phase=np.pi / 2.0, clearance=2e-7)
    if float(flight_of(motor).at(1e-6)[1]) > 0.0:
        motor = default_motor(phase=-np.pi / 2.0, clearance=2e-7)
    flight = flight_of(motor)
    expected = flight.first_touch(1e-4)
    assert expected is not None
    assert np.all(flight.at(np.linspace(1e-7, expected, 200))[1] < 0.0)
    assert touch_downs(motor, law, 1e-4)[0] == pytest.approx(expected, abs=TIME_DIGIT)
