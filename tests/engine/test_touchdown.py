"""The first touch-down of a motor is that of its flight in closed form; what round-off does there."""

import numpy as np
import pytest
from support.flights import flight_of
from support.motors import case_a, default_motor, every_law, run

from contactlab.config import build
from contactlab.laws import ContactLaw

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


def test_a_touch_by_round_off_leaves_no_impulse() -> None:
    """The sums of a run are those of its contacts, of which there may be none."""
    options = (
        *("law=composed", "law/normal=lining", "law/damping=lankarani_nikravesh", "law/friction=cohesive"),
        *("law.normal.soft_stiffness=2e6", "law.normal.hard_stiffness=8e7", "law.normal.lining_depth=9e-7"),
        *("law.normal.passage=7e-8", "law.damping.restitution=0.96", "law.damping.least_speed=2.7e-3"),
        *("law.friction.static_ratio=5", "law.friction.cohesion=0.0157", "drive=two_mode"),
        *(
            "placement.start=0.01546",
            "placement.end=0.02427",
            "drive.voltage_1=0",
            "contact.clearance=0",
            "solver.duration=1.2e-3",
        ),
    )
    made = build(options).run()
    impulse = float(made.series["normal_force"][1:] @ np.diff(made.time))
    assert impulse == pytest.approx(made.contacts["normal_impulse"].sum(), rel=1e-12, abs=0.0)
