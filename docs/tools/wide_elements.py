"""Whether any page of a built site is wider than its window, or an element wider than its column.

    python docs/tools/wide_elements.py SITE

Chromium opens every page in windows of 1200 and 1440 px, in which no equation, table, picture, command or
line of code may be wider than its column, and of 400 px, in which no page may scroll sideways. What does is
printed by page; the status is then 1.
"""

import json
import re
import subprocess
import sys
from argparse import ArgumentParser
from collections.abc import Iterator, Sequence
from html import unescape
from pathlib import Path
from string import Template
from tempfile import TemporaryDirectory
from typing import Final

COLUMN: Final = (1200, 1440)
"""Widths of windows [px] in which every element fits its column."""

WINDOW: Final = (400,)
"""Widths of windows [px] that no page is wider than."""

SLACK: Final = 2
"""Pixels by which the browser's rounding may have an element wider."""

HARNESS: Final = Path(__file__).with_suffix(".html")


def wide_elements(site: Path) -> Iterator[str]:
    """Yield a line for every page or element of a built site that is too wide.

    Raises:
        RuntimeError: the browser did not come to the end.
    """
    pages = sorted(page.relative_to(site).as_posix() for page in site.rglob("*.html"))
    widths = [*((width, True) for width in COLUMN), *((width, False) for width in WINDOW)]
    text = Template(HARNESS.read_text(encoding="utf-8")).substitute(
        pages=json.dumps(pages), widths=json.dumps(widths), slack=SLACK, count=len(pages)
    )
    harness = site / "_wide_elements.html"
    harness.write_text(text, encoding="utf-8")
    try:
        with TemporaryDirectory() as profile:
            run = subprocess.run(
                [
                    *("chromium", "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"),
                    *("--allow-file-access-from-files", f"--user-data-dir={profile}"),
                    *("--virtual-time-budget=1000000", "--dump-dom", harness.as_uri()),
                ],
                capture_output=True,
                text=True,
                check=True,
            )
    finally:
        harness.unlink()
    seen = re.search(r'<pre id="wide">(.*?)</pre>', run.stdout, re.DOTALL)
    lines = unescape(seen[1]).splitlines() if seen else []
    if lines[:1] != [f"{len(pages)} pages"]:
        raise RuntimeError(f"The browser did not look at all {len(pages)} pages of {site}.")
    yield from lines[1:]


def main(arguments: Sequence[str] | None = None) -> int:
    """Print what is too wide and return the exit status."""
    parser = ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("site", type=Path, help="folder of the built site")
    lines = list(wide_elements(parser.parse_args(arguments).site.resolve()))
    print(*lines, sep="\n", end="\n" if lines else "")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
