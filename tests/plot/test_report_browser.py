"""The report in a browser, on a desk and on a phone: nothing is wider than the page."""

import json
import os
import re
import shutil
import subprocess
from html import unescape
from pathlib import Path

import pytest
from support.configurations import LAWS

from contactlab import build, compare

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")

MEASURE = """<script>
const wide = innerWidth, scrolls = (e) => e.parentElement && e.parentElement.closest('.box, pre');
const out = [...document.body.querySelectorAll('*')].filter(
  (e) => !scrolls(e) && e.getBoundingClientRect().right > wide + 0.5);
parent.postMessage(JSON.stringify({
    width: wide, scroll: document.documentElement.scrollWidth, out: out.map((e) => e.outerHTML.slice(0, 80)),
    pictures: [...document.images].map((i) => i.naturalWidth * (i.clientWidth > 0)),
    boxes: [...document.querySelectorAll('.box')].map((e) => e.scrollWidth - e.clientWidth),
    small: parseFloat(getComputedStyle(document.querySelector('td')).fontSize) }), '*');
</script>"""

# A browser's own window is never narrower than 500 px; a frame is as narrow as a phone.
FRAME = """<!doctype html><meta charset="utf-8"><pre id="found"></pre><script>
addEventListener('message', (e) => { document.getElementById('found').textContent = e.data; });
</script><iframe src="copy.html" style="border:0;width:%dpx;height:%dpx"></iframe>"""


@pytest.fixture(scope="module")
def browser() -> str:
    result = next((path for name in NAMES if (path := shutil.which(name))), None)
    if result is None:
        (pytest.fail if os.environ.get("CI") else pytest.skip)(
            "There is no Chromium to open the report in; on Debian, apt-get install chromium brings one."
        )
    return result


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    # Without the one that settles to no orbit, which takes long.
    setups = [build([f"law={law}"]) for law in LAWS if law != "lagrange_slip"]
    compare(setups, output=folder, samples=2, starts=1, workers=1)
    return folder / "report.html"


def _open(browser: str, page: Path, size: tuple[int, int], *options: str) -> str:
    """Have the browser open a page, as root in a container too."""
    return subprocess.run(
        [
            browser,
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
            "--virtual-time-budget=5000",
            f"--user-data-dir={page.parent / 'profile'}",
            f"--window-size={size[0]},{size[1]}",
            *options,
            page.as_uri(),
        ],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
    ).stdout


@pytest.mark.long
@pytest.mark.parametrize("size", [(1280, 900), (390, 844)])
def test_nothing_is_wider_than_the_page(
    browser: str, report: Path, tmp_path: Path, size: tuple[int, int]
) -> None:
    # A copy measures itself; the report has no script.
    copy = tmp_path / "copy.html"
    page = report.read_text(encoding="utf-8").replace("<details>", "<details open>")
    copy.write_text(page.replace("</body>", f"{MEASURE}</body>"), encoding="utf-8")
    frame = tmp_path / "frame.html"
    frame.write_text(FRAME % size, encoding="utf-8")
    shown = _open(browser, frame, (1400, 1000), "--dump-dom")
    result = json.loads(unescape(re.findall(r'<pre id="found">(.*?)</pre>', shown, re.S)[0]))
    assert result["width"] == size[0]
    assert result["scroll"] <= size[0]
    assert result["out"] == []
    assert len(result["pictures"]) == 5
    assert min(result["pictures"]) > 500
    assert result["small"] >= 12.0
    # No table is cut: neither has to be scrolled.
    assert max(result["boxes"]) <= 0


def test_a_screenshot_shows_it(browser: str, report: Path, tmp_path: Path) -> None:
    picture = tmp_path / "phone.png"
    _open(browser, report, (390, 844), f"--screenshot={picture}")
    assert picture.stat().st_size > 10_000
