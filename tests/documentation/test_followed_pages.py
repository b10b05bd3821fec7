"""A page with pictures is followed once, read again as its pictures change, and its faults end the build."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import kept_pages
import pytest

followed_pages = pytest.importorskip("followed_pages", reason="needs Sphinx", exc_type=ImportError)

PAGE = """# A page

<!-- notebook -->

```bash
{command}
```

<!-- picture: n.png, a picture -->
"""


@pytest.fixture
def app(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return what stands for the builder of a site, whose code does not change."""
    monkeypatch.setattr(kept_pages, "digest_of", lambda *_, **__: "code")
    return SimpleNamespace(srcdir=tmp_path)


def test_a_page_is_followed_once_and_read_again_with_other_pictures(app: Any) -> None:
    followed, path = followed_pages.Followed(), app.srcdir / "page.md"
    picture = app.srcdir / "followed" / "page" / "n.png"
    for command, outdated in (
        ("printf 1 > n.png", True),
        ("printf 1 > n.png", False),
        ("printf 2 > n.png", True),
    ):
        path.write_text(PAGE.format(command=command), encoding="utf-8")
        followed.begin(app)
        assert followed.outdated() == ["page"] * outdated
        source = [path.read_text(encoding="utf-8")]
        followed.fill(app, "page", source)
        assert picture.read_text() == command[7]
        assert "![a picture](/followed/page/n.png)" in source[0]
        assert "</followed/page/page.ipynb>" in source[0]
        assert (picture.parent / "page.ipynb").is_file()


def test_a_block_that_fails_ends_the_build_with_its_line(app: Any) -> None:
    (app.srcdir / "page.md").write_text(PAGE.format(command="exit 3"), encoding="utf-8")
    followed = followed_pages.Followed()
    followed.begin(app)
    with pytest.raises(followed_pages.ExtensionError, match=r"page\.md, line 5"):
        followed.fill(app, "page", [(app.srcdir / "page.md").read_text(encoding="utf-8")])
