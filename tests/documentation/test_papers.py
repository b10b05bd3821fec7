"""A paper follows its results: numbers change together; what has fallen or is missing fails."""

import json
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import papers
import pytest
import recorded_numbers
import results_pages
import results_store
from claims import PAPERS
from contrast_figures import SPEED
from law_contrasts import LawContrasts
from law_practice import LawPractice
from results_pages import Page
from support.made_contrasts import data_of, practice_of
from xarray import DataTree

LAWS = "paper/laws/laws.md"
ROOT = results_pages.ROOT


@pytest.fixture
def world(monkeypatch: pytest.MonkeyPatch) -> Callable[..., dict[str, Any]]:
    """Return a function that puts made-up motors, or no section, into the store."""
    recorded_numbers.results.cache_clear()
    made = {}
    for study, data in ((LawContrasts(), data_of(40)), (LawPractice(), practice_of(40))):
        rows = [{name: x for name, x in row.items() if x == x} for row in study.rows(data)]
        numbers = study.numbers(DataTree(data))
        made[study.name] = {"finding": "", "holds": 1, "rows": rows, "numbers": numbers}

    def put(change: Callable[[dict[str, Any]], None] | None = None, there: bool = True) -> None:
        own = json.loads(results_store.text_of(deepcopy(made)))
        if change:
            change(own["law_contrasts"])
        content = results_store.read("experiments")
        for name, results in own.items():
            content["sections"].pop(name, None)
            if there:
                content["sections"][name] = results_store.sealed({"results": results})

        def read(name: str) -> dict[str, Any]:
            return content if name == "experiments" else results_store.read(name)

        monkeypatch.setattr(recorded_numbers, "read", read)
        recorded_numbers.results.cache_clear()

    yield put
    recorded_numbers.results.cache_clear()


def without_a_difference(own: dict[str, Any]) -> None:
    """Leave no contrast a share above chance."""
    for row in own["rows"]:
        if not row["contrast"].startswith("null"):
            row |= {"share": 0.0, "low": 0.0, "high": 0.0}


def first(own: dict[str, Any]) -> None:
    """Let the first contrast turn all motors."""
    own["numbers"]["size"][SPEED]["rigid or compliant"] = ["turned"] * 40


def filled() -> Page:
    """Return the paper with the numbers of the store, as if they had always stood there."""
    page = Page(LAWS)
    assert [*page.fill()] == []
    page.old = page.text
    return page


def test_a_changed_number_changes_text_table_and_figure(world: Callable[..., None]) -> None:
    world()
    before = filled()
    drawn = [papers.FIGURES[""](recorded_numbers.results("experiments")["law_contrasts"]["numbers"])]
    world(first)
    after = filled()
    drawn.append(papers.FIGURES[""](recorded_numbers.results("experiments")["law_contrasts"]["numbers"]))
    assert "| rigid or compliant | 1 |" in before.text
    assert "| rigid or compliant | 40 |" in after.text
    assert "*rigid or compliant* does so in 100 %" in " ".join(after.text.split())
    assert "*rigid or compliant* does so in 100 %" not in " ".join(before.text.split())
    texts = [{each.get_text() for each in figure.axes[0].texts} for figure in drawn]
    assert ["40 turned" in each for each in texts] == [False, True]


def test_a_sentence_that_falls_is_named_with_the_one_that_holds(world: Callable[..., None]) -> None:
    world()
    page = filled()
    assert [*page.fallen()] == []
    world(without_a_difference)
    (fault,) = page.fallen()
    assert "drawn motors the law matters beyond chance" in fault
    assert "drawn motors the law does not matter beyond chance" in fault


def test_nothing_is_written_where_a_section_is_missing(
    world: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    world(there=False)
    before = {name: (ROOT / name).read_bytes() for name in PAPERS}
    assert papers.main() == 1
    errors = capsys.readouterr().err
    assert all(name in errors for name in papers.NEEDED)
    assert before == {name: (ROOT / name).read_bytes() for name in PAPERS}


def test_what_only_authors_can_write_is_a_marked_blank() -> None:
    for name in PAPERS:
        text = (ROOT / name).read_text(encoding="utf-8")
        head, _, rest = text.partition("# AI usage disclosure")
        assert {*map(papers.BLANK.search, (head, rest.partition("\n# ")[0]))}.isdisjoint({None})
        assert Path(ROOT / name).is_file()
