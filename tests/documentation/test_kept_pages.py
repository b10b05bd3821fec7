"""Pictures of the site are kept until the code or the page that made them changes."""

from pathlib import Path

import kept_pages
from dependencies import digest_of


def test_pictures_are_kept_until_the_code_or_the_page_changes(tmp_path: Path) -> None:
    page, module = tmp_path / "page.md", tmp_path / "contactlab" / "law.py"
    pictures = tmp_path / "pictures"
    style = tmp_path / "docs" / "extensions" / "gallery_figures.py"
    for folder in (module.parent, pictures, style.parent):
        folder.mkdir(parents=True)
    style.touch()
    page.write_text("a page")
    module.write_text("k = 1.0\n")

    def current() -> bool:
        digest_of.cache_clear()
        return kept_pages.is_current(pictures, kept_pages.digest(page, root=tmp_path))

    assert not current()
    kept_pages.keep(pictures, kept_pages.digest(page, root=tmp_path))
    assert current()
    module.write_text("k = 1.0  # A comment draws no other picture.\n")
    assert current()
    module.write_text("k = 2.0\n")
    assert not current()
    module.write_text("k = 1.0\n")
    assert current()
    page.write_text("another page")
    assert not current()
