"""Words of a command are the options that they look like: ranges of numbers, files, and nothing else."""

import pytest

from contactlab.cli.study import as_overrides
from contactlab.studies.compare.priors import Prior
from contactlab.studies.study import Range


@pytest.mark.parametrize(
    ("text", "ends"),
    [
        ("contact.clearance=1 um..4 um", (1e-6, 4e-6)),
        ("contact.clearance=-.5..+1e-6", (-0.5, 1e-6)),
        ("contact.clearance=1e-6..2.", (1e-6, 2.0)),
    ],
)
def test_a_range_has_the_ends_of_its_text(text: str, ends: tuple[float, float]) -> None:
    assert Range.of_text(text).within("m") == ends


@pytest.mark.parametrize("value", ["a/../b", "../a/../b", "2026/../b", "2026/x..y/../b", "a..b", "1e-6"])
def test_a_path_or_a_number_is_no_range(value: str) -> None:
    word = f"resonator.file={value}"
    with pytest.raises(ValueError, match="START"):
        Range.of_text(word)
    with pytest.raises(ValueError, match="LOW"):
        Prior.of_text(word)
    assert word in as_overrides("branch", [word])
    assert word in as_overrides("compare", [word])


@pytest.mark.parametrize("value", ["1 um..4 um", "-.5..+.5", "1e-6+-1e-7", "+-10 %", "log(1e-6..1e-5)"])
def test_a_distribution_of_numbers_is_one(value: str) -> None:
    word = f"contact.clearance={value}"
    assert str(Prior.of_text(word).name) == "contact.clearance"
    assert any(word in line for line in as_overrides("compare", [word]))


def test_files_and_ranges_go_to_the_options_that_take_them() -> None:
    compared = as_overrides("compare", ["two/law=newton", "law/normal=linear", "three"])
    assert "study.runs=['two/law=newton','three']" in compared
    assert "law/normal=linear" in "".join(compared)
