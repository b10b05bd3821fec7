"""The folders of sweeps and their jobs: named by the overrides, so that they are found again."""

from pathlib import Path

import pytest
from support.command_line import Command
from support.sweeps import QUICK, Simulations, state_of

from contactlab.cli.start import MOST_CHARACTERS, folder_name

THREE = ("-m", "contact.clearance=1e-6,2e-6,3e-6", *QUICK)


def test_a_folder_that_is_named_by_numbers_keeps_them(command: Command, simulations: Simulations) -> None:
    numbered = [*THREE, "hydra.sweep.subdir=${hydra.job.num}"]
    simulations.endings = {1.0: RuntimeError("no luck"), 3.0: RuntimeError("no luck")}
    assert command(*numbered)[0] == 1
    simulations.endings = {}
    assert command(*numbered)[0] == 0
    assert simulations.seen == [1.0, 2.0, 3.0, 1.0, 3.0]
    assert [state_of(Path("sweep") / str(n))["state"] for n in range(3)] == ["complete"] * 3


def test_a_sweep_without_a_folder_finds_its_own_again(command: Command, simulations: Simulations) -> None:
    values = "contact.clearance=1 um,2 um"
    assert command("-m", "law=hertz_penalty", values, "record.picture=false")[0] == 0
    assert command("-m", "record.picture=false", values, "law=hertz_penalty")[0] == 0
    assert simulations.seen == [1.0, 2.0]
    (only,) = Path("multirun").iterdir()
    assert only.name == "contact.clearance=1_um,2_um,law=hertz_penalty,record.picture=false"


def test_the_folder_that_a_file_of_ones_own_gives_is_taken(
    command: Command, simulations: Simulations, tmp_path: Path
) -> None:
    (tmp_path / "mine/experiment").mkdir(parents=True)
    (tmp_path / "mine/experiment/mine.yaml").write_text(
        "# @package _global_\nhydra:\n  sweep:\n    dir: out/${folder_name:${hydra.job.override_dirname}}\n"
    )
    lines = ("-m", "experiment=mine", "contact.clearance=1e-6,2e-6", "record.picture=false")
    assert command("--config-dir", "mine", *lines)[0] == 0
    (only,) = Path("out").iterdir()
    assert only.name == "contact.clearance=1e-6,2e-6,experiment=mine,record.picture=false"
    assert len(list(only.glob("*/run.nc"))) == 2


@pytest.mark.parametrize(
    ("overrides", "name"),
    [
        ("law=lagrange_slip", "law=lagrange_slip"),
        ("contact.clearance=1\\ um", "contact.clearance=1_um"),
        ("contact.clearance='2 \u00b5m'", "contact.clearance=2_um"),
        ("law/normal=linear,law=composed", "law-normal=linear,law=composed"),
        ("", "default"),
    ],
)
def test_a_folder_is_named_by_the_overrides(overrides: str, name: str) -> None:
    assert folder_name(overrides) == name


def test_folders_differ_where_their_overrides_do() -> None:
    several = ["a=x/y", "a=x-y", "a=x:y", *(f"a={'x' * 300}{n}" for n in range(9))]
    names = [folder_name(overrides) for overrides in several]
    assert len(set(names)) == len(several)
    assert max(map(len, names)) <= MOST_CHARACTERS
    assert not any(set(name) & set("/:\\ '\"") for name in names)


def test_a_folder_of_several_jobs_is_refused(command: Command) -> None:
    status, _, err = command("-m", "contact.clearance=1e-6,2e-6", *QUICK, "hydra.sweep.subdir=one")
    assert status == 2
    assert "hydra.sweep.subdir" in err
