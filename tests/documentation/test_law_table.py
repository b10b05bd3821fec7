"""docs/law_table.md has a row for every law and part, and says what it is held to."""

import re
from pathlib import Path

import law_table
import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def rows() -> dict[str, list[str]]:
    """The cells of the committed page by law."""
    page = (ROOT / "docs" / law_table.PAGE).read_text(encoding="utf-8")
    lines = [re.split(r"(?<!\\)\|", line)[1:-1] for line in page.splitlines() if line.startswith("| `")]
    return {cells[0].split("`")[1]: [cell.strip() for cell in cells] for cells in lines}


def test_every_law_has_a_row_and_no_row_is_without_a_law(rows: dict[str, list[str]]) -> None:
    assert [*rows] == [entry.name for entry in law_table.entries()], "Run python docs/tools/law_table.py."


def test_no_row_is_of_a_law_that_fails(rows: dict[str, list[str]]) -> None:
    assert not [name for name, cells in rows.items() if "**" in "".join(cells)]
    assert all(len(cells) == 8 for cells in rows.values())


def test_a_row_is_what_the_contract_and_the_publication_say() -> None:
    (entry,) = (e for e in law_table.entries() if e.name == "law/friction=smooth_cone")
    made = law_table.row(entry)
    assert "(compliant)" in made
    assert "declared broken: stick_is_exact" in made
    assert "0.000693147 m s-1" in made
