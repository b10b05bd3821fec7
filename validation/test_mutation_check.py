"""The errors that the mutation check puts in are there to be put in, and one of them is, and is caught."""

import ast
import shutil
from pathlib import Path

import mutation_check as check
import pytest

QUICK = "the mass of one layer of patches (misprint of eq. 28)"


def test_every_error_applies_to_the_sources_as_they_are(tmp_path: Path) -> None:
    assert len({mutation.name for mutation in check.MUTATIONS}) == len(check.MUTATIONS) >= 60
    stale = []
    for mutation in check.MUTATIONS:
        source, copy = check.ROOT / mutation.file, tmp_path / mutation.file
        copy.parent.mkdir(parents=True, exist_ok=True)
        if source.is_file():
            shutil.copy(source, copy)
        try:
            mutation.apply(copy.parents[len(Path(mutation.file).parts) - 1])
            # An error of the physics and not of the grammar, and one that changes something.
            changed, unchanged = (ast.dump(ast.parse(f.read_text())) for f in (copy, source))
            assert changed != unchanged, mutation.name
        except ValueError as fault:
            stale.append(str(fault))
        missing = [test for test in mutation.tests if not (check.ROOT / test).is_file()]
        stale += [f"'{mutation.name}': there is no {test}." for test in missing]
        assert mutation.tests, mutation.name
    assert not stale, "\n".join(stale)


@pytest.mark.long
def test_an_error_is_caught() -> None:
    # Of the resonator: no kernel has to be compiled for it.
    (mutation,) = (m for m in check.MUTATIONS if m.name == QUICK)
    # That the unchanged project is not is what its own tests say.
    outcome = check.try_out(mutation, mutation.tests)
    assert outcome.caught
    assert "test_resonator.py" in outcome.by


@pytest.mark.parametrize(("old", "count"), [("no such text", 0), ("phase", r"\d\d?")])
def test_an_error_that_no_longer_applies_is_told_in_a_sentence(old: str, count: object) -> None:
    stale = check.Mutation("stale", "contactlab/motor/drive.py", old, "")
    with pytest.raises(ValueError, match=rf"stands {count} times in contactlab/motor/drive\.py"):
        stale.apply(check.ROOT)
