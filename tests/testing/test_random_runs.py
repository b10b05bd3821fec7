"""Random configurations of the command end as they must, and what they leave keeps every invariant.

`python tests/tools/random_runs.py` does the same for thousands; docs/random_runs.md has its figures.
"""

import shlex

import pandas as pd
import pytest
import random_runs as script
from random_configuration import law_groups
from support.command_line import Command, cases

from contactlab import load
from contactlab.metrics import INVARIANTS

NUMBERS = [*range(588, 600), *range(600, 1200, 5)]
"""Each law, and each fifth combination of the parts of a composed one; the script makes them all."""


@pytest.mark.parametrize("number", cases(NUMBERS, [*range(588, 600), *range(600, 1200, 100)]))
def test_a_random_configuration_is_refused_or_keeps_every_invariant(number: int) -> None:
    outcome = script.outcome_of(number)
    assert not script.broken(outcome), script.command_line(number)
    assert (outcome["ending"] == "complete") != bool(outcome["message"])


def test_a_tip_that_leaves_as_it_came_from_the_rotor_made_no_contact() -> None:
    # Without clearance and under one antisymmetric tone, round-off of 1e-43 m touches for 1e-19 s.
    outcome = script.outcome_of(736)
    assert (outcome["ending"], outcome["contacts"]) == ("complete", 0)
    assert not script.broken(outcome)


def test_a_number_gives_the_same_configuration_and_the_same_figures() -> None:
    first, again = (script.outcomes_of([3]).drop(columns="seconds") for _ in range(2))
    pd.testing.assert_frame_equal(first, again)
    assert script.command_line(3) == script.command_line(3) != script.command_line(3, seed=1)


def test_the_command_line_that_is_printed_is_that_run(command: Command) -> None:
    outcome = script.outcome_of(5)
    text = shlex.split(script.command_line(5))[1:]
    assert command(*text, "record.picture=false", "hydra.run.dir=here")[0] == 0
    assert load("here/run.nc").contacts.sizes["contact"] == outcome["contacts"]
    assert command("verify", "here")[0] == 0


def test_a_broken_invariant_is_counted() -> None:
    names = "hertz_penalty", "moreau_jean", "poisson"
    laws = [choice["law"] for choice in law_groups()]
    outcomes = script.outcomes_of([laws.index(name) for name in names])
    assert list(script.table(outcomes).index) == [*names]
    assert all(key in script.page(outcomes, "a test") for key in INVARIANTS)
    wrong = outcomes.assign(phantom_contacts=[0.5, 0.0, 0.0])
    assert [script.broken(row) for row in wrong.to_dict("records")] == [["phantom_contacts"], [], []]
