"""The documentation is right: every command and Python block of a page runs, in order, in an empty folder.

A block that cannot run on a desk is marked by a line before it, `<!-- not run: why -->`. A block of text is
what the block before it prints, where `...` stands for anything.
"""

import sys
from pathlib import Path

import pytest
from page_blocks import Block, PageError, Picture, agrees, blocks, items, pictures, with_pictures
from page_desk import Desk, follow, surroundings

TESTS = Path(__file__).resolve().parents[1]
ROOT = TESTS.parent
ELSEWHERE = {
    "docs/howto/own_law_package.md": "documentation/test_own_law_package.py",
    "docs/impacts.md": "test_impact.py",
    "docs/writing_laws.md": "laws/test_guide.py",
}
"""Pages whose blocks another test runs, which holds them to more."""

WITH_BLOCKS = {
    path.relative_to(ROOT).as_posix(): text
    for path in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    if "examples" not in path.relative_to(ROOT).parts and blocks(text := path.read_text(encoding="utf-8"))
}
FOLLOWED = {page for page, text in WITH_BLOCKS.items() if pictures(text)}
"""Pages with pictures: the build of the site, which makes them, follows these in the same way."""

PAGES = [page for page in WITH_BLOCKS if page not in FOLLOWED and page not in ELSEWHERE]
PAGE = """
```bash
export WORD=kept && cd . && printf 'one   two\\n3.14159 four\\n'
```

Words.

```text
one two
3.1... four
```

<!-- not run: it has no end -->
```bash
false
```

```text
nothing
```

```python
import os

print(os.environ.get("WORD"))
open("made.png", "w").close()
```

<!-- picture: made.png, nothing at all -->
"""


def of(page: str) -> str:
    return (ROOT / page).read_text(encoding="utf-8")


def desk(folder: Path) -> Desk:
    return Desk(folder, surroundings(Path(sys.executable)))


@pytest.mark.long
@pytest.mark.parametrize("page", PAGES)
def test_every_block_of_a_page_runs_in_order_and_prints_what_the_page_says(page: str, tmp_path: Path) -> None:
    with desk(tmp_path) as at:
        assert len(list(follow(ROOT / page, tmp_path, at))) == len(blocks(of(page)))


def test_blocks_share_a_shell_and_a_session_and_outputs_belong_to_what_ran(tmp_path: Path) -> None:
    found = items(PAGE)
    assert [type(one) for one in found] == [Block, Block, Picture]
    assert [one.line for one in found] == [2, 22, 29]
    assert [one.said for one in blocks(PAGE)] == ["one two\n3.1... four\n", None]
    page = tmp_path / "page.md"
    page.write_text(PAGE)
    with desk(tmp_path) as at:
        printed = [words for _, words in follow(page, tmp_path, at)]
        assert at.shell("echo $WORD").split() == ["kept"]
    assert printed[1].split() == ["None"]
    assert "![nothing at all](folder/made.png)" in with_pictures(PAGE, "folder")


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ("```bash\nls | false\necho on\n```\n", "line 1"),
        ("\n```python\nx = 1\nraise ValueError('no')\n```\n", "line 4, in <module>.*ValueError: no"),
        ("```bash\necho one two\n```\n\n```text\none ... three\n```\n", "printed.*one two.*and not.*three"),
        ("<!-- picture: missing.png, a hole -->\n", "nothing has made missing.png"),
        ("```text\nnothing\n```\n", "the output of nothing"),
    ],
)
def test_a_page_that_is_wrong_is_told(wrong: str, told: str, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(wrong)
    with desk(tmp_path) as at, pytest.raises(PageError, match=f"(?s){told}"):
        list(follow(page, tmp_path, at))


def test_an_output_is_compared_word_by_word() -> None:
    assert agrees("a  b\n...\nc 1.2... d", "a b\n\nwhatever\n c 1.234 d\n")
    assert not agrees("a b", "a bc")
    assert not agrees("a ... b", "a b c")
    assert not agrees("(1)", "1")


def test_no_page_of_tasks_is_without_a_block_that_runs() -> None:
    tasks = {path.relative_to(ROOT).as_posix() for path in (ROOT / "docs/howto").glob("*.md")}
    assert tasks - {*PAGES, *ELSEWHERE, *FOLLOWED} == {"docs/howto/index.md"}


@pytest.mark.parametrize("page", ELSEWHERE)
def test_a_page_whose_blocks_another_test_runs_has_them_and_is_read_there(page: str) -> None:
    assert blocks(of(page))
    assert Path(page).name in (TESTS / ELSEWHERE[page]).read_text(encoding="utf-8")


def test_no_block_that_can_be_pasted_is_indented() -> None:
    """A command that is set by spaces alone is run by no test."""
    for path in sorted((ROOT / "docs").rglob("*.md")):
        lines = path.read_text(encoding="utf-8").splitlines()
        indented = [line for line in lines if line.startswith(("    contactlab ", "    python ", "    pip "))]
        assert not indented, path.name


def test_every_python_block_can_be_compiled() -> None:
    for page in PAGES:
        for block in blocks(of(page)):
            if block.language == "python":
                compile("\n" * block.line + block.code, ROOT / page, "exec")
