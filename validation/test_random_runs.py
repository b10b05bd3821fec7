"""Random configurations of the command end as they must, and what they leave keeps every invariant.

`python validation/random_runs.py` does the same for thousands; docs/random_runs.md has its figures.
"""

import shlex

import numpy as np
import pandas as pd
import pytest
import random_runs as script
from random_configuration import law_groups
from support.command_line import Command, cases

import contactlab as cl
from contactlab.metrics import INVARIANTS, Run, assess
from contactlab.trajectory import Ending

FIRST = 108
"""The last share of the laws begins here, the parts of the composed law follow."""

SOME = [*range(FIRST, FIRST + 12), *range(FIRST + 12, len(law_groups()), 25)]
SHORT = SOME[1::3]
MAUGIS = [
    len(law_groups()) + place
    for place, choice in enumerate(law_groups())
    if choice.get("law/normal") == "jkr"
]


@pytest.mark.parametrize(
    "number", cases({*SOME, *range(FIRST, len(law_groups()), 4), *MAUGIS}, [*SHORT, *MAUGIS[:2]])
)
def test_a_random_configuration_is_refused_or_keeps_every_invariant(number: int) -> None:
    outcome = script.outcome_of(number)
    assert not script.broken(outcome), script.command_line(number)
    assert (outcome["ending"] == "complete") != bool(outcome["message"])


def test_an_impulse_that_ends_the_slip_of_a_rigid_contact_is_in_its_sum() -> None:
    # The slip begins with round-off, friction turns it round, and its end is located at 1e-13 m/s. Its way,
    # which round-off decides, may lead into Painleve's paradox: of neighbours most reach their end.
    setup = script.setup_of(3800)
    clearance = setup.motor.geometry.clearance
    nearby = [setup.with_(f"contact.clearance={clearance * (1.0 + 1e-12 * k)!r}") for k in range(8)]
    complete = [(each, run) for each in nearby if (run := each.run()).complete]
    assert len(complete) >= 4
    for each, run in complete:
        figures = assess(Run.of_trajectory(run, each.configuration), {"rotor_momentum"})
        assert figures["rotor_momentum"] < 1e-12


def test_a_damping_whose_force_the_sweeps_of_a_step_cannot_follow_takes_newton_steps() -> None:
    # It sticks where normal and friction force move the tip nearly alike, and relaxes within a step.
    outcome = script.outcome_of(9896)
    assert outcome["ending"] == "complete"
    assert not script.broken(outcome)
    assert outcome["steps"] < 20_000


@pytest.mark.parametrize(
    "number",
    [
        pytest.param(881, id="rings with thousands of kinks at a small tolerance"),
        pytest.param(20407, id="rings that fill within picometres of a line"),
        pytest.param(20680, id="a lining whose stage ends in its hard part"),
    ],
)
def test_a_step_that_ends_at_a_kink_is_no_stall(number: int) -> None:
    outcome = script.outcome_of(number)
    assert outcome["ending"] == "complete"
    assert not script.broken(outcome)


def test_a_step_that_is_too_long_for_the_fastest_mode_is_named_with_the_angle_that_it_turns() -> None:
    setup = script.setup_of(8793)
    assert setup.contact_step is not None
    long, short = setup.run(), setup.run(contact_step=setup.contact_step / 8)
    assert (long.ending, short.ending) == (Ending.UNBALANCED, Ending.COMPLETE)
    angle = setup.contact_step * np.sqrt(setup.motor.modes.stiffness.max())
    assert f"{angle:.2g} rad" in long.message


GRAZING = """
    law=hertz_penalty resonator=finite_element resonator.kept_modes=14
    resonator.mass_damping=18.692532639380058
    resonator.stiffness_damping=0 resonator.tip_mass=0.0007741433410662654
    resonator.tip_inertia=1.8819730310364226e-08 placement.start=0.014603482215299515
    placement.end=0.027484565836893113 drive.voltage_1=0 drive.voltage_2=20.24485620648313
    drive.frequency=5272.750835666867 drive.frequency_ratio=0.07972715647978822 contact.clearance=0
    contact.friction_coefficient=0 contact.tip_length=0.0164288958243675 rotor.radius=0.021707948819773743
    rotor.inertia=1.5683402436694062e-07 rotor.damping=3.453419464127366e-06
    solver.duration=0.0033657711140671334
"""


def test_a_tip_that_leaves_as_it_came_from_the_rotor_made_no_contact() -> None:
    # Without clearance and under one antisymmetric tone, round-off of 1e-43 m touches for 1e-19 s.
    run = cl.simulate(cl.build(GRAZING.split()))
    assert run.complete
    assert run.contacts.sizes["contact"] == 0


@pytest.mark.parametrize(
    ("figure", "wrong"), [("cut_difference", -0.01), ("change_difference", 0.01), ("bearing_momentum", 0.01)]
)
def test_the_search_sees_a_wrong_cut_change_or_bearing(figure: str, wrong: float) -> None:
    text = ["contact.preload=2", "solver.duration=1 ms", "record.interval=2 us"]
    if figure == "change_difference":
        text.append("solver.changes=['0.6 ms; contact.preload=4']")
    setup = cl.build(text)
    run, (bound, measure) = setup.run(), script.OWN[figure]
    assert measure(setup, run) <= bound
    # Another preload, of which nothing tells.
    other = cl.build([*text, f"contact.preload={2 + 100 * wrong}"])
    assert measure(other, run) > bound


def test_a_number_gives_the_same_configuration_and_the_same_figures() -> None:
    first, again = (script.outcomes_of([3]).drop(columns="seconds") for _ in range(2))
    pd.testing.assert_frame_equal(first, again)
    assert script.command_line(3) == script.command_line(3) != script.command_line(3, seed=1)


def test_the_command_line_that_is_printed_is_that_run(command: Command) -> None:
    outcome = script.outcome_of(5)
    text = shlex.split(script.command_line(5))[1:]
    assert command(*text, "record.picture=false", "hydra.run.dir=here")[0] == 0
    assert cl.load("here/run.nc").contacts.sizes["contact"] == outcome["contacts"]
    assert command("verify", "here")[0] == 0


def test_a_broken_invariant_is_counted() -> None:
    names = "hertz_penalty", "moreau_jean", "poisson"
    laws = [choice["law"] for choice in law_groups()]
    outcomes = script.outcomes_of([laws.index(name) for name in names])
    assert list(script.table(outcomes).index) == [*names]
    assert all(key in script.page(outcomes, "a test") for key in INVARIANTS)
    wrong = outcomes.assign(phantom_contacts=[0.5, 0.0, 0.0])
    assert [script.broken(row) for row in wrong.to_dict("records")] == [["phantom_contacts"], [], []]
