"""A dataset that is not as its run left it is refused before anything opens it."""

import random
from pathlib import Path

import pytest
from support.sweeps import left_run
from support.synthetic import CONFIGURATION, synthetic_trajectory

from contactlab import ComparisonError, SweepError, compare
from contactlab.metrics import read_run
from contactlab.results.netcdf import to_datatree, write_tree
from contactlab.studies.run_state import Status, is_done
from contactlab.studies.sweep.collection import collect


def test_no_damage_of_a_dataset_comes_through(tmp_path: Path) -> None:
    """Single bits in what the file says of itself, where the format has no check of its own."""
    file = left_run(tmp_path / "run")
    sound = file.read_bytes()
    chance = random.Random(1)
    for _ in range(100):
        damaged = bytearray(sound)
        damaged[chance.randrange(20_000)] ^= 1 << chance.randrange(8)
        file.write_bytes(damaged)
        with pytest.raises(ValueError, match=r"run\.nc"):
            read_run(file)
        assert not is_done(file.parent, "key")
    file.write_bytes(sound)
    read_run(file)
    assert is_done(file.parent, "key")


def test_a_number_that_was_changed_in_place_reaches_no_metric(tmp_path: Path) -> None:
    file = left_run(tmp_path / "run")
    text = file.read_bytes()
    changed = text.replace(b"radius: 0.025", b"radius: 0.075")
    assert changed != text
    file.write_bytes(changed)
    result = collect(tmp_path)
    assert result["status"].values.tolist() == [Status.FAILED]
    with pytest.raises(SweepError, match="complete"):
        collect(tmp_path, series=["gap"])
    with pytest.raises(ComparisonError, match=r"run\.nc"):
        compare([tmp_path], refine=False)


def test_a_run_in_the_place_of_another_is_told(tmp_path: Path) -> None:
    file = left_run(tmp_path / "run")
    other = synthetic_trajectory(duration=4e-3)
    write_tree(to_datatree(other, CONFIGURATION), file)
    with pytest.raises(ValueError, match=r"run\.nc"):
        read_run(file)


@pytest.mark.parametrize("text", [None, "no json", "[]", '{"digest": 5}', '{"digest": ""}', "{}"])
def test_a_dataset_of_which_nothing_tells_is_taken_as_it_is(tmp_path: Path, text: str | None) -> None:
    file = left_run(tmp_path / "run")
    (file.parent / "state.json").unlink()
    if text is not None:
        (file.parent / "state.json").write_text(text)
    assert read_run(file)["time"].size == synthetic_trajectory().time.size
