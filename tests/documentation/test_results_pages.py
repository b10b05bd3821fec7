"""Pages state the numbers of docs/results, which are not older than the code."""

import re
from copy import deepcopy
from functools import partial
from pathlib import Path
from shutil import copytree
from typing import Any

import claims
import pytest
import results_pages
import results_store
from claims import Number
from results_pages import Page
from results_store import CHECKED, OLDER, PHYSICS, ROOT, digest_of

STEADY = "docs/steady.md"
DAMPING = claims.DAMPING


@pytest.fixture
def fresh():
    claims.results.cache_clear()
    yield
    claims.results.cache_clear()


def test_the_pages_are_those_of_the_results(capsys: pytest.CaptureFixture[str]) -> None:
    assert results_pages.main(["--check"]) == 0, capsys.readouterr().out


def test_a_factor_in_the_engine_makes_results_old_and_a_comment_does_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("contactlab", "conf", "experiments"):
        copytree(ROOT / name, tmp_path / name, ignore=lambda _, names: {"__pycache__"} & {*names})
    unchanged = results_store.stamp_of("motor_findings", PHYSICS)
    engine = tmp_path / "contactlab" / "engine" / "flight.py"
    source = engine.read_text()
    engine.write_text(f'"""Another docstring."""\n\n# A comment.\n{source}')
    present = partial(digest_of, root=tmp_path)
    monkeypatch.setattr(results_store, "digest_of", present)
    assert results_store.stamp_of("motor_findings", PHYSICS) == unchanged
    mutant = re.sub(r"= (\w+) \* ", r"= 1.001 * \1 * ", source, count=1)
    assert mutant != source
    engine.write_text(mutant)
    results_store.parsed.cache_clear()
    digest_of.cache_clear()
    assert results_store.stamp_of("motor_findings", PHYSICS) != unchanged
    section = {**unchanged, "script": "motor_findings", "parts": [*PHYSICS]}
    assert results_store.state_of(section) == OLDER
    assert results_store.different({"motor": {"modes": lambda: {}}}) == ["motor: modes"]


def test_a_changed_number_changes_tables_and_sentences_together(
    fresh: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    changed = deepcopy(results_store.read("motor"))
    changed["sections"][DAMPING]["results"]["stiffness_damping=2e-5"]["hertz"]["rotor_velocity"] = -1.5
    monkeypatch.setattr(claims, "read", lambda name: changed if name == "motor" else results_store.read(name))
    page = Page(STEADY)
    assert [*page.fill()] == []
    assert "| `stiffness_damping=2e-5` (paper) | 0.135, 0.237 | -1.5000 |" in page.text
    assert "is the slowest of the four" in page.old
    assert "is the slowest of the four" not in page.text
    assert "is not the slowest of the four" in page.text


def test_what_errors_blur_is_inconclusive(fresh: None, monkeypatch: pytest.MonkeyPatch) -> None:
    changed = deepcopy(results_store.read("motor"))
    changed["sections"][DAMPING]["results"]["damping_ratio=0.01"]["stick"]["rotor_velocity_error"] = 1.0
    monkeypatch.setattr(claims, "read", lambda name: changed if name == "motor" else results_store.read(name))
    page = Page(STEADY)
    assert [*page.fill()] == []
    assert "is open within the errors" in " ".join(page.text.split())
    assert claims.less(Number(1.0, 0.2), Number(1.1)) is None
    assert claims.every((True, None)) is None
    assert claims.every((False, None)) is False


def test_a_result_without_a_claim_is_refused() -> None:
    page = Page(STEADY)
    assert [*page.bare()] == []
    page.text += "\nUnder `newton` the motor turns at\n1.43 rad/s, and takes 12 % less.\n"
    assert [*page.bare()] == [f"{STEADY}: '1.43 rad/s' has no claim", f"{STEADY}: '12 %' has no claim"]


def test_other_digits_of_a_cheap_section_stamp_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    stored = results_store.read("motor")["sections"]["modes"]["results"]
    written: dict[str, dict[str, Any]] = {}
    monkeypatch.setattr(results_store, "write", written.__setitem__)
    near = deepcopy(stored)
    near["converged"]["damping_ratio"][0] *= 1.001
    assert results_store.check({"motor": {"modes": lambda: near}}, claims.FILES) == ["motor: modes"]
    assert not written
    present = {"script_code": "s" * 16, "made": "f" * 16}
    monkeypatch.setattr(results_store, "stamp_of", lambda *_: present)
    assert results_store.check({"motor": {"modes": lambda: stored}}, claims.FILES) == []
    sections = written["motor"]["sections"]
    assert sections["modes"]["made"] == "f" * 16
    assert sections[claims.PHASE]["by"] == ["motor: modes"]
    assert results_store.state_of(sections[claims.PHASE]) == CHECKED
    # What depends on more than the cheap section, or on a script that has changed, is not checked by it.
    assert results_store.state_of(sections["known worlds"]) == OLDER
    for section in written["experiments"]["sections"].values():
        assert results_store.state_of(section) == OLDER
