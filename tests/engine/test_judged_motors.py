"""Random motors over every law and part end where the independent integrator of `tests/oracle` ends.

`python tests/tools/judged_motors.py` does the same for 245 of them; docs/judged_motors.md has its figures.
The bounds here are four times and more above the worst figures there.
"""

import numpy as np
import pytest
from oracle import solve_hertz
from oracle.composed import Judge, Parts
from oracle.friction_parts import SetValued
from oracle.motor import OracleMotor
from oracle.normal_parts import Jkr, Power, elliptic_stiffness, loss_number
from support.command_line import cases
from support.judged_motors import DEFAULT, DURATION, QUANTITIES, RIGID, TOTAL, case_of, judged, of_judge, rows

ROWS = rows()
SHORT = [ROWS.index(name) for name in ("normal thornton", "friction mindlin", "friction stribeck", "newton")]

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


def test_the_two_oracles_agree() -> None:
    # One flies by DOP853 with the ledger in its state, the other by a matrix exponential.
    motor = OracleMotor(frequency=3210.0)
    other = Judge(motor, Parts(Power(1e10, 1.5), SetValued(0.3)), 1e-10).run(DURATION)
    run = solve_hertz(motor, 1e10, DURATION)
    assert other.rotor_velocity == pytest.approx(run.rotor_velocity, rel=1e-7)
    assert of_judge(other)["normal_impulse"] == pytest.approx(run.normal_impulse.sum(), rel=1e-8)
    assert other.durations == pytest.approx(run.duration, rel=1e-7)


def test_the_parts_have_their_published_numbers() -> None:
    radius, modulus, work = 4e-3, 1e11, 0.1
    neck = Jkr(radius, modulus, work)
    pull_off = 1.5 * np.pi * work * radius
    assert neck.spring(0, 0.0, 0.0, [])[0] == pytest.approx(-8.0 / 9.0 * pull_off, rel=1e-12)
    assert neck.spring(0, neck.break_depth, 0.0, [])[0] == pytest.approx(-5.0 / 9.0 * pull_off, rel=1e-12)
    # Equal radii are a sphere's.
    sphere = elliptic_stiffness(radius, radius, modulus)
    assert sphere == pytest.approx(4.0 / 3.0 * modulus * radius**0.5, rel=1e-12)
    nearly = elliptic_stiffness(radius, 1.001 * radius, modulus)
    assert nearly == pytest.approx(sphere * 1.001**0.25, rel=1e-6)
    # Nearly elastic: D = 3/2 (1 - e).
    assert loss_number(0.9999) == pytest.approx(1.5e-4, rel=1e-3)
