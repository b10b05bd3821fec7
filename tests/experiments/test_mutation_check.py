"""The errors that the mutation check puts in are there to be put in, and one of them is, and is caught."""

import importlib
import sys
from pathlib import Path
from types import ModuleType

import pytest

EXPERIMENTS = Path(__file__).parents[2] / "experiments"
QUICK = "the mass of one layer of patches (misprint of eq. 28)"


@pytest.fixture(scope="module")
def check() -> ModuleType:
    sys.path.insert(0, str(EXPERIMENTS))
    try:
        return importlib.import_module("mutation_check")
    finally:
        sys.path.remove(str(EXPERIMENTS))


def test_every_error_applies_to_the_sources_as_they_are(check: ModuleType) -> None:
    for mutation in check.MUTATIONS:
        source = mutation.find(check.ROOT).read_text(encoding="utf-8")
        assert mutation.apply(source) != source, mutation.name
        assert all((check.ROOT / test).is_file() for test in mutation.tests), mutation.name


def test_there_are_many_and_each_has_a_name_of_its_own(check: ModuleType) -> None:
    names = [mutation.name for mutation in check.MUTATIONS]
    assert len(set(names)) == len(names) >= 25


def test_an_error_is_caught_and_the_unchanged_project_is_not(check: ModuleType) -> None:
    # Of the resonator: no kernel has to be compiled for it.
    (mutation,) = (m for m in check.MUTATIONS if m.name == QUICK)
    assert check.try_unchanged(mutation.tests)
    outcome = check.try_out(mutation)
    assert outcome.caught
    assert "test_resonator.py" in outcome.by


def test_an_error_that_no_longer_applies_is_told_in_a_sentence(check: ModuleType) -> None:
    stale = check.Mutation("stale", "contactlab/drive.py", "no such text", "", ())
    with pytest.raises(ValueError, match=r"stands in 0 files of contactlab/drive\.py"):
        stale.find(check.ROOT)
    doubled = check.Mutation("doubled", "contactlab/drive.py", "phase", "", ())
    with pytest.raises(ValueError, match=r"stands \d+ times in contactlab/drive\.py"):
        doubled.apply(doubled.find(check.ROOT).read_text(encoding="utf-8"))
