"""Random motors over every law and part end where the independent integrator of `validation/oracle` ends.

`python validation/judged_motors.py` does the same for 245 of them; docs/judged_motors.md has its figures.
The bounds here are four times and more above the worst figures there.
"""

import numpy as np
import pytest
from support.command_line import cases
from random_motors import BOTH, DEFAULT, KINDS, QUANTITIES, RIGID, TOTAL, case_of, judged, kind_of, rows

ROWS = rows()
SHORT = [
    ROWS.index(name) + KINDS.index(kind) * len(ROWS)
    for name, kind in (
        ("normal thornton", "plain"),
        ("friction mindlin", "bearing"),
        ("hertz_penalty", "changes"),
        ("newton", "bearing and changes"),
    )
]

EVERY = [number + number % len(KINDS) * len(ROWS) for number in range(len(ROWS))]
"""A motor of every row, the kinds in turn."""

DENTS = [1003, 1007, 1009, 1011, 1014, 1015, 1016, 1023]
"""Touch down inside of a dent that a contact has left, or unload a spring that grows stiffer at once."""

KINKED = {"friction lugre", "friction elasto_plastic", "friction dahl", "friction bouc_wen", "mixed"}
"""Frictions whose rate has a kink where the slip reverses, at which no step of the engine ends."""


# SciPy's Radau tries ever larger differences where a force does not depend on a state.
@pytest.mark.filterwarnings("ignore:overflow encountered in multiply:RuntimeWarning")
@pytest.mark.parametrize("number", cases({*SHORT, *EVERY, *DENTS}, SHORT))
def test_a_random_motor_ends_where_the_independent_integrator_ends(number: int) -> None:
    outcome = judged(number, (DEFAULT,))
    own = np.array([outcome[f"judge {name}"] for name in QUANTITIES])
    errors = np.array([outcome[f"{DEFAULT} {name}"] for name in QUANTITIES])
    if outcome["row"] in RIGID:
        # Bounces that die out end at another speed in the integrator; it books no work.
        errors, own = np.delete(errors[:4], 2), np.delete(own[:4], 2)
    bound = KINKED_BOUND if outcome["row"] in KINKED else BOUND
    assert outcome[f"{DEFAULT} contacts"] == outcome["contacts"]
    assert np.all(errors <= bound + 10.0 * own)


BOUND, KINKED_BOUND = 2e-6, 3e-4


def test_every_row_has_its_motors() -> None:
    assert {case_of(number).row for number in range(len(ROWS))} == set(ROWS)


def test_every_row_but_johnson_has_every_kind_of_motor() -> None:
    pairs = {(number % len(ROWS), kind_of(number)) for number in range(TOTAL)}
    assert len(pairs) == len(ROWS) * len(KINDS) - 2
    case = case_of(KINDS.index(BOTH) * len(ROWS))
    assert case.later
    assert case.motor.preload is not None
