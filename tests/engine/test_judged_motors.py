"""Random motors over every law and part end where the independent integrator of `tests/oracle` ends.

`python tests/tools/judged_motors.py` does the same for 245 of them; docs/judged_motors.md has its figures.
The bounds here are four times and more above the worst figures there.
"""

import numpy as np
import pytest
from support.command_line import cases
from support.judged_motors import DEFAULT, QUANTITIES, RIGID, TOTAL, case_of, judged, rows

ROWS = rows()
SHORT = [ROWS.index(name) for name in ("normal thornton", "friction mindlin", "newton")]

DENTS = [1003, 1007, 1009, 1011, 1014, 1015, 1016, 1023]
"""Touch down inside of a dent that a contact has left, or unload a spring that grows stiffer at once."""

KINKED = {"friction lugre", "friction elasto_plastic", "friction dahl", "friction bouc_wen", "mixed"}
"""Frictions whose rate has a kink where the slip reverses, at which no step of the engine ends."""


@pytest.mark.parametrize("number", cases([*range(TOTAL), *DENTS], SHORT))
def test_a_random_motor_ends_where_the_independent_integrator_ends(number: int) -> None:
    outcome = judged(number, (DEFAULT,))
    own = np.array([outcome[f"judge {name}"] for name in QUANTITIES])
    errors = np.array([outcome[f"{DEFAULT} {name}"] for name in QUANTITIES])
    if outcome["row"] in RIGID:
        # Of first order in the contact step, and bounces that die out are cut off by it.
        assert np.all(errors[:4] <= RIGID_BOUND + 10.0 * own[:4])
        return
    bound = KINKED_BOUND if outcome["row"] in KINKED else BOUND
    assert outcome[f"{DEFAULT} contacts"] == outcome["contacts"]
    assert np.all(errors <= bound + 10.0 * own)


BOUND, KINKED_BOUND, RIGID_BOUND = 2e-6, 3e-4, 5e-2


def test_every_row_has_its_motors() -> None:
    assert {case_of(number).row for number in range(len(ROWS))} == set(ROWS)
