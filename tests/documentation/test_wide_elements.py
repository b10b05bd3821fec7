"""The check of a built site sees what is wider than its column, and nothing else."""

import os
import shutil
from pathlib import Path

import pytest
from wide_elements import wide_elements

PAGE = """<!doctype html><meta charset="utf-8"><body style="margin: 0">
<article class="bd-article" style="{style}">
<pre style="overflow-x: auto">{line}</pre></article></body>"""


@pytest.mark.skipif(
    not os.environ.get("CI") and shutil.which("chromium") is None,
    reason="There is no Chromium; on Debian, apt-get install chromium brings one.",
)
def test_a_line_wider_than_its_column_and_a_page_wider_than_a_phone_are_named(tmp_path: Path) -> None:
    (tmp_path / "narrow.html").write_text(PAGE.format(style="", line="short"))
    (tmp_path / "long.html").write_text(PAGE.format(style="", line="long " * 100))
    (tmp_path / "fixed.html").write_text(PAGE.format(style="width: 700px", line="short"))
    lines = [line.split(" | ") for line in wide_elements(tmp_path)]
    assert [(page, width, element) for page, width, element, *_ in lines] == [
        ("fixed.html", "400", "html"),
        ("long.html", "1200", "pre"),
        ("long.html", "1440", "pre"),
    ]
    assert {path.name for path in tmp_path.iterdir()} == {"narrow.html", "long.html", "fixed.html"}
