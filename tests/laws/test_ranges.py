"""range(START,STOP,STEP) has the values that were typed and ends before STOP, whatever round-off says."""

import pytest
from hydra.core.override_parser.overrides_parser import OverridesParser
from support.command_line import Command

from contactlab.cli.application import CONFIG_NAME, started
from contactlab.cli.composer import Composer
from contactlab.cli.map_plan import plan_of
from contactlab.cli.sweep_values import typed
from contactlab.sweeps.plan import Outputs

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
    found = typed(f"drive.phase={text}", OverridesParser.create()).listed
    assert list(found) == RANGES[text]
    assert [type(value) for value in found] == [type(value) for value in RANGES[text]]


@pytest.mark.parametrize("text", RANGES)
def test_a_sweep_of_folders_takes_the_same_values(text: str) -> None:
    with started() as hydra:
        composer = Composer(hydra.config_loader, CONFIG_NAME)
        jobs = composer.jobs(composer.parse([f"drive.phase={text}"]), None)
    assert composer.faults == []
    assert [job[0].value() for job in jobs] == RANGES[text]


def test_a_shuffled_range_keeps_its_values_and_a_sorted_one_its_order() -> None:
    with started() as hydra:
        composer = Composer(hydra.config_loader, CONFIG_NAME)

        def values(text: str) -> list[float]:
            jobs = composer.jobs(composer.parse([f"drive.phase={text}"]), None)
            return [float(job[0].value()) for job in jobs]  # type: ignore[arg-type]

        assert sorted(values("shuffle(range(0,3e-6,1e-6))")) == [0.0, 1e-6, 2e-6]
        backwards = values("sort(range(0,3e-6,1e-6),reverse=true)")
    assert backwards == pytest.approx([2e-6, 1e-6, 0.0], abs=1e-18)


def test_a_map_has_a_cell_for_each_value() -> None:
    lines = ["sweep.contact.clearance=range(0,3e-6,1e-6)"]
    with started() as hydra:
        plan = plan_of(hydra.config_loader, CONFIG_NAME, lines, Wanted(), None)
    assert plan.axes[0].values == (0.0, 1e-6, 2e-6)


def test_help_says_that_stop_is_none_of_the_values(command: Command) -> None:
    _, out, _ = command("map", "--help")
    assert "range(START,STOP,STEP) without STOP" in " ".join(out.split())
