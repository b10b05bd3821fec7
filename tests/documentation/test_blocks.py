"""Every command and Python block of a page runs, in order, and prints what the page shows.

A block that cannot run in a test is marked by a line before it, `<!-- not run: why -->`. A block of text is
the output of the block before it, where `...` stands for anything.
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
"""Pages whose blocks another test runs, with further assertions."""

WITH_BLOCKS = {
    path.relative_to(ROOT).as_posix(): text
    for path in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    if "examples" not in path.relative_to(ROOT).parts and blocks(text := path.read_text(encoding="utf-8"))
}
PAGES = [page for page, text in WITH_BLOCKS.items() if not pictures(text) and page not in ELSEWHERE]
"""Pages with pictures are run by the build of the site, which needs the pictures."""

PAGE = """
```bash
export WORD=kept && cd . && printf 'one   two\\n3.14159 four\\n'
```

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


def desk(folder: Path) -> Desk:
    return Desk(folder, surroundings(Path(sys.executable)))


@pytest.mark.long
@pytest.mark.parametrize("page", PAGES)
def test_every_block_of_a_page_runs_in_order_and_prints_what_the_page_shows(
    page: str, tmp_path: Path
) -> None:
    with desk(tmp_path) as at:
        assert len(list(follow(ROOT / page, tmp_path, at))) == len(blocks(WITH_BLOCKS[page]))


def test_blocks_share_a_shell_and_a_session_and_outputs_belong_to_the_block_before(tmp_path: Path) -> None:
    assert [type(item) for item in items(PAGE)] == [Block, Block, Picture]
    assert [block.output for block in blocks(PAGE)] == ["one two\n3.1... four\n", None]
    page = tmp_path / "page.md"
    page.write_text(PAGE)
    with desk(tmp_path) as at:
        printed = [text for _, text in follow(page, tmp_path, at)]
        assert at.shell("echo $WORD").split() == ["kept"]
    assert printed[1].split() == ["None"]
    assert "(folder/made.png)" in with_pictures(PAGE, "folder")
    assert not agrees("a ... b", "a b c")


@pytest.mark.parametrize(
    "wrong",
    [
        "```bash\nls | false\necho on\n```\n",
        "\n```python\nx = 1\nraise ValueError('no')\n```\n",
        "```bash\necho one two\n```\n\n```text\none ... three\n```\n",
        "<!-- picture: missing.png, a hole -->\n",
        "```text\nnothing\n```\n",
    ],
)
def test_a_page_that_is_wrong_is_refused(wrong: str, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(wrong)
    with desk(tmp_path) as at, pytest.raises(PageError):
        list(follow(page, tmp_path, at))
