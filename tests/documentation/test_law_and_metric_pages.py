"""The pages that are made: docs/laws.md with a picture a law, docs/plausibility.md."""

import re
from pathlib import Path

import law_page
import metric_page
import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.long
def test_the_page_is_what_the_laws_declare() -> None:
    committed = (ROOT / "docs" / "laws.md").read_text(encoding="utf-8")
    assert committed == law_page.page(), "Run python docs/tools/law_page.py."


def test_every_law_has_a_picture_and_no_picture_is_without_a_law() -> None:
    committed = (ROOT / "docs" / "laws.md").read_text(encoding="utf-8")
    shown = set(re.findall(r"\]\((laws/\w+\.png)\)", committed))
    there = {f"laws/{path.name}" for path in (ROOT / "docs" / "laws").iterdir()}
    assert shown == there


@pytest.mark.long
def test_the_page_can_be_made_elsewhere(tmp_path: Path) -> None:
    assert law_page.main(["--output", str(tmp_path)]) == 0
    assert (tmp_path / "laws.md").is_file()
    assert (tmp_path / "laws" / "friction_mindlin.png").stat().st_size > 5000


def test_the_page_of_the_metrics_is_what_they_say() -> None:
    committed = (ROOT / "docs" / "plausibility.md").read_text(encoding="utf-8")
    assert committed == metric_page.page(), "Run python docs/tools/metric_page.py."
