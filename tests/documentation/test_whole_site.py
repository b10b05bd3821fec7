"""The check of the built site finds broken links, pictures without a description and fetched files."""

from pathlib import Path

import pytest

whole_site = pytest.importorskip(
    "whole_site", reason="needs Sphinx: pip install -e '.[docs]'", exc_type=ImportError
)


@pytest.mark.parametrize(
    ("page", "faults"),
    [
        ('<a href="a/other.html#there">x</a><p id="here"><a href="#here">x</a><a href="">x</a>', 0),
        ('<a href="https://example.org/nowhere">x</a><a href="mailto:a@b">x</a><img src="x.png" alt="">', 0),
        ('<a href="a/missing.html">x</a>', 1),
        ('<a href="a/other.html#nothing">x</a>', 1),
        ('<a href="#nothing">x</a>', 1),
        ('<img src="x.png">', 1),
        ('<script src="https://example.org/x.js"></script>', 1),
    ],
)
def test_a_page_has_as_many_faults_as_it_has(tmp_path: Path, page: str, faults: int) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "other.html").write_text('<p id="there"></p>', encoding="utf-8")
    (tmp_path / "x.png").touch()
    (tmp_path / "index.html").write_text(page, encoding="utf-8")
    assert len(list(whole_site.faults_in(tmp_path))) == faults
