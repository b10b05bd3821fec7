"""The check of the built site finds what is wrong with a page, and nothing else."""

from pathlib import Path

import pytest

whole_site = pytest.importorskip(
    "whole_site", reason="needs Sphinx: pip install -e '.[docs]'", exc_type=ImportError
)


def faults(tmp_path: Path, page: str) -> list[str]:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "other.html").write_text('<p id="there"></p>', encoding="utf-8")
    (tmp_path / "x.png").touch()
    (tmp_path / "index.html").write_text(page, encoding="utf-8")
    return list(whole_site.faults_in(tmp_path))


@pytest.mark.parametrize(
    "page",
    [
        '<a href="a/other.html#there">x</a>',
        '<p id="here"><a href="#here">x</a><a href="">x</a>',
        '<a href="https://example.org/nowhere">x</a><a href="mailto:a@b">x</a>',
        '<img src="x.png" alt="">',
    ],
)
def test_what_is_right_is_left_alone(tmp_path: Path, page: str) -> None:
    assert faults(tmp_path, page) == []


@pytest.mark.parametrize(
    ("page", "words"),
    [
        ('<a href="a/missing.html">x</a>', "a/missing.html leads nowhere"),
        ('<a href="a/other.html#nothing">x</a>', "other.html#nothing leads to a page that has no such place"),
        ('<a href="#nothing">x</a>', "#nothing leads to a page that has no such place"),
        ('<img src="x.png">', "x.png has no words"),
        ('<script src="https://example.org/x.js"></script>', "it fetches https://example.org/x.js"),
    ],
)
def test_a_fault_is_told_with_its_page(tmp_path: Path, page: str, words: str) -> None:
    (told,) = faults(tmp_path, page)
    assert told.startswith("index.html: ")
    assert words in told
