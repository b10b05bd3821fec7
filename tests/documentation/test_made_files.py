"""Pages and pictures that are made by scripts and committed are those that the scripts make."""

import re
from pathlib import Path

import law_page
import law_table
import metric_page
import numpy as np
import pytest
import reader_pictures
import readme_pictures
from first_hour import Step, page_of
from PIL import Image, ImageSequence
from readme_commands import FIGURE, GREEN, commands_of, steps_of

import contactlab as cl
from contactlab.laws import LAWS, PARTS
from contactlab.laws.declaration import Declared

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"


def test_every_law_has_a_picture_and_every_picture_a_law() -> None:
    pages = "".join(path.read_text(encoding="utf-8") for path in (DOCS / "laws").glob("*.md"))
    assert sorted(re.findall(r"\]\((\w+\.png)\)", pages)) == sorted(
        path.name for path in (DOCS / "laws").glob("*.png")
    )


def test_the_laws_of_the_paper_come_first_and_each_law_has_a_row_and_a_section() -> None:
    entry = (DOCS / law_page.PAGE).read_text(encoding="utf-8")
    rows = re.findall(r"^\| \[(\w+)\]\((laws/\w+\.md)#(\w+)\)", entry, re.MULTILINE)
    assert [name for name, _, _ in rows[:3]] == ["lagrange_slip", "lagrange_stick", "hertz_penalty"]
    assert len(rows) == len(LAWS) - 1 + sum(map(len, PARTS.values()))  # A composed law is its parts.
    for name, page, anchor in rows:
        assert anchor == name
        assert f"\n## {name}\n" in (DOCS / page).read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("law", "kind"),
    [
        (cl.LagrangeSlip(), ("rigid", "all", "none", "no", "none", "no")),
        (cl.HertzPenalty(), ("compliant", "none", "rigid", "no", "none", "no")),
        (cl.HuntCrossley(), ("compliant", "some", "rigid", "yes", "none", "no")),
        # Its loss goes by the ratio of the speed to that of the approach.
        (cl.Flores(), ("compliant", "some", "rigid", "no", "none", "no")),
        (cl.Jkr(), ("compliant", "some", "rigid", "no", "none", "yes")),
        (cl.Dahl(), ("compliant", "none", "elastic", "no", "deflection", "no")),
        (cl.RateAndState(), ("compliant", "none", "creep", "yes", "age", "no")),
    ],
)
def test_what_a_law_has_follows_from_its_declarations(law: Declared, kind: tuple[str, ...]) -> None:
    assert law_page.properties(type(law)) == kind


@pytest.mark.long
def test_the_pages_of_the_laws_are_current_and_can_be_made_elsewhere(tmp_path: Path) -> None:
    assert law_page.main(["--output", str(tmp_path)]) == 0
    assert (tmp_path / "laws" / "friction_mindlin.png").stat().st_size > 5000
    made = [*tmp_path.rglob("*.md")]
    assert made
    for page in made:
        committed = DOCS / page.relative_to(tmp_path)
        assert committed.read_text(encoding="utf-8") == page.read_text(encoding="utf-8"), committed


def test_the_page_of_the_metrics_is_current() -> None:
    committed = (DOCS / "plausibility.md").read_text(encoding="utf-8")
    assert committed == metric_page.page(), "python docs/tools/metric_page.py"


def test_the_table_of_the_laws_has_a_row_for_each_and_none_that_fails() -> None:
    page = (DOCS / law_table.PAGE).read_text(encoding="utf-8")
    lines = [re.split(r"(?<!\\)\|", line)[1:-1] for line in page.splitlines() if re.match(r"\| [`\[]", line)]
    entries = {entry.label: entry for entry in law_table.entries()}
    assert [cells[0].strip() for cells in lines] == [*entries], "python docs/tools/law_table.py"
    assert "**" not in page
    # 1 mm/s times 0.6/sqrt(1 - 0.6^2).
    (label,) = (each for each in entries if "regularised" in each)
    assert "0.00075 m/s" in law_table.row(entries[label])


@pytest.mark.long
def test_the_pictures_of_readme_are_current(tmp_path: Path) -> None:
    readme_pictures.main(tmp_path)
    reader_pictures.main(tmp_path)
    small = (f"for_{name}.png" for name in reader_pictures.READERS)
    for name in ("motor.gif", "laws.png", "order.png", "compared.png", *small):
        made, committed = frames_of(tmp_path / name), frames_of(readme_pictures.STATIC / name)
        assert made.shape == committed.shape
        # Another machine rounds otherwise, which moves an edge by a shade.
        assert np.abs(made - committed).mean() < 0.5


def frames_of(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        return np.array([np.asarray(frame.convert("RGB"), float) for frame in ImageSequence.Iterator(image)])


def test_readmes_two_commands_are_those_that_are_timed_and_run_for_every_change() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    names = [name for name, _ in steps_of(readme, tests=True)]
    assert names == [*FIGURE, "second run", *GREEN[-2:]]
    assert all(command in (ROOT / ".ci/run").read_text(encoding="utf-8") for command in commands_of(readme))
    steps = [Step("abc", "3.13.0", name, 2.0, 1.0, 10.0, 0.0, name != "tests") for name in names]
    # A failed step reaches nothing.
    assert "not reached" in page_of(steps)
    assert "not reached" not in page_of(steps[:4])
