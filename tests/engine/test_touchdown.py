"""The first touch-down of a motor is that of its flight in closed form."""

import numpy as np
import pytest
from support.motors import case_a, default_motor, every_law, run

from contactlab.laws import ContactLaw
from contactlab.testing.flights import flight_of

TIME_DIGIT = 1e-12
"""Touch-downs are known to better than this [s]: gap round-off 1e-21 m over rates above 1e-8 m/s."""


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
    assert run(motor, law, 1e-4, 1e-6).contacts["start_time"][0] == pytest.approx(expected, abs=TIME_DIGIT)
