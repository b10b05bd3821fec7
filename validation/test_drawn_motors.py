"""Contrasts of drawn motors are those of the independent solver, to a thousandth of themselves.

Both laws of a contrast need an orbit whose section lies in flight: motions that do not repeat themselves, and
motors that are in contact throughout, are left out, and so is the contrast of rigid and elastic stick (see
`drawn_motors`).
"""

from math import log

import pytest
from drawn_motors import JUDGED, Drawn
from law_contrasts import CONTRASTS
from support.command_line import cases

MOTORS, SHORT = (*range(8), 9, 10), (3,)

CLOSE = 1e-3
"""Largest difference of two contrasts over their size."""

LEAST = 1e-6
"""Contrast below which two laws are one to the tolerance of an orbit."""


@pytest.mark.parametrize("number", cases(MOTORS, SHORT))
def test_contrasts_are_those_of_the_independent_solver(number: int) -> None:
    motor = Drawn(number)
    speeds = {}
    for law in JUDGED:
        state = motor.steady(law)
        if state is not None and state.orbit is not None and state.orbit.map.contact is None:
            speeds[law] = abs(state.velocity.value), abs(motor.again(law, state))
    pairs = [pair for pair in CONTRASTS.values() if {*pair} <= {*speeds}]
    assert pairs
    for first, second in pairs:
        own, again = (log(a / b) for a, b in zip(speeds[first], speeds[second], strict=True))
        assert again == pytest.approx(own, rel=CLOSE, abs=CLOSE * LEAST), f"{first}, {second}"
