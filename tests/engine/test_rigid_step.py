"""Every step in rigid contact ends on the closed gap, as the corrector of the paper has it."""

import numpy as np
import pytest
from support.motors import case_a, default_motor, run

from contactlab.laws import LagrangeSlip, LagrangeStick

STEP = 1e-6

laws = pytest.mark.parametrize("law", [LagrangeStick(0.3), LagrangeSlip(0.3)], ids=lambda law: law.name)


@laws
def test_every_whole_step_ends_on_the_closed_gap(law: LagrangeStick | LagrangeSlip) -> None:
    touch = float(run(case_a(), law, 2e-4, 1e-6, STEP).contacts["start_time"][0])
    for steps in (1, 2, 4, 8):
        # A little further, so that the last step is whole: a step that is cut is not projected.
        end = touch + steps * STEP * (1.0 + 1e-9)
        made = run(case_a(), law, end, end, STEP)
        assert made.contact_mode[-1] != 0
        # The round-off of a distance of 25 mm; without the corrector the gap is 1e-10 m and more.
        assert abs(made.series["gap"][-1]) < 1e-15
        assert np.isnan(made.contacts["separation_velocity"][-1])


@laws
def test_a_release_is_where_the_force_ends_and_not_where_the_step_does(
    law: LagrangeStick | LagrangeSlip,
) -> None:
    def duration(step: float | None) -> float:
        return float(run(default_motor(clearance=3e-7), law, 2e-3, 1e-4, step).contacts["duration"][0])

    coarse, fine = duration(2.0 * STEP), duration(STEP)
    # Its error falls smoothly, at first order: what is left by Richardson is a hundredth of a step.
    assert abs(2.0 * fine - coarse - duration(None)) < 0.02 * STEP
