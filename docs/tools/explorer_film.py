"""A film of the explorer in Chromium: sliders that a hand moves, and the motors that follow.

`python docs/tools/explorer_film.py` leaves `explorer.webp` in `docs/static`, or in the folder that is given.
It needs Chromium, playwright and contactlab-explorer. A picture is taken when the page is complete, so the
film has no waiting in it.
"""

import io
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from PIL import Image
from playwright.sync_api import Page, sync_playwright

from contactlab.results.files import whole_file

STATIC: Final = Path(__file__).resolve().parents[1] / "static"
LAWS: Final = "law=newton,hertz_penalty"
SIZE: Final = (1120, 700)
SHOWN: Final = 0.75
"""Size of the page [pixel], and of a pixel in the film."""

MOVES: Final = {
    "law.restitution@newton": ["ArrowRight"] * 40 + ["ArrowLeft"] * 30,
    "drive.voltage_1": ["ArrowLeft"] * 50,
}
"""Keys pressed on each slider, one after the other."""

KEYS_OF_A_PICTURE: Final = 5
DURATION: Final = 400
"""Of a picture [ms]."""


def main(folder: Path = STATIC) -> None:
    """Make the film."""
    line = [sys.executable, "-m", "contactlab", "explore", "browser=false", LAWS]
    with subprocess.Popen(line, stdout=subprocess.PIPE, text=True) as server, sync_playwright() as play:
        assert server.stdout is not None
        link = re.search(r"http://\S+", server.stdout.readline())
        assert link is not None
        browser = play.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        width, height = SIZE
        page = browser.new_page(viewport={"width": width, "height": height}, device_scale_factor=SHOWN)
        page.goto(link[0])
        first, *others = [Image.open(io.BytesIO(picture)) for picture in _pictures(page)]
        browser.close()
        server.send_signal(signal.SIGINT)
    film: dict[str, Any] = {"duration": DURATION, "loop": 0, "quality": 60, "method": 6}
    with whole_file(folder / "explorer.webp") as partial:
        first.save(partial, format="WEBP", save_all=True, append_images=others, **film)


def _pictures(page: Page) -> Iterator[bytes]:
    """Yield a picture of the complete page at the start and after some keys."""
    yield _picture(page)
    for key, presses in MOVES.items():
        page.locator(f'[data-key="{key}"] [tabindex]').first.focus()
        for start in range(0, len(presses), KEYS_OF_A_PICTURE):
            for press in presses[start : start + KEYS_OF_A_PICTURE]:
                page.keyboard.press(press)
            page.wait_for_timeout(400)
            yield _picture(page)


def _picture(page: Page) -> bytes:
    page.locator("[data-state=ready]").wait_for(timeout=120_000)
    # What is drawn moves to its place.
    page.wait_for_timeout(400)
    return page.screenshot(animations="disabled")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
