"""Swept values are those that were typed: a range ends before STOP whatever round-off says."""

import pytest
from support.command_line import Command
from support.sweeps import METRICS_ALONE, QUICK, Simulations

from contactlab.studies.sweep.collection import collect
from contactlab.studies.sweep.values import short_names, spread

RANGES = {
    "range(0,3e-6,1e-6)": [0.0, 1e-6, 2e-6],
    "range(0,1,0.1)": [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9],
    "range(0,0.95,0.1)": [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9],
    "range(1e-6,0,-2.5e-7)": [1e-6, 7.5e-7, 5e-7, 2.5e-7],
    "range(3)": [0, 1, 2],
    "range(2,9,3)": [2, 5, 8],
}


@pytest.mark.parametrize("text", RANGES)
def test_a_range_has_the_values_that_were_typed(text: str) -> None:
    result = spread("drive.phase", text)
    assert result == RANGES[text]
    assert [type(value) for value in result] == [type(value) for value in RANGES[text]]


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("range(0 um,3 um,1 um)", [0.0, 1.0, 2.0]),
        ("geomspace(1 um,4e-6,3)", [1.0, 2.0, 4.0]),
        ("sort(range(0,3e-6,1e-6),reverse=true)", [2.0, 1.0, 0.0]),
    ],
)
@pytest.mark.long
def test_sweeps_of_folders_and_of_metrics_take_the_same_values(
    command: Command, simulations: Simulations, text: str, values: list[float]
) -> None:
    swept = f"contact.clearance={text}"
    assert command("-m", swept, *QUICK)[0] == 0
    assert simulations.seen == values
    status, _, err = command(*METRICS_ALONE, swept, "solver.duration=0.1 ms", "hydra.sweep.dir=alone")
    assert status == 0, err
    assert sorted(collect("alone")["clearance"].values.tolist()) == pytest.approx(
        collect("sweep")["clearance"].values.tolist(), abs=1e-18
    )


def test_a_shuffled_range_keeps_its_values(command: Command, simulations: Simulations) -> None:
    assert command("-m", "contact.clearance=shuffle(range(0,3e-6,1e-6))", *QUICK)[0] == 0
    assert sorted(simulations.seen) == [0.0, 1.0, 2.0]


def test_a_name_is_the_shortest_tail_of_its_key_that_no_other_has() -> None:
    keys = ["contact.clearance", "law", "law/normal", "law.normal.stiffness", "law.friction.stiffness"]
    assert [*short_names([*keys, "law.restitution"], {"restitution"}).values()] == [
        *("clearance", "law", "normal", "normal_stiffness", "friction_stiffness", "law_restitution")
    ]
